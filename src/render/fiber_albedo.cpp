//> Define the mean scattering of a fiber
#include "render/fiber_albedo.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

constexpr size_t kNodes = 33;
constexpr size_t kSamplesOfNode = 16384;

//> Sum up one half of what a fiber scatters
class HalfSum {
  public:
    void Add(const Spectrum &weight, float angle) {
        albedo_ += weight;
        const double y = std::max(0.f, weight.y());
        weight_ += y, first_ += y * angle, second_ += y * angle * angle;
    }
    FiberHalf Mean(size_t samples) const {
        FiberHalf half;
        half.albedo = albedo_ * (1 / static_cast<float>(samples));
        if (weight_ > 0) {
            const double mean = first_ / weight_;
            half.shift = static_cast<float>(mean);
            half.spread = static_cast<float>(std::sqrt(std::max(0., second_ / weight_ - mean * mean)));
        }
        return half;
    }

  private:
    Spectrum albedo_;
    double weight_ = 0, first_ = 0, second_ = 0;
};
//<

//> Let light meet a fiber at all offsets
// Offsets, azimuths and the model's own four numbers are multiples of powers of one number, the root of
// x^7 = x + 1: such multiples fill a cube evenly.
FiberAlbedo AlbedoAt(const Material &material, std::span<const SurfaceInteraction> places, float theta) {
    HalfSum forward, backward;
    constexpr double kRoot = 1.1127756842787055;
    for (size_t k = 0; k < kSamplesOfNode; ++k) {
        std::array<float, 6> v;
        double power = 1;
        for (float &x : v) {
            power /= kRoot;
            const double turns = 0.5 + static_cast<double>(k + 1) * power;
            x = std::min(static_cast<float>(turns - std::floor(turns)), OneMinusEpsilon);
        }
        SurfaceInteraction si = places[k % places.size()];
        si.uv.y = v[0];
        const float azimuth = 2 * kPi<float> * v[1];
        si.shading = Frame{};
        si.n = Normal3f(0, 0, 1);
        si.wo = {std::sin(theta), std::cos(theta) * std::cos(azimuth), std::cos(theta) * std::sin(azimuth)};
        BSDF bsdf;
        bsdf.SetFrame(si.shading, si.n);
        material.MakeBSDF(si, &bsdf);
        BSDFSample sample;
        Spectrum weight;
        if (!bsdf.Sample_f(si.wo, {v[2], v[3], v[4], v[5]}, &sample, &weight))
            continue;
        const float angle = theta + std::asin(std::clamp(sample.wi.x, -1.f, 1.f));
        const bool isForward = si.wo.y * sample.wi.y + si.wo.z * sample.wi.z < 0;
        (isForward ? forward : backward).Add(weight, angle);
    }
    return {forward.Mean(kSamplesOfNode), backward.Mean(kSamplesOfNode)};
}
//<

FiberHalf Between(const FiberHalf &a, const FiberHalf &b, float t) {
    return {a.albedo * (1 - t) + b.albedo * t, Lerp(t, a.shift, b.shift), Lerp(t, a.spread, b.spread)};
}

float ThetaOfNode(size_t i) {
    // The ends stay off the axis, where nothing is scattered
    return 0.98f * kPi<float> * (static_cast<float>(i) / (kNodes - 1) - 0.5f);
}

} // namespace

FiberAlbedoTable::FiberAlbedoTable(const Material &material, std::span<const SurfaceInteraction> places)
    : nodes_(kNodes) {
    ParallelFor(kNodes, [&](size_t i) { nodes_[i] = AlbedoAt(material, places, ThetaOfNode(i)); });
}

FiberAlbedo FiberAlbedoTable::At(float sinTheta) const {
    const float theta = std::asin(std::clamp(sinTheta, -1.f, 1.f));
    const float x = std::clamp((theta / (0.98f * kPi<float>)+0.5f) * (kNodes - 1), 0.f, kNodes - 1.001f);
    const auto i = static_cast<size_t>(x);
    const float t = x - static_cast<float>(i);
    return {Between(nodes_[i].forward, nodes_[i + 1].forward, t),
            Between(nodes_[i].backward, nodes_[i + 1].backward, t)};
}

//> Sum up what is scattered back between fibers
// A1: backward once, after i fibers forward and past the same number on the way out; A3: backward three
// times. White fibers between which nothing is lost would return infinitely much: the sum is brought to what
// a fiber lets pass at most.
FiberHalf MultipleBackscatter(const FiberAlbedo &albedo) {
    FiberHalf back;
    const FiberHalf &f = albedo.forward, &b = albedo.backward;
    for (size_t c = 0; c < 3; ++c) {
        const float af = std::min(f.albedo.c[c], 0.999f), ab = b.albedo.c[c], s = af * af;
        const float one = ab * s / (1 - s), three = ab * ab * ab * s / ((1 - s) * (1 - s) * (1 - s));
        back.albedo.c[c] = one + three;
    }
    const float af = std::min(f.albedo.y(), 0.999f), ab = b.albedo.y(), rest = 1 - af * af;
    back.shift = b.shift * (1 - 2 * ab * ab / (rest * rest)) +
                 f.shift * (2 * rest * rest + 4 * af * af * ab * ab) / (rest * rest * rest);
    const float vf = f.spread * f.spread, vb = b.spread * b.spread, ab3 = ab * ab * ab;
    const float below = ab + ab3 * (2 * f.spread + 3 * b.spread);
    if (below > 0)
        back.spread =
            (1 + 0.7f * af * af) * (ab * std::sqrt(2 * vf + vb) + ab3 * std::sqrt(2 * vf + 3 * vb)) / below;
    return back;
}
//<

} // namespace cuticle
//<
