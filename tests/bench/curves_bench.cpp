// Rays through a ball of hair: the curve set, the plain binary tree and Embree's curves, in one run.
//
// Rays per second are of one thread. "camera": primary rays; "bounce": random walks from hair to hair, as a path tracer
// of light hair makes them, the nearest hit or any hit. Accuracy is counted against an oracle in extended precision, on
// the same bounces for all, with the same start of the ray.
#include "core/sampling.h"
#include "shapes/curve_set.h"

#include "../shapes/curve_oracle.h"

#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>

namespace cuticle {
namespace {

constexpr size_t kSegmentsPerStrand = 8;
size_t Strands() {
    const char *s = std::getenv("CUTICLE_BENCH_STRANDS");
    return s ? static_cast<size_t>(std::atoll(s)) : 50000;
}

//  Strands grow outward from a sphere of half the ball's radius, bending at random; radius 0.6 to 2 thousandths.
std::vector<CurveSegment> Ball(size_t strands) {
    std::mt19937_64 engine(7);
    std::uniform_real_distribution<float> uniform;
    const auto direction = [&] { return UniformSampleSphere({uniform(engine), uniform(engine)}); };
    std::vector<CurveSegment> segments;
    segments.reserve(strands * kSegmentsPerStrand);
    for (size_t i = 0; i < strands; ++i) {
        Vector3f d = direction();
        Point3f p = d * 0.5f;
        std::vector<Point3f> points;
        for (size_t k = 0; k < kSegmentsPerStrand + 3; ++k) {
            points.push_back(p);
            p += d * (0.5f / kSegmentsPerStrand);
            d = Normalize(d + direction() * 0.45f);
        }
        const float width = 2e-3f * (0.6f + 1.4f * uniform(engine));
        AppendCurve(points.data(), points.size(), CurveBasis::BSpline, 3, width, 0.5f * width, 0, &segments);
    }
    return segments;
}

struct Task {
    Ray ray;
    bool bounce = false;
    CurveOrigin origin;
    float clear = 0; // where the ray is clear of the hair it leaves
};

struct World {
    std::vector<CurveSegment> segments = Ball(Strands());
    std::unique_ptr<CurveSet> set;
    std::unique_ptr<BinaryCurveBvh> binary;
    double setSeconds = 0, binarySeconds = 0;
    std::vector<Task> camera, bounce;

