//> Define direct light on hair
#include "render/hair_light.h"

#include "core/memory_budget.h"
#include "core/rounding.h"
#include "volume/density.h"
#include "volume/normals.h"

#include <fmt/format.h>

#include <algorithm>

namespace cuticle {

namespace {

//> Make the shell of all hair of a scene
// All curves of a scene as strands of their own, each a run of straight lines.
struct SceneStrands {
    std::vector<Point3f> points;
    std::vector<float> widths;
    std::vector<uint32_t> offsets{0};

    explicit SceneStrands(const Scene &scene) {
        scene.ForEachCurve([&](const CurveSegment &segment, const Transform *toWorld) {
            constexpr size_t kChords = 3;
            for (size_t k = 0; k <= kChords; ++k) {
                const float u = static_cast<float>(k) / kChords, v = 1 - u;
                const Point3f p = segment.cp[0] * (v * v * v) + segment.cp[1] * (3 * u * v * v) +
                                  segment.cp[2] * (3 * u * u * v) + segment.cp[3] * (u * u * u);
                points.push_back(toWorld ? toWorld->Point(p) : p);
                widths.push_back(Lerp(u, segment.width[0], segment.width[1]));
            }
            offsets.push_back(static_cast<uint32_t>(points.size()));
        });
    }
};

// None where there is no hair.
std::optional<HairShell> ShellOf(const Scene &scene, float cell) {
    const SceneStrands all(scene);
    if (all.points.empty())
        return {};
    const StrandSet strands = StrandsOf(all.points, all.widths, all.offsets);
    const Bounds3f bounds = BoundsOf(strands);
    const Vector3f d = bounds.Diagonal();
    const float side = cell > 0 ? cell : std::max({d.x, d.y, d.z}) / 96;
    constexpr size_t kSmoothing = 2;
    const DenseGrid<float> density =
        Smoothed(LineDensity(strands, BoxAround(bounds, side, kSmoothing + 3)), kSmoothing);
    return MakeShell(density, MedianDensity(density) / 2);
}
//<

} // namespace

//> Hold light against the normal of the shell
float HairLightIntegrator::ShellFactor(const Point3f &p, const Vector3f &wi) const {
    if (!shell_)
        return 1;
    const Normal3f n = ShellNormal(shell_->distance, p);
    if (n.LengthSquared() == 0)
        return 1;
    return std::max(0.f, (Dot(n, wi) + settings_.wrap) / (1 + settings_.wrap));
}
//<

//> Let light through hair, crossing by crossing
float HairLightIntegrator::Traced(const SurfaceInteraction &si, const Vector3f &wi, float distance,
                                  const Scene &scene, RayCounts &counts) const {
    constexpr float kDark = 1e-4f; // less than this is nothing
    float share = 1;
    const float end = WalkThroughHair(scene, scene.SpawnRayTo(si, wi, distance), &counts,
                                      [&](float, const SurfaceInteraction &) {
                                          share *= 1 - settings_.map.opacity;
                                          return share > kDark;
                                      });
    return end < Infinity || share <= kDark ? 0 : share;
}
//<

//> Ask how much of a light arrives
float HairLightIntegrator::Arrives(const SurfaceInteraction &si, const LightSample &light, int number,
                                   const Scene &scene, RayCounts &counts) const {
    if (settings_.shadow == Shadow::Opaque) {
        ++counts.shadowRays;
        return scene.Occluded(scene.SpawnRayTo(si, light.wi, light.distance)) ? 0.f : 1.f;
    }
    const auto i = static_cast<size_t>(number);
    if (i >= maps_.size() || !maps_[i])
        return Traced(si, light.wi, light.distance, scene, counts);
    // A point lies before whatever shadows itself by a step of the map, which is as coarse as its pixels
    const LightRays &rays = maps_[i]->Rays();
    float depth;
    rays.PlaceOf(si.p, &depth);
    return maps_[i]->Share(si.p, 1.5f * rays.Spacing(settings_.map.side, depth));
}
//<

//> Add up the light of all lamps
Spectrum HairLightIntegrator::DirectLight(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                                          PixelSampler &sampler, RayCounts &counts) const {
    Spectrum L;
    for (int i = 0; i < scene.LightCount(); ++i) {
        const Light &lamp = scene.LightAt(static_cast<size_t>(i));
        for (int s = 0; s < lamp.Samples(); ++s) {
            LightSample light;
            if (!lamp.Sample_Li(si.p, sampler.Get2D(), &light) || !(light.pdf > 0) || light.L.IsBlack())
                continue;
            float pdf;
            Spectrum f = bsdf.FCos(si.wo, light.wi, &pdf);
            if (bsdf.IsHair())
                f *= ShellFactor(si.p, light.wi);
            if (!f.IsBlack())
                L +=
                    f * light.L *
                    (Arrives(si, light, i, scene, counts) / (light.pdf * static_cast<float>(lamp.Samples())));
        }
    }
    return L;
}
//<

//> Make the shell and the maps before the first sample
void HairLightIntegrator::Prepare(const Scene &scene, const Camera &camera) {
    Integrator::Prepare(scene, camera);
    if (settings_.shellNormals)
        shell_ = ShellOf(scene, settings_.shellCell);
    if (settings_.shadow != Shadow::DeepMap)
        return;
    const Bounds3f bounds = scene.WorldBound();
    maps_.resize(static_cast<size_t>(scene.LightCount()));
    for (size_t i = 0; i < maps_.size(); ++i) {
        const Light &lamp = scene.LightAt(i);
        LightSample light;
        // A light without area says by one sample from where it shines
        if (bounds.IsEmpty() || !lamp.IsDelta() || !lamp.Sample_Li(bounds.Center(), {0.5f, 0.5f}, &light))
            continue;
        const LightRays rays = lamp.Kind() == LightKind::Distant
                                   ? LightRays::Parallel(-light.wi, bounds)
                                   : LightRays::From(bounds.Center() + light.wi * light.distance);
        maps_[i].emplace(rays, settings_.map,
                         [&](const Ray &ray, const std::function<void(float)> &crossing) {
                             RayCounts notOfThePicture;
                             return WalkThroughHair(scene, SceneRay{ray, {}, false}, &notOfThePicture,
                                                    [&](float depth, const SurfaceInteraction &) {
                                                        crossing(depth);
                                                        return true;
                                                    });
                         });
    }
}

std::string HairLightIntegrator::Learned() const {
    std::string text;
    if (shell_)
        text = fmt::format("a shell of {} triangles", shell_->mesh.indices.size() / 3);
    for (const auto &map : maps_)
        if (map)
            text += fmt::format("{}a deep shadow map of {} points for {} steps, {}", text.empty() ? "" : "; ",
                                map->Points(), map->Steps(), ByteSizeText(map->Bytes()));
    return text;
}
//<

} // namespace cuticle
//<
