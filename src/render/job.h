// A render as a job: a scene and the samples to take of it in, a film with counts out. The command line, the
// figures and the tests all render by it.
#pragma once

#include "render/film.h"
#include "render/filter.h"
#include "render/integrator.h"
#include "render/progress.h"
#include "render/sampler.h"
#include "scene/camera.h"
#include "scene/scene.h"

#include <atomic>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cuticle {

// How a job keeps what it has done on disk, so that a run that is killed loses little.
struct Checkpoints {
    std::string filename;      // the film's file (render/film_file.h), the "part"
    double seconds = 60;       // > 0; no kill loses more of this job's time than that
    bool resume = false;       // the job goes on from the file, if it is there
    bool afterStop = false;    // a stopped job writes it however short it was; else from `seconds` on
    size_t *written = nullptr; // is told how often the file was written, or that it was read; null: nobody
};

// The wishes of a job's caller; every default is what the scene says.
struct JobOptions {
    // The samples per pixel of the whole render, of which this job may be a part: they make one stratified
    // set, so that sample s is the same point in every part. Default: the scene's Sampler says.
    std::optional<int> spp;
    std::optional<SampleRange> samples; // this job's part, 0 <= first < last <= spp; default: all of them
    uint64_t seed = 0;                  // another seed, another noise
    FilmOptions film;                   // the crop window
    bool variance = false;              // the film keeps what the variance of every pixel needs
    bool quick = false; // pbrt's --quick: a quarter of the samples and of the resolution in each direction
    std::optional<std::string> integrator; // overrides the scene's
    // An integrator of the caller's own, which keeps it; it precedes every name.
    const Integrator *ownIntegrator = nullptr;
    // The causes of the picture that only the caller knows, by name: the contents of the scene's files,
    // the options that it was built with.
    std::vector<std::pair<std::string, std::string>> facts;
    std::optional<Checkpoints> checkpoints;
    size_t threads = 0;               // 0: all cores. The film does not depend on it.
    ProgressSink *progress = nullptr; // is told after each tile
    WarningSink *warnings = nullptr;  // takes the job's warnings; null: the calling thread's sink does
    // Becomes true to stop the job: tiles under way are finished, no more are begun.
    const std::atomic<bool> *interrupted = nullptr;
    // Takes what was thrown while samples were taken, and the job ends as if interrupted; null: it is thrown
    // by RunJob, and the film is lost.
    std::exception_ptr *failure = nullptr;
};

// A job that is done.
struct JobResult {
    Film film;
    Camera camera;           // that took the picture
    int spp = 0;             // of the whole render
    SampleRange samples;     // that were to be taken
    bool complete = false;   // false after an interrupt that left samples out
    RayCounts rays;          // traced
    uint64_t nanSamples = 0; // samples that were not finite: reported and left out of the film
    std::string learned;     // by the integrator from a pilot, in words
    size_t threads = 1;      // that the job could use
    double seconds = 0;      // on the wall, of all runs that went on from one another; so are the counts

    // The samples of this job that every pixel has got, those left out as not finite included.
    int SamplesReached() const { return film.FewestDone(); }
};

// The ray of a pixel's sample that was started, and its weight in the pixel.
Ray CameraRay(const Camera &camera, const Filter &filter, Point2i pixel, PixelSampler *sampler,
              float *weight);

// Renders the job's samples of a scene. The film is the same bit for bit for any number of threads. Throws
// Error where the scene's film, sampler, filter, camera or integrator is wrong, or the range is no part of
// the render, and where it is to go on from a film of another one, or would write over a film of this one. A
// CHECK that fails meanwhile names scene, pixel and sample.
JobResult RunJob(const SceneDescription &description, const Scene &scene, const JobOptions &options);

} // namespace cuticle
