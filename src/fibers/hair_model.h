//> Put the model together, plainly
#pragma once

#include "fibers/ap.h"
#include "fibers/fiber_angles.h"
#include "fibers/hair_lanes.h"
#include "fibers/mp.h"
#include "fibers/np.h"

namespace cuticle {

//> Declare the plain model
// One lobe after the other, in the order of the text: what the book explains and what the kernels are tested
// against. Float renders where no kernel fits the processor; double and long double are the reference.
template <typename T>
class HairLobes {
  public:
    explicit HairLobes(const HairParameters &parameters);
    // Takes what a kernel has prepared.
    explicit HairLobes(const HairSetup &setup)
        : h(setup.h), cosGammaO(setup.cosGammaO),
          eta(setup.eta), sigmaA{setup.sigmaA[0], setup.sigmaA[1], setup.sigmaA[2]}, v(setup.v),
          sinTilt(setup.sinTilt), cosTilt(setup.cosTilt), s(setup.s), npTail(setup.npTail) {}

    struct Value {
        std::array<T, 3> fCos; // f |wi.z|
        T pdf;
    };
    // The same for directions given as unit vectors.
    Value Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const;
    // Chooses *wi from four numbers in [0, 1).
    Value Sample(const Vector3<T> &wo, std::array<T, 4> u, Vector3<T> *wi) const;
    // A_p of each lobe in r, g, b for wo.
    std::array<std::array<T, 3>, kLobes> Attenuations(const Vector3<T> &wo) const;
    // M_p and N_p of lobe p.
    T Longitudinal(size_t p, T sinThetaO, T cosThetaO, T sinThetaI, T cosThetaI) const;
    T Azimuthal(size_t p, T dPhi) const;

    T h, cosGammaO, eta;
    std::array<T, 3> sigmaA;
    std::array<T, kLobes> v, sinTilt, cosTilt;
    T s, npTail;

