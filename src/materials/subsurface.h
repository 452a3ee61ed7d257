// Measured scattering media, and the reflectance of a deep body of one: what stands in for subsurface
// scattering.
#pragma once

#include "core/color.h"

#include <optional>
#include <string_view>

namespace cuticle {

// Absorption and reduced scattering, 1/mm, in linear RGB.
struct ScatteringMedium {
    Spectrum sigmaA, reducedSigmaS;
};
// The medium of pbrt-v3's name ("Skin1", "Wholemilk"); nothing for any other.
std::optional<ScatteringMedium> FindScatteringMedium(std::string_view name);

// The fraction of diffuse light that a half space reflects, by the dipole of Jensen et al. 2001 (the
// integral of its equation 4). reducedAlbedo = sigma_s' / (sigma_s' + sigma_a), clamped to [0, 1]; eta > 0:
// the index of the body.
float DipoleReflectance(float reducedAlbedo, float eta);

} // namespace cuticle