    World() {
        using Clock = std::chrono::steady_clock;
        const auto seconds = [](Clock::time_point from) {
            return std::chrono::duration<double>(Clock::now() - from).count();
        };
        CurveSetOptions options;
        if (const char *s = std::getenv("CUTICLE_BENCH_SPLIT"))
            options.split = std::atoi(s);
        auto from = Clock::now();
        set = std::make_unique<CurveSet>(segments, std::vector<CurveType>{CurveType::Flat},
                                         std::unordered_map<uint32_t, RibbonNormals>(), options);
        setSeconds = seconds(from);
        from = Clock::now();
        binary = std::make_unique<BinaryCurveBvh>(segments, std::vector<CurveType>{CurveType::Flat});
        binarySeconds = seconds(from);

        std::mt19937_64 engine(3);
        std::uniform_real_distribution<float> uniform;
        constexpr int n = 400;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                Task task;
                task.ray.o = {0, 0, -4};
                task.ray.d = Normalize(Vector3f((static_cast<float>(x) + uniform(engine)) / n - 0.5f,
                                                (static_cast<float>(y) + uniform(engine)) / n - 0.5f, 2));
                camera.push_back(task);
                if ((x + y) % 4 != 0)
                    continue;
                //  Walk from hair to hair.
                for (int depth = 0; depth < 8; ++depth) {
                    CurveHit hit;
                    if (!set->Intersect(task.ray, task.bounce ? &task.origin : nullptr, &hit))
                        break;
                    const CurveSurface s = set->Surface(task.ray, hit);
                    task.bounce = true;
                    task.ray = Ray();
                    task.ray.o = s.p;
                    task.ray.d = UniformSampleSphere({uniform(engine), uniform(engine)});
                    task.origin = {hit.segment, hit.u};
                    const float c = Dot(task.ray.d, s.tangent);
                    task.clear = 1.5f * 0.5f * s.width / std::sqrt(std::max(1 - c * c, 1e-6f));
                    bounce.push_back(task);
                }
            }
    }
    static World &Get() {
        static World world;
        return world;
    }
};

//  Embree's curves over the same segments.
struct EmbreeCurves {
    RTCDevice device = rtcNewDevice("threads=0");
    RTCScene scene = rtcNewScene(device);
    ssize_t bytes = 0;
    double seconds = 0;
    EmbreeCurves(RTCGeometryType type, float tessellation) {
        rtcSetDeviceMemoryMonitorFunction(
            device,
            [](void *self, ssize_t n, bool) {
                __atomic_add_fetch(&static_cast<EmbreeCurves *>(self)->bytes, n, __ATOMIC_RELAXED);
                return true;
            },
            this);
        const auto &segments = World::Get().segments;
        const auto from = std::chrono::steady_clock::now();
        RTCGeometry geometry = rtcNewGeometry(device, type);
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
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
        rtcCommitScene(scene);
        seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    }
    static RTCRay MakeRay(const Task &task) {
        RTCRay ray;
        ray.org_x = task.ray.o.x, ray.org_y = task.ray.o.y, ray.org_z = task.ray.o.z;
        ray.dir_x = task.ray.d.x, ray.dir_y = task.ray.d.y, ray.dir_z = task.ray.d.z;
        ray.tnear = task.clear, ray.tfar = INFINITY, ray.time = 0;
        ray.mask = ~0u, ray.id = 0, ray.flags = 0;
        return ray;
    }
    bool Intersect(const Task &task, CurveHit *hit) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit query;
        query.ray = MakeRay(task);
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
            return false;
        *hit = {query.ray.tfar, query.hit.u, 0.5f + 0.5f * query.hit.v, query.hit.primID};
        return true;
    }
    bool Occluded(const Task &task) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRay ray = MakeRay(task);
        rtcOccluded1(scene, &context, &ray);
        return ray.tfar < 0;
    }
    static const EmbreeCurves &Get(int which) {
        static const EmbreeCurves flat4(RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE, 4);
        static const EmbreeCurves flat16(RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE, 16);
        static const EmbreeCurves round(RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE, 0);
        return which == 0 ? flat4 : which == 1 ? flat16 : round;
    }
};

enum Who { Set, Binary, Flat4, Flat16, Round };
enum Kind { Camera, Closest, Any };
const char *const kWho[] = {"curve_set", "binary_recursive", "embree_flat4", "embree_flat16", "embree_round"};
const char *const kKind[] = {"camera", "bounce_closest", "bounce_any"};

bool Trace(Who who, Kind kind, const Task &task, CurveHit *hit) {
    const World &w = World::Get();
    const CurveOrigin *origin = task.bounce ? &task.origin : nullptr;
    if (who == Set)
        return kind == Any ? w.set->Occluded(task.ray, origin) : w.set->Intersect(task.ray, origin, hit);
    if (who == Binary)
        return kind == Any ? w.binary->Occluded(task.ray, origin)
                           : w.binary->Intersect(task.ray, origin, hit);
    const EmbreeCurves &e = EmbreeCurves::Get(who - Flat4);
    return kind == Any ? e.Occluded(task) : e.Intersect(task, hit);
}

void BM_Rays(benchmark::State &state, Who who, Kind kind) {
    const std::vector<Task> &tasks = kind == Camera ? World::Get().camera : World::Get().bounce;
    CurveHit hit;
    size_t i = 0, hits = 0, rays = 0;
    Trace(who, kind, tasks[0], &hit); // builds what is built on first use
    for (auto _ : state) {
        for (int k = 0; k < 1000; ++k) {
            hits += Trace(who, kind, tasks[i], &hit);
            i = i + 1 < tasks.size() ? i + 1 : 0;
        }
        rays += 1000;
    }
    benchmark::DoNotOptimize(hit);
    state.counters["Mrays/s"] =
        benchmark::Counter(static_cast<double>(rays) * 1e-6, benchmark::Counter::kIsRate);
    state.counters["hit%"] = 100 * static_cast<double>(hits) / static_cast<double>(rays);
}

