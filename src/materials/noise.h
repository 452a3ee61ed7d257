// Perlin's gradient noise and the sums of it that textures are made of, with pbrt-v3's values.
#pragma once

#include "core/vecmath.h"

namespace cuticle {

// Perlin 2002, "Improving Noise": 0 at the points of the integer lattice, within [-1, 1], with continuous
// first and second derivatives; it repeats after 256 units along each axis. A coordinate that is not finite
// gives NaN.
float Noise(const Point3f &p);

// The sum of omega^i Noise(1.99^i p) over the octaves i = 0 .. octaves - 1; 0 for none.
//
// pbrt-v3 leaves out the octaves that a ray's differentials say are finer than a pixel. Rays carry no
// differentials here, so all octaves are summed, which is what pbrt-v3 itself does for a ray without them;
// the samples of a pixel average what is finer. The picture is that of pbrt-v3 as its pixels shrink, at the
// price of a little noise far away.
float FBm(const Point3f &p, float omega, int octaves);

// As FBm, with the absolute value of each octave. pbrt-v3 adds 0.2, about its mean, for an octave that it
// leaves out, and also for one beyond the last where it leaves out none: omega^octaves / 5, kept here so
// that values agree.
float Turbulence(const Point3f &p, float omega, int octaves);

} // namespace cuticle
