// Any model of a fiber, measured the same way: what the atlas needs of it.
#pragma once

#include "core/vecmath.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace cuticle {

// The common parameters of a fiber in a scene, and where across its width it is met. Angles in degrees.
struct FiberInputs {
    double h = 0.3, eta = 1.55, sigmaA = 0, betaM = 0.3, betaN = 0.3, alpha = 2;
    double reflectance = -1; // of a gray fiber, in place of sigmaA; negative: none
};

class AtlasFiber {
  public:
    struct Value {
        std::array<double, 3> fCos; // f |cos| in red, green, blue
        double pdf;
    };
    virtual ~AtlasFiber() = default;
    virtual Value Evaluate(const Vector3d &wo, const Vector3d &wi) const = 0;
    // Chooses *wi from four numbers in [0, 1). pdf 0: none.
    virtual Value Sample(const Vector3d &wo, const std::array<double, 4> &u, Vector3d *wi) const = 0;
};

// How the atlas has a model: as its paper printed it, in float; ours as scenes have it, in float; ours in double.
enum class AtlasForm { Published, InFloat, InDouble };
inline constexpr std::array kAtlasForms = {AtlasForm::Published, AtlasForm::InFloat, AtlasForm::InDouble};

// unpublished: why there is no form of its own as published, in lines; empty if there is one. parameters: those of a scene
// that make it so, with which it is sampled in our way; the papers before Chiang's give none.
struct AtlasModel {
    std::string name;  // that a scene gives its hair
    std::string title; // for readers
    std::string parameters;
    std::vector<std::string> unpublished;
    bool cells = false;    // linear from cell to cell of a FiberTable
    bool farField = false; // does not know h
    bool Has(AtlasForm form) const { return form != AtlasForm::Published || unpublished.empty(); }
    // Only of a form that it has.
    std::unique_ptr<AtlasFiber> At(AtlasForm form, const FiberInputs &inputs) const;
};
// Every name that a scene may give its hair, the default model first.
const std::vector<AtlasModel> &AtlasModels();
// The default model as it renders.
std::unique_ptr<AtlasFiber> OurFiber(const FiberInputs &inputs);

// Pharr's BSDF with the tilt on theta_i (the text) or theta_o (pbrt-v3's program).
std::unique_ptr<AtlasFiber> PrintedFiber(const FiberInputs &inputs, bool tiltOnThetaI);

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
std::vector<ThetaPeak> LobePeaks(const FiberInputs &inputs, double thetaO);

// What goes wrong with one fiber seen from thetaO (radians). The quadrature's own error of the energy is below 1e-6 for
// lobes that are smooth around the fiber, 3e-5 at the kink of the trimmed logistic for beta_n near 1, tables are integrated from cell to cell; samples' moments have
// a noise of about 4e-3 (quick: 2e-2).
struct FiberFaults {
    double bad; // share of values and samples with NaN, infinite or negative numbers
    double
        energy; // |light that leaves - light that leaves a smooth fiber of the same h, eta and absorption|, of 1
    double disagreement; // of samples and density: the largest difference of nine moments of the direction
    double weight;       // the largest f |cos| / pdf of a sample
    double asymmetry;    // mean of |S - S'| / (S + S'), S' with both directions exchanged, over the width
};
FiberFaults MeasureFiber(const AtlasModel &model, AtlasForm form, const FiberInputs &inputs, double thetaO,
                         bool quick);
// Its energy in green by quadrature of f, and by the mean of f |cos| / pdf over samples.
double EnergyByQuadrature(const AtlasFiber &fiber, const FiberInputs &inputs, double thetaO);
double EnergyBySamples(const AtlasFiber &fiber, double thetaO, size_t n);

} // namespace cuticle
