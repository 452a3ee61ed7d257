// The loop over pixels and samples: parallel, resumable by the interrupt key, the same picture for any number of threads.
#pragma once

#include "images/image.h"
#include "render/film.h"
#include "scene/scene.h"

#include <atomic>
#include <optional>
#include <string>

namespace cuticle {

struct RenderOptions {
    std::optional<int> spp;                // overrides the scene's sampler
    std::optional<std::string> integrator; // overrides the scene's
    int threads = 0;                       // 0: all cores
    uint64_t seed = 0;
    FilmOptions film;
    bool quick = false;    // pbrt's --quick: a quarter of the samples and of the resolution in each direction
    bool progress = true;  // on standard error, only where that is a terminal
    bool variance = false; // add variance channels
    // Becomes true when the user asks to stop: tiles under way are finished, no more are begun.
    const std::atomic<bool> *interrupted = nullptr;
};

struct RenderStats {
    double renderSeconds = 0;
    int spp = 0;        // asked for
    int sppReached = 0; // by every pixel; smaller than spp after an interrupt
    int width = 0, height = 0, threads = 0;
    uint64_t rays = 0, shadowRays = 0; // to find the next surface; to find whether a light is seen
    uint64_t nanSamples = 0;           // left out of the picture and reported
};

// Renders the scene. The image carries as attributes: scene, spp, seed, version, worldToCamera, worldToScreen (EXR's row-vector convention),
// renderTime (seconds). Throws Error where the scene's film, sampler, filter, camera or integrator is wrong.
Image Render(const SceneDescription &description, const Scene &scene, const RenderOptions &options,
             RenderStats *stats);

// The picture's file name: the Film's, or the scene's name with .exr.
std::string DefaultOutput(const SceneDescription &description);

} // namespace cuticle
