#include "figures/charts/curve_rays.h"

#include "core/clock.h"
#include "core/sampling.h"
#include "shapes/curve.h"
#include "shapes/embree.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace cuticle {

std::vector<CurveSegment> HairBall(size_t strands, float widthScale) {
    std::mt19937_64 engine(7);
    std::uniform_real_distribution<float> uniform;
    const auto direction = [&] { return UniformSampleSphere({uniform(engine), uniform(engine)}); };
    CurveList segments;
    for (size_t i = 0; i < strands; ++i) {
        Vector3f d = direction();
        Point3f p = d * 0.5f;
        std::vector<Point3f> points;
        for (size_t k = 0; k < kSegmentsPerStrand + 3; ++k) {
            points.push_back(p);
            p += d * (0.5f / kSegmentsPerStrand);
            d = Normalize(d + direction() * 0.45f);
        }
        const float width = widthScale * 2e-3f * (0.6f + 1.4f * uniform(engine));
        AppendCurve(points.data(), points.size(), CurveBasis::BSpline, 3, width, 0.5f * width, 0, &segments);
    }
    return {segments.begin(), segments.end()};
}

CurveTasks MakeCurveTasks(const CurveSet &set, int side) {
    CurveTasks tasks;
    std::mt19937_64 engine(3);
    std::uniform_real_distribution<float> uniform;
    const auto n = static_cast<float>(side);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            CurveTask task;
            task.ray.o = {0, 0, -4};
            task.ray.d = Normalize(Vector3f((static_cast<float>(x) + uniform(engine)) / n - 0.5f,
                                            (static_cast<float>(y) + uniform(engine)) / n - 0.5f, 2));
            tasks.camera.push_back(task);
            if ((x + y) % 4 != 0)
                continue;
            // Walk from hair to hair.
            for (int depth = 0; depth < 8; ++depth) {
                CurveHit hit;
                if (!set.Intersect(task.ray, task.bounce ? &task.origin : nullptr, &hit))
                    break;
                const CurveSurface s = set.Surface(task.ray, hit);
                task.bounce = true;
                task.ray = Ray();
                task.ray.o = s.p;
                task.ray.d = UniformSampleSphere({uniform(engine), uniform(engine)});
                task.origin = {hit.segment, hit.u};
                const float c = Dot(task.ray.d, s.tangent);
                task.clear = 1.5f * 0.5f * s.width / std::sqrt(std::max(1 - c * c, 1e-6f));
                tasks.bounce.push_back(task);
            }
        }
    return tasks;
}

// --- Embree ------------------------------------------------------------------------------------------------

EmbreeCurves::EmbreeCurves(const std::vector<CurveSegment> &segments, EmbreeShape shape, float tessellation)
    : device_(rtcNewDevice("threads=0")), scene_(rtcNewScene(device_)) {
    rtcSetDeviceMemoryMonitorFunction(
        device_,
        [](void *self, ssize_t n, bool) {
            __atomic_add_fetch(&static_cast<EmbreeCurves *>(self)->bytes_, n, __ATOMIC_RELAXED);
            return true;
        },
        this);
    const double start = ProcessCpuSeconds();
    RTCGeometry geometry = rtcNewGeometry(device_, shape == Flat ? RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE
                                                                 : RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE);
    auto *vertices = static_cast<float *>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 16, 4 * segments.size()));
    auto *indices = static_cast<uint32_t *>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, segments.size()));
    for (size_t i = 0; i < segments.size(); ++i) {
        indices[i] = static_cast<uint32_t>(4 * i);
        for (size_t k = 0; k < 4; ++k) {
            for (int c = 0; c < 3; ++c)
                vertices[16 * i + 4 * k + static_cast<size_t>(c)] = segments[i].cp[k][c];
            vertices[16 * i + 4 * k + 3] =
                0.5f * Lerp(static_cast<float>(k) / 3, segments[i].width[0], segments[i].width[1]);
        }
    }
    if (tessellation > 0)
        rtcSetGeometryTessellationRate(geometry, tessellation);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(scene_);
    seconds_ = ProcessCpuSeconds() - start;
}

EmbreeCurves::~EmbreeCurves() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
}

static RTCRay MakeRay(const CurveTask &task) {
    RTCRay ray;
    ray.org_x = task.ray.o.x, ray.org_y = task.ray.o.y, ray.org_z = task.ray.o.z;
    ray.dir_x = task.ray.d.x, ray.dir_y = task.ray.d.y, ray.dir_z = task.ray.d.z;
    ray.tnear = task.clear, ray.tfar = INFINITY, ray.time = 0;
    ray.mask = ~0u, ray.id = 0, ray.flags = 0;
    return ray;
}

