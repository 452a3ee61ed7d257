// Scene in, picture out: a job that takes all samples, and the picture of its film with what is known of it.
#pragma once

#include "images/image.h"
#include "render/job.h"

#include <string>

namespace cuticle {

using RenderOptions = JobOptions;

struct RenderStats {
    double renderSeconds = 0;  // on the wall
    int spp = 0;               // asked for
    int sppReached = 0;        // by every pixel; smaller than spp after an interrupt
    int width = 0, height = 0; // of the whole picture, crop windows aside
    size_t threads = 0;
    uint64_t rays = 0, shadowRays = 0; // to find the next surface; to find whether a light is seen
    std::string learned;               // by the integrator from a pilot, in words
    std::string denoised;    // how far the picture is off, in words; empty where it was not asked for
    uint64_t nanSamples = 0; // left out of the picture and reported
};

// Renders the scene. The image carries as attributes: scene, spp, seed, version, worldToCamera, worldToScreen
// (EXR's row-vector convention), renderTime (seconds). Throws Error as RunJob does. The statistics are
// written if asked for.
Image Render(const SceneDescription &description, const Scene &scene, const RenderOptions &options,
             RenderStats *stats = nullptr);

// The picture's file name: the Film's, or the scene's name with .exr.
std::string DefaultOutput(const SceneDescription &description);

} // namespace cuticle
