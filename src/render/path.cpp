//> Define the path integrator
#include "render/path.h"

namespace cuticle {

Spectrum PathIntegrator::Li(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                            RayCounts &counts) const {
    //> Start a path at the camera
    Spectrum L, beta(1); // radiance found, and the path's throughput
    SceneRay ray{cameraRay, {}, false};
    // Of the last scattering event: where it was, the density of the direction that it chose, and whether light
    // sampling had no chance there (a mirror, glass, or the camera itself).
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
        // The balance of two strategies for one and the same light: this ray, with density `bsdfPdf`, and the
        // light sampling at the surface before, with the density that it would have had for this direction.
        const auto weight = [&](float lightPdf) {
            return specularBounce ? 1 : PowerHeuristic(bsdfPdf, lightPdf);
        };
        if (!found) {
            for (int i : scene.InfiniteLights()) {
                const Light &light = scene.LightAt(i);
                const float pdf = scene.Lights().Probability(i) * light.Pdf_Li(previousPoint, ray.ray.d);
                L += beta * light.Le(ray.ray) * weight(pdf);
            }
        } else if (si.light >= 0) {
            const Spectrum Le = scene.AreaLightAt(si.light).L(si.n, -ray.ray.d);
            if (!Le.IsBlack())
                L += beta * Le *
                     weight(scene.Lights().Probability(si.light) * scene.AreaLightPdf(previousPoint, si));
        }
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
        si.material->MakeBSDF(si, &bsdf);
        bsdf.SetFrame(si.shading, si.n);
        if (bsdf.HasNonSpecular())
            L += beta * SampleLight(si, bsdf, scene, sampler, counts);
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
        // A path of little throughput lives on with probability 1 - q, and counts for more if it does. The first
        // bounces are spared: they carry the picture. A path of a thousand bounces is spared no longer, whatever
        // the scene says: between perfect mirrors it would never end.
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

//> Estimate direct light by choosing a light and a point on it
Spectrum PathIntegrator::SampleLight(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                                     PixelSampler &sampler, RayCounts &counts) const {
    float choice = 0;
    const float uLight = sampler.Get1D();
    const Point2f u = sampler.Get2D();
    const int index = scene.Lights().Sample(uLight, &choice);
    LightSample light;
    if (index < 0 || !scene.LightAt(index).Sample_Li(si.p, u, &light) || !(light.pdf > 0) ||
        light.L.IsBlack())
        return {};
    //> Weigh the light's sample against BSDF sampling
    float bsdfPdf = 0;
    const Spectrum f = bsdf.FCos(si.wo, light.wi, &bsdfPdf);
    if (f.IsBlack())
        return {};
    const float pdf = choice * light.pdf;
    // Nothing but light sampling finds a delta light.
    const float weight = light.delta ? 1 : PowerHeuristic(pdf, bsdfPdf);
    //<
    //> Trace the shadow ray last: it costs the most
    ++counts.shadowRays;
    SceneRay shadow = scene.SpawnRay(si, light.wi);
    shadow.ray.tMax = light.distance;
    if (scene.Occluded(shadow))
        return {};
    return f * light.L * (weight / pdf);
    //<
}
//<

} // namespace cuticle
//<
