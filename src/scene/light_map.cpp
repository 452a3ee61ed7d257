#include "scene/light_map.h"

#include "core/error.h"
#include "core/memory_budget.h"
#include "images/image.h"
#include "scene/light_makers.h"

namespace cuticle {

Point2f SphericalMapPoint(const Vector3f &w) {
    float phi = std::atan2(w.y, w.x);
    if (phi < 0)
        phi += 2 * Pi;
    const float theta = std::atan2(std::sqrt(w.x * w.x + w.y * w.y), w.z);
    return {std::min(phi * (0.5f / Pi), OneMinusEpsilon), std::min(theta * (1 / Pi), OneMinusEpsilon)};
}

LightMap::LightMap(const ParamSet &params, const Spectrum &scale, Border border) : border_(border) {
    const std::string filename = params.FindFilename("mapname");
    if (filename.empty()) {
        texels_.assign(1, scale);
        return;
    }
    const FileLoc &loc = params.Find("mapname")->loc;
    Image image;
    try {
        const PlaceScope here(loc);
        image = ReadImage(filename, false);
    } catch (const Error &e) {
        Error(e).WithPbrtInstead("the light has no map").GoOnAsPbrt("light without its map");
        texels_.assign(1, scale);
        return;
    }
    constexpr int kMaxSize = 1 << 20;
    if (image.width < 1 || image.height < 1 || image.width > kMaxSize || image.height > kMaxSize)
        throw Error(loc, "{}: {} x {} pixels are no map of a light", filename, image.width, image.height);
    width_ = static_cast<size_t>(image.width), height_ = static_cast<size_t>(image.height);
    ClaimMemory(fmt::format("the light's map of {} x {}", width_, height_),
                width_ * height_ * (sizeof(Spectrum) + 2 * sizeof(float)),
                loc); // with the table to sample it
    texels_.reserve(width_ * height_);
    size_t bad = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            Spectrum s = image.RGB(x, y) * scale;
            for (float &v : s.c)
                if (!(v >= 0 && v <= kMaxLightValue)) {
                    v = 0;
                    ++bad;
                }
            texels_.push_back(s);
        }
    if (bad > 0)
        Warning(loc, "map values out of range",
                fmt::format("{}: {} values are negative, NaN, infinite or above 1e18, and set to 0", filename,
                            bad));
}

Spectrum LightMap::MeanOverSphere() const {
    // Between the centres of two rows at theta0 and theta1 their weights are linear; times sin theta,
    // integrated.
    const double step = kPi<double> / static_cast<double>(height_);
    std::vector<double> weight(height_, 0);
    weight.front() += 1 - std::cos(step / 2);
    weight.back() += 1 - std::cos(step / 2);
    for (size_t j = 0; j + 1 < height_; ++j) {
        const double theta0 = step * (static_cast<double>(j) + 0.5), theta1 = theta0 + step;
        const double slope = (std::sin(theta1) - std::sin(theta0)) / step;
        weight[j] += std::cos(theta0) - slope;
        weight[j + 1] += slope - std::cos(theta1);
    }
    Vector3d total;
    for (size_t y = 0; y < height_; ++y)
        for (size_t x = 0; x < width_; ++x)
            for (int c = 0; c < 3; ++c)
                total[c] += weight[y] * double{Texel(x, y)[c]};
    const auto mean = [&](double sum) {
        return static_cast<float>(sum / (2. * static_cast<double>(width_)));
    };
    return {mean(total.x), mean(total.y), mean(total.z)};
}

} // namespace cuticle
