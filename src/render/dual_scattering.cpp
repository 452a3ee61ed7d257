//> Define dual scattering
#include "render/dual_scattering.h"

#include "core/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

constexpr float kDark = 1e-4f; // less than this share of the light is nothing

//> Find places where each material of hair is met
using HairPlaces = std::map<const Material *, std::vector<SurfaceInteraction>>;

// Sends rays through the middles of curves spread over the scene, and keeps hairs that they meet.
HairPlaces FindHair(const Scene &scene) {
    constexpr size_t kRays = 4096, kPlaces = 1024;
    std::vector<Point3f> middles;
    size_t stride = std::max<size_t>(1, scene.Curves() / kRays), number = 0;
    scene.ForEachCurve([&](const CurveSegment &segment, const Transform *toWorld) {
        if (number++ % stride != 0)
            return;
        const Point3f p = (segment.cp[0] + segment.cp[1] * 3 + segment.cp[2] * 3 + segment.cp[3]) * 0.125f;
        middles.push_back(toWorld ? toWorld->Point(p) : p);
    });
    HairPlaces places;
    const Bounds3f bounds = scene.WorldBound();
    const float reach = bounds.IsEmpty() ? 0 : bounds.Diagonal().Length();
    RNG rng(7);
    RayCounts notOfThePicture;
    constexpr size_t kFewest = 256; // some curves hide behind others from most sides
    for (size_t k = 0; k < std::max(middles.size(), middles.empty() ? 0 : kFewest); ++k) {
        const Point3f &middle = middles[k % middles.size()];
        const float u = rng.UniformFloat(), v = rng.UniformFloat();
        const Vector3f d = UniformSampleSphere({u, v});
        const SceneRay ray{{.o = middle - d * reach, .d = d, .tMax = 2 * reach}, {}, false};
        WalkThroughHair(scene, ray, &notOfThePicture, [&](float, const SurfaceInteraction &si) {
            std::vector<SurfaceInteraction> &list = places[si.material];
            if (list.size() < kPlaces)
                list.push_back(si);
            else if (const size_t at = rng.UniformUInt32() % (4 * kPlaces); at < kPlaces)
                list[at] = si;
            return true;
        });
    }
    return places;
}
//<

float SineTo(const Frame &fiber, const Vector3f &w) { return std::clamp(Dot(fiber.x, w), -1.f, 1.f); }

// A normal distribution of angles, per radian.
float GaussianOf(float angle, float variance) {
    return std::exp(-0.5f * angle * angle / variance) / std::sqrt(2 * kPi<float> * variance);
}

} // namespace

//> Tabulate the hair of a scene
void DualScatteringIntegrator::Prepare(const Scene &scene, const Camera &camera) {
    Integrator::Prepare(scene, camera);
    const HairPlaces places = FindHair(scene);
    for (const auto &[material, list] : places)
        if (material)
            any_ = tables_.try_emplace(material, *material, list).first->second;
    if (settings_.count == Count::Grid)
        grid_ = CrossingGrid::Of(scene.WorldBound(), settings_.cell, [&](const CrossingGrid::UseCurve &use) {
            scene.ForEachCurve([&](const CurveSegment &segment, const Transform *toWorld) {
                std::array<Point3f, 4> p;
                for (size_t i = 0; i < p.size(); ++i)
                    p[i] = toWorld ? toWorld->Point(segment.cp[i]) : segment.cp[i];
                use(p, {segment.width[0], segment.width[1]});
            });
        });
}

std::string DualScatteringIntegrator::Learned() const {
    std::string text =
        fmt::format("the scattering of {} hair material{}", tables_.size(), tables_.size() == 1 ? "" : "s");
    if (grid_)
        text += fmt::format("; a grid of {} x {} x {}", grid_->Size()[0], grid_->Size()[1], grid_->Size()[2]);
    return text;
}

FiberAlbedo DualScatteringIntegrator::AlbedoOf(const Material *material, float sinTheta) const {
    const auto found = tables_.find(material);
    if (found != tables_.end())
        return found->second.At(sinTheta);
    return any_ ? any_->At(sinTheta) : FiberAlbedo{};
}
//<

//> Follow light through the hair before a place
DualScatteringIntegrator::Passage DualScatteringIntegrator::PassageOf(const SurfaceInteraction &si,
                                                                      const Vector3f &wi, float distance,
                                                                      const Scene &scene,
                                                                      RayCounts &counts) const {
    if (grid_)
        return PassageByGrid(si, wi, distance, scene, counts);
    Passage passage;
    Spectrum share(1);
    size_t hairs = 0;
    const float end = WalkThroughHair(
        scene, scene.SpawnRayTo(si, wi, distance), &counts, [&](float, const SurfaceInteraction &hair) {
            const FiberAlbedo a = AlbedoOf(hair.material, SineTo(hair.shading, wi));
            share *= a.forward.albedo;
            passage.variance += Sqr(a.forward.spread);
            ++hairs;
            return share.MaxComponentValue() > kDark;
        });
    if (end < Infinity || share.MaxComponentValue() <= kDark)
        return {0, Spectrum(0), 0};
    if (hairs == 0)
        return passage;
    passage.free = 0;
    passage.scattered = share * settings_.forwardDensity;
    return passage;
}
//<

