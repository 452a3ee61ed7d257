//> Let hairs feel one another's motion
// Velocities of many strands on a lattice, smoothed there, and handed back: hair to hair friction at the cost
// of a grid (Petrovic, Henne and Anderson 2005, section 5.1).
#pragma once

#include "core/vecmath.h"
#include "volume/grid.h"

#include <cstddef>
#include <span>
#include <vector>

namespace cuticle {

//> Declare the grid of velocities
class VelocityGrid {
  public:
    // Spreads masses (>= 0) and momenta of points over a lattice of this cell (cm, > 0) by the tent. Points
    // that are not finite, or beyond what a lattice of kMaxVertices reaches, are left out.
    VelocityGrid(std::span<const Vector3d> points, std::span<const double> masses,
                 std::span<const Vector3d> velocities, double cell);
    // Mixes every vertex's velocity with those of its neighbours, so many times. Momentum stays, energy does
    // not grow.
    void Smooth(size_t passes);
    // The velocity at a point, by the tent; `otherwise` where no mass is.
    Vector3d At(const Vector3d &p, const Vector3d &otherwise) const;
    // Sums over the lattice of D V and of D |V|^2 / 2.
    Vector3d Momentum() const;
    double Energy() const;

    static constexpr size_t kMaxVertices = size_t{1} << 22;

  private:
    DenseGrid<double> mass_;
    DenseGrid<Vector3d> velocity_;
};
//<

} // namespace cuticle
//<
