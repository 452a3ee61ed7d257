//> Derive the lobes of older models from the common parameters
// A scene that gives only beta_m, beta_n and alpha renders with every model: lobes as wide as the default
// model's.
#pragma once

#include "fibers/models.h"
#include "fibers/mp.h"
#include "fibers/np.h"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

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

//> Read which orders a scene asks for
// The parameter "orders": words R, TT, TRT, TRRT ..., and "rest" for the lobe that all further orders share;
// bit p of what is returned is order p, the lobe of the rest is bit `lobes`. All of them where it is not
// given; Error for another word.
inline uint32_t OrdersOf(const FiberSettings &settings, int lobes, bool rest) {
    if (!settings.Has("orders"))
        return ~0u;
    std::vector<std::string> names;
    for (int p = 0; p < lobes; ++p)
        names.push_back(p == 0 ? "R" : "T" + std::string(static_cast<size_t>(p) - 1, 'R') + "T");
    if (rest)
        names.emplace_back("rest");
    const std::vector<std::string_view> known(names.begin(), names.end());
    uint32_t orders = 0;
    std::istringstream words(settings.Word("orders", ""));
    for (std::string word; words >> word;) {
        const auto found = std::find(known.begin(), known.end(), word);
        if (found == known.end())
            throw settings.ErrorAt("orders", fmt::format("\"orders\" names \"{}\". {}", word,
                                                         Suggestion(word, known.data(), known.size())));
        orders |= 1u << (found - known.begin());
    }
    if (orders == 0)
        throw settings.ErrorAt("orders",
                               "\"orders\" names no order; name some of R, TT, TRT, or leave it out");
    return orders;
}
inline constexpr ParamInfo kOrdersParam = {
    "orders", "string", "", "all",
    "the lobes that count: some of R, TT, TRT ..., and rest, with blanks between"};
//<

} // namespace cuticle
//<