bool EmbreeCurves::Intersect(const CurveTask &task, CurveHit *hit) const {
    EmbreeContext context;
    InitEmbreeContext(&context);
    RTCRayHit query;
    query.ray = MakeRay(task);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    EmbreeIntersect(scene_, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;
    *hit = {query.ray.tfar, query.hit.u, 0.5f + 0.5f * query.hit.v, query.hit.primID};
    return true;
}

bool EmbreeCurves::Occluded(const CurveTask &task) const {
    EmbreeContext context;
    InitEmbreeContext(&context);
    RTCRay ray = MakeRay(task);
    EmbreeOccluded(scene_, &context, &ray);
    return ray.tfar < 0;
}

// --- the truth ---------------------------------------------------------------------------------------------

namespace {

// A plain tree, halved by number, that finds every segment whose box a ray meets.
class OracleTree {
  public:
    explicit OracleTree(const std::vector<CurveSegment> &segments) : segments_(segments) {
        for (uint32_t i = 0; i < segments.size(); ++i) {
            boxes_.push_back(Curve(segments[i], CurveType::Flat).WorldBound());
            order_.push_back(i);
        }
        Build(0, static_cast<uint32_t>(order_.size()));
    }
    void Visit(const Ray &ray, std::vector<oracle::Candidate> *out) const { Visit(0, ray, out); }

  private:
    struct Node {
        Bounds3f box;
        uint32_t first, count, right; // count 0: an inner node, whose left child follows it
    };
    void Build(uint32_t first, uint32_t count) {
        const size_t self = nodes_.size();
        Bounds3f box;
        for (uint32_t i = first; i < first + count; ++i)
            box.Extend(boxes_[order_[i]]);
        box.pMin -= Vector3f(1e-5f, 1e-5f, 1e-5f), box.pMax += Vector3f(1e-5f, 1e-5f, 1e-5f);
        nodes_.push_back({box, first, count, 0});
        if (count <= 4)
            return;
        const Vector3f e = box.Diagonal();
        const int axis = e.x > e.y ? (e.x > e.z ? 0 : 2) : (e.y > e.z ? 1 : 2);
        const auto at = order_.begin() + first;
        std::nth_element(at, at + count / 2, at + count, [&](uint32_t a, uint32_t b) {
            return boxes_[a].Center()[axis] < boxes_[b].Center()[axis];
        });
        nodes_[self].count = 0;
        Build(first, count / 2);
        nodes_[self].right = static_cast<uint32_t>(nodes_.size());
        Build(first + count / 2, count - count / 2);
    }
    void Visit(uint32_t at, const Ray &ray, std::vector<oracle::Candidate> *out) const {
        const Node &n = nodes_[at];
        double in = 0, leave = 1e30;
        for (int c = 0; c < 3; ++c) {
            const double d = ray.d[c] == 0 ? 1e-30 : ray.d[c];
            const double a = (double(n.box.pMin[c]) - ray.o[c]) / d,
                         b = (double(n.box.pMax[c]) - ray.o[c]) / d;
            in = std::max(in, std::min(a, b)), leave = std::min(leave, std::max(a, b));
        }
        if (in > leave)
            return;
        for (uint32_t i = n.first; i < n.first + n.count; ++i)
            oracle::FindAll(segments_[order_[i]], order_[i], nullptr, ray, 5e-6L, 1e-5L, out);
        if (n.count == 0) {
            Visit(at + 1, ray, out);
            Visit(n.right, ray, out);
        }
    }

    const std::vector<CurveSegment> &segments_;
    std::vector<Bounds3f> boxes_;
    std::vector<uint32_t> order_;
    std::vector<Node> nodes_;
};

} // namespace

std::vector<CurveTruth> FindCurveTruths(const std::vector<CurveSegment> &segments,
                                        const std::vector<CurveTask> &tasks, size_t count) {
    const OracleTree tree(segments);
    std::vector<CurveTruth> truths;
    const size_t stride = std::max<size_t>(1, tasks.size() / count);
    for (size_t i = 0; i < tasks.size(); i += stride) {
        CurveTruth truth{tasks[i], {}};
        truth.task.bounce = false;
        truth.task.ray.tMin = truth.task.clear;
        std::vector<oracle::Candidate> all;
        tree.Visit(truth.task.ray, &all);
        bool border = false;
        for (const auto &c : all) {
            if (c.t <= truth.task.ray.tMin * 0.99999)
                continue;
            border |= c.margin < 1e-6L || c.u < 0 || c.u > 1 || c.t < truth.task.ray.tMin * 1.00001;
            if (!truth.nearest || c.t < truth.nearest->t)
                truth.nearest = c;
        }
        if (!border)
            truths.push_back(truth);
    }
    return truths;
}

double CurveAccuracy::Percentile(const std::vector<double> &rising, double share) {
    return rising.empty() ? 0 : rising[static_cast<size_t>(share * static_cast<double>(rising.size() - 1))];
}

CurveAccuracy CompareWithTruth(const std::vector<CurveSegment> &segments,
                               const std::vector<CurveTruth> &truths, bool eitherSide,
                               const std::function<bool(const CurveTask &, CurveHit *)> &intersect) {
    CurveAccuracy result;
    for (const CurveTruth &truth : truths) {
        ++result.rays;
        CurveHit hit;
        const bool found = intersect(truth.task, &hit);
        result.missed += truth.nearest && !found;
        result.invented += !truth.nearest && found;
        if (!truth.nearest || !found)
            continue;
        const oracle::Candidate &nearest = *truth.nearest;
        const auto &w = segments[nearest.segment].width;
        const double r = 0.5 * std::max(w[0], w[1]);
        const double tError = std::abs(static_cast<double>(nearest.t) - hit.t);
        // A joint belongs to two segments.
        const bool same =
            nearest.segment == hit.segment ||
            (std::abs(int64_t(nearest.segment) - int64_t(hit.segment)) == 1 && tError < 0.1 * r);
        result.otherHair += !same;
        if (!same)
            continue;
        const auto v = static_cast<double>(nearest.v);
        const double e = std::abs(v - hit.v);
        result.vError.push_back(eitherSide ? std::min(e, std::abs(1 - v - hit.v)) : e);
        result.tError.push_back(tError / r);
    }
    std::sort(result.vError.begin(), result.vError.end());
    std::sort(result.tError.begin(), result.tError.end());
    return result;
}

} // namespace cuticle