//> Follow light through the density of hair
// Hairs lie at random here, so the number of crossings is Poisson's: with n of them in the mean, light meets
// none in exp(-n) of the cases, and what each lets pass of it, a, leaves exp(-n (1 - a)) in the mean.
DualScatteringIntegrator::Passage DualScatteringIntegrator::PassageByGrid(const SurfaceInteraction &si,
                                                                          const Vector3f &wi, float distance,
                                                                          const Scene &scene,
                                                                          RayCounts &counts) const {
    const SceneRay toLamp = scene.SpawnRayTo(si, wi, distance);
    ++counts.shadowRays;
    if (scene.OccludedBySolids(toLamp))
        return {0, Spectrum(0), 0};
    float t0 = 0, t1 = toLamp.ray.tMax;
    if (!grid_->Clip(si.p, wi, &t0, &t1))
        return {};
    const auto steps = static_cast<size_t>(std::ceil((t1 - t0) / (0.5f * grid_->Cell())));
    const float step = (t1 - t0) / static_cast<float>(steps);
    float met = 0, passed = 0, variance = 0;
    Spectrum lost;
    for (size_t k = 0; k < steps && met < 100; ++k) {
        // A hair's own share of the grid reaches two cells far, and it must not shade itself
        const float t =
            std::max(t0 + (static_cast<float>(k) + 0.5f) * step, si.isCurve ? 2 * grid_->Cell() : 0);
        const auto hair = grid_->At(si.p + wi * t, wi);
        if (hair.perLength == 0)
            continue;
        const float n = hair.perLength * step;
        const FiberHalf forward = any_->At(std::sqrt(hair.sineSquared)).forward;
        met += n, lost += (Spectrum(1) - forward.albedo) * n;
        passed += n * forward.albedo.y(), variance += n * forward.albedo.y() * Sqr(forward.spread);
    }
    Passage passage;
    passage.free = std::exp(-met);
    for (size_t c = 0; c < 3; ++c)
        passage.scattered.c[c] =
            settings_.forwardDensity * std::max(0.f, std::exp(-lost.c[c]) - passage.free);
    // Of light that meets hair at all: at least one crossing
    passage.variance = passed > 0 ? variance / -std::expm1(-passed) : 0;
    return passage;
}
//<

//> Scatter what arrives toward the viewer
// Light that was scattered forward comes from around the lamp: inclinations normal about the lamp's, azimuths
// anywhere in the half around it. One direction of these is drawn, and the fiber's own model asked.
Spectrum DualScatteringIntegrator::HairLight(const SurfaceInteraction &si, const BSDF &bsdf,
                                             const Vector3f &wi, const Passage &passage,
                                             const Point2f &u) const {
    const Frame &fiber = si.shading;
    const float sinI = SineTo(fiber, wi), sinO = SineTo(fiber, si.wo);
    const float thetaI = std::asin(sinI), thetaO = std::asin(sinO);
    const Vector3f across = wi - fiber.x * sinI, seen = si.wo - fiber.x * sinO;
    const float lengthI = across.Length();
    // Around the fiber from the lamp's azimuth
    const Vector3f y = lengthI > 1e-6f ? across * (1 / lengthI) : fiber.z, z = Cross(fiber.x, y);

    const FiberHalf back = MultipleBackscatter(AlbedoOf(si.material, 0.5f * (sinI - sinO)));
    const auto returned = [&](float variance) {
        const float angle = thetaI + thetaO - back.shift;
        const float g =
            GaussianOf(angle, variance + Sqr(back.spread) + 1e-6f) / std::max(0.05f, std::cos(thetaO));
        const bool isBehind = Dot(across, seen) < 0;
        const float around = settings_.returned == Return::Printed ? 2 / kPi<float>
                             : isBehind                            ? 0
                                                                   : 1 / kPi<float>;
        return back.albedo * (settings_.backwardDensity * around * g);
    };
    Spectrum L;
    float pdf;
    if (passage.free > 0)
        L += (bsdf.FCos(si.wo, wi, &pdf) + returned(0)) * passage.free;
    if (!passage.scattered.IsBlack()) {
        // Box and Muller's normal number; an angle beyond the axis is folded back
        const float normal = std::sqrt(-2 * std::log(1 - u.x)) * std::cos(2 * kPi<float> * u.y);
        float theta = thetaI + std::sqrt(passage.variance) * normal;
        theta = std::asin(std::sin(theta));
        const float turn = u.y * 4 - std::floor(u.y * 4); // what is left of the number
        const float phi = kPi<float> * (turn - 0.5f);
        const Vector3f from =
            fiber.x * std::sin(theta) + (y * std::cos(phi) + z * std::sin(phi)) * std::cos(theta);
        L += (bsdf.FCos(si.wo, from, &pdf) + returned(passage.variance)) * passage.scattered;
    }
    return L;
}
//<

//> Add up the light of all lamps, however it comes
Spectrum DualScatteringIntegrator::DirectLight(const SurfaceInteraction &si, const BSDF &bsdf,
                                               const Scene &scene, PixelSampler &sampler,
                                               RayCounts &counts) const {
    Spectrum L;
    for (int i = 0; i < scene.LightCount(); ++i) {
        const Light &lamp = scene.LightAt(static_cast<size_t>(i));
        for (int s = 0; s < lamp.Samples(); ++s) {
            LightSample light;
            const Point2f where = sampler.Get2D(), around = sampler.Get2D();
            if (!lamp.Sample_Li(si.p, where, &light) || !(light.pdf > 0) || light.L.IsBlack())
                continue;
            Spectrum f(1);
            float pdf;
            if (!bsdf.IsHair() && (f = bsdf.FCos(si.wo, light.wi, &pdf)).IsBlack())
                continue;
            const Passage passage = PassageOf(si, light.wi, light.distance, scene, counts);
            if (passage.free == 0 && passage.scattered.IsBlack())
                continue;
            if (bsdf.IsHair())
                f = HairLight(si, bsdf, light.wi, passage, around);
            else
                f *= Spectrum(passage.free) + passage.scattered;
            L += f * light.L * (1 / (light.pdf * static_cast<float>(lamp.Samples())));
        }
    }
    return L;
}
//<

} // namespace cuticle
//<
