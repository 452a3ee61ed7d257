//> Derive the lobes of older models from the common parameters
// A scene that gives only beta_m, beta_n and alpha renders with every model: lobes as wide as the default
// model's.
#pragma once

#include "fibers/models.h"
#include "fibers/mp.h"
#include "fibers/np.h"

namespace cuticle {

//> Measure the default model's lobes in degrees
// Standard deviations: of theta_i + theta_o in lobe p, and around the fiber.
inline float LongitudinalWidth(size_t p, float betaM) {
    return Degrees(std::sqrt(LongitudinalVariance(std::clamp(betaM, 0.f, 1.f))[p]));
}
inline float AzimuthalWidth(float betaN) {
    return 180 / std::sqrt(3.f) * AzimuthalScale(std::clamp(betaN, 0.f, 1.f));
}
//<

//> Tilt lobe p as the default model does
// The shift of theta_i + theta_o in degrees, from -180 to 180, for an alpha of any size.
inline float ShiftOfTilt(size_t p, float alpha) {
    return static_cast<float>(std::remainder(-double(kTiltInAlpha[p]) * double(alpha), 360.));
}
//<

//> Take the angles of three lobes from a scene where it gives them
// beta_R, beta_TT, beta_TRT and alpha_R, ... in degrees, times `unit`; else those of the default model.
class LobeAngles {
  public:
    LobeAngles(const FiberSettings &settings, float unit) : unit_(unit) {
        constexpr const char *kBeta[] = {"beta_R", "beta_TT", "beta_TRT"},
                             *kAlpha[] = {"alpha_R", "alpha_TT", "alpha_TRT"};
        for (size_t p = 0; p < 3; ++p)
            beta_[p] = settings.Slot(kBeta[p]), alpha_[p] = settings.Slot(kAlpha[p]);
    }
    float Width(size_t p, const FiberInputs &at) const {
        return beta_[p] ? unit_ * at.numbers[*beta_[p]] : LongitudinalWidth(p, at.betaM);
    }
    float Shift(size_t p, const FiberInputs &at, float otherwise) const {
        return alpha_[p] ? unit_ * at.numbers[*alpha_[p]] : otherwise;
    }

  private:
    float unit_;
    std::array<std::optional<size_t>, 3> beta_, alpha_;
};
//<

//> Count the lobes of a scene
// How many orders have a lobe of their own: the parameter "lobes", 1 to 16; Error beyond.
inline constexpr int kMaxSceneLobes = 16;
inline int LobesOf(const FiberSettings &settings, int otherwise) {
    const int lobes = settings.Integer("lobes", otherwise);
    if (lobes < 1 || lobes > kMaxSceneLobes)
        throw settings.ErrorAt("lobes",
                               fmt::format("\"lobes\" must be 1 to {}, not {}", kMaxSceneLobes, lobes));
    return lobes;
}
//<

} // namespace cuticle
//<