//  Finds every segment whose box a ray meets: a plain tree, halved by number.
struct Reference {
    struct Node {
        Bounds3f box;
        uint32_t first, count, right;
    };
    std::vector<Node> nodes;
    std::vector<uint32_t> order;
    Reference() {
        const auto &segments = World::Get().segments;
        std::vector<Bounds3f> boxes;
        for (uint32_t i = 0; i < segments.size(); ++i) {
            boxes.push_back(Curve(segments[i], CurveType::Flat).WorldBound());
            order.push_back(i);
        }
        Build(boxes, 0, static_cast<uint32_t>(order.size()));
    }
    void Build(const std::vector<Bounds3f> &boxes, uint32_t first, uint32_t count) {
        const size_t self = nodes.size();
        Bounds3f box;
        for (uint32_t i = first; i < first + count; ++i)
            box.Extend(boxes[order[i]]);
        box.pMin -= Vector3f(1e-5f, 1e-5f, 1e-5f), box.pMax += Vector3f(1e-5f, 1e-5f, 1e-5f);
        nodes.push_back({box, first, count, 0});
        if (count <= 4)
            return;
        const Vector3f e = box.Diagonal();
        const int axis = e.x > e.y ? (e.x > e.z ? 0 : 2) : (e.y > e.z ? 1 : 2);
        const auto at = order.begin() + first;
        std::nth_element(at, at + count / 2, at + count, [&](uint32_t a, uint32_t b) {
            return boxes[a].Center()[axis] < boxes[b].Center()[axis];
        });
        nodes[self].count = 0;
        Build(boxes, first, count / 2);
        nodes[self].right = static_cast<uint32_t>(nodes.size());
        Build(boxes, first + count / 2, count - count / 2);
    }
    void Visit(uint32_t at, const Ray &ray, std::vector<oracle::Candidate> *out) const {
        const Node &n = nodes[at];
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
            oracle::FindAll(World::Get().segments[order[i]], order[i], nullptr, ray, 5e-6L, 1e-5L, out);
        if (n.count == 0) {
            Visit(at + 1, ray, out);
            Visit(n.right, ray, out);
        }
    }
};

//  Counts over the bounces, all with the same start of the ray and no origin.
void BM_Accuracy(benchmark::State &state, Who who) {
    static const Reference reference;
    const std::vector<Task> &bounces = World::Get().bounce;
    const size_t stride = std::max<size_t>(1, bounces.size() / 20000);
    size_t rays = 0, missed = 0, invented = 0, other = 0;
    std::vector<double> vError, tError;
    for (auto _ : state) {
        for (size_t i = 0; i < bounces.size(); i += stride) {
            Task task = bounces[i];
            task.bounce = false;
            task.ray.tMin = task.clear;
            std::vector<oracle::Candidate> all;
            reference.Visit(0, task.ray, &all);
            const oracle::Candidate *nearest = nullptr;
            bool border = false;
            for (const auto &c : all) {
                if (c.t <= task.ray.tMin * 0.99999)
                    continue;
                border |= c.margin < 1e-6L || c.u < 0 || c.u > 1 || c.t < task.ray.tMin * 1.00001;
                if (!nearest || c.t < nearest->t)
                    nearest = &c;
            }
            if (border)
                continue;
            ++rays;
            CurveHit hit;
            const bool found = Trace(who, Closest, task, &hit);
            missed += nearest && !found;
            invented += !nearest && found;
            if (!nearest || !found)
                continue;
            const auto &w = World::Get().segments[nearest->segment].width;
            const double r = 0.5 * std::max(w[0], w[1]);
            //  A joint belongs to two segments.
            const bool same = nearest->segment == hit.segment ||
                              (std::abs(int64_t(nearest->segment) - int64_t(hit.segment)) == 1 &&
                               std::abs(static_cast<double>(nearest->t) - hit.t) < 0.1 * r);
            other += !same;
            if (!same)
                continue;
            //  Embree's v may count from the other side.
            const double v = static_cast<double>(nearest->v), e = std::abs(v - hit.v);
            vError.push_back(who >= Flat4 ? std::min(e, std::abs(1 - v - hit.v)) : e);
            tError.push_back(std::abs(static_cast<double>(nearest->t) - hit.t) / r);
        }
    }
    const auto percentile = [](std::vector<double> &x, double p) {
        if (x.empty())
            return 0.;
        std::sort(x.begin(), x.end());
        return x[static_cast<size_t>(p * static_cast<double>(x.size() - 1))];
    };
    state.counters["rays"] = static_cast<double>(rays);
    state.counters["missed"] = static_cast<double>(missed);
    state.counters["invented"] = static_cast<double>(invented);
    state.counters["other_hair"] = static_cast<double>(other);
    state.counters["v_median"] = percentile(vError, 0.5);
    state.counters["v_p99"] = percentile(vError, 0.99);
    state.counters["t_p99_radii"] = percentile(tError, 0.99);
}

