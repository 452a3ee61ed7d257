//> Define the path integrator
#include "render/path.h"

namespace cuticle {

Spectrum PathIntegrator::Li(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                            RayCounts &counts) const {
    //> Start a path at the camera
    Spectrum L, beta(1); // radiance found, and the path's throughput
    SceneRay ray{cameraRay, {}, false};
    // These tell of the last scattering event: where it was, the density of the direction that it chose, and
    // whether light sampling had no chance there (a mirror, glass, or the camera itself).
    Point3f previousPoint = cameraRay.o;
    float bsdfPdf = 0;
    bool specularBounce = true;
    // Radiance is squeezed on entering glass; roulette should not take that for a loss.
    float etaScale = 1;
    int passedThrough = 0;
    //<
    for (int bounces = 0;; ++bounces) {
        //> Find the next surface on the path
        SurfaceInteraction si;
        ++counts.rays;
        const bool found = scene.Intersect(ray, &si);
        //<
        //> Add light that the ray ran into, weighted against light sampling
        if (!settings_.separateLightRay || specularBounce)
            L += beta * LightFound(scene, ray.ray, found ? &si : nullptr, previousPoint,
                                   specularBounce ? nullptr : &bsdfPdf);
        //<
        //> End the path in the void or at its greatest depth
        if (!found || bounces >= settings_.maxDepth)
            break;
        if (settings_.directOnly && !specularBounce)
            break;
        //<
        //> Pass through surfaces that have no material
        if (!si.material) {
            // Only emitters are kept without a material; a closed box of them cannot hold a path for ever.
            if (++passedThrough > 1000)
                break;
            ray = scene.SpawnRay(si, ray.ray.d);
            --bounces;
            continue;
        }
        //<
        //> Compute the BSDF and sample a light
        BSDF bsdf;
        bsdf.SetFrame(si.shading, si.n);
        si.material->MakeBSDF(si, &bsdf);
        if (bsdf.HasNonSpecular())
            L += beta * SampleLights(si, bsdf, scene, sampler, counts);
        if (settings_.separateLightRay)
            L += beta * SampleBSDFForLight(si, bsdf, scene, sampler, counts);
        //<
        //> Choose the next direction by the BSDF
        BSDFSample sample;
        Spectrum throughput;
        if (!bsdf.Sample_f(si.wo, sampler.Get4D(), &sample, &throughput))
            break;
        beta *= throughput;
        if (sample.specular && sample.transmission)
            etaScale *= sample.eta * sample.eta;
        ray = scene.SpawnRay(si, sample.wi);
        previousPoint = si.p;
        bsdfPdf = sample.pdf;
        specularBounce = sample.specular;
        //<
        //> Perhaps end the path by Russian roulette
        // A path of little throughput lives on with probability 1 - q, and counts for more if it does. The
        // first bounces are spared: they carry the picture. A path of a thousand bounces is spared no longer,
        // whatever the scene says: between perfect mirrors it would never end.
        const float strength = (beta * etaScale).MaxComponentValue();
        if ((strength < settings_.rrThreshold && bounces > 3) || bounces > 1000) {
            const float q = std::max(0.05f, 1 - strength);
            if (sampler.Get1D() < q)
                break;
            beta /= 1 - q;
        }
        //<
    }
    return L;
}

//> Weigh the light that a ray finds against light sampling
// Balances two strategies for one and the same light: this ray, with density `bsdfPdf` (null: light sampling
// has no chance of finding it), and light sampling at the ray's origin `from`.
Spectrum PathIntegrator::LightFound(const Scene &scene, const Ray &ray, const SurfaceInteraction *surface,
                                    const Point3f &from, const float *bsdfPdf) const {
    const auto weight = [&](float lightPdf) { return bsdfPdf ? PowerHeuristic(*bsdfPdf, lightPdf) : 1; };
    Spectrum L;
    if (!surface) {
        for (int i : scene.InfiniteLights()) {
            const Light &light = scene.LightAt(i);
            L += light.Le(ray) * weight(SamplesOf(scene, i) * light.Pdf_Li(from, ray.d));
        }
    } else if (surface->light >= 0) {
        const Spectrum Le = scene.AreaLightAt(surface->light).L(surface->n, -ray.d);
        if (!Le.IsBlack())
            L = Le * weight(SamplesOf(scene, surface->light) * scene.AreaLightPdf(from, *surface));
    }
    return L;
}
//<

//> Look for light with a ray of its own
// Follows a second direction by the BSDF as far as the next surface and no farther, as pbrt-v3 does.
Spectrum PathIntegrator::SampleBSDFForLight(const SurfaceInteraction &si, const BSDF &bsdf,
                                            const Scene &scene, PixelSampler &sampler,
                                            RayCounts &counts) const {
    BSDFSample sample;
    Spectrum throughput;
    if (!bsdf.Sample_f(si.wo, sampler.Get4D(), &sample, &throughput) || sample.specular)
        return {};
    SurfaceInteraction next;
    ++counts.rays;
    const SceneRay ray = scene.SpawnRay(si, sample.wi);
    const bool found = scene.Intersect(ray, &next);
    return throughput * LightFound(scene, ray.ray, found ? &next : nullptr, si.p, &sample.pdf);
}
//<

//> Count the samples that a light gets
// The expected number of samples that one hit takes of a light: its probability, or its count.
float PathIntegrator::SamplesOf(const Scene &scene, int light) const {
    return settings_.lights == LightStrategy::All ? static_cast<float>(scene.LightAt(light).Samples())
                                                  : scene.Lights().Probability(light);
}
//<

//> Estimate direct light by one light, or by all of them
Spectrum PathIntegrator::SampleLights(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                                      PixelSampler &sampler, RayCounts &counts) const {
    //> Choose one light, and sample it once
    if (settings_.lights == LightStrategy::One) {
        float probability = 0;
        const int index = scene.Lights().Sample(sampler.Get1D(), &probability);
        const Point2f u = sampler.Get2D();
        if (index < 0)
            return {};
        return SampleLight(si, bsdf, scene, scene.LightAt(index), probability, u, counts);
    }
    //<
    //> Sample every light, as often as it says
    Spectrum L;
    for (int i = 0; i < scene.LightCount(); ++i)
        for (int s = 0; s < scene.LightAt(i).Samples(); ++s)
            L += SampleLight(si, bsdf, scene, scene.LightAt(i), SamplesOf(scene, i), sampler.Get2D(), counts);
    return L;
    //<
}
//<

//> Estimate the light of one lamp by a point on it
// samples: the expected number of samples that this hit takes of the light.
Spectrum PathIntegrator::SampleLight(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                                     const Light &lamp, float samples, const Point2f &u, RayCounts &counts) {
    LightSample light;
    if (!lamp.Sample_Li(si.p, u, &light) || !(light.pdf > 0) || light.L.IsBlack())
        return {};
    //> Ask whether the light arrives, of hair before anything else
    const SceneRay shadow = scene.SpawnRayTo(si, light.wi, light.distance);
    const auto isBlocked = [&] {
        ++counts.shadowRays;
        return scene.Occluded(shadow);
    };
    const bool hair = bsdf.IsHair();
    if (hair && isBlocked())
        return {};
    //<
    //> Weigh the light's sample against BSDF sampling
    float bsdfPdf = 0;
    const Spectrum f = bsdf.FCos(si.wo, light.wi, &bsdfPdf);
    if (f.IsBlack() || (!hair && isBlocked()))
        return {};
    const float pdf = samples * light.pdf;
    // Nothing but light sampling finds a delta light.
    const float weight = light.delta ? 1 : PowerHeuristic(pdf, bsdfPdf);
    return f * light.L * (weight / pdf);
    //<
}
//<

} // namespace cuticle
//<
