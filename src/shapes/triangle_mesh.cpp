#include "shapes/triangle_mesh.h"

#include "core/error.h"
#include "core/rounding.h"
#include "core/sampling.h"
#include "shapes/solid_set.h"

#include <cmath>
#include <optional>

namespace cuticle {

struct TracedMesh::Sampling {
    std::optional<Distribution1D> byArea; // none where there is no area
    double area = 0;
};

TracedMesh::TracedMesh(TriangleMesh mesh, bool flipNormals, MeshAlpha alpha)
    : mesh_(std::move(mesh)), flipNormals_(flipNormals), alpha_(std::move(alpha)) {
    if (mesh_.indices.size() % 3 != 0)
        throw Error("triangle mesh: {} indices, which is not a multiple of 3", mesh_.indices.size());
    if (!mesh_.n.empty() && mesh_.n.size() != mesh_.p.size())
        throw Error("triangle mesh: {} normals for {} vertices", mesh_.n.size(), mesh_.p.size());
    if (!mesh_.uv.empty() && mesh_.uv.size() != mesh_.p.size())
        throw Error("triangle mesh: {} texture coordinates for {} vertices", mesh_.uv.size(), mesh_.p.size());
    DropUselessTriangles();
    mesh_.p.reserve(mesh_.p.size() +
                    1); // Embree reads 16 bytes for each vertex of 12: one spare behind the last
}
TracedMesh::~TracedMesh() = default;

void TracedMesh::DropUselessTriangles() {
    TriangleMesh &m = mesh_;
    size_t outOfRange = 0, notFinite = 0, noArea = 0, kept = 0;
    const size_t triangles = m.indices.size() / 3;
    for (size_t i = 0; i < triangles; ++i) {
        const uint32_t v[3] = {m.indices[3 * i], m.indices[3 * i + 1], m.indices[3 * i + 2]};
        bool good = false;
        if (v[0] >= m.p.size() || v[1] >= m.p.size() || v[2] >= m.p.size()) {
            ++outOfRange;
        } else if (!IsWithinReach(m.p[v[0]]) || !IsWithinReach(m.p[v[1]]) || !IsWithinReach(m.p[v[2]])) {
            ++notFinite;
        } else {
            const Vector3d p0 = P(v[0]);
            good = Cross(P(v[1]) - p0, P(v[2]) - p0).LengthSquared() > 0;
            noArea += !good;
        }
        if (!good) {
            if (given_.empty())
                for (size_t j = 0; j < kept; ++j)
                    given_.push_back(static_cast<uint32_t>(j));
            continue;
        }
        if (kept != i) {
            given_.push_back(static_cast<uint32_t>(i));
            std::copy(v, v + 3, &m.indices[3 * kept]);
        }
        ++kept;
        for (const uint32_t vertex : v)
            bound_.Extend(m.p[vertex]);
    }
    if (kept == triangles)
        return;
    m.indices.resize(3 * kept);
    std::string why;
    const auto add = [&](size_t n, const char *text) {
        if (n > 0)
            why += fmt::format("{}{} {}", why.empty() ? "" : ", ", n, text);
    };
    add(outOfRange, "with an index out of range");
    add(notFinite, "with a vertex that is not finite");
    add(noArea, "without area");
    Warning("triangles dropped",
            fmt::format("triangle mesh: {} of {} triangles dropped ({})", triangles - kept, triangles, why));
}

size_t TracedMesh::MemoryBytes() const {
    return sizeof(TracedMesh) + mesh_.p.capacity() * sizeof(Point3f) + mesh_.n.capacity() * sizeof(Normal3f) +
           mesh_.uv.capacity() * sizeof(Point2f) +
           (mesh_.indices.capacity() + given_.capacity()) * sizeof(uint32_t);
}

// --- intersection ----------------------------------------------------------------------

TracedMesh::PlaneHit TracedMesh::IntersectPlane(size_t triangle, const Ray &ray) const {
    const uint32_t *v = Corners(triangle);
    const Vector3d p0 = P(v[0]), e1 = P(v[1]) - p0, e2 = P(v[2]) - p0;
    const Vector3d o(ray.o), d(ray.d), s = o - p0, n = Cross(e1, e2);
    const double det = -Dot(d, n);
    const Vector3d q = Cross(s, d);
    const double b1 = Dot(e2, q) / det, b2 = -Dot(e1, q) / det;
    // Embree decides who owns a point on an edge; here the point is only kept inside.
    const double inside1 = std::clamp(b1, 0., 1.), inside2 = std::clamp(b2, 0., 1. - inside1);
    return {Dot(s, n) / det, {1 - inside1 - inside2, inside1, inside2}};
}

bool TracedMesh::IsThere(size_t triangle, const Vector3d &b, bool shadow) const {
    if (!alpha_)
        return true;
    Vector2<double> corner[3];
    CornerUVs(triangle, corner);
    const Vector2<double> uv = corner[0] * b[0] + corner[1] * b[1] + corner[2] * b[2];
    return alpha_(Point3f(Point(triangle, b)), {static_cast<float>(uv.x), static_cast<float>(uv.y)}, shadow);
}

// --- the surface at a hit --------------------------------------------------------------

Vector3d TracedMesh::AreaNormal(size_t triangle) const {
    const uint32_t *v = Corners(triangle);
    const Vector3d p0 = P(v[0]);
    return Cross(P(v[1]) - p0, P(v[2]) - p0);
}
// Returns the interpolated vertex normal, or zero where there is none.
Vector3d TracedMesh::ShadingNormal(size_t triangle, const Vector3d &b) const {
    if (mesh_.n.empty())
        return {};
    const uint32_t *v = Corners(triangle);
    const Vector3d n =
        Vector3d(mesh_.n[v[0]]) * b[0] + Vector3d(mesh_.n[v[1]]) * b[1] + Vector3d(mesh_.n[v[2]]) * b[2];
    const double length = n.Length();
    return length > 0 && std::isfinite(length) ? n / length : Vector3d();
}
// Returns the geometric normal on the side of the shading normal ns, if there is one.
Vector3d TracedMesh::OrientedNormal(const Vector3d &areaNormal, const Vector3d &ns) const {
    const Vector3d n = Normalize(areaNormal);
    const double side = Dot(n, ns);
    return side != 0 ? (side < 0 ? -n : n) : (flipNormals_ ? -n : n);
}
void TracedMesh::CornerUVs(size_t triangle, Vector2<double> uv[3]) const {
    uv[0] = {0, 0}, uv[1] = {1, 0}, uv[2] = {1, 1};
    if (!mesh_.uv.empty())
        for (size_t i = 0; i < 3; ++i) {
            const Point2f &corner = mesh_.uv[Corners(triangle)[i]];
            uv[i] = {corner.x, corner.y};
        }
}

void TracedMesh::FillHit(size_t triangle, const Vector3d &b, SolidHit *hit) const {
    hit->primId = given_.empty() ? static_cast<uint32_t>(triangle) : given_[triangle];
    const uint32_t *v = Corners(triangle);
    const Vector3d p0 = P(v[0]), p1 = P(v[1]), p2 = P(v[2]);
    const Vector3d p = p0 * b[0] + p1 * b[1] + p2 * b[2];
    hit->p = Point3f(p);
    hit->pError = RoundingError(p);

    const Vector3d ns = ShadingNormal(triangle, b);
    hit->n = Normal3f(OrientedNormal(AreaNormal(triangle), ns));
    hit->ns = ns.LengthSquared() > 0 ? Normal3f(ns) : hit->n;

    Vector2<double> uv[3];
    CornerUVs(triangle, uv);
    const Vector2<double> uvHit = uv[0] * b[0] + uv[1] * b[1] + uv[2] * b[2];
    hit->uv = {static_cast<float>(uvHit.x), static_cast<float>(uvHit.y)};
    const Vector2<double> duv02 = uv[0] - uv[2], duv12 = uv[1] - uv[2];
    const Vector3d dp02 = p0 - p2, dp12 = p1 - p2;
    const double det = duv02.x * duv12.y - duv02.y * duv12.x;
    const Vector3d dpdu = (dp02 * duv12.y - dp12 * duv02.y) / det,
                   dpdv = (dp12 * duv02.x - dp02 * duv12.x) / det;
    hit->dpdu = Vector3f(dpdu);
    hit->dpdv = Vector3f(dpdv);
    if (!(Cross(dpdu, dpdv).LengthSquared() > 0) || !IsFinite(hit->dpdu) || !IsFinite(hit->dpdv))
        CoordinateSystem(hit->n, &hit->dpdu, &hit->dpdv);
}

// --- sampling --------------------------------------------------------------------------

const TracedMesh::Sampling &TracedMesh::GetSampling() const {
    std::call_once(samplingOnce_, [this] {
        auto sampling = std::make_unique<Sampling>();
        std::vector<float> areas(Triangles());
        for (size_t i = 0; i < areas.size(); ++i)
            sampling->area += areas[i] = TriangleArea(i);
        if (sampling->area > 0)
            sampling->byArea.emplace(areas.data(), areas.size());
        sampling_ = std::move(sampling);
    });
    return *sampling_;
}

double TracedMesh::Area() const { return GetSampling().area; }

bool TracedMesh::Sample(const Point2f &u, ShapeSample *sample, size_t *triangle, Vector3d *p) const {
    const Sampling &sampling = GetSampling();
    if (!sampling.byArea)
        return false;
    float u0;
    *triangle = sampling.byArea->SampleDiscrete(u.x, nullptr, &u0);
    const Point2f b = UniformSampleTriangle({u0, u.y});
    const Vector3d bary = {b.x, b.y, 1 - double(b.x) - double(b.y)};
    *p = Point(*triangle, bary);
    sample->p = Point3f(*p);
    sample->pError = RoundingError(*p);
    sample->n = Normal3f(OrientedNormal(AreaNormal(*triangle), ShadingNormal(*triangle, bary)));
    sample->pdf = sampling.byArea->DiscretePDF(*triangle) / TriangleArea(*triangle);
    return sample->pdf > 0 && std::isfinite(sample->pdf);
}
bool TracedMesh::Sample(const Point2f &u, ShapeSample *sample) const {
    size_t triangle;
    Vector3d p;
    return Sample(u, sample, &triangle, &p);
}

void TracedMesh::Normals(Vector3f *axis, float *angle) const {
    *axis = {0, 0, 1}, *angle = Pi;
    Vector3d mean;
    for (size_t i = 0; i < Triangles(); ++i)
        mean += AreaNormal(i);
    if (!mesh_.n.empty() || !(mean.LengthSquared() > 0))
        return;
    mean = OrientedNormal(mean, {});
    double cosine = 1;
    for (size_t i = 0; i < Triangles(); ++i)
        cosine = std::min(cosine, Dot(OrientedNormal(AreaNormal(i), {}), mean));
    *axis = Vector3f(mean);
    *angle = static_cast<float>(std::acos(std::clamp(cosine, -1., 1.)));
}

// Returns the height of ref above the plane of a triangle, on the side of AreaNormal; 0 where it is no more
// than what ref's rounded coordinates leave open.
double TracedMesh::HeightAbove(size_t triangle, const Point3f &ref) const {
    const Vector3d n = Normalize(AreaNormal(triangle)), world(ref);
    const double height = Dot(world - P(*Corners(triangle)), n);
    return std::abs(height) > Dot(Abs(n), Abs(world)) * 0x1p-23 ? height : 0;
}

bool TracedMesh::Sample(const Point3f &ref, const Point2f &u, ShapeSample *sample) const {
    size_t triangle;
    Vector3d p;
    if (!Sample(u, sample, &triangle, &p))
        return false;
    const double height = HeightAbove(triangle, ref);
    const bool turned = Dot(AreaNormal(triangle), Vector3d(sample->n)) < 0;
    sample->pdf = SolidAngleDensity(sample->pdf, p - Vector3d(ref), turned ? -height : height, sample);
    return sample->pdf > 0;
}

float TracedMesh::Pdf(const Point3f &ref, uint32_t given, const Point3f &p) const {
    const Sampling &sampling = GetSampling();
    size_t triangle = given;
    if (!given_.empty())
        triangle =
            static_cast<size_t>(std::lower_bound(given_.begin(), given_.end(), given) - given_.begin());
    if (!sampling.byArea || triangle >= Triangles())
        return 0;
    return SolidAngleDensity(sampling.byArea->DiscretePDF(triangle) / TriangleArea(triangle),
                             Vector3d(p) - Vector3d(ref), HeightAbove(triangle, ref), nullptr);
}

} // namespace cuticle
