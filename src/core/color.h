// Colours are linear RGB (Rec. 709 primaries, D65 white, as pbrt-v3); here are they and the ways into them.
#pragma once

#include "core/vecmath.h"

#include <string>
#include <vector>

namespace cuticle {

// pbrt-v3's RGBSpectrum: three coefficients, componentwise arithmetic.
class RGBSpectrum {
  public:
    constexpr RGBSpectrum() = default;
    constexpr explicit RGBSpectrum(float v) : c{v, v, v} {}
    constexpr RGBSpectrum(float r, float g, float b) : c{r, g, b} {}
    static RGBSpectrum FromRGB(const float rgb[3]) { return {rgb[0], rgb[1], rgb[2]}; }

    constexpr float operator[](size_t i) const { return c[i]; }
    constexpr float &operator[](size_t i) { return c[i]; }
    constexpr RGBSpectrum operator+(const RGBSpectrum &b) const {
        return {c[0] + b[0], c[1] + b[1], c[2] + b[2]};
    }
    constexpr RGBSpectrum operator-(const RGBSpectrum &b) const {
        return {c[0] - b[0], c[1] - b[1], c[2] - b[2]};
    }
    constexpr RGBSpectrum operator*(const RGBSpectrum &b) const {
        return {c[0] * b[0], c[1] * b[1], c[2] * b[2]};
    }
    constexpr RGBSpectrum operator/(const RGBSpectrum &b) const {
        return {c[0] / b[0], c[1] / b[1], c[2] / b[2]};
    }
    constexpr RGBSpectrum operator*(float s) const { return {c[0] * s, c[1] * s, c[2] * s}; }
    constexpr RGBSpectrum operator/(float s) const { return {c[0] / s, c[1] / s, c[2] / s}; }
    constexpr RGBSpectrum operator-() const { return {-c[0], -c[1], -c[2]}; }
    constexpr RGBSpectrum &operator+=(const RGBSpectrum &b) { return *this = *this + b; }
    constexpr RGBSpectrum &operator*=(const RGBSpectrum &b) { return *this = *this * b; }
    constexpr RGBSpectrum &operator*=(float s) { return *this = *this * s; }
    constexpr RGBSpectrum &operator/=(float s) { return *this = *this / s; }
    constexpr bool operator==(const RGBSpectrum &) const = default;
    constexpr bool IsBlack() const { return c[0] == 0 && c[1] == 0 && c[2] == 0; }
    constexpr float MaxComponentValue() const { return std::max(c[0], std::max(c[1], c[2])); }
    // CIE Y of the linear colour.
    constexpr float y() const { return 0.212671f * c[0] + 0.715160f * c[1] + 0.072169f * c[2]; }
    bool HasNaNs() const { return std::isnan(c[0]) || std::isnan(c[1]) || std::isnan(c[2]); }
    bool IsFinite() const { return std::isfinite(c[0]) && std::isfinite(c[1]) && std::isfinite(c[2]); }
    constexpr RGBSpectrum Clamp(float low = 0, float high = Infinity) const {
        return {std::clamp(c[0], low, high), std::clamp(c[1], low, high), std::clamp(c[2], low, high)};
    }
    friend constexpr RGBSpectrum operator*(float s, const RGBSpectrum &b) { return b * s; }

    std::array<float, 3> c{};
};
using Spectrum = RGBSpectrum;
inline Spectrum Exp(const Spectrum &s) { return {std::exp(s[0]), std::exp(s[1]), std::exp(s[2])}; }
inline Spectrum Sqrt(const Spectrum &s) { return {std::sqrt(s[0]), std::sqrt(s[1]), std::sqrt(s[2])}; }
inline std::ostream &operator<<(std::ostream &os, const Spectrum &s) {
    return os << "[ " << s[0] << ", " << s[1] << ", " << s[2] << " ]";
}

// Convert CIE XYZ (Y = 1 for white of RGB (1,1,1)) to linear RGB, and back.
Spectrum XYZToRGB(const std::array<double, 3> &xyz);
std::array<double, 3> RGBToXYZ(const Spectrum &rgb);

// x-bar, y-bar, z-bar of the CIE 1931 2-degree observer; lambda in nm, 0 outside 360 to 830. Tabulated in
// steps of 5 nm, a cubic in between.
std::array<double, 3> MatchingFunction(double lambda);

// The standard illuminant D65, 100 at 560 nm; lambda in nm, 0 outside 380 to 780. Tabulated in steps of 10
// nm, linear in between (CIE 15).
double IlluminantD65(double lambda);

// CIE 1976 L*a*b* against the white of RGB (1,1,1), and the colour difference of two of them after CIEDE2000
// (Sharma, Wu and Dalal 2005), all weights 1: about 1 is just noticed.
std::array<double, 3> XYZToLab(const std::array<double, 3> &xyz);
double CIEDE2000(const std::array<double, 3> &lab1, const std::array<double, 3> &lab2);

// Integrates a sampled spectrum against the CIE 1931 2-degree observer, as pbrt-v3 does: XYZ divided by the
// integral of Y-bar, linear between samples, constant beyond the ends. lambda: nm, any order, same length as
// values; wavelengths and values must be finite and at least one (Error otherwise).
std::array<double, 3> XYZFromSamples(std::vector<double> lambda, std::vector<double> values);
Spectrum SpectrumFromSamples(std::vector<double> lambda, std::vector<double> values);

// Planck's law normalised to a maximum of 1 over wavelength, times scale (pbrt-v3's "blackbody"). kelvin > 0
// (Error otherwise).
Spectrum BlackbodyToRGB(double kelvin, double scale);

// The sRGB transfer function and its inverse; linear and encoded values nominally in [0, 1].
float LinearToSRGB(float v);
float SRGBToLinear(float v);

} // namespace cuticle
