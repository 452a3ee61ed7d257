//> Pull points to a density
#include "dynamics/directing.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

namespace {

// How far hair may move away from the target and still feel it.
constexpr size_t kMargin = 12;

//> Weigh the vertices around a point
// A vertex, the weight that a point gives to it, the derivative by the point (1/cm), and a bound of the
// second derivative in any direction (1/cm^2).
struct KernelVertex {
    size_t at;
    double weight;
    Vector3d gradient;
    double curvature;
};
struct KernelVertices {
    std::array<KernelVertex, 27> vertices;
    size_t count = 0; // 0: the point is outside
    std::span<const KernelVertex> All() const { return {vertices.data(), count}; }
    // Adds a vertex whose weight is the product of three numbers w, with their first and second derivatives
    // (per cell).
    void Add(size_t at, const Vector3d &w, const Vector3d &first, const Vector3d &second, double cell) {
        const double mixed = std::abs(first.x * first.y * w.z) + std::abs(first.x * w.y * first.z) +
                             std::abs(w.x * first.y * first.z);
        const double straight =
            std::abs(second.x) * w.y * w.z + w.x * std::abs(second.y) * w.z + w.x * w.y * std::abs(second.z);
        const Vector3d gradient{first.x * w.y * w.z, w.x * first.y * w.z, w.x * w.y * first.z};
        vertices[count++] = {at, w.x * w.y * w.z, gradient / cell, (straight + 2 * mixed) / (cell * cell)};
    }
};

KernelVertices VerticesAround(const GridBox &box, DensityKernel kernel, const Vector3d &p) {
    KernelVertices found;
    if (!IsWithinReach(Point3f(p)))
        return found;
    const auto cell = static_cast<double>(box.cell);
    const Vector3d q = (p - Vector3d(box.origin)) / cell;
    if (kernel == DensityKernel::Tent) {
        const TentWeights<double> tent(box.size, q);
        for (size_t corner = 0; tent.isInside && corner < 8; ++corner) {
            Vector3d w, first;
            for (size_t axis = 0; axis < 3; ++axis) {
                const bool isUpper = (corner >> axis & 1) != 0;
                w[axis] = isUpper ? tent.at[axis] : 1 - tent.at[axis];
                first[axis] = isUpper ? 1 : -1;
            }
            found.Add(tent.Index(box, corner), w, first, {}, cell);
        }
        return found;
    }
    //> Take three weights along each axis
    GridBox::Vertex nearest{};
    double w[3][3], slope[3][3];
    constexpr double bend[3] = {1, -2, 1};
    for (size_t axis = 0; axis < 3; ++axis) {
        const double rounded = std::floor(q[axis] + 0.5);
        if (!(rounded >= 1 && rounded + 2 <= static_cast<double>(box.size[axis])))
            return found;
        nearest[axis] = static_cast<size_t>(rounded);
        const double x = q[axis] - rounded; // -1/2 to 1/2
        w[axis][0] = 0.5 * Sqr(0.5 - x), w[axis][1] = 0.75 - x * x, w[axis][2] = 0.5 * Sqr(0.5 + x);
        slope[axis][0] = x - 0.5, slope[axis][1] = -2 * x, slope[axis][2] = x + 0.5;
    }
    //<
    for (size_t k = 0; k < 3; ++k)
        for (size_t j = 0; j < 3; ++j)
            for (size_t i = 0; i < 3; ++i)
                found.Add(box.Index(nearest[0] + i - 1, nearest[1] + j - 1, nearest[2] + k - 1),
                          {w[0][i], w[1][j], w[2][k]}, {slope[0][i], slope[1][j], slope[2][k]},
                          {bend[i], bend[j], bend[k]}, cell);
    return found;
}
//<

Bounds3f BoundsOfPoints(std::span<const Vector3d> points) {
    Bounds3f bounds;
    bounds.Extend(Point3f());
    for (const Vector3d &p : points)
        if (IsWithinReach(Point3f(p)))
            bounds.Extend(Point3f(p));
    return bounds;
}

} // namespace

//> Lay the target's density down
DensityTarget::DensityTarget(std::span<const Vector3d> target, double cell, DensityKernel kernel)
    : box_(BoxAround(BoundsOfPoints(target), static_cast<float>(cell), kMargin)), kernel_(kernel) {
    target_ = std::vector<double>(box_.Count());
    const std::vector<double> density = Difference(target);
    target_ = density;
}
std::vector<double> DensityTarget::Difference(std::span<const Vector3d> points) const {
    std::vector<double> difference(target_.size());
    std::transform(target_.begin(), target_.end(), difference.begin(), [](double d) { return -d; });
    for (const Vector3d &p : points) {
        const KernelVertices around = VerticesAround(box_, kernel_, p);
        for (const KernelVertex &v : around.All())
            difference[v.at] += v.weight;
    }
    return difference;
}
double DensityTarget::Energy(std::span<const Vector3d> points) const {
    double sum = 0;
    for (const double d : Difference(points))
        sum += d * d / 2;
    return sum;
}
//<

//> Pull against the difference, and know how stiffly
std::vector<DensityTarget::Pull> DensityTarget::Pulls(std::span<const Vector3d> points) const {
    const std::vector<double> difference = Difference(points);
    std::vector<double> slopes(difference.size()); // sums of |gradient| over all points
    for (const Vector3d &p : points) {
        const KernelVertices around = VerticesAround(box_, kernel_, p);
        for (const KernelVertex &v : around.All())
            slopes[v.at] += v.gradient.Length();
    }
    std::vector<Pull> pulls(points.size());
    for (size_t i = 0; i < points.size(); ++i) {
        const KernelVertices around = VerticesAround(box_, kernel_, points[i]);
        for (const KernelVertex &v : around.All()) {
            pulls[i].force -= v.gradient * difference[v.at];
            pulls[i].stiffness +=
                slopes[v.at] * v.gradient.Length() + std::abs(difference[v.at]) * v.curvature;
        }
    }
    return pulls;
}
//<

} // namespace cuticle
//<
