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

struct AtlasModel {
    std::string name;
    std::unique_ptr<AtlasFiber> (*make)(const std::string &name, const FiberInputs &inputs);
    bool farField = false; // does not know h
    std::unique_ptr<AtlasFiber> At(const FiberInputs &inputs) const { return make(name, inputs); }
};
// Chiang's as Pharr printed it, then every name that a scene may give its hair, then ours in double.
std::vector<AtlasModel> AtlasModels();
inline constexpr size_t kPrintedModel = 0, kOurModel = 1; // in this list

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
// lobes that are smooth around the fiber, 3e-5 at the kink of the trimmed logistic for beta_n near 1; samples' moments have
// a noise of about 4e-3 (quick: 2e-2).
struct FiberFaults {
    double bad; // share of values and samples with NaN, infinite or negative numbers
    double
        energy; // |light that leaves - light that leaves a smooth fiber of the same h, eta and absorption|, of 1
    double disagreement; // of samples and density: the largest difference of nine moments of the direction
    double weight;       // the largest f |cos| / pdf of a sample
    double asymmetry;    // mean of |S - S'| / (S + S'), S' with both directions exchanged, over the width
};
FiberFaults MeasureFiber(const AtlasModel &model, const FiberInputs &inputs, double thetaO, bool quick);
// Its energy in green by quadrature of f, and by the mean of f |cos| / pdf over samples.
double EnergyByQuadrature(const AtlasFiber &fiber, const FiberInputs &inputs, double thetaO);
double EnergyBySamples(const AtlasFiber &fiber, double thetaO, size_t n);

} // namespace cuticle
