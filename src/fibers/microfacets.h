//> Declare a rough surface of microfacets
#pragma once

#include "core/vecmath.h"

namespace cuticle {

//> Choose how the slopes of a rough surface are distributed
// Both with roughness alpha, the slope at which the distribution falls to 1/e (Beckmann) or to 1/4 (GGX,
// Trowbridge and Reitz) of its peak; the root mean square slope of Beckmann's is alpha / sqrt(2), that of GGX
// is infinite.
enum class MicrofacetDistribution { Beckmann, GGX };
//<

//> Describe a random height field
// Smith's surface: slopes as given, heights independent of them and uniform in [-1, 1]. Directions are unit
// vectors in the frame of the mean surface: x along roughness alphaX, y along alphaY, z up; a walk over the
// surface and through it (Heitz et al. 2016) needs the two questions below, and loses no light.
class Microfacets {
  public:
    // Roughnesses are above 0; those below 1e-4 count as 1e-4.
    Microfacets(MicrofacetDistribution distribution, double alphaX, double alphaY);

    // The height at which a ray that travels along w (up or down) from height h meets the surface next; u in
    // (0, 1). Above 1: it leaves.
    double NextHeight(const Vector3d &w, double h, double u) const;
    // The normal of a facet that faces toward, chosen by the area that it shows to it. toward may point down:
    // facets are seen from below the mean surface as well, by rays that have passed between them.
    Vector3d VisibleNormal(const Vector3d &toward, double u0, double u1) const;
    // Smith's Lambda: of the facets, the area turned away over the projected area. At least 0 for w.z > 0, at
    // most -1 for w.z < 0.
    double Lambda(const Vector3d &w) const;

  private:
    MicrofacetDistribution distribution_;
    double alphaX_, alphaY_;
};
//<

} // namespace cuticle
//<
