//> Declare how much hair a ray meets
#pragma once

#include "volume/grid.h"

#include <functional>

namespace cuticle {

// How much hair there is in each place and how it lies: the area of fibers, seen from the side, per volume,
// and the second moments of their directions. From this the mean number of crossings along any ray follows.
class CrossingGrid {
  public:
    // One cubic piece: its control points, and its widths at both ends.
    using UseCurve = std::function<void(const std::array<Point3f, 4> &p, const std::array<float, 2> &widths)>;
    // cell: side of a cell; 0: 1/96 of the longest side of the hair. bounds: of all of it.
    static CrossingGrid Of(const Bounds3f &bounds, float cell,
                           const std::function<void(const UseCurve &use)> &forEachCurve);

    // Hair along a short way: crossings per length, and the mean square of the sine of the ray's inclination
    // to the fibers, weighted by crossings.
    struct Crossings {
        float perLength = 0, sineSquared = 0;
    };
    Crossings At(const Point3f &p, const Vector3f &direction) const;
    const GridBox::Vertex &Size() const { return moments_.box.size; }
    float Cell() const { return moments_.box.cell; }
    // Cuts the range *t0 to *t1 of the ray p + t d to what is in the grid; false: nothing is.
    bool Clip(const Point3f &p, const Vector3f &d, float *t0, float *t1) const;

  private:
    // Area per volume, times xx, yy, zz, xy, xz, yz of the direction; their trace is the area itself.
    struct Moments {
        std::array<float, 6> m{};
        Moments operator*(float s) const {
            Moments r = *this;
            for (float &v : r.m)
                v *= s;
            return r;
        }
        Moments &operator+=(const Moments &o) {
            for (size_t i = 0; i < m.size(); ++i)
                m[i] += o.m[i];
            return *this;
        }
    };
    DenseGrid<Moments> moments_;
};

} // namespace cuticle
//<
