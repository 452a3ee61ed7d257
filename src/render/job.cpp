#include "render/job.h"

#include "core/check.h"
#include "core/clock.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/printable.h"
#include "render/film_file.h"
#include "render/filter.h"
#include "render/sampler.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <mutex>

namespace cuticle {

namespace {

constexpr int kMaxPass = 16; // samples of a pixel in a row
// A tile may take so long in one pass, where its samples are not slower than that: it is lost in a kill, and
// an interrupt waits for it.
constexpr double kMaxTileSeconds = 2;

// The samples per pixel of the whole render.
int TargetSamples(const JobOptions &options, const SamplerSetup &sampler) {
    return options.spp.value_or(options.quick ? std::max(1, sampler.spp / 4) : sampler.spp);
}

// Names the whole render, so that films of different ones are not merged or gone on with. To add something
// that determines the picture: name it here, or in the caller's JobOptions::facts.
RenderIdentity IdentityOf(const SceneDescription &description, const JobOptions &options, int spp) {
    RenderIdentity identity;
    const auto add = [&](const char *name, const std::string &value) {
        identity.facts.emplace_back(name, value);
    };
    add("version of the program", CUTICLE_VERSION);
    add("scene", std::filesystem::path(description.filename).filename().string());
    add("scene's text in bytes", std::to_string(description.bytesRead));
    add("integrator", options.ownIntegrator ? "one of the caller's own"
                                            : options.integrator.value_or(description.integrator.type));
    add("number of samples per pixel", std::to_string(spp));
    add("seed", std::to_string(options.seed));
    identity.facts.insert(identity.facts.end(), options.facts.begin(), options.facts.end());
    return identity;
}

// Everything that a job renders with, made from the scene's directives. Throws Error where one of them is
// wrong.
class RenderJob {
  public:
    RenderJob(const SceneDescription &description, const Scene &scene, const JobOptions &options)
        : scene_(scene), options_(options), sceneName_(description.filename),
          film_(description.film, {options.film.crop, options.quick, options.variance, options.film.denoise,
                                   options.film.shrink}),
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
          samplesInAll_(film_.Pixels() * static_cast<uint64_t>(samples_.Count())) {
        if (!(0 <= samples_.first && samples_.first < samples_.last && samples_.last <= spp_))
            throw Error("the samples {} to {} are no part of {} per pixel", samples_.first, samples_.last,
                        spp_);
        if (film_.HasParts() && spp_ < 2)
            throw Error(description.sampler.params.loc,
                        "denoising compares two halves of the samples, and there is one sample per pixel")
                .WithRemedy("take 2 or more, or say --no-denoise");
        film_.Expect(IdentityOf(description, options, spp_), samples_);
        if (options.checkpoints)
            LookForPart(*options.checkpoints);
    }
    JobResult Run() &&;

  private:
    bool Interrupted() const {
        return hasFailed_.load(std::memory_order_relaxed) ||
               (options_.interrupted && options_.interrupted->load(std::memory_order_relaxed));
    }
    void RenderTileOrFail(size_t tile, int to);
    void LookForPart(const Checkpoints &checkpoints);
    void RenderTile(size_t tile, int to);
    PixelSampler MakePixelSampler() const;
    bool TakeSample(int x, int y, int sample, PixelSampler *sampler, RayCounts *rays, FilmTile *tile) const;
    void Learn();
    void ReportNaN(int x, int y, int sample);
    void Join(const FilmTile &tile, int samples, double seconds, const RayCounts &rays);
    int PassLength(int wished) const;
    bool PartIsDue() const { return options_.checkpoints && WallSeconds() >= nextPart_; }
    void WritePart();
    std::mutex &LockOf(size_t tile) { return tileLocks_[tile % std::size(tileLocks_)]; }

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
    uint64_t samplesInAll_;

