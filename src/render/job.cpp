#include "render/job.h"

#include "core/check.h"
#include "core/clock.h"
#include "core/error.h"
#include "core/parallel.h"
#include "render/filter.h"
#include "render/sampler.h"

#include <algorithm>
#include <filesystem>
#include <mutex>

namespace cuticle {

namespace {

constexpr int kTile = 16;    // pixels to a side: the piece of work that a thread takes
constexpr int kMaxPass = 16; // samples of a pixel in a row

int TilesAcross(int pixels) { return (pixels + kTile - 1) / kTile; }

// The samples per pixel of the whole render.
int TargetSamples(const JobOptions &options, const SamplerSetup &sampler) {
    return options.spp.value_or(options.quick ? std::max(1, sampler.spp / 4) : sampler.spp);
}

// Names the whole render, so that films of different ones are not merged.
RenderIdentity IdentityOf(const SceneDescription &description, const JobOptions &options, int spp) {
    return {fmt::format("{} of {} bytes", std::filesystem::path(description.filename).filename().string(),
                        description.bytesRead),
            options.ownIntegrator ? "an integrator of the caller's own"
                                  : options.integrator.value_or(description.integrator.type),
            spp, options.seed};
}

// Everything that a job renders with, made from the scene's directives. Throws Error where one of them is
// wrong.
class RenderJob {
  public:
    RenderJob(const SceneDescription &description, const Scene &scene, const JobOptions &options)
        : scene_(scene), options_(options), sceneName_(description.filename),
          film_(description.film, {options.film.crop, options.quick, options.variance}),
          camera_(MakeCamera(description.camera, film_.Resolution(),
                             description.film.params.FindFloat("diagonal", 35))),
          filter_(MakeFilter(description.filter)),
          madeIntegrator_(options.ownIntegrator
                              ? nullptr
                              : MakeIntegrator(description.integrator,
                                               options.integrator.value_or(description.integrator.type))),
          integrator_(options.ownIntegrator ? options.ownIntegrator : madeIntegrator_.get()),
          sampler_(MakeSampler(description.sampler)), spp_(TargetSamples(options, sampler_)),
          samples_(options.samples.value_or(SampleRange{0, spp_})),
          tilesX_(TilesAcross(film_.WindowSize().x)),
          tiles_(static_cast<size_t>(tilesX_ * TilesAcross(film_.WindowSize().y))),
          samplesInAll_(film_.Pixels() * static_cast<uint64_t>(samples_.Count())) {
        if (!(0 <= samples_.first && samples_.first < samples_.last && samples_.last <= spp_))
            throw Error("the samples {} to {} are no part of {} per pixel", samples_.first, samples_.last,
                        spp_);
        film_.Expect(IdentityOf(description, options, spp_), samples_);
    }
    JobResult Run() &&;

  private:
    bool Interrupted() const {
        return options_.interrupted && options_.interrupted->load(std::memory_order_relaxed);
    }
    void RenderTile(size_t tile, const SampleRange &pass);
    Spectrum TakeSample(int x, int y, int sample, PixelSampler *sampler, RayCounts *rays) const;
    void ReportNaN(int x, int y, int sample);
    void Join(const RayCounts &rays, uint64_t nanSamples, uint64_t samples);

    const Scene &scene_;
    const JobOptions &options_;
    std::string sceneName_;
    Film film_;
    Camera camera_;
    Filter filter_;
    std::unique_ptr<Integrator> madeIntegrator_;
    const Integrator *integrator_;
    SamplerSetup sampler_;
    int spp_;
    SampleRange samples_;
    int tilesX_;
    size_t tiles_;
    uint64_t samplesInAll_;

