#include "materials/noise.h"

#include "core/sampling.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace cuticle {

namespace {

// Perlin's permutation of 0 to 255.
constexpr std::array<uint8_t, 256> kPermutation = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,
    69,  142, 8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,
    94,  252, 219, 203, 117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136,
    171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166, 77,  146, 158, 231, 83,  111, 229, 122,
    60,  211, 133, 230, 220, 105, 92,  41,  55,  46,  245, 40,  244, 102, 143, 54,  65,  25,  63,  161,
    1,   216, 80,  73,  209, 76,  132, 187, 208, 89,  18,  169, 200, 196, 135, 130, 116, 188, 159, 86,
    164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250, 124, 123, 5,   202, 38,  147, 118, 126,
    255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,  182, 189, 28,  42,  223, 183, 170, 213,
    119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,   129, 22,  39,  253,
    19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,  242, 193,
    238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,
    181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,
    222, 114, 67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

static_assert(
    [] {
        std::array<bool, 256> seen{};
        for (const uint8_t p : kPermutation)
            seen[p] = true;
        for (const bool s : seen)
            if (!s)
                return false;
        return true;
    }(),
    "every number from 0 to 255, once");

uint32_t Permute(uint32_t i) { return kPermutation[i & 255]; }

// The gradient of a lattice point times the offset from it: one of the twelve vectors from a cube's centre
// to its edges, four of them twice so that the hash is a mask.
float Gradient(uint32_t hash, float dx, float dy, float dz) {
    const uint32_t h = hash & 15;
    const float u = h < 8 || h == 12 || h == 13 ? dx : dy;
    const float v = h < 4 || h == 12 || h == 13 ? dy : dz;
    return (h & 1 ? -u : u) + (h & 2 ? -v : v);
}

// 6 t^5 - 15 t^4 + 10 t^3, whose first and second derivatives vanish at 0 and 1.
float Fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

// One coordinate's lattice cell, modulo 256, and the place within it. The remainder is taken before the
// conversion to an integer, which a large coordinate would not fit.
struct LatticeCell {
    explicit LatticeCell(float x)
        : offset(x - std::floor(x)), weight(Fade(offset)),
          index(static_cast<uint32_t>(static_cast<int32_t>(std::fmod(std::floor(x), 256.f)) + 256)) {}
    float offset, weight;
    uint32_t index;
};

template <class Octave>
float SumOfOctaves(const Point3f &p, float omega, int octaves, const Octave &octave) {
    float sum = 0, lambda = 1, o = 1;
    for (int i = 0; i < octaves; ++i, lambda *= 1.99f, o *= omega)
        sum += o * octave(Noise(p * lambda));
    return sum;
}

} // namespace

float Noise(const Point3f &p) {
    if (!IsFinite(p))
        return std::numeric_limits<float>::quiet_NaN();
    const LatticeCell x(p.x), y(p.y), z(p.z);
    // Interpolate along x, then y, then z
    const auto edge = [&](uint32_t j, uint32_t k) {
        const auto corner = [&](uint32_t i) {
            return Gradient(Permute(Permute(Permute(x.index + i) + y.index + j) + z.index + k),
                            x.offset - static_cast<float>(i), y.offset - static_cast<float>(j),
                            z.offset - static_cast<float>(k));
        };
        return Lerp(x.weight, corner(0), corner(1));
    };
    const auto face = [&](uint32_t k) { return Lerp(y.weight, edge(0, k), edge(1, k)); };
    return Lerp(z.weight, face(0), face(1));
}

float FBm(const Point3f &p, float omega, int octaves) {
    return SumOfOctaves(p, omega, octaves, [](float noise) { return noise; });
}

float Turbulence(const Point3f &p, float omega, int octaves) {
    return SumOfOctaves(p, omega, octaves, [](float noise) { return std::abs(noise); }) +
           0.2f * std::pow(omega, static_cast<float>(octaves));
}

} // namespace cuticle
