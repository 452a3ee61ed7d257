// Any model of a fiber, measured the same way: what the atlas needs of it.
#pragma once

#include "core/vecmath.h"
#include "fibers/bxdf.h"
#include "fibers/models.h"

#include <array>
#include <memory>
#include <vector>

namespace cuticle {

// The common parameters of a fiber in a scene, and where across its width it is met. Angles in degrees.
struct AtlasInputs {
    double h = 0.3, eta = 1.55, sigmaA = 0, betaM = 0.3, betaN = 0.3, alpha = 2;
    double reflectance = -1; // of a gray fiber, in place of sigmaA; negative: none
};

// How the atlas has a model: as its paper printed it, in float; ours as scenes have it, in float; ours in
// double.
enum class AtlasForm { Published, InFloat, InDouble };
inline constexpr std::array kAtlasForms = {AtlasForm::Published, AtlasForm::InFloat, AtlasForm::InDouble};

// False only of a model without a published form of its own: its row (fibers/models.h) says why.
bool HasForm(const FiberModel &model, AtlasForm form);
// Only of a form that it has. The papers before Chiang's give no way to sample: published forms of these are
// ours with other parameters, and sampled in our way.
std::unique_ptr<FiberInDouble> MakeAtlasFiber(const FiberModel &model, AtlasForm form,
                                              const AtlasInputs &inputs);
// The default model as it renders.
std::unique_ptr<FiberInDouble> OurFiber(const AtlasInputs &inputs);

// Pharr's BSDF with the tilt on theta_i (the text) or theta_o (pbrt-v3's program).
std::unique_ptr<FiberInDouble> PrintedFiber(const AtlasInputs &inputs, bool tiltOnThetaI);

// A unit direction; angles in radians, phi from the surface's tangent plane.
Vector3d FiberDirection(double theta, double phi);

// Numbers that stand in the unit cube of four dimensions more evenly than chance has them: the i-th.
std::array<double, 4> EvenlySpread(size_t i);

// A quadrature over theta in [-pi/2, pi/2] whose nodes close up on peaks.
struct ThetaRule {
    std::vector<double> theta, weight;
};
struct ThetaPeak {
    double centre, width;
};
ThetaRule MakeThetaRule(const std::vector<ThetaPeak> &peaks, size_t nodesInAPanel = 5);
// The peaks of the four longitudinal lobes for a viewer at thetaO.
std::vector<ThetaPeak> LobePeaks(const AtlasInputs &inputs, double thetaO);

// Measures of what goes wrong with one fiber seen from thetaO (radians). The quadrature's own error of the
// energy is below 1e-6 for lobes that are smooth around the fiber, 3e-5 at the kink of the trimmed logistic
// for beta_n near 1, tables are integrated from cell to cell; samples' moments have a noise of about 4e-3
// (quick: 2e-2).
struct FiberFaults {
    double bad; // share of values and samples with NaN, infinite or negative numbers
    // |light that leaves - light that leaves a smooth fiber of the same h, eta and absorption|, of 1
    double energy;
    double disagreement; // of samples and density: the largest difference of nine moments of the direction
    double weight;       // the largest f |cos| / pdf of a sample
    double asymmetry;    // mean of |S - S'| / (S + S'), S' with both directions exchanged, over the width
};
FiberFaults MeasureFiber(const FiberModel &model, AtlasForm form, const AtlasInputs &inputs, double thetaO,
                         bool quick);
// Its energy in green by quadrature of f, and by the mean of f |cos| / pdf over samples.
double EnergyByQuadrature(const FiberInDouble &fiber, const AtlasInputs &inputs, double thetaO);
double EnergyBySamples(const FiberInDouble &fiber, double thetaO, size_t n);

} // namespace cuticle