  private:
    Refraction<T> Refracted(T cosThetaO) const {
        return Refract(cosThetaO, h, cosGammaO, eta, (eta - 1) * (eta + 1));
    }
    Value Gather(const FiberAngles<T> &o, T sinThetaI, T cosThetaI, const std::array<T, kLobes> &dPhi) const;
};
//<

//> Prepare a fiber
template <typename T>
HairLobes<T>::HairLobes(const HairParameters &parameters)
    : h(parameters.h), cosGammaO(std::sqrt((1 - h) * (1 + h))), eta(parameters.eta),
      v(LongitudinalVariance(T(parameters.betaM))), s(AzimuthalScale(T(parameters.betaN))),
      npTail(LogisticTail(s)) {
    for (size_t c = 0; c < 3; ++c)
        sigmaA[c] = T(parameters.sigmaA[c]);
    const std::array<T, kLobes> turns = TiltsInTurns(T(parameters.alpha), parameters.tilt);
    for (size_t p = 0; p < kLobes; ++p) {
        sinTilt[p] = std::sin(2 * kPi<T> * turns[p]);
        cosTilt[p] = std::cos(2 * kPi<T> * turns[p]);
    }
}
//<

//> Attenuate each lobe and each colour
template <typename T>
std::array<std::array<T, 3>, kLobes> HairLobes<T>::Attenuations(const Vector3<T> &wo) const {
    const Refraction<T> inside = Refracted(AnglesOf(wo.x, wo.y, wo.z).cosTheta);
    const FresnelPair<T> fresnel = Fresnel(inside.cosIncident, inside.t, eta);
    std::array<std::array<T, 3>, kLobes> result;
    for (size_t c = 0; c < 3; ++c) {
        const T depth = sigmaA[c] * inside.length;
        const std::array<T, kLobes> ap =
            Ap(fresnel.f, fresnel.oneMinusF, std::exp(-depth), -std::expm1(-depth));
        for (size_t p = 0; p < kLobes; ++p)
            result[p][c] = ap[p];
    }
    return result;
}
//<

//> Evaluate one lobe
template <typename T>
T HairLobes<T>::Longitudinal(size_t p, T sinThetaO, T cosThetaO, T sinThetaI, T cosThetaI) const {
    const SinCosine<T> tilted = Tilted(sinThetaO, cosThetaO, sinTilt[p], cosTilt[p]);
    return Mp(cosThetaI, tilted.cos, sinThetaI, tilted.sin, v[p]);
}
template <typename T>
T HairLobes<T>::Azimuthal(size_t p, T dPhi) const {
    return p < 3 ? Logistic(dPhi, s) / (1 - npTail) : 1 / (2 * kPi<T>);
}
//<

//> Add the lobes up
// dPhi: the angle of each lobe from its centre. pdf weighs the lobes by the luminance of A_p.
template <typename T>
typename HairLobes<T>::Value HairLobes<T>::Gather(const FiberAngles<T> &o, T sinThetaI, T cosThetaI,
                                                  const std::array<T, kLobes> &dPhi) const {
    const auto ap = Attenuations({o.sinTheta, o.cosTheta, T(0)});
    Value value{{0, 0, 0}, 0};
    T sumY = 0;
    for (size_t p = 0; p < kLobes; ++p) {
        const T density =
            Longitudinal(p, o.sinTheta, o.cosTheta, sinThetaI, cosThetaI) * Azimuthal(p, dPhi[p]);
        const T y = Luminance(ap[p]);
        for (size_t c = 0; c < 3; ++c)
            value.fCos[c] += ap[p][c] * density;
        value.pdf += y * density;
        sumY += y;
    }
    value.pdf = sumY < T(kBlack) ? T(0) : value.pdf / sumY;
    return value;
}
//<

//> Evaluate the sum for two directions
template <typename T>
typename HairLobes<T>::Value HairLobes<T>::Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const {
    const FiberAngles<T> o = AnglesOf(wo.x, wo.y, wo.z), i = AnglesOf(wi.x, wi.y, wi.z);
    const SinCosine<T> phi = RelativeAzimuth(o, i);
    const Refraction<T> inside = Refracted(o.cosTheta);
    const PhiInPlane<T> turn = TurnsOfPaths(h, cosGammaO, inside);
    std::array<T, kLobes> dPhi;
    for (size_t p = 0; p < kLobes; ++p)
        dPhi[p] = std::atan2(phi.sin * turn.cos[p] - phi.cos * turn.sin[p],
                             phi.cos * turn.cos[p] + phi.sin * turn.sin[p]);
    return Gather(o, i.sinTheta, i.cosTheta, dPhi);
}
//<

//> Sample a direction
template <typename T>
typename HairLobes<T>::Value HairLobes<T>::Sample(const Vector3<T> &wo, std::array<T, 4> u,
                                                  Vector3<T> *wi) const {
    for (T &x : u)
        x = std::clamp(x, T(kMinU), T(OneMinusEpsilon));
    const FiberAngles<T> o = AnglesOf(wo.x, wo.y, wo.z);
    const Refraction<T> inside = Refracted(o.cosTheta);
    //> Choose the lobe by its share of the luminance
    const auto ap = Attenuations(wo);
    std::array<T, kLobes> y;
    T sumY = 0;
    for (size_t p = 0; p < kLobes; ++p)
        sumY += y[p] = Luminance(ap[p]);
    size_t q = 0;
    T rest = u[0] * sumY;
    for (size_t p = 0; p < kLobes && rest >= 0; ++p)
        if (y[p] > 0) // never a lobe without light, whatever the rounding
            q = p, rest -= y[p];
    //<
    //> Sample $\theta_i$ about the tilted mirror direction
    const SinCosine<T> axis = Tilted(o.sinTheta, o.cosTheta, sinTilt[q], cosTilt[q]);
    const T x = SampleMpCosine(u[2], v[q]), psi = 2 * kPi<T> * u[3];
    const SinCosine<T> thetaI = TurnFromAxis(x, std::sin(psi), std::cos(psi), axis.sin, axis.cos);
    //<
    //> Sample $\phi_i - \phi_o$ about the turn of the path
    const T dPhiQ = q < 3 ? SampleTrimmedLogistic(u[1], s, npTail) : kPi<T> * (2 * u[1] - 1);
    const PhiInPlane<T> turn = TurnsOfPaths(h, cosGammaO, inside);
    const T c = std::cos(dPhiQ), d = std::sin(dPhiQ);
    const SinCosine<T> phi = UnitVector(d * turn.cos[q] + c * turn.sin[q], c * turn.cos[q] - d * turn.sin[q]);
    *wi = o.Turned(thetaI.sin, thetaI.cos, phi.sin, phi.cos);
    //<
    //> Evaluate at the sampled angles
    // Not at those of *wi: rounding to a vector would change the azimuth by many parts of a narrow lobe's
    // width.
    std::array<T, kLobes> dPhi;
    for (size_t p = 0; p < kLobes; ++p)
        dPhi[p] = p == q ? dPhiQ
                         : std::atan2(phi.sin * turn.cos[p] - phi.cos * turn.sin[p],
                                      phi.cos * turn.cos[p] + phi.sin * turn.sin[p]);
    return Gather(o, thetaI.sin, thetaI.cos, dPhi);
    //<
}
//<

} // namespace cuticle
//<
