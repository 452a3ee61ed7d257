//> Declare what guides a picture's smoothing
#pragma once

#include "render/denoise.h"
#include "render/filter.h"
#include "scene/camera.h"
#include "scene/scene.h"

namespace cuticle {

// A window of a picture, and how each of its pixels is looked at for guides.
struct GuideView {
    Point2i min, max; // min.x <= x < max.x, and so on
    int rays = 0;     // for each pixel, at least 1
    uint64_t seed = 0;
};

// Looks at a picture by rays that end where they first hit something: how much of each pixel is covered, and
// the light that what is seen would send to the camera if nothing stood in the way of the lamps. A tenth of a
// path's time or less. The same for any number of threads; rays share nothing with those of paths.
Guides SeeGuides(const Scene &scene, const Camera &camera, const Filter &filter, const GuideView &view);

} // namespace cuticle
//<
