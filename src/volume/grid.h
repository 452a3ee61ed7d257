//> Declare dense grids and the tent
#pragma once

#include "core/error.h"
#include "core/vecmath.h"

#include <array>
#include <cstddef>
#include <vector>

namespace cuticle {

//> Place a lattice in space
// Places a lattice of vertices in space: vertex (i, j, k) lies at origin + cell (i, j, k). Its cells are
// cubes, one fewer to a side than there are vertices.
struct GridBox {
    using Vertex = std::array<size_t, 3>;
    Point3f origin;
    float cell = 1;       // side of a cell, > 0, in the units of the points
    Vertex size{0, 0, 0}; // vertices to a side; 2 or more where there are cells

    size_t Count() const { return size[0] * size[1] * size[2]; }
    size_t Index(size_t i, size_t j, size_t k) const { return (k * size[1] + j) * size[0] + i; }
    // Distance in memory from a vertex to the next along an axis.
    size_t Stride(size_t axis) const { return axis == 0 ? 1 : axis == 1 ? size[0] : size[0] * size[1]; }
    Point3f Position(size_t i, size_t j, size_t k) const {
        return origin + Vector3f{static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)} * cell;
    }
    // A point counted in cells from the origin.
    template <typename T>
    Vector3<T> InCells(const Point3f &p) const {
        return (Vector3<T>(p) - Vector3<T>(origin)) / static_cast<T>(cell);
    }
    bool operator==(const GridBox &) const = default;
};

// The largest number of vertices of a grid: 645 to a side of a cube, 1 GB of floats.
inline constexpr size_t kMaxGridVertices = size_t{1} << 28;

// The smallest lattice of this cell that holds the bounds and `margin` (>= 1) cells more on every side.
// Throws Error where the bounds are empty or not finite, the cell is not positive, or there would be more
// than kMaxGridVertices.
GridBox BoxAround(const Bounds3f &bounds, float cell, size_t margin);
//<

//> Weigh the corners of a cell by the tent
// The tent (Petrovic, Henne and Anderson 2005, equation 1): the cell that holds a point and what the point
// gives to each of its 8 corners, the product over the axes of 1 minus the distance along it. The weights are
// not negative and their sum is 1. They are also those of trilinear interpolation.
template <typename T>
struct TentWeights {
    GridBox::Vertex low{}; // the corner with the smallest coordinates
    std::array<T, 3> at{}; // where in the cell the point lies, 0 to 1 along each axis
    bool isInside = false; // whether such a cell exists; else all else is without meaning

    TentWeights() = default;
    // p: in cells, see InCells. A point on a wall belongs to the cell above it, on the last wall to the last
    // cell.
    TentWeights(const GridBox::Vertex &size, const Vector3<T> &p) {
        for (size_t axis = 0; axis < 3; ++axis) {
            const T end = static_cast<T>(size[axis]) - 1;
            if (!(p[axis] >= 0 && p[axis] <= end && end >= 1)) // also for NaN
                return;
            low[axis] = std::min(static_cast<size_t>(p[axis]), size[axis] - 2);
            at[axis] = p[axis] - static_cast<T>(low[axis]);
        }
        isInside = true;
    }
    // The weight of a corner, 0 to 7: bit 0 says whether it is the upper one along x, bit 1 along y, bit 2 z.
    T operator()(size_t corner) const { return Side(corner, 0) * Side(corner, 1) * Side(corner, 2); }
    // The derivative of that weight by the point, per cell. On a wall it is that of the cell above; from
    // there to the cell below it jumps.
    Vector3<T> Gradient(size_t corner) const {
        const T x = Side(corner, 0), y = Side(corner, 1), z = Side(corner, 2);
        return {Sign(corner, 0) * y * z, Sign(corner, 1) * x * z, Sign(corner, 2) * x * y};
    }
    size_t Index(const GridBox &box, size_t corner) const {
        return box.Index(low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2));
    }

  private:
    static bool IsUpper(size_t corner, size_t axis) { return (corner >> axis & 1) != 0; }
    T Side(size_t corner, size_t axis) const { return IsUpper(corner, axis) ? at[axis] : 1 - at[axis]; }
    static T Sign(size_t corner, size_t axis) { return IsUpper(corner, axis) ? T(1) : T(-1); }
};
//<

//> Keep a value at every vertex
// A value at every vertex of a lattice, x running fastest, then y.
template <typename T>
struct DenseGrid {
    GridBox box;
    std::vector<T> values;

    DenseGrid() = default;
    explicit DenseGrid(const GridBox &b, const T &value = {}) : box(b), values(b.Count(), value) {}
    T &At(size_t i, size_t j, size_t k) { return values[box.Index(i, j, k)]; }
    const T &At(size_t i, size_t j, size_t k) const { return values[box.Index(i, j, k)]; }
    size_t Bytes() const { return values.size() * sizeof(T); }

    // Trilinear interpolation; a point outside has the value of the nearest place inside.
    T Sample(const Point3f &p) const {
        const TentWeights<float> tent(box.size, Clamped(p));
        T sum{};
        for (size_t corner = 0; corner < 8; ++corner)
            sum += values[tent.Index(box, corner)] * tent(corner);
        return sum;
    }

  private:
    // In cells, brought into the box; a NaN becomes 0.
    Vector3f Clamped(const Point3f &p) const {
        Vector3f q = box.InCells<float>(p);
        for (size_t axis = 0; axis < 3; ++axis)
            q[axis] = q[axis] > 0 ? std::min(q[axis], static_cast<float>(box.size[axis] - 1)) : 0.f;
        return q;
    }
};

// Central differences at a vertex, one-sided at the walls: the gradient per unit of length.
Vector3f GradientAt(const DenseGrid<float> &grid, const GridBox::Vertex &at);
// The same anywhere: the gradients of the 8 vertices around, interpolated, so that it has no jumps.
Vector3f SampleGradient(const DenseGrid<float> &grid, const Point3f &p);
//<

} // namespace cuticle
//<
