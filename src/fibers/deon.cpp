//> Define the model of d'Eon and colleagues
#include "fibers/deon.h"

#include "core/error.h"
#include "fibers/ap.h"
#include "fibers/fiber_angles.h"
#include "fibers/longitudinal_forms.h"
#include "fibers/np.h"

#include <sstream>

namespace cuticle {

//> Check the parameters of d'Eon's model
namespace {
float Checked(const char *name, float value, float low, float high) {
    if (!std::isfinite(value))
        throw Error(std::string("DEonBSDF: ") + name + " must be a finite number");
    return std::clamp(value, low, high);
}
} // namespace
DEonParameters CheckedDEon(DEonParameters p) {
    p.eta = Checked("eta", p.eta, 1.001f, 1e3f);
    for (size_t i = 0; i < 3; ++i) {
        p.sigmaA[i] = Checked("sigma_a", p.sigmaA[i], 0, 1e18f);
        p.alpha[i] = Checked("alpha", p.alpha[i], -180, 180);
        p.betaM[i] = Checked("beta_m", p.betaM[i], 0.006f, 1e3f);
        p.betaN[i] = Checked("beta_n", p.betaN[i], 0.05f, 1e3f);
    }
    p.lobes = std::clamp(p.lobes, 1, 16);
    p.order = std::clamp(p.order, 0, static_cast<int>(kMaxNodes));
    if (p.h)
        p.h = Checked("h", *p.h, -1, 1);
    return p;
}
//<

//> Prepare the quadrature
template <typename T>
DEonQuadrature<T>::DEonQuadrature(const DEonParameters &p) : parameters(p) {
    for (size_t i = 0; i < 3; ++i)
        sigmaA_[i] = p.sigmaA[i], betaN_[i] = kPi<T> / 180 * T(p.betaN[i]);
}
//<

//> Count the nodes
template <typename T>
size_t DEonQuadrature<T>::Nodes(int p, const Inside &fiber) const {
    size_t count = 0;
    ForEachNode(p, fiber, [&](T, T) { ++count; });
    return count;
}
//<

//> Integrate one lobe over the width
//> Attenuate a path, or all that have no lobe
// The Fresnel factor of the half angle, if R has it, is put in later, where both directions are known.
template <typename T>
std::array<T, 3> DEonQuadrature<T>::Attenuation(int p, T gamma, const Inside &fiber) const {
    if (p == 0 && parameters.halfAngleFresnel)
        return {1, 1, 1};
    return fiber.Attenuation(p, gamma, sigmaA_, parameters.length);
}
template <typename T>
std::array<T, 3> DEonQuadrature<T>::Tail(const Inside &fiber) const {
    const auto at = [&](T gamma) { return fiber.Tail(parameters.lobes, gamma, sigmaA_, parameters.length); };
    return parameters.h ? at(std::asin(T(*parameters.h))) : MeanOverWidth<16, T>(at);
}
//<
//> See a ray through the detector
// The logistic's scale for a standard deviation.
template <typename T>
T LogisticScale(T deviation) {
    return deviation * std::sqrt(T(3)) / kPi<T>;
}
// Rays at h and -h leave at Phi and -Phi. Deviation is also how samples are distributed about a ray.
template <typename T>
T DEonQuadrature<T>::Deviation(T beta, T x) const {
    if (parameters.detector != AzimuthalDetector::Logistic)
        return GaussianDetector(beta, x);
    const T s = LogisticScale(beta);
    return Logistic(std::abs(WrapAngle(x)), s) / (1 - LogisticTail(s));
}
template <typename T>
T DEonQuadrature<T>::Seen(T beta, T phi, T turn) const {
    if (parameters.detector != AzimuthalDetector::Nearest)
        return (Deviation(beta, phi - turn) + Deviation(beta, phi - Other(turn))) / 2;
    const T from = WrapAngle(phi);
    return (Gaussian(beta, from - WrapAngle(turn)) + Gaussian(beta, from - WrapAngle(Other(turn)))) / 2;
}
//<
// density: the same sum, of luminance and without the loss of the nearest detector, normalised: it is exactly
// how Sample distributes phi, whatever the nodes.
template <typename T>
AroundValue<T> DEonQuadrature<T>::Value(size_t p, const Inside &fiber, T phi) const {
    if (parameters.IsTail(p)) {
        std::array<T, 3> n = Tail(fiber);
        for (T &c : n)
            c /= 2 * kPi<T>;
        return {n, 1 / (2 * kPi<T>)};
    }
    const T beta = Width(p);
    AroundValue<T> sum{{0, 0, 0}, 0};
    T all = 0;
    ForEachRay(p, fiber, [&](T turn, const std::array<T, 3> &light) {
        const T seen = Seen(beta, phi, turn), y = Luminance(light);
        for (size_t c = 0; c < 3; ++c)
            sum.n[c] += light[c] * seen;
        all += y;
        if (parameters.detector == AzimuthalDetector::Nearest)
            sum.density += y / 2 * (Deviation(beta, phi - turn) + Deviation(beta, phi - Other(turn)));
    });
    if (parameters.detector != AzimuthalDetector::Nearest)
        sum.density = Luminance(sum.n);
    sum.density = all > 0 ? sum.density / all : T(0);
    return sum;
}
template <typename T>
std::array<T, 3> DEonQuadrature<T>::Mean(size_t lobe, const Inside &fiber) const {
    if (parameters.IsTail(lobe))
        return Tail(fiber);
    std::array<T, 3> sum = {0, 0, 0};
    const int p = static_cast<int>(lobe);
    ForEachNode(p, fiber, [&](T gamma, T weight) {
        const std::array<T, 3> a = fiber.Attenuation(p, gamma, sigmaA_, parameters.length);
        for (size_t c = 0; c < 3; ++c)
            sum[c] += weight * a[c];
    });
    return sum;
}
//<

//> Integrate with a fixed order, as printed
template <typename T>
std::array<T, 3> DEonQuadrature<T>::ByFixedOrder(int p, const Inside &fiber, T phi, size_t order,
                                                 bool half) const {
    std::array<T, 3> sum = {0, 0, 0};
    const T beta = Width(static_cast<size_t>(p));
    NodesOfOrder<T>(order, half, [&](T gamma, T weight) {
        const std::array<T, 3> a = Attenuation(p, gamma, fiber);
        const T turn = fiber.Phi(p, gamma);
        const T seen = half ? Seen(beta, phi, turn) : GaussianDetector(beta, phi - turn);
        for (size_t c = 0; c < 3; ++c)
            sum[c] += weight * a[c] * seen;
    });
    return sum;
}
//<

//> Draw an azimuth from the quadrature
// A node by the luminance it passes, a side, and the Gaussian about its turn.
template <typename T>
T DEonQuadrature<T>::Share(size_t lobe, const Inside &fiber) const {
    const int p = static_cast<int>(lobe);
    if (parameters.IsTail(lobe))
        return Luminance(Tail(fiber));
    const auto at = [&](T gamma) { return fiber.Attenuation(p, gamma, sigmaA_, parameters.length); };
    return Luminance(parameters.h ? at(std::asin(T(*parameters.h))) : MeanOverWidth<4, T>(at));
}
template <typename T>
T DEonQuadrature<T>::Sample(size_t lobe, const Inside &fiber, T rest, T u) const {
    if (parameters.IsTail(lobe))
        return 2 * kPi<T> * u;
    T all = 0;
    ForEachRay(lobe, fiber, [&](T, const std::array<T, 3> &light) { all += Luminance(light); });
    T turn = 0, left = rest * all, part = 0;
    ForEachRay(lobe, fiber, [&](T ray, const std::array<T, 3> &light) {
        const T y = Luminance(light);
        if (left >= 0 && y > 0)
            turn = ray, part = left / y;
        left -= y;
    });
    const T beta = Width(lobe), s = LogisticScale(beta);
    return (part < T(0.5L) ? Other(turn) : turn) + (parameters.detector == AzimuthalDetector::Logistic
                                                        ? SampleTrimmedLogistic(u, s, LogisticTail(s))
                                                        : beta * std::sqrt(T(2)) * InverseErf(2 * u - 1));
}
template class DEonQuadrature<float>;
template class DEonQuadrature<double>;
//<

//> Put d'Eon's model together
template <typename T, class Around>
DEon<T, Around>::DEon(const DEonParameters &p, const Around &a) : parameters(p), around(a) {
    for (size_t i = 0; i < 3; ++i)
        along_[i] = {p.longitudinal, kPi<T> / 180 * T(p.betaM[i]), kPi<T> / 180 * T(p.alpha[i])};
    along_[3] = {p.longitudinal, kPi<T> / 180 * T(p.betaM[2]), 0};
}
//> Share out the samples of d'Eon's model
// Shares are the luminance of each lobe where most of it is seen. At the viewer's own inclination alone, a
// viewer along the fiber would sample nothing but R, and meet TT, half a width away, with weights of
// hundreds.
template <typename T, class Around>
typename DEon<T, Around>::Shares DEon<T, Around>::SharesOf(T cosThetaO) const {
    const auto inside = around.At(cosThetaO);
    Shares shares{};
    T sum = 0;
    for (size_t p = 0; p < parameters.AllLobes(); ++p) {
        if (!parameters.Counts(p))
            continue;
        const T seen = Along(p).UsualCosThetaD(cosThetaO);
        const bool beside =
            parameters.inclination == AttenuationInclination::HalfDifference && seen > cosThetaO;
        sum += shares[p] = around.Share(p, beside ? around.At(seen) : inside);
    }
    for (T &s : shares)
        s = sum > 0 ? s / sum : T(0);
    return shares;
}
//<
template <typename T, class Around>
FiberValue<T> DEon<T, Around>::Gather(const Shares &shares, const Inclination<T> &o, const Inclination<T> &i,
                                      T phi) const {
    const auto inside = around.At(CosThetaD(o, i));
    FiberValue<T> value{{0, 0, 0}, 0};
    for (size_t p = 0; p < parameters.AllLobes(); ++p) {
        if (!parameters.Counts(p))
            continue;
        const T m = Along(p).Value(o, i);
        AroundValue<T> n = around.Value(p, inside, phi);
        value.pdf += shares[p] * Along(p).Density(o, i) * n.density;
        if (p == 0 && parameters.halfAngleFresnel) {
            //> Reflect at the half angle
            // The cosine of half the angle between the directions.
            const T cosine = o.sin * i.sin + o.cos * i.cos * std::cos(phi), eta = parameters.eta;
            const T half = std::sqrt(std::max(T(1e-12L), (1 + cosine) / 2));
            const T f = Fresnel(half, std::sqrt((eta - 1) * (eta + 1) + half * half), eta).f;
            for (T &c : n.n)
                c *= f;
            //<
        }
        for (size_t c = 0; c < 3; ++c)
            value.fCos[c] += m * n.n[c];
    }
    return value;
}
template <typename T, class Around>
FiberValue<T> DEon<T, Around>::Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const {
    const FiberAngles<T> o = AnglesOf(wo.x, wo.y, wo.z), i = AnglesOf(wi.x, wi.y, wi.z);
    const SinCosine<T> phi = RelativeAzimuth(o, i);
    return Gather(SharesOf(o.cosTheta), {o.sinTheta, o.cosTheta}, {i.sinTheta, i.cosTheta},
                  std::atan2(phi.sin, phi.cos));
}
//<

//> Draw a direction from d'Eon's model
template <typename T, class Around>
FiberValue<T> DEon<T, Around>::Sample(const Vector3<T> &wo, std::array<T, 4> u, Vector3<T> *wi) const {
    const FiberAngles<T> angles = AnglesOf(wo.x, wo.y, wo.z);
    const Inclination<T> o{angles.sinTheta, angles.cosTheta};
    const Shares shares = SharesOf(o.cos);
    size_t p = 0;
    while (p + 1 < parameters.AllLobes() && u[0] >= shares[p])
        u[0] -= shares[p++];
    while (p > 0 && !(shares[p] > 0))
        --p;
    if (!(shares[p] > 0)) { // the orders that count are black
        *wi = wo;
        return {{0, 0, 0}, 0};
    }
    const T rest = std::clamp(u[0] / shares[p], T(0), T(OneMinusEpsilon));
    const Inclination<T> i = Along(p).Sample(o, u[2], u[3]);
    const T phi = around.Sample(p, around.At(CosThetaD(o, i)), rest, u[1]);
    *wi = angles.Turned(i.sin, i.cos, std::sin(phi), std::cos(phi));
    return Gather(shares, o, i, WrapAngle(phi));
}
template class DEon<float, DEonQuadrature<float>>;
template class DEon<double, DEonQuadrature<double>>;
template class DEon<float, DEonTableOf<float>::View>;
template class DEon<double, DEonTableOf<double>::View>;
//<

//> Count the lobes by the light
template <typename T>
int ChosenLobes<T>::LobesAt(T cosThetaO) const {
    const SmoothFiber<T> fiber(cosThetaO, T(parameters.eta));
    const T gamma = std::asin(T(*parameters.h));
    const std::array<T, 3> sigmaA = {parameters.sigmaA[0], parameters.sigmaA[1], parameters.sigmaA[2]};
    const auto beyond = [&](int p) { return Luminance(fiber.Tail(p, gamma, sigmaA, parameters.length)); };
    const T all = Luminance(fiber.Attenuation(0, gamma, sigmaA, parameters.length)) + beyond(1);
    int lobes = 1;
    while (lobes < parameters.lobes && beyond(lobes) > tailShare * all)
        ++lobes;
    return lobes;
}
template <typename T>
DEon<T, DEonQuadrature<T>> ChosenLobes<T>::At(const Vector3<T> &wo) const {
    DEonParameters p = parameters;
    p.lobes = LobesAt(AnglesOf(wo.x, wo.y, wo.z).cosTheta);
    return {p, DEonQuadrature<T>(p)};
}
template class ChosenLobes<float>;
template class ChosenLobes<double>;

ChosenLobesBSDF::ChosenLobesBSDF(const DEonParameters &p, Float tailShare)
    : BxDFOf(ChosenLobes<Float>(CheckedDEon(p), Checked("the tail's share", tailShare, 0, 1))) {
    if (!p.h || !p.tail || p.inclination != AttenuationInclination::Viewer)
        throw Error("ChosenLobesBSDF: needs h, a tail, and attenuation at the viewer's inclination");
}
std::string ChosenLobesBSDF::ToString() const {
    std::ostringstream out;
    out << "[ ChosenLobesBSDF tail: " << model_.tailShare << " of "
        << DescribeDEon("DEonBSDF", model_.parameters) << " ]";
    return out.str();
}
//<

//> Offer d'Eon's model as a BSDF
DEonBSDF::DEonBSDF(const DEonParameters &p)
    : BxDFOf(DEon<Float, DEonQuadrature<Float>>(CheckedDEon(p), DEonQuadrature<Float>(CheckedDEon(p)))) {}
TabulatedDEonBSDF::TabulatedDEonBSDF(const DEonParameters &p, const DEonTable *table)
    : BxDFOf(DEon<Float, DEonTable::View>(CheckedDEon(p), DEonTable::View(table))) {}

std::string DescribeDEon(const char *name, const DEonParameters &p) {
    std::ostringstream out;
    const auto list = [&out](const char *what, const std::array<float, 3> &values) {
        out << " " << what << ": [ " << values[0] << ", " << values[1] << ", " << values[2] << " ]";
    };
    out << "[ " << name << " eta: " << p.eta;
    list("sigma_a", p.sigmaA), list("alpha", p.alpha), list("beta_m", p.betaM), list("beta_n", p.betaN);
    out << " lobes: " << p.lobes << (p.tail ? " and a tail" : "");
    if (p.h)
        out << " h: " << *p.h;
    out << (p.halfAngleFresnel ? " half-angle Fresnel" : "")
        << (p.inclination == AttenuationInclination::Viewer ? " at the viewer's inclination" : "")
        << (p.detector == AzimuthalDetector::Nearest    ? " nearest detector"
            : p.detector == AzimuthalDetector::Logistic ? " logistic detector"
                                                        : "")
        << " length: " << static_cast<int>(p.length) << " longitudinal: " << static_cast<int>(p.longitudinal)
        << " ]";
    return out.str();
}
std::string DEonBSDF::ToString() const { return DescribeDEon("DEonBSDF", model_.parameters); }
std::string TabulatedDEonBSDF::ToString() const {
    return DescribeDEon("TabulatedDEonBSDF", model_.parameters);
}
//<

} // namespace cuticle
//<
