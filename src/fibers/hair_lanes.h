//> Declare the kernels that run the four lobes in the lanes of a register
#pragma once

#include "core/vecmath.h"

#include <array>
#include <string>
#include <vector>

namespace cuticle {

//> Say what the letters stand for
// T is float, double or long double. V is one of these, or a register of floats that holds one number for
// each lobe or for each colour; functions of V are what the fast kernels and the plain model share.
//
// theta is the angle from the plane normal to the fiber, sin theta = w.x, positive toward the tip. phi is the
// angle around the fiber. Suffix O: toward the viewer. I: toward the light. T: inside. p counts the segments
// inside.
inline constexpr int kLobes = 4;
//<

//> Choose which way the scales tilt the lobes
// The R lobe, with u from root to tip and angles measured toward the tip, lies at theta_i + theta_o = -2
// alpha as Marschner et al. 2003 measured and as Pharr's text has it: RootToTip. pbrt-v3's program has it at
// +2 alpha.
enum class ScaleTilt { RootToTip, PbrtV3 };
//<

//> List the parameters of a fiber
// As HairBSDF takes them, already clamped.
struct HairParameters {
    float h, eta;
    std::array<float, 3> sigmaA;
    float betaM, betaN, alpha; // alpha in degrees
    ScaleTilt tilt;
};
//<

//> Keep what depends on the fiber alone, one lane for each lobe
// Filled once at every hit. The last lane is the lobe of all remaining orders, whose azimuth is uniform: a
// logistic of infinite width, 1/s = 0.
struct HairSetup {
    float h, cosGammaO, eta, etaSquaredMinusOne;
    std::array<float, 4> sigmaA;           // r, g, b, and 0
    std::array<float, 4> sinTilt, cosTilt; // of the angle added to theta_o
    std::array<float, 4> v, invV, mpNorm;  // variance, 1 / v, 1 / (v (1 - exp(-2/v)))
    std::array<float, 4> mpMass;           // 1 - exp(-2/v)
    std::array<float, 4> invS, npNorm;     // 1 / s and the factor of the logistic
    float s, npTail;                       // npTail: twice the mass that a logistic has beyond pi
};
//<

//> Name the results of an evaluation
// fCos: f |wi.z| in r, g, b; pdf in 1/sr.
struct HairValue {
    std::array<float, 3> fCos;
    float pdf;
};
//<

//> Declare the kernels
struct HairKernels {
    const char *name; // of the instruction set, or "scalar"
    void (*setUp)(const HairParameters &parameters, HairSetup &setup);
    HairValue (*evaluate)(const HairSetup &setup, const Vector3f &wo, const Vector3f &wi);
    HairValue (*sample)(const HairSetup &setup, const Vector3f &wo, const std::array<float, 4> &u,
                        Vector3f *wi);
};
// Returns the kernels in use: at first those of the instruction set that core/isa.h chooses, which throws
// Error where CUTICLE_ISA cannot be obeyed.
const HairKernels &CurrentHairKernels();
// Returns the names of those that this processor runs, the widest first; "scalar" is always among them.
std::vector<std::string> HairKernelNames();
// Uses the kernels of that name from here on, for comparisons; call it before rendering starts. Error if the
// name is unknown or the processor cannot run them.
void SetHairKernels(const std::string &name);
//<

} // namespace cuticle
//<