    double start_ = WallSeconds();
    std::mutex tileLocks_[64]; // of the film's tiles
    std::mutex mutex_;         // of what is counted besides
    RenderTally tally_;        // without this run's seconds
    uint64_t samplesTaken_ = 0;
    double slowestSample_ = 0; // seconds of a tile for one sample of its pixels, in this pass
    double slowestTile_ = 0;   // seconds for all that it was given
    std::atomic<bool> nanReported_ = false, hasFailed_ = false;

    std::mutex partMutex_; // of who writes the part
    std::atomic<double> nextPart_ = 0;
    std::atomic<size_t> partsWritten_ = 0;
};

// Goes on from the part, where that is wished. What was rendered is not thrown away unasked: a part of this
// very render is an error if nobody wishes to go on from it.
void RenderJob::LookForPart(const Checkpoints &checkpoints) {
    nextPart_ = start_ + checkpoints.seconds;
    const std::string &name = checkpoints.filename;
    std::error_code error;
    if (!std::filesystem::exists(name, error))
        return;
    std::optional<StoredFilm> stored;
    std::string difference;
    try {
        stored = ReadFilm(name);
        difference = film_.Difference(stored->film);
        const std::vector<FilmRange> &taken = stored->film.Taken();
        if (difference.empty() && (taken.size() != 1 || !(taken[0].range == samples_)))
            difference = "it holds other samples";
    } catch (const Error &e) {
        if (checkpoints.resume)
            throw;
        Warning("part that cannot be read",
                fmt::format("{}; it will be replaced once this render has taken {:g} s", e.Message(),
                            checkpoints.seconds));
        return;
    }
    const std::string holds =
        fmt::format("{} of {} samples per pixel", stored->film.FewestDone(), samples_.Count());
    if (!difference.empty() && checkpoints.resume)
        throw Error("\"{}\" is a part of another render: {}", name, difference)
            .WithRemedy("give the options that it was begun with, or remove it to begin anew");
    if (!difference.empty()) {
        Warning("part of another render",
                fmt::format("\"{}\" is a part of another render ({}); it will be replaced once this one has "
                            "taken {:g} s",
                            name, difference, checkpoints.seconds));
        return;
    }
    if (!checkpoints.resume)
        throw Error("\"{}\" holds {} of this render already, from a run that was stopped", name, holds)
            .WithRemedy("go on from it by --resume, or remove it to begin anew");
    VLOG(1) << name << ": going on from " << holds;
    film_ = std::move(stored->film);
    tally_ = stored->tally;
    samplesTaken_ = film_.SamplesDone();
    partsWritten_ = 1;
}

// Writes the film as it is now. A failure costs the part, not the render.
void RenderJob::WritePart() {
    const Checkpoints &checkpoints = *options_.checkpoints;
    const double begin = WallSeconds();
    RenderTally tally;
    double slowestTile = 0;
    {
        const std::lock_guard lock(mutex_);
        tally = tally_;
        slowestTile = slowestTile_;
    }
    tally.seconds += begin - start_;
    try {
        WriteFilm(checkpoints.filename, film_, tally,
                  [&](size_t tile) { return std::unique_lock(LockOf(tile)); });
        ++partsWritten_;
        VLOG(1) << checkpoints.filename << ": written in " << WallSeconds() - begin << " s";
    } catch (const Error &e) {
        Warning("part that cannot be written",
                fmt::format("what is rendered so far cannot be kept for --resume: {}", e.Message()));
    }
    // What a kill costs: the time between two parts, that which one takes to write, and the tiles under way
    const double spare = std::min(checkpoints.seconds / 2, WallSeconds() - begin + slowestTile);
    nextPart_ = begin + checkpoints.seconds - spare;
}

// Samples to be denoised make two sets, the even and the odd ones, each stratified by itself: what is
// measured by comparing them holds only if they share nothing.
PixelSampler RenderJob::MakePixelSampler() const {
    return {sampler_.kind, film_.HasParts() ? (spp_ + 1) / 2 : spp_, options_.seed};
}

// Takes a sample and adds it to its tile; false where it is not finite.
bool RenderJob::TakeSample(int x, int y, int sample, PixelSampler *sampler, RayCounts *rays,
                           FilmTile *tile) const {
    const bool inParts = film_.HasParts();
    sampler->Start(x, y, inParts ? sample / 2 + sample % 2 * sampler->SamplesPerPixel() : sample);
    float weight = 1;
    const Ray ray = CameraRay(camera_, filter_, {x, y}, sampler, &weight);
    if (!inParts)
        return tile->Add(x, y, integrator_->Li(ray, scene_, *sampler, *rays) * weight);
    LightParts parts;
    const Spectrum L = integrator_->LiInParts(ray, scene_, *sampler, *rays, &parts);
    return tile->Add(x, y, L * weight, sample, parts.direct * weight);
}

// Lets the integrator learn from a pilot that is small beside the render, unless a useful one would not be.
// The whole picture and all its samples count, so that parts of a render learn the same.
void RenderJob::Learn() {
    constexpr double kMinPaths = 512, kMaxPaths = 4096, kPart = 1. / 32;
    constexpr int kSamples = 2; // the fewest that show a variance
    const Point2i size = film_.Resolution();
    const double paths =
        std::min(kMaxPaths, static_cast<double>(size.x) * static_cast<double>(size.y) * spp_ * kPart);
    if (!madeIntegrator_ || paths < kMinPaths)
        return;
    Pilot pilot;
    const double spacing =
        std::max(1., std::sqrt(static_cast<double>(size.x) * static_cast<double>(size.y) * kSamples / paths));
    const auto cellsIn = [&](int pixels) { return std::max(1, static_cast<int>(pixels / spacing)); };
    pilot.cells = {cellsIn(size.x), cellsIn(size.y)};
    pilot.samples = kSamples;
    pilot.ray = [&](Point2i cell, int sample, PixelSampler *sampler) {
        const auto middle = [](int i, int of, int pixels) {
            return static_cast<int>((static_cast<int64_t>(2 * i + 1) * pixels) / (2 * of));
        };
        const int x = middle(cell.x, pilot.cells.x, size.x), y = middle(cell.y, pilot.cells.y, size.y);
        sampler->Start(x, y, sample);
        float weight = 1;
        return CameraRay(camera_, filter_, {x, y}, sampler, &weight);
    };
    madeIntegrator_->Learn(pilot, scene_);
    VLOG(1) << Printable(sceneName_) << ": " << madeIntegrator_->Learned();
}

// Takes the samples of a tile that it lacks up to `to`.
void RenderJob::RenderTile(size_t tile, int to) {
    const int from = samples_.first + film_.Done(tile);
    if (from >= to)
        return;
    const double start = WallSeconds();
    FilmTile piece(film_, tile);
    int x = piece.Min().x, y = piece.Min().y, s = from;
    const std::function<std::string()> whereWeAre = [&] {
        return fmt::format("while rendering {}, pixel ({}, {}), sample {}", sceneName_, x, y, s);
    };
    const CheckContext context(whereWeAre);
    PixelSampler sampler = MakePixelSampler();
    RayCounts rays;
    for (y = piece.Min().y; y < piece.Max().y; ++y)
        for (x = piece.Min().x; x < piece.Max().x; ++x)
            for (s = from; s < to; ++s)
                if (!TakeSample(x, y, s, &sampler, &rays, &piece))
                    ReportNaN(x, y, s);
    Join(piece, to - from, WallSeconds() - start, rays);
    if (PartIsDue())
        if (const std::unique_lock lock(partMutex_, std::try_to_lock); lock && PartIsDue())
            WritePart();
}

// Hands what is thrown to the caller who takes it, with what all other tiles got.
void RenderJob::RenderTileOrFail(size_t tile, int to) {
    if (!options_.failure)
        return RenderTile(tile, to);
    try {
        RenderTile(tile, to);
    } catch (...) {
        if (!hasFailed_.exchange(true))
            *options_.failure = std::current_exception();
    }
}

// Says where the first sample that is not finite was met.
void RenderJob::ReportNaN(int x, int y, int sample) {
    if (!nanReported_.exchange(true))
        Warning("sample that is not finite",
                fmt::format("a sample that is not finite was left out at pixel ({}, {}), sample {}", x, y,
                            sample));
}

// Adds what a tile got and counted to the whole, and tells how far the job is.
void RenderJob::Join(const FilmTile &tile, int samples, double seconds, const RayCounts &rays) {
    {
        const std::lock_guard lock(LockOf(tile.Number()));
        film_.Join(tile, samples);
    }
    const Point2i min = tile.Min(), max = tile.Max();
    const std::lock_guard lock(mutex_);
    tally_.rays += rays.rays;
    tally_.shadowRays += rays.shadowRays;
    samplesTaken_ += static_cast<uint64_t>((max.x - min.x) * (max.y - min.y) * samples);
    slowestSample_ = std::max(slowestSample_, seconds / samples);
    slowestTile_ = std::max(slowestTile_, seconds);
    if (options_.progress)
        options_.progress->Report(samplesTaken_, samplesInAll_);
}

// The samples of the next pass: as many as wished, fewer where a tile would take too long for them.
int RenderJob::PassLength(int wished) const {
    const double fit = kMaxTileSeconds / std::max(slowestSample_, 1e-9);
    return std::clamp(static_cast<int>(std::min(fit, 1e6)), 1, std::min(wished, kMaxPass));
}

JobResult RenderJob::Run() && {
    size_t threads = 1;
    OnThreads(options_.threads, [&] {
        threads = MaxThreads();
        if (madeIntegrator_)
            madeIntegrator_->Prepare(scene_, camera_);
        Learn();
        // Passes over the whole picture that grow in length, so that an interrupt leaves an even picture
        // early. How the samples are cut into passes has no influence on the film.
        int wished = 1;
        for (int to = samples_.first + film_.FewestDone(); to < samples_.last && !Interrupted();) {
            const int pass = std::min(PassLength(wished), samples_.last - to);
            VLOG(1) << Printable(sceneName_) << ": samples " << to << " to " << to + pass - 1;
            to += pass, wished = 2 * pass, slowestSample_ = slowestTile_ = 0;
            ParallelFor(film_.Tiles(), [&](size_t tile) {
                if (!Interrupted())
                    RenderTileOrFail(tile, to);
            });
        }
    });
    const bool complete = samplesTaken_ == samplesInAll_;
    if (const auto &checkpoints = options_.checkpoints; checkpoints && !complete)
        if (checkpoints->afterStop || partsWritten_ > 0 || WallSeconds() - start_ >= checkpoints->seconds)
            WritePart();
    if (options_.checkpoints && options_.checkpoints->written)
        *options_.checkpoints->written = partsWritten_;
    const uint64_t leftOut = film_.LeftOut();
    return {.film = std::move(film_),
            .camera = camera_,
            .spp = spp_,
            .samples = samples_,
            .complete = complete,
            .rays = {tally_.rays, tally_.shadowRays},
            .nanSamples = leftOut,
            .learned = integrator_->Learned(),
            .threads = threads,
            .seconds = tally_.seconds + WallSeconds() - start_};
}

} // namespace

Ray CameraRay(const Camera &camera, const Filter &filter, Point2i pixel, PixelSampler *sampler,
              float *weight) {
    const FilterSample offset = filter.Sample(sampler->Get2D());
    *weight = offset.weight;
    const Point2f pFilm{static_cast<float>(pixel.x) + 0.5f + offset.offset.x,
                        static_cast<float>(pixel.y) + 0.5f + offset.offset.y};
    return camera.GenerateRay(pFilm, sampler->Get2D());
}

JobResult RunJob(const SceneDescription &description, const Scene &scene, const JobOptions &options) {
    std::optional<WarningScope> warnings;
    if (options.warnings)
        warnings.emplace(options.warnings);
    return RenderJob(description, scene, options).Run();
}

} // namespace cuticle