//  How often a bounce meets the hair that it leaves, by the reach of the test that should prevent it; and how often it
//  meets something else than with the default reach when the ray instead starts so many radii out.
void BM_SelfHits(benchmark::State &state, float reach, bool offset) {
    const World &w = World::Get();
    CurveSetOptions options;
    options.selfReach = reach;
    const CurveSet set(w.segments, {CurveType::Flat}, {}, options);
    const size_t stride = std::max<size_t>(1, w.bounce.size() / 100000);
    size_t rays = 0, own = 0, ownNear = 0, differs = 0;
    for (auto _ : state)
        for (size_t i = 0; i < w.bounce.size(); i += stride) {
            Task task = w.bounce[i];
            CurveHit hit, standard;
            const bool expected = w.set->Intersect(task.ray, &task.origin, &standard);
            if (offset)
                task.ray.tMin = task.clear / 1.5f * reach;
            const bool found = set.Intersect(task.ray, offset ? nullptr : &task.origin, &hit);
            ++rays;
            const bool same =
                found && hit.segment / kSegmentsPerStrand == task.origin.segment / kSegmentsPerStrand;
            own += same;
            ownNear += same && hit.t < 2 * task.clear;
            differs +=
                found != expected || (found && (hit.segment != standard.segment || hit.t != standard.t));
        }
    const double n = static_cast<double>(rays);
    state.counters["rays"] = n;
    state.counters["own_hair%"] = 100 * static_cast<double>(own) / n;
    state.counters["own_hair_near%"] = 100 * static_cast<double>(ownNear) / n;
    state.counters["differs%"] = 100 * static_cast<double>(differs) / n;
}

void BM_Memory(benchmark::State &state, Who who) {
    const World &w = World::Get();
    const double n = static_cast<double>(w.segments.size());
    for (auto _ : state) {
        const double bytes = who == Set ? static_cast<double>(w.set->MemoryBytes())
                             : who == Binary
                                 ? static_cast<double>(w.binary->MemoryBytes())
                                 : static_cast<double>(EmbreeCurves::Get(who - Flat4).bytes) + 60 * n;
        state.counters["bytes/curve"] = bytes / n;
        state.counters["build_s"] = who == Set      ? w.setSeconds
                                    : who == Binary ? w.binarySeconds
                                                    : EmbreeCurves::Get(who - Flat4).seconds;
    }
}

} // namespace
} // namespace cuticle

int main(int argc, char **argv) {
    using namespace cuticle;
    benchmark::Initialize(&argc, argv);
    std::printf("%zu strands of %zu segments; instruction set %s\n", Strands(), kSegmentsPerStrand,
                CurveSetIsa());
    for (const Kind kind : {Camera, Closest, Any})
        for (const Who who : {Set, Binary, Flat4, Flat16, Round})
            benchmark::RegisterBenchmark((std::string("rays/") + kKind[kind] + "/" + kWho[who]).c_str(),
                                         BM_Rays, who, kind);
    for (const Who who : {Set, Binary, Flat4, Flat16, Round}) {
        benchmark::RegisterBenchmark((std::string("memory/") + kWho[who]).c_str(), BM_Memory, who)
            ->Iterations(1);
        benchmark::RegisterBenchmark((std::string("accuracy/") + kWho[who]).c_str(), BM_Accuracy, who)
            ->Iterations(1);
    }
    for (const float reach : {0.f, 0.5f, 1.f, 1.5f, 3.f})
        benchmark::RegisterBenchmark(("self_hits/reach:" + std::to_string(reach).substr(0, 3)).c_str(),
                                     BM_SelfHits, reach, false)
            ->Iterations(1);
    for (const float radii : {0.2f, 1.5f, 4.f, 7.f})
        benchmark::RegisterBenchmark(("self_hits/offset_radii:" + std::to_string(radii).substr(0, 3)).c_str(),
                                     BM_SelfHits, radii, true)
            ->Iterations(1);
    benchmark::RunSpecifiedBenchmarks();
}
