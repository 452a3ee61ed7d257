//> Define direct light past mirrors
#include "render/direct_light.h"

namespace cuticle {

//> Follow mirrors and glass to the first surface that light can be asked for
Spectrum DirectLightIntegrator::Li(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                                   RayCounts &counts) const {
    Spectrum L, beta(1);
    SceneRay ray{cameraRay, {}, false};
    int passedThrough = 0;
    FiberStrata strata;
    float distance = 0;
    for (int bounces = 0;; ++bounces) {
        SurfaceInteraction si;
        ++counts.rays;
        if (!scene.Intersect(ray, &si)) {
            for (const int i : scene.InfiniteLights())
                L += beta * scene.LightAt(static_cast<size_t>(i)).Le(ray.ray);
            return L;
        }
        if (si.light >= 0)
            L += beta * scene.AreaLightAt(static_cast<size_t>(si.light)).L(si.n, si.wo);
        if (bounces >= maxDepth_)
            return L;
        if (!si.material) {
            if (++passedThrough > 1000)
                return L;
            ray = scene.SpawnRay(si, ray.ray.d);
            --bounces;
            continue;
        }
        BSDF bsdf;
        bsdf.SetFrame(si.shading, si.n);
        distance += si.t;
        bsdf.AskForMean(&strata, width_.Offsets(si, distance, false, HairField::Auto));
        si.material->MakeBSDF(si, &bsdf);
        if (bsdf.HasNonSpecular())
            L += beta * DirectLight(si, bsdf, scene, sampler, counts);
        BSDFSample sample;
        Spectrum throughput;
        if (bsdf.IsHair() || !bsdf.Sample_f(si.wo, sampler.Get4D(), &sample, &throughput) || !sample.specular)
            return L;
        beta *= throughput;
        ray = scene.SpawnRay(si, sample.wi);
    }
}
//<

} // namespace cuticle
//<
