//> Define how much hair a ray meets
#include "volume/crossing_grid.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

CrossingGrid CrossingGrid::Of(const Bounds3f &bounds, float cell,
                              const std::function<void(const UseCurve &use)> &forEachCurve) {
    Bounds3f hair;
    forEachCurve([&](const std::array<Point3f, 4> &p, const std::array<float, 2> &) {
        for (const Point3f &q : p)
            hair.Extend(q);
    });
    CrossingGrid grid;
    if (hair.IsEmpty() || bounds.IsEmpty())
        return grid;
    const Vector3f d = hair.Diagonal();
    const float side = cell > 0 ? cell : std::max({d.x, d.y, d.z}) / 96;
    if (!(side > 0))
        return grid;
    grid.moments_ = DenseGrid<Moments>(BoxAround(hair, side, 1));
    //> Give each short chord to the corners of the cell that holds its middle
    const GridBox &box = grid.moments_.box;
    const float perVolume = 1 / (side * side * side);
    forEachCurve([&](const std::array<Point3f, 4> &p, const std::array<float, 2> &widths) {
        const float length = (p[1] - p[0]).Length() + (p[2] - p[1]).Length() + (p[3] - p[2]).Length();
        const int chords = std::clamp(static_cast<int>(std::ceil(2 * length / side)), 2, 64);
        Point3f before = p[0];
        for (int k = 1; k <= chords; ++k) {
            const float u = static_cast<float>(k) / static_cast<float>(chords), v = 1 - u;
            const Point3f after =
                p[0] * (v * v * v) + p[1] * (3 * u * v * v) + p[2] * (3 * u * u * v) + p[3] * (u * u * u);
            const Vector3f chord = after - before;
            const float l = chord.Length();
            const TentWeights<float> tent(box.size, box.InCells<float>(before + chord * 0.5f));
            if (l > 0 && tent.isInside) {
                const Vector3f t = chord * (1 / l);
                const float area = l * Lerp(u, widths[0], widths[1]) * perVolume;
                const Moments m{{area * t.x * t.x, area * t.y * t.y, area * t.z * t.z, area * t.x * t.y,
                                 area * t.x * t.z, area * t.y * t.z}};
                for (size_t corner = 0; corner < 8; ++corner)
                    grid.moments_.values[tent.Index(box, corner)] += m * tent(corner);
            }
            before = after;
        }
    });
    //<
    return grid;
}

//> Count crossings from areas and directions
// A fiber that lies at an angle a to the ray shows it its area times sin a. The mean of sin a is taken as the
// root of the mean of its square, which is the mean itself where hairs lie alike.
CrossingGrid::Crossings CrossingGrid::At(const Point3f &p, const Vector3f &d) const {
    const Moments s = moments_.Sample(p);
    const float area = s.m[0] + s.m[1] + s.m[2];
    if (!(area > 0))
        return {};
    const float along = s.m[0] * d.x * d.x + s.m[1] * d.y * d.y + s.m[2] * d.z * d.z +
                        2 * (s.m[3] * d.x * d.y + s.m[4] * d.x * d.z + s.m[5] * d.y * d.z);
    const float sineSquared = std::clamp(along / area, 0.f, 1.f);
    return {area * std::sqrt(1 - sineSquared), sineSquared};
}
//<

bool CrossingGrid::Clip(const Point3f &p, const Vector3f &d, float *t0, float *t1) const {
    if (moments_.values.empty())
        return false;
    const GridBox &box = moments_.box;
    for (size_t axis = 0; axis < 3; ++axis) {
        const float low = box.origin[axis], high = low + box.cell * static_cast<float>(box.size[axis] - 1);
        float a = (low - p[axis]) / d[axis], b = (high - p[axis]) / d[axis];
        if (a > b)
            std::swap(a, b);
        // A ray along a wall divides 0 by 0; comparisons with NaN leave the ends as they are
        if (a > *t0)
            *t0 = a;
        if (b < *t1)
            *t1 = b;
    }
    return *t0 < *t1;
}

} // namespace cuticle
//<
