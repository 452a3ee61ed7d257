//> Define what guides a picture's smoothing
#include "render/guides.h"

#include "core/parallel.h"
#include "render/job.h"
#include "render/sampler.h"

namespace cuticle {

//> Light what is seen, shadows left out
// One sample of each kind of lamp; of the sky only where there is no other light, as a sample of it is noisy.
static float UnshadowedLight(const SurfaceInteraction &si, const Scene &scene, const WidthSeen &width,
                             PixelSampler *sampler) {
    BSDF bsdf;
    bsdf.SetFrame(si.shading, si.n);
    FiberStrata strata;
    bsdf.AskForMean(&strata, width.Offsets(si, si.t, false, HairField::Auto));
    si.material->MakeBSDF(si, &bsdf);
    if (!bsdf.HasNonSpecular())
        return 0;
    const bool skyAlone = scene.InfiniteLights().size() == static_cast<size_t>(scene.LightCount());
    const LightSampler::Receiver receiver{si.p, bsdf.IsHair() ? Vector3f() : Vector3f(si.n)};
    float sum = 0;
    for (const LightKind kind : {LightKind::Infinite, LightKind::Distant, LightKind::Local}) {
        if ((kind == LightKind::Infinite) != skyAlone)
            continue;
        float probability = 0, bsdfPdf = 0;
        const int index = scene.Lights().SampleKind(kind, receiver, sampler->Get1D(), &probability);
        const Point2f u = sampler->Get2D();
        LightSample light;
        if (index >= 0 && scene.LightAt(static_cast<size_t>(index)).Sample_Li(si.p, u, &light) &&
            light.pdf > 0)
            sum += (bsdf.FCos(si.wo, light.wi, &bsdfPdf) * light.L / (light.pdf * probability)).y();
    }
    return std::isfinite(sum) ? sum : 0;
}
//<

//> Look once more, by rays that end where they hit
Guides SeeGuides(const Scene &scene, const Camera &camera, const Filter &filter, const GuideView &view) {
    CHECK_GE(view.rays, 1);
    const auto columns = static_cast<size_t>(view.max.x - view.min.x),
               rows = static_cast<size_t>(view.max.y - view.min.y);
    WidthSeen width;
    width.Look(camera);
    Guides guides;
    for (std::vector<float> &guide : guides)
        guide.assign(columns * rows, 0);
    ParallelFor(rows, [&](size_t row) {
        const int y = view.min.y + static_cast<int>(row);
        PixelSampler sampler(SamplerKind::LowDiscrepancy, view.rays, ~view.seed);
        for (int x = view.min.x; x < view.max.x; ++x) {
            float covered = 0, light = 0;
            for (int i = 0; i < view.rays; ++i) {
                sampler.Start(x, y, i);
                float weight = 1;
                const SceneRay ray{CameraRay(camera, filter, {x, y}, &sampler, &weight), {}, false};
                SurfaceInteraction si;
                if (!scene.Intersect(ray, &si))
                    continue;
                covered += weight;
                if (si.material)
                    light += weight * UnshadowedLight(si, scene, width, &sampler);
            }
            const size_t at = row * columns + static_cast<size_t>(x - view.min.x);
            guides[0][at] = covered / static_cast<float>(view.rays);
            guides[1][at] = light / static_cast<float>(view.rays);
        }
    });
    return guides;
}
//<

} // namespace cuticle
//<
