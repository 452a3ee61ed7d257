//> Declare how strands become a density
#pragma once

#include "grooms/groom.h"
#include "volume/grid.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace cuticle {

//> Hand out strands one by one
// One strand as a run of points joined by straight lines, root to tip. widths: diameters, one per point, or
// empty where only lengths count.
struct StrandRun {
    std::vector<Point3f> points;
    std::vector<float> widths;
    void Clear() { points.clear(), widths.clear(); }
};

// Writes strand `i` into *run, which comes empty; is called from any thread, in any order.
using ReadStrand = std::function<void(size_t i, StrandRun *run)>;

// A set of strands, wherever they come from.
struct StrandSet {
    size_t count = 0;
    ReadStrand read;
};

// Strands handed in as arrays, which must outlive the set: strand i is the points [offsets[i], offsets[i +
// 1]). widths: one per point or empty.
StrandSet StrandsOf(std::span<const Point3f> points, std::span<const float> widths,
                    std::span<const uint32_t> offsets);
// The control points of a groom as they stand, joined straight. The groom must outlive the set and have no
// placements (WithoutPlacements).
StrandSet ControlPoints(const Groom &groom);
// The curves of a groom, each cubic piece as `chords` (>= 1) straight lines between points on it; the same
// conditions.
StrandSet CurvesOf(const Groom &groom, size_t chords = 4);
//<

//> Declare the two densities
// The paper's density (Petrovic, Henne and Anderson 2005, equation 1): each vertex gives 1 to the corners of
// its cell by the tent; the sum over the grid is the number of vertices. It changes when a strand is
// resampled.
DenseGrid<float> VertexDensity(const StrandSet &strands, const GridBox &box);

// Our density: the tent integrated along the strands, exactly. With widths it is the share of space that
// fibers fill (times the volume of a cell, the sum over the grid is their volume); without widths, length of
// fiber per unit of volume. It does not change when a strand is resampled.
DenseGrid<float> LineDensity(const StrandSet &strands, const GridBox &box);

// Smooths a field `passes` times, each time by the weights 1/4, 1/2, 1/4 along every axis; keeps its sum.
DenseGrid<float> Smoothed(DenseGrid<float> grid, size_t passes);

// The sum over the grid times the volume of a cell: what a density per unit of volume adds up to.
double Mass(const DenseGrid<float> &density);

// Bounds all points. Throws Error where one is not finite or beyond kMaxCoordinate.
Bounds3f BoundsOf(const StrandSet &strands);
// Length of all strands, and volume of all fibers (0 where they have no widths).
struct StrandTotals {
    size_t points = 0;
    double length = 0, volume = 0;
};
StrandTotals TotalsOf(const StrandSet &strands);
//<

} // namespace cuticle
//<
