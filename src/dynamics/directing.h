//> Direct hair to a wanted density
// A force that draws hair to where a target has it, without saying which hair goes where (Petrovic, Henne and
// Anderson 2005, section 5.2).
#pragma once

#include "core/vecmath.h"
#include "volume/grid.h"

#include <cstddef>
#include <span>
#include <vector>

namespace cuticle {

//> Choose how points make a density
// Tent: the paper's, over 8 vertices, whose derivative jumps at the walls of cells. Smooth: the quadratic
// B-spline over 27, whose derivative does not.
enum class DensityKernel { Smooth, Tent };
//<

//> Declare the force of equation 3
// E = 1/2 sum (Ds - Dt)^2 over a lattice, with the density Ds of the points (each counts 1) and the target's
// Dt.
class DensityTarget {
  public:
    // cell: cm, > 0. Points that are not finite are left out, here and below.
    DensityTarget(std::span<const Vector3d> target, double cell, DensityKernel kernel);
    double Energy(std::span<const Vector3d> points) const;
    // A point is drawn by -dE/dP (1/cm) and has a stiffness (1/cm^2): moved from here by small steps d at the
    // same time, points have an energy of at most E - sum force . d + 1/2 sum stiffness d^2.
    struct Pull {
        Vector3d force;
        double stiffness = 0;
    };
    std::vector<Pull> Pulls(std::span<const Vector3d> points) const;

  private:
    std::vector<double> Difference(std::span<const Vector3d> points) const; // Ds - Dt
    GridBox box_;
    DensityKernel kernel_;
    std::vector<double> target_;
};
//<

} // namespace cuticle
//<
