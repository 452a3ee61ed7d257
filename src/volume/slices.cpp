//> Define pictures of cuts through a distance
#include "volume/slices.h"

#include "core/check.h"
#include "core/parallel.h"

#include <algorithm>

namespace cuticle {

namespace {

//> Colour a distance
// s: the distance, in pixels; deepest: where the colour has faded. step: between lines, in pixels.
Spectrum ColorOfDistance(float s, float deepest, float step) {
    const Spectrum blue(0.03f, 0.12f, 0.6f), orange(0.95f, 0.35f, 0.04f), white(0.97f);
    const float faded = std::sqrt(std::min(std::abs(s) / deepest, 1.f));
    Spectrum color = (s < 0 ? blue : orange) * (1 - faded) + white * faded;
    // Lines, smoothed over a pixel
    const float toLine = std::abs(s / step - std::round(s / step)) * step;
    color *= 1 - 0.35f * std::clamp(1 - toLine, 0.f, 1.f);
    return color * std::clamp(std::abs(s) - 1, 0.f, 1.f);
}
//<

} // namespace

//> Cut the distance by a plane
SlicePicture CutDistance(const DenseGrid<float> &distance, const Point3f &at, size_t axis, size_t scale,
                         float step) {
    CHECK(axis < 3 && scale >= 1 && step > 0);
    const GridBox &box = distance.box;
    // The axis to the right, the one up, and whether they run against the picture
    const size_t right = axis == 0 ? 2 : 0, up = axis == 1 ? 2 : 1;
    const bool flipRight = axis == 0, flipUp = axis == 1;
    SlicePicture picture{(box.size[right] - 1) * scale, (box.size[up] - 1) * scale, {}};
    picture.colors.resize(picture.width * picture.height);
    const float pixel = box.cell / static_cast<float>(scale);
    float inner = 0, outer = 0;
    for (const float s : distance.values)
        inner = std::max(inner, -s / pixel), outer = std::max(outer, s / pixel);
    ParallelFor(picture.height, [&](size_t y) {
        for (size_t x = 0; x < picture.width; ++x) {
            const float r = (static_cast<float>(flipRight ? picture.width - 1 - x : x) + 0.5f) * pixel,
                        u = (static_cast<float>(flipUp ? y : picture.height - 1 - y) + 0.5f) * pixel;
            Point3f p = at;
            p[right] = box.origin[right] + r;
            p[up] = box.origin[up] + u;
            const float s = distance.Sample(p) / pixel;
            picture.colors[y * picture.width + x] = ColorOfDistance(s, s < 0 ? inner : outer, step / pixel);
        }
    });
    return picture;
}
//<

//> Put pictures beside each other
SlicePicture SideBySide(const std::vector<SlicePicture> &pictures, size_t gap) {
    SlicePicture all;
    for (const SlicePicture &p : pictures) {
        all.width += p.width + (all.width > 0 ? gap : 0);
        all.height = std::max(all.height, p.height);
    }
    all.colors.assign(all.width * all.height, Spectrum(1));
    size_t left = 0;
    for (const SlicePicture &p : pictures) {
        const size_t top = (all.height - p.height) / 2;
        for (size_t y = 0; y < p.height; ++y)
            std::copy_n(&p.colors[y * p.width], p.width, &all.colors[(top + y) * all.width + left]);
        left += p.width + gap;
    }
    return all;
}
//<

} // namespace cuticle
//<
