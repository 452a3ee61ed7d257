//> Declare the model of Marschner and colleagues
#pragma once

#include "fibers/bxdf.h"
#include "fibers/longitudinal.h"
#include "fibers/smooth_fiber.h"

#include <array>

namespace cuticle {

//> List the parameters of Table 1
// Angles in degrees. alpha and beta are those of theta_h = (theta_i + theta_o) / 2, in the order R, TT, TRT.
// Values that are not finite throw Error; others out of range are clamped.
//
//   eta           1.001 to 1e3
//   sigmaA        absorption per fiber radius, at least 0
//   alpha         shift of the lobes: negative toward the root, positive toward the tip
//   beta          their standard deviations, at least 0.003
//   eccentricity  a, minor over major axis, 0.2 to 5; 1 is a circle
//   kG            strength of the glints, at least 0
//   wc            standard deviation of the glints around the fiber, 0.1 to 60
//   etaRange      over which they fade after they have met, in eta'; at least 1e-3
//   maxH          limit of their power: of the width of the fiber, in h
//   kd            energy of a diffuse term, at least 0 (section 5.3)
//   axis          azimuth of the major axis in the local frame, from y toward z
//   orders        bit p: whether order p counts (R, TT, TRT)
struct MarschnerParameters {
    float eta = 1.55f;
    std::array<float, 3> sigmaA = {0.2f, 0.2f, 0.2f};
    std::array<float, 3> alpha = {-5, 2.5f, 7.5f};
    std::array<float, 3> beta = {7.5f, 3.75f, 15};
    float eccentricity = 1;
    float kG = 1, wc = 15, etaRange = 0.3f, maxH = 0.5f;
    std::array<float, 3> kd = {0, 0, 0};
    float axis = 0;
    uint32_t orders = 7;

    RootMethod roots = RootMethod::Exact;
    SegmentLength length = SegmentLength::Chord;
    LongitudinalForm longitudinal = LongitudinalForm::FullAngle;
    // The printed eta* has its caustics the wrong way round: a^2 belongs to phi_h = 90 degrees. True: as
    // printed.
    bool printedEccentricity = false;
};
//<

//> Write the model for any kind of number
// T is float or double. Directions are unit vectors in the local frame of the fiber, x along it.
template <typename T>
class Marschner {
  public:
    // Parameters must be in range: see CheckedMarschner.
    explicit Marschner(const MarschnerParameters &parameters);

    FiberValue<T> Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const;
    // Chooses *wi from four numbers in (0, 1).
    FiberValue<T> Sample(const Vector3<T> &wo, std::array<T, 4> u, Vector3<T> *wi) const;

    // N_p of p = 0, 1, 2 at cos theta_d; phi = phi_o - phi_i (any sign: N_p is even), phiH their mean from
    // the major axis.
    std::array<T, 3> Azimuthal(int p, T cosThetaD, T phi, T phiH) const;
    // eta* of the TRT lobe.
    T EtaStar(T phiH) const;

    MarschnerParameters parameters;

  private:
    struct Glint; // of TRT, for one inclination
    struct View;  // what depends on the viewer alone
    bool Counts(size_t p) const { return (parameters.orders >> p & 1) != 0; }
    Glint GlintOf(T cosThetaD, T etaStar) const;
    View ViewOf(const Vector3<T> &wo) const;
    T Path(int p, T gamma, const SmoothFiber<T> &fiber) const;
    std::array<T, 3> ThroughRoots(int p, T phi, const SmoothFiber<T> &paths,
                                  const SmoothFiber<T> &fiber) const;
    T PathDensity(int p, T phi, const SmoothFiber<T> &fiber) const;
    T TrtDensity(const View &view, T cosThetaD, T phi) const;
    T SampleTrt(const View &view, T cosThetaD, T rest, T u) const;
    FiberValue<T> Gather(const View &view, const Inclination<T> &i, T phi) const;

    T eta_;
    std::array<T, 3> sigmaA_, kd_;
    std::array<LongitudinalLobe<T>, 3> along_;
};
//<

//> Say what Marschner's class takes
// Marschner, Jensen, Cammarano, Worley and Hanrahan 2003. Far field. Throws Error for parameters that are not
// finite.
class MarschnerBSDF final : public BxDFOf<Marschner<Float>> {
  public:
    explicit MarschnerBSDF(const MarschnerParameters &parameters);
    std::string ToString() const override;
};
// The parameters, clamped to their ranges.
MarschnerParameters CheckedMarschner(MarschnerParameters parameters);
//<

} // namespace cuticle
//<
