//> Declare the hair model behind pbrt-v3's interface
#pragma once

#include "fibers/bxdf.h"
#include "fibers/hair_lanes.h"

namespace cuticle {

//> Describe what the model takes, and what it does with bad input
// The scattering of one fiber at one place across its width: the model of Chiang et al. 2016 as Pharr's text
// presents it, made exact. What departs from the text, and why, stands beside the code in mp.h, ap.h, np.h.
//
//   h        offset across the width, [-1, 1], as the ribbon that faces wo is hit; clamped
//   eta      index of refraction of the fiber against its surroundings; clamped to [1e-3, 1e3]. 1 means no
//            interface: light passes straight on, absorbed. Below 1 light is also reflected totally.
//   sigma_a  absorption per fiber radius, linear RGB; clamped to [0, 1e18]
//   beta_m   longitudinal roughness in [0, 1], clamped. Lobes narrower than 2^-15 rad (standard deviation),
//            hence also beta_m = 0, are given that width: the narrowest that binary32 directions still
//            resolve.
//   beta_n   azimuthal roughness in [0, 1], clamped; the narrowest logistic scale is 2^-16 rad
//   alpha    tilt of the cuticle scales in degrees, any finite value; of use are 0 to about 10
//
// NaN in any of these, and an infinite eta or alpha, throws Error. Directions are unit vectors in the local
// frame (x along the fiber from root to tip, y across its width, z the normal): NaN there, or in u, comes
// back as NaN in value, density and direction, so that it can be counted. Nothing here aborts or loops on
// data.
//<
class HairBSDF final : public FiberBxDF {
  public:
    // Lobes p = 0 (R), 1 (TT), 2 (TRT) are modelled one by one; lobe pMax holds all that remain.
    static const int pMax = 3;

    HairBSDF(Float h, Float eta, const Spectrum &sigma_a, Float beta_m, Float beta_n, Float alpha,
             ScaleTilt tilt = ScaleTilt::RootToTip);

    // The same fiber met at another offset: next to nothing has to be computed anew.
    HairBSDF(const HairBSDF &fiber, Float h);

    //> Evaluate, sample and weigh
    // Value and density together cost about half of the two.
    Spectrum FPdf(const Vector3f &wo, const Vector3f &wi, Float *pdf) const override;
    // The four numbers choose the lobe, the azimuth and (two) the longitudinal angle. They are clamped to
    // [2^-33, 1 - 2^-24], so the density is never zero for the number 0. *pdf = 0 (and f black) where no
    // light leaves: A_p below 1e-38 in sum.
    using FiberBxDF::Sample_f;
    Spectrum Sample_f(const Vector3f &wo, Vector3f *wi, const std::array<Float, 4> &u,
                      Float *pdf) const override;
    //<

    std::string ToString() const override;

    //> Turn pigments or a colour into absorption
    // sigma_a of ce parts eumelanin (black, brown) and cp parts pheomelanin (red): blonde is about ce = 0.3,
    // brown 1.3, black 8. d'Eon et al. 2011. Negative concentrations count as 0.
    static Spectrum SigmaAFromConcentration(Float ce, Float cp);
    // The sigma_a with which a dense mass of this hair looks of colour c under a white dome: the fit of
    // Chiang et al. 2016. c is clamped into [1e-4, 1]: 0 would need infinite absorption. beta_n is clamped to
    // [0, 1]. Never NaN unless c is.
    static Spectrum SigmaAFromReflectance(const Spectrum &c, Float beta_n);
    //<

  private:
    HairParameters parameters_;
    HairSetup setup_;
    const HairKernels *kernels_;
};

} // namespace cuticle
//<
