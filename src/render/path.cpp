//> Define the path integrator
#include "render/path.h"

#include "core/parallel.h"

namespace cuticle {

//> Ask for the light that a ray runs into
// Calls add(radiance, light, density) for each light that a ray from `from` meets; the density per steradian
// is that with which sampling the light would have found the ray's direction.
template <class Add>
static void ForEachLightFound(const Scene &scene, const Ray &ray, const SurfaceInteraction *surface,
                              const Point3f &from, const Add &add) {
    if (!surface) {
        for (int i : scene.InfiniteLights()) {
            const Light &light = scene.LightAt(i);
            add(light.Le(ray), i, light.Pdf_Li(from, ray.d));
        }
    } else if (surface->light >= 0) {
        const Spectrum Le = scene.AreaLightAt(surface->light).L(surface->n, -ray.d);
        if (!Le.IsBlack())
            add(Le, surface->light, scene.AreaLightPdf(from, *surface));
    }
}

static LightSampler::Receiver ReceiverAt(const SurfaceInteraction &si, const BSDF &bsdf) {
    return {si.p, bsdf.IsHair() ? Vector3f() : Vector3f(si.n)};
}
//<

// The recorder is told what the path meets; that of a picture does nothing.
// Long because: it is one loop, whose steps the chapter shows one by one.
template <class Recorder>
Spectrum PathIntegrator::Trace(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                               RayCounts &counts, Recorder &recorder) const {
    //> Start a path at the camera
    Spectrum L, beta(1); // radiance found, and the path's throughput
    SceneRay ray{cameraRay, {}, false};
    // These tell of the last scattering event: where it was, the density of the direction that it chose, and
    // whether light sampling had no chance there (a mirror, glass, or the camera itself).
    Receiver previous{cameraRay.o, {}};
    float bsdfPdf = 0;
    bool specularBounce = true;
    // Radiance is squeezed on entering glass; roulette should not take that for a loss.
    float etaScale = 1;
    int passedThrough = 0;
    // What is seen of hair by a pixel, or by light that rough surfaces have scattered, is wider than a fiber.
    FiberStrata strata;
    float distance = 0;
    bool wide = false;
    //<
    for (int bounces = 0;; ++bounces) {
        //> Find the next surface on the path
        SurfaceInteraction si;
        ++counts.rays;
        const bool found = scene.Intersect(ray, &si);
        //<
        //> Add light that the ray ran into, weighted against light sampling
        const float *const otherPdf = specularBounce ? nullptr : &bsdfPdf;
        if (!settings_.separateLightRay || specularBounce) {
            const Spectrum met = beta * LightFound(scene, ray.ray, found ? &si : nullptr, previous, otherPdf);
            L += met;
            recorder.Gathered(met);
        }
        recorder.Found(beta, scene, ray.ray, found ? &si : nullptr, previous, otherPdf);
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
        distance += si.t;
        bsdf.AskForMean(&strata, width_.Offsets(si, distance, wide, settings_.field));
        si.material->MakeBSDF(si, &bsdf);
        if (bsdf.HasNonSpecular()) {
            recorder.Scattered();
            const Spectrum sampled = beta * SampleLights(si, bsdf, scene, sampler, counts);
            L += sampled;
            recorder.Gathered(sampled);
            recorder.AtSurface(beta, si, bsdf, scene, sampler);
        }
        if (settings_.separateLightRay) {
            const Spectrum met = beta * SampleBSDFForLight(si, bsdf, scene, sampler, counts);
            L += met;
            recorder.Gathered(met);
        }
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
        previous = ReceiverAt(si, bsdf);
        bsdfPdf = sample.pdf;
        specularBounce = sample.specular;
        wide = wide || !specularBounce;
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

//> Trace a path that nobody records
namespace {

struct NoRecorder {
    template <class... Ignored>
    void Found(const Ignored &...) const {}
    template <class... Ignored>
    void AtSurface(const Ignored &...) const {}
    void Gathered(const Spectrum &) const {}
    void Scattered() const {}
};

} // namespace

Spectrum PathIntegrator::Li(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                            RayCounts &counts) const {
    NoRecorder nobody;
    return Trace(cameraRay, scene, sampler, counts, nobody);
}
//<

//> Tell direct light from what is scattered more often
namespace {

// Adds up the light that is found until a second rough surface scatters it.
struct PartsRecorder : NoRecorder {
    void Gathered(const Spectrum &light) {
        if (scatterings <= 1)
            direct += light;
    }
    void Scattered() { ++scatterings; }
    Spectrum direct;
    int scatterings = 0;
};

} // namespace

Spectrum PathIntegrator::LiInParts(const Ray &cameraRay, const Scene &scene, PixelSampler &sampler,
                                   RayCounts &counts, LightParts *parts) const {
    PartsRecorder recorder;
    const Spectrum L = Trace(cameraRay, scene, sampler, counts, recorder);
    parts->direct = recorder.direct;
    return L;
}
//<

//> Weigh the light that a ray finds against light sampling
// Balances two strategies for one and the same light: this ray, with density `bsdfPdf` (null: light sampling
// has no chance of finding it), and light sampling at the ray's origin `from`.
Spectrum PathIntegrator::LightFound(const Scene &scene, const Ray &ray, const SurfaceInteraction *surface,
                                    const Receiver &from, const float *bsdfPdf) const {
    Spectrum L;
    ForEachLightFound(scene, ray, surface, from.p, [&](const Spectrum &Le, int light, float lightPdf) {
        L += Le * (bsdfPdf ? PowerHeuristic(*bsdfPdf, SamplesOf(scene, light, from) * lightPdf) : 1.f);
    });
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
    return throughput *
           LightFound(scene, ray.ray, found ? &next : nullptr, ReceiverAt(si, bsdf), &sample.pdf);
}
//<

//> Count the samples that a light gets
// The expected number of samples that one hit takes of a light: its probability there, or its count.
float PathIntegrator::SamplesOf(const Scene &scene, int light, const Receiver &at) const {
    return settings_.lights == LightStrategy::All ? static_cast<float>(scene.LightAt(light).Samples())
                                                  : scene.Lights().Probability(Shares(scene), at, light);
}
//<

//> Estimate direct light by one light, or by all of them
Spectrum PathIntegrator::SampleLights(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                                      PixelSampler &sampler, RayCounts &counts) const {
    LightEstimate estimate;
    //> Choose one light, and sample it once
    if (settings_.lights == LightStrategy::One) {
        float probability = 0;
        const int index =
            scene.Lights().Sample(Shares(scene), ReceiverAt(si, bsdf), sampler.Get1D(), &probability);
        const Point2f u = sampler.Get2D();
        if (index < 0 || !SampleLight(si, bsdf, scene, scene.LightAt(index), u, counts, &estimate))
            return {};
        return estimate.Weighted(probability);
    }
    //<
    //> Sample every light, as often as it says
    Spectrum L;
    for (int i = 0; i < scene.LightCount(); ++i) {
        const int samples = scene.LightAt(i).Samples();
        for (int s = 0; s < samples; ++s)
            if (SampleLight(si, bsdf, scene, scene.LightAt(i), sampler.Get2D(), counts, &estimate))
                L += estimate.Weighted(static_cast<float>(samples));
    }
    return L;
    //<
}
//<

//> Estimate the light of one lamp by a point on it
// False where nothing arrives.
bool PathIntegrator::SampleLight(const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                                 const Light &lamp, const Point2f &u, RayCounts &counts,
                                 LightEstimate *estimate) {
    LightSample light;
    if (!lamp.Sample_Li(si.p, u, &light) || !(light.pdf > 0) || light.L.IsBlack())
        return false;
    //> Ask whether the light arrives, of hair before anything else
    const SceneRay shadow = scene.SpawnRayTo(si, light.wi, light.distance);
    const auto isBlocked = [&] {
        ++counts.shadowRays;
        return scene.Occluded(shadow);
    };
    const bool hair = bsdf.IsHair();
    if (hair && isBlocked())
        return false;
    //<
    const Spectrum f = bsdf.FCos(si.wo, light.wi, &estimate->bsdfPdf);
    if (f.IsBlack() || (!hair && isBlocked()))
        return false;
    estimate->value = f * light.L / light.pdf;
    estimate->pdf = light.pdf;
    estimate->delta = light.delta;
    return true;
}
//<

//> Learn from a pilot how often to sample which kind of light
namespace {

// Collects for one path of the pilot what each kind of light gives where it is sampled, and what the path
// runs into.
class LightRecorder {
  public:
    using Sampling = bool (*)(const SurfaceInteraction &, const BSDF &, const Scene &, const Light &,
                              const Point2f &, RayCounts &, LightEstimate *);
    LightRecorder(LightPilotPath *path, Sampling sample) : path_(*path), sample_(sample) {}

    void Gathered(const Spectrum &) const {}
    void Scattered() const {}
    void Found(const Spectrum &beta, const Scene &scene, const Ray &ray, const SurfaceInteraction *surface,
               const LightSampler::Receiver &from, const float *bsdfPdf) {
        ForEachLightFound(scene, ray, surface, from.p, [&](const Spectrum &Le, int light, float lightPdf) {
            const LightSampler &lights = scene.Lights();
            path_.found.push_back({(beta * Le).y(), lightPdf * lights.ProbabilityOfKind(from, light),
                                   bsdfPdf ? *bsdfPdf : -1, scene.LightAt(light).Kind()});
        });
    }
    void AtSurface(const Spectrum &beta, const SurfaceInteraction &si, const BSDF &bsdf, const Scene &scene,
                   PixelSampler &sampler) {
        LightPilotPath::Vertex vertex;
        for (size_t kind = 0; kind < vertex.size(); ++kind) {
            float probability = 0;
            LightEstimate e;
            const int light = scene.Lights().SampleKind(static_cast<LightKind>(kind), ReceiverAt(si, bsdf),
                                                        sampler.Get1D(), &probability);
            const Point2f u = sampler.Get2D();
            if (light >= 0 && sample_(si, bsdf, scene, scene.LightAt(light), u, counts_, &e))
                vertex[kind] = {(beta * e.value).y() / probability, probability * e.pdf,
                                e.delta ? 0 : e.bsdfPdf};
        }
        path_.sampled.push_back(vertex);
    }

  private:
    LightPilotPath &path_;
    Sampling sample_;
    RayCounts counts_;
};

} // namespace

void PathIntegrator::Learn(const Pilot &pilot, const Scene &scene) {
    if (settings_.lights != LightStrategy::One)
        return;
    const auto cells = static_cast<size_t>(pilot.cells.x * pilot.cells.y);
    const auto samples = static_cast<size_t>(pilot.samples);
    std::vector<LightPilotPath> paths(cells * samples);
    ParallelFor(cells, [&](size_t cell) {
        const Point2i at{static_cast<int>(cell) % pilot.cells.x, static_cast<int>(cell) / pilot.cells.x};
        PixelSampler sampler(SamplerKind::Independent, pilot.samples, 0);
        for (size_t s = 0; s < samples; ++s) {
            LightRecorder recorder(&paths[cell * samples + s], SampleLight);
            RayCounts notOfThePicture;
            const Ray ray = pilot.ray(at, static_cast<int>(s), &sampler);
            Trace(ray, scene, sampler, notOfThePicture, recorder);
        }
    });
    shares_ = LearnLightShares(paths, pilot, scene.Lights());
}

std::string PathIntegrator::Learned() const { return shares_ ? DescribeShares(*shares_) : std::string(); }
//<

} // namespace cuticle
//<
