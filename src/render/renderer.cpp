#include "render/renderer.h"

#include "core/error.h"
#include "render/filter.h"
#include "render/integrator.h"
#include "render/sampler.h"
#include "scene/camera.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <unistd.h>

namespace cuticle {

namespace {

double SecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string Clock(double seconds) {
    char text[32];
    const int s = static_cast<int>(seconds);
    if (s < 60)
        std::snprintf(text, sizeof text, "%.1fs", seconds);
    else if (s < 3600)
        std::snprintf(text, sizeof text, "%dm%02ds", s / 60, s % 60);
    else
        std::snprintf(text, sizeof text, "%dh%02dm", s / 3600, s / 60 % 60);
    return text;
}

// One line on a terminal, rewritten at most five times a second.
class Progress {
  public:
    Progress(bool on, double total) : on_(on && isatty(STDERR_FILENO)), total_(total) {}
    ~Progress() {
        if (on_)
            std::fprintf(stderr, "\r\033[K");
    }
    void Advance(double amount) {
        if (!on_)
            return;
        const std::lock_guard lock(mutex_);
        done_ += amount;
        const double elapsed = SecondsSince(start_);
        if (elapsed < lastShown_ + 0.2)
            return;
        lastShown_ = elapsed;
        const double fraction = done_ / total_;
        constexpr int kWidth = 30;
        const int filled = static_cast<int>(fraction * kWidth);
        std::fprintf(stderr, "\rRendering [%.*s%*s] %5.1f%%  %s elapsed, %s left \033[K", filled,
                     "##############################", kWidth - filled, "", 100 * fraction,
                     Clock(elapsed).c_str(),
                     Clock(elapsed * (1 - fraction) / std::max(fraction, 1e-9)).c_str());
    }

  private:
    bool on_;
    double total_, done_ = 0, lastShown_ = 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::mutex mutex_;
};

ImageAttribute TextAttribute(const std::string &s) {
    ImageAttribute a;
    a.text = s;
    return a;
}
ImageAttribute NumberAttribute(double v) {
    ImageAttribute a;
    a.kind = ImageAttribute::Kind::Number;
    a.number = v;
    return a;
}
// OpenEXR and pbrt multiply row vectors from the left: their matrix is the transpose of ours.
ImageAttribute MatrixAttribute(const Transform &t) {
    ImageAttribute a;
    a.kind = ImageAttribute::Kind::Matrix;
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j)
            a.matrix[4 * i + j] = static_cast<float>(t.M()[j][i]);
    return a;
}

} // namespace

std::string DefaultOutput(const SceneDescription &description) {
    std::string name = description.film.params.FindString("filename", "");
    if (!name.empty())
        return name;
    std::filesystem::path p = std::filesystem::path(description.filename).filename();
    if (p.extension() == ".gz")
        p.replace_extension();
    return p.replace_extension(".exr").string();
}