    std::mutex mutex_; // of what the tiles are joined to
    RayCounts rays_;
    uint64_t nanSamples_ = 0, samplesTaken_ = 0;
    std::atomic<bool> nanReported_ = false;
};

Spectrum RenderJob::TakeSample(int x, int y, int sample, PixelSampler *sampler, RayCounts *rays) const {
    sampler->Start(x, y, sample);
    const FilterSample offset = filter_.Sample(sampler->Get2D());
    const Point2f pFilm{static_cast<float>(x) + 0.5f + offset.offset.x,
                        static_cast<float>(y) + 0.5f + offset.offset.y};
    const Ray ray = camera_.GenerateRay(pFilm, sampler->Get2D());
    return integrator_->Li(ray, scene_, *sampler, *rays) * offset.weight;
}

void RenderJob::RenderTile(size_t tile, const SampleRange &pass) {
    const int index = static_cast<int>(tile);
    const Point2i lo = film_.WindowMin(), hi = film_.WindowMax();
    const int x0 = lo.x + index % tilesX_ * kTile, y0 = lo.y + index / tilesX_ * kTile;
    const int x1 = std::min(x0 + kTile, hi.x), y1 = std::min(y0 + kTile, hi.y);
    int x = x0, y = y0, s = pass.first;
    const std::function<std::string()> whereWeAre = [&] {
        return fmt::format("while rendering {}, pixel ({}, {}), sample {}", sceneName_, x, y, s);
    };
    const CheckContext context(whereWeAre);
    PixelSampler sampler(sampler_.kind, spp_, options_.seed);
    RayCounts rays;
    uint64_t nanSamples = 0;
    for (y = y0; y < y1; ++y)
        for (x = x0; x < x1; ++x)
            for (s = pass.first; s < pass.last; ++s)
                if (!film_.Add(x, y, TakeSample(x, y, s, &sampler, &rays))) {
                    ++nanSamples;
                    ReportNaN(x, y, s);
                }
    Join(rays, nanSamples, static_cast<uint64_t>((x1 - x0) * (y1 - y0) * pass.Count()));
}

// Says where the first sample that is not finite was met.
void RenderJob::ReportNaN(int x, int y, int sample) {
    if (!nanReported_.exchange(true))
        Warning("sample that is not finite",
                fmt::format("a sample that is not finite was left out at pixel ({}, {}), sample {}", x, y,
                            sample));
}

// Adds what a tile counted to the whole, and tells how far the job is.
void RenderJob::Join(const RayCounts &rays, uint64_t nanSamples, uint64_t samples) {
    const std::lock_guard lock(mutex_);
    rays_.rays += rays.rays;
    rays_.shadowRays += rays.shadowRays;
    nanSamples_ += nanSamples;
    samplesTaken_ += samples;
    if (options_.progress)
        options_.progress->Report(samplesTaken_, samplesInAll_);
}

JobResult RenderJob::Run() && {
    const double start = WallSeconds();
    size_t threads = 1;
    OnThreads(options_.threads, [&] {
        threads = MaxThreads();
        // Passes over the whole picture that grow in length, so that an interrupt leaves an even picture
        // early.
        for (int done = samples_.first, pass = 1; done < samples_.last && !Interrupted();
             done += pass, pass = std::min(2 * pass, kMaxPass)) {
            pass = std::min(pass, samples_.last - done);
            VLOG(1) << sceneName_ << ": samples " << done << " to " << done + pass - 1;
            ParallelFor(tiles_, [&](size_t tile) {
                if (!Interrupted())
                    RenderTile(tile, {done, done + pass});
            });
        }
    });
    return {.film = std::move(film_),
            .camera = camera_,
            .spp = spp_,
            .samples = samples_,
            .complete = samplesTaken_ == samplesInAll_,
            .rays = rays_,
            .nanSamples = nanSamples_,
            .threads = threads,
            .seconds = WallSeconds() - start};
}

} // namespace

JobResult RunJob(const SceneDescription &description, const Scene &scene, const JobOptions &options) {
    std::optional<WarningScope> warnings;
    if (options.warnings)
        warnings.emplace(options.warnings);
    return RenderJob(description, scene, options).Run();
}

} // namespace cuticle
