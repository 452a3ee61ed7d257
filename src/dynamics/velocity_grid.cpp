//> Smooth velocities on a lattice
#include "dynamics/velocity_grid.h"

#include "core/check.h"
#include "core/parallel.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

//> Fit a lattice to the points
// Around the middle of the points, where these are too far apart for kMaxVertices.
GridBox FittingBox(std::span<const Vector3d> points, double cell) {
    Bounds3f bounds;
    for (const Vector3d &p : points)
        if (IsWithinReach(Point3f(p)))
            bounds.Extend(Point3f(p));
    if (bounds.IsEmpty())
        bounds.Extend(Point3f());
    const auto reach =
        static_cast<float>(0.5 * cell * (std::cbrt(static_cast<double>(VelocityGrid::kMaxVertices)) - 6));
    const Vector3f half = Min(bounds.Diagonal() * 0.5f, Vector3f{reach, reach, reach});
    const Point3f middle = bounds.Center();
    return BoxAround({middle - half, middle + half}, static_cast<float>(cell), 1);
}
//<

// A point counted in cells, in full precision.
Vector3d InCells(const GridBox &box, const Vector3d &p) {
    return (p - Vector3d(box.origin)) / static_cast<double>(box.cell);
}

} // namespace

//> Spread momentum over the lattice
VelocityGrid::VelocityGrid(std::span<const Vector3d> points, std::span<const double> masses,
                           std::span<const Vector3d> velocities, double cell)
    : mass_(FittingBox(points, cell)), velocity_(mass_.box) {
    CHECK(points.size() == masses.size() && points.size() == velocities.size());
    for (size_t i = 0; i < points.size(); ++i) {
        if (!IsWithinReach(Point3f(points[i])) || !std::isfinite(velocities[i].LengthSquared()))
            continue;
        const TentWeights<double> tent(mass_.box.size, InCells(mass_.box, points[i]));
        if (!tent.isInside)
            continue;
        for (size_t corner = 0; corner < 8; ++corner) {
            const size_t at = tent.Index(mass_.box, corner);
            const double m = masses[i] * tent(corner);
            mass_.values[at] += m;
            velocity_.values[at] += velocities[i] * m;
        }
    }
    for (size_t at = 0; at < mass_.values.size(); ++at)
        if (mass_.values[at] > 0)
            velocity_.values[at] = velocity_.values[at] / mass_.values[at];
}
//<

//> Mix velocities through the faces of cells
void VelocityGrid::Smooth(size_t passes) {
    const GridBox &box = mass_.box;
    DenseGrid<Vector3d> mixed(box);
    for (size_t pass = 0; pass < passes; ++pass) {
        ParallelForRange(box.size[2], 1, [&](size_t first, size_t last) {
            for (size_t k = first; k < last; ++k)
                for (size_t j = 0; j < box.size[1]; ++j)
                    for (size_t i = 0; i < box.size[0]; ++i) {
                        const size_t at = box.Index(i, j, k);
                        const double mass = mass_.values[at];
                        Vector3d v = velocity_.values[at], flow;
                        const GridBox::Vertex vertex{i, j, k};
                        for (size_t axis = 0; axis < 3 && mass > 0; ++axis) {
                            const size_t stride = box.Stride(axis);
                            if (vertex[axis] > 0)
                                flow += (velocity_.values[at - stride] - v) *
                                        std::min(mass, mass_.values[at - stride]);
                            if (vertex[axis] + 1 < box.size[axis])
                                flow += (velocity_.values[at + stride] - v) *
                                        std::min(mass, mass_.values[at + stride]);
                        }
                        mixed.values[at] = mass > 0 ? v + flow / (6 * mass) : v;
                    }
        });
        std::swap(mixed.values, velocity_.values);
    }
}
//<

//> Ask for the velocity of the hair around a point
Vector3d VelocityGrid::At(const Vector3d &p, const Vector3d &otherwise) const {
    if (!IsWithinReach(Point3f(p)))
        return otherwise;
    const TentWeights<double> tent(mass_.box.size, InCells(mass_.box, p));
    if (!tent.isInside)
        return otherwise;
    Vector3d sum;
    double weight = 0;
    for (size_t corner = 0; corner < 8; ++corner) {
        const size_t at = tent.Index(mass_.box, corner);
        if (mass_.values[at] > 0) {
            sum += velocity_.values[at] * tent(corner);
            weight += tent(corner);
        }
    }
    return weight > 0 ? sum / weight : otherwise;
}
//<

//> Sum up momentum and energy of the grid
Vector3d VelocityGrid::Momentum() const {
    Vector3d sum;
    for (size_t at = 0; at < mass_.values.size(); ++at)
        sum += velocity_.values[at] * mass_.values[at];
    return sum;
}
double VelocityGrid::Energy() const {
    double sum = 0;
    for (size_t at = 0; at < mass_.values.size(); ++at)
        sum += 0.5 * mass_.values[at] * velocity_.values[at].LengthSquared();
    return sum;
}
//<

} // namespace cuticle
//<
