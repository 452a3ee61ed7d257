//> Define the scalp
#include "grooms/scalp.h"

#include "core/sampling.h"
#include "grooms/head_shape.h"
#include "grooms/lock_source.h"

#include <algorithm>

namespace cuticle {

namespace {

// The cranium's middle, from which directions to the scalp are measured.
constexpr Point3f kCranium{0, 2.6f, -0.8f};
constexpr Point3f kCrown{1.f, 10.6f, -4.8f};

} // namespace

//> Draw the hairline
float HairDensity(const Point3f &p) {
    // The hairline by azimuth from the face (degrees) and elevation seen from the cranium's middle: forehead,
    // temple, sideburn, above and behind the ear, nape.
    static constexpr float kLine[][2] = {
        {0, 35}, {18, 37.5f}, {36, 37.5f}, {52, 27},   {60, 12},   {66, -6},   {71, -20},  {75, -16},
        {79, 4}, {96, 7},     {108, 3},    {118, -16}, {130, -33}, {146, -44}, {162, -49}, {180, -50}};
    const Vector3f d = p - kCranium;
    const float azimuth = Degrees(std::atan2(std::abs(d.x), d.z));
    const float elevation = Degrees(std::atan2(d.y, std::sqrt(d.x * d.x + d.z * d.z)));
    size_t i = 0;
    while (i + 2 < std::size(kLine) && azimuth > kLine[i + 1][0])
        ++i;
    const float t = (azimuth - kLine[i][0]) / (kLine[i + 1][0] - kLine[i][0]);
    const float edge = Lerp(t, kLine[i][1], kLine[i + 1][1]);
    // No line, but a wavering edge a centimetre and a half wide
    const float side = d.x < 0 ? 2.f : 0.f;
    const float waver = 0.9f * std::sin(0.23f * azimuth + side) + 0.7f * std::sin(0.61f * azimuth + 3 * side);
    return SmoothStep(-2.5f, 7.5f, elevation - edge + waver);
}
//<

//> Find the skin along a direction
Point3f Scalp::SurfaceAlong(float azimuth, float cosine) const {
    const float sine = std::sqrt(std::max(0.f, 1 - cosine * cosine));
    const Vector3f d{sine * std::sin(azimuth), cosine, sine * std::cos(azimuth)};
    // The cranium is star-shaped seen from its middle: regula falsi between inside and outside, in the
    // Illinois way (an end that stays for two steps counts half).
    float inside = 5, outside = 13;
    float a = HeadDistance(kCranium + d * inside), b = HeadDistance(kCranium + d * outside);
    if (!(a < 0 && b > 0)) { // along the neck: no scalp there, any point of it will do
        return kCranium + d * outside;
    }
    int last = 0;
    float t = outside;
    for (int i = 0; i < 40; ++i) {
        t = inside + (outside - inside) * (a / (a - b));
        const float v = HeadDistance(kCranium + d * t);
        if (std::abs(v) < 2e-6f)
            break;
        const int end = v < 0 ? -1 : 1;
        (end < 0 ? inside : outside) = t;
        (end < 0 ? a : b) = v;
        if (end == last)
            (end < 0 ? b : a) *= 0.5f;
        last = end;
    }
    return kCranium + d * t;
}
//<

//> Tabulate where hair grows
Scalp::Scalp() {
    // Area times density of cells even in azimuth and in the cosine from straight up.
    std::vector<Point3f> corner((kAzimuth + 1) * (kHeight + 1));
    for (size_t j = 0; j <= kHeight; ++j)
        for (size_t i = 0; i <= kAzimuth; ++i)
            corner[j * (kAzimuth + 1) + i] =
                SurfaceAlong(2 * Pi * static_cast<float>(i) / kAzimuth - Pi,
                             1 - 2 * static_cast<float>(j) / static_cast<float>(kHeight));
    double total = 0;
    rowCdf_.assign(kHeight + 1, 0);
    columnCdf_.assign(kHeight * (kAzimuth + 1), 0);
    for (size_t j = 0; j < kHeight; ++j) {
        double row = 0;
        float *cdf = columnCdf_.data() + j * (kAzimuth + 1);
        for (size_t i = 0; i < kAzimuth; ++i) {
            //> Weigh a cell by its area, its hair and the crown
            const auto at = [&](size_t y, size_t x) { return corner[y * (kAzimuth + 1) + x]; };
            const Point3f a = at(j, i), b = at(j, i + 1), c = at(j + 1, i), d = at(j + 1, i + 1);
            const float area = (Cross(b - a, c - a).Length() + Cross(b - d, c - d).Length()) / 2;
            const Point3f middle = (a + b + c + d) * 0.25f;
            // Hair lies away from the crown on all sides and would leave it bare: it grows closer there.
            const float crown = 1 + 1.5f * std::exp((middle - kCrown).LengthSquared() * -0.125f);
            row += static_cast<double>(area * HairDensity(middle) * crown);
            //<
            cdf[i + 1] = static_cast<float>(row);
        }
        if (row > 0)
            for (size_t i = 0; i <= kAzimuth; ++i)
                cdf[i] /= static_cast<float>(row);
        total += row;
        rowCdf_[j + 1] = static_cast<float>(total);
    }
    area_ = static_cast<float>(total);
    for (float &v : rowCdf_)
        v /= area_;
}
//<

//> Pick a place on the scalp
ScalpPoint Scalp::Sample(float u, float v) const {
    const auto invert = [](const float *cdf, size_t n, float x) {
        const auto below = static_cast<size_t>(std::upper_bound(cdf, cdf + n + 1, x) - cdf);
        const size_t cell = std::min(below > 0 ? below - 1 : 0, n - 1);
        const float width = cdf[cell + 1] - cdf[cell];
        return std::pair(cell, width > 0 ? std::min((x - cdf[cell]) / width, 1.f) : 0.5f);
    };
    const auto [row, fv] = invert(rowCdf_.data(), kHeight, v);
    const auto [column, fu] = invert(columnCdf_.data() + row * (kAzimuth + 1), kAzimuth, u);
    ScalpPoint s;
    s.p = SurfaceAlong(2 * Pi * (static_cast<float>(column) + fu) / kAzimuth - Pi,
                       1 - 2 * (static_cast<float>(row) + fv) / static_cast<float>(kHeight));
    s.n = HeadNormal(s.p);
    s.density = HairDensity(s.p);
    return s;
}
//<

} // namespace cuticle
//<