Image Render(const SceneDescription &description, const Scene &scene, const RenderOptions &options,
             RenderStats *stats) {
    const auto start = std::chrono::steady_clock::now();
    FilmOptions filmOptions = options.film;
    filmOptions.quick = options.quick;
    Film film(description.film, filmOptions);
    const Camera camera =
        MakeCamera(description.camera, film.Resolution(), description.film.params.FindFloat("diagonal", 35));
    const Filter filter = MakeFilter(description.filter);
    const std::unique_ptr<Integrator> integrator =
        MakeIntegrator(description.integrator, options.integrator.value_or(description.integrator.type));
    const SamplerSetup setup = MakeSampler(description.sampler);
    const int spp = options.spp.value_or(options.quick ? std::max(1, setup.spp / 4) : setup.spp);

    struct ThreadState {
        RayCounts counts;
        uint64_t nanSamples = 0;
    };
    tbb::enumerable_thread_specific<ThreadState> states;
    const Point2i lo = film.WindowMin(), hi = film.WindowMax();
    constexpr int kTile = 16;
    const Point2i tiles{(hi.x - lo.x + kTile - 1) / kTile, (hi.y - lo.y + kTile - 1) / kTile};
    const auto interrupted = [&] {
        return options.interrupted && options.interrupted->load(std::memory_order_relaxed);
    };

    Progress progress(options.progress, static_cast<double>(hi.x - lo.x) * (hi.y - lo.y) * spp);
    const auto renderTile = [&](int tile, int firstSample, int lastSample) {
        ThreadState &state = states.local();
        const int x0 = lo.x + tile % tiles.x * kTile, y0 = lo.y + tile / tiles.x * kTile;
        const int x1 = std::min(x0 + kTile, hi.x), y1 = std::min(y0 + kTile, hi.y);
        PixelSampler sampler(setup.kind, spp, options.seed);
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x)
                for (int s = firstSample; s < lastSample; ++s) {
                    sampler.Start(x, y, s);
                    const FilterSample offset = filter.Sample(sampler.Get2D());
                    const Point2f pFilm{static_cast<float>(x) + 0.5f + offset.offset.x,
                                        static_cast<float>(y) + 0.5f + offset.offset.y};
                    const Ray ray = camera.GenerateRay(pFilm, sampler.Get2D());
                    const Spectrum radiance =
                        integrator->Li(ray, scene, sampler, state.counts) * offset.weight;
                    if (!film.Add(x, y, radiance) && state.nanSamples++ == 0)
                        Warning("sample that is not finite",
                                "a sample that is not finite was left out at pixel (" + std::to_string(x) +
                                    ", " + std::to_string(y) + "), sample " + std::to_string(s));
                }
        progress.Advance(static_cast<double>(x1 - x0) * (y1 - y0) * (lastSample - firstSample));
    };

    // Passes over the whole picture that grow in length, so that an interrupt leaves an even picture early. The order
    // of additions within a pixel is that of its samples: passes and threads do not change a bit of the sum.
    tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
    for (int done = 0, pass = 1; done < spp && !interrupted(); done += pass, pass = std::min(2 * pass, 16)) {
        const int end = std::min(spp, done + pass);
        arena.execute([&] {
            tbb::parallel_for(tbb::blocked_range<int>(0, tiles.x * tiles.y, 1),
                              [&](const tbb::blocked_range<int> &r) {
                                  for (int tile = r.begin(); tile < r.end() && !interrupted(); ++tile)
                                      renderTile(tile, done, end);
                              });
        });
        pass = end - done;
    }

    stats->renderSeconds = SecondsSince(start);
    stats->spp = spp;
    stats->sppReached = film.MinSamples();
    stats->width = film.Resolution().x;
    stats->height = film.Resolution().y;
    stats->threads = arena.max_concurrency();
    stats->rays = stats->shadowRays = stats->nanSamples = 0;
    for (const ThreadState &state : states) {
        stats->rays += state.counts.rays;
        stats->shadowRays += state.counts.shadowRays;
        stats->nanSamples += state.nanSamples;
    }
    // A pixel that lost samples to NaN holds fewer than were taken; nothing is lost by an interrupt then
    if (!interrupted())
        stats->sppReached = spp;

    Image image = film.Develop(options.variance);
    image.attributes["scene"] =
        TextAttribute(std::filesystem::path(description.filename).filename().string());
    image.attributes["version"] = TextAttribute(CUTICLE_VERSION);
    image.attributes["spp"] = NumberAttribute(stats->sppReached);
    image.attributes["seed"] = NumberAttribute(static_cast<double>(options.seed));
    image.attributes["renderTime"] = NumberAttribute(stats->renderSeconds);
    image.attributes["worldToCamera"] = MatrixAttribute(camera.WorldToCamera());
    if (camera.HasCameraToScreen())
        image.attributes["worldToScreen"] = MatrixAttribute(camera.CameraToScreen() * camera.WorldToCamera());
    return image;
}

} // namespace cuticle
