// The makers of lights, for the tables in light.cpp, and what they share.
#pragma once

#include "scene/light.h"

#include <string_view>

namespace cuticle {

// The largest value of a light, in any unit: what is brighter could leave binary32 when a sharp lobe
// multiplies it nearby. The sun's disk has a radiance of 1e7 W/(m^2 sr).
inline constexpr float kMaxLightValue = 1e18f;

// The parameter `name` times "scale", each 1 where it is not given. Values below 0, NaN or above
// kMaxLightValue are set to 0 or that maximum, with a Warning at the directive. light: "point", for the
// message.
Spectrum ScaledLightValue(const ParamSet &params, std::string_view name, std::string_view light);

// The radius of the scene's bounding sphere; 1 for an empty scene.
float WorldRadius(const Bounds3f &b);

// Error at the directive where the light's transformation has no inverse.
void RequireInvertible(const LightEntity &entity);

// Each maker reads its parameters and throws Error at the directive where they make no light. worldBound: of
// all shapes. In infinite_light.cpp:
std::unique_ptr<Light> MakeInfinite(const LightEntity &entity, const Bounds3f &worldBound);
// In delta_lights.cpp:
std::unique_ptr<Light> MakeDistant(const LightEntity &entity, const Bounds3f &worldBound);
std::unique_ptr<Light> MakePoint(const LightEntity &entity, const Bounds3f &worldBound);
std::unique_ptr<Light> MakeSpot(const LightEntity &entity, const Bounds3f &worldBound);
std::unique_ptr<Light> MakeGoniometric(const LightEntity &entity, const Bounds3f &worldBound);
std::unique_ptr<Light> MakeProjection(const LightEntity &entity, const Bounds3f &worldBound);

} // namespace cuticle
