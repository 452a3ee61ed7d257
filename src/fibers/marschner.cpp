//> Define the model of Marschner and colleagues
#include "fibers/marschner.h"

#include "core/error.h"
#include "fibers/ap.h"
#include "fibers/fiber_angles.h"
#include "fibers/longitudinal_forms.h"
#include "fibers/np.h"

#include <sstream>

namespace cuticle {

//> Check the parameters
namespace {
float Checked(const char *name, float value, float low, float high) {
    if (!std::isfinite(value))
        throw Error(std::string("MarschnerBSDF: ") + name + " must be a finite number");
    return std::clamp(value, low, high);
}
} // namespace
MarschnerParameters CheckedMarschner(MarschnerParameters p) {
    p.eta = Checked("eta", p.eta, 1.001f, 1e3f);
    for (size_t i = 0; i < 3; ++i) {
        p.sigmaA[i] = Checked("sigma_a", p.sigmaA[i], 0, 1e18f);
        p.alpha[i] = Checked("alpha", p.alpha[i], -90, 90);
        p.beta[i] = Checked("beta", p.beta[i], 0.003f, 1e3f);
        p.kd[i] = Checked("Kd", p.kd[i], 0, 1e6f);
    }
    p.eccentricity = Checked("eccentricity", p.eccentricity, 0.2f, 5);
    p.kG = Checked("kG", p.kG, 0, 1e6f);
    p.wc = Checked("wc", p.wc, 0.1f, 60);
    p.etaRange = Checked("etaRange", p.etaRange, 1e-3f, 1e3f);
    p.maxH = Checked("maxH", p.maxH, 0, 2);
    p.axis = Checked("axis", p.axis, -1e6f, 1e6f);
    return p;
}
//<

//> Construct the three lobes
// Table 1 speaks of theta_h; the lobes of theta_i + theta_o, which is twice that.
template <typename T>
Marschner<T>::Marschner(const MarschnerParameters &p) : parameters(p), eta_(p.eta) {
    for (size_t i = 0; i < 3; ++i) {
        sigmaA_[i] = p.sigmaA[i], kd_[i] = p.kd[i];
        along_[i] = {p.longitudinal, kPi<T> / 90 * T(p.beta[i]), kPi<T> / 90 * T(p.alpha[i])};
    }
}
//<

//> Sum over the paths that leave at $\phi$
// Equation 8. paths: the circle whose rays are followed; fiber: the one whose Fresnel factors and lengths
// count.
template <typename T>
std::array<T, 3> Marschner<T>::ThroughRoots(int p, T phi, const SmoothFiber<T> &paths,
                                            const SmoothFiber<T> &fiber) const {
    std::array<T, 3> sum = {0, 0, 0};
    const PathRoots<T> roots = paths.Roots(p, phi, parameters.roots);
    for (size_t r = 0; r < roots.count; ++r) {
        const std::array<T, 3> a = fiber.Attenuation(p, roots.gamma[r], sigmaA_, parameters.length);
        const T density = paths.Density(p, roots.gamma[r], parameters.roots);
        for (size_t c = 0; c < 3; ++c)
            sum[c] += a[c] * density;
    }
    return sum;
}
//<

//> Bend the index for eccentric fibers
// Section 5.2.3 with a^-2 at phi_h = 0: with a < 1 and phi measured from the major axis, that is where the
// exact caustics of an ellipse are (4.8 degrees at phi_i = 0, 32.6 at 90 for a = 0.9, eta 1.55; this gives
// 4.2 and 40.9, the printed pairing the reverse). Below 1.001 there would be no refraction: an extreme
// printed a is stopped there.
template <typename T>
T Marschner<T>::EtaStar(T phiH) const {
    const T a = T(parameters.eccentricity), square = parameters.printedEccentricity ? a * a : 1 / (a * a);
    const T first = 2 * (eta_ - 1) * square - eta_ + 2, second = 2 * (eta_ - 1) / square - eta_ + 2;
    return std::max(T(1.001L), ((first + second) + std::cos(2 * phiH) * (first - second)) / 2);
}
//<

//> Put a smooth lobe in the place of a caustic
//> Describe the glints of one inclination
// phiC: their azimuths are +-phiC. fade: t of the paper. power: k_G t A dh, of each of the two, per colour; A
// is taken at the caustic's h, the paper leaves open where. energy: luminance of both.
template <typename T>
struct Marschner<T>::Glint {
    T phiC, width, fade, energy;
    std::array<T, 3> power;
    // Adds what is left of the path's own light to the two lobes.
    T Kept(T phi) const {
        const T peak = Gaussian(width, T(0));
        return std::max(T(0), (1 - fade * GaussianDetector(width, phi - phiC) / peak)) *
               std::max(T(0), (1 - fade * GaussianDetector(width, phi + phiC) / peak));
    }
    T Lobes(T phi) const { return GaussianDetector(width, phi - phiC) + GaussianDetector(width, phi + phiC); }
};
//<
// The procedure of section 5.2.2. dh is the width in h of what lands within wc of the caustic; beyond the
// merge the glints stay at phi = 0 and fade out.
template <typename T>
typename Marschner<T>::Glint Marschner<T>::GlintOf(T cosThetaD, T etaStar) const {
    const SmoothFiber<T> bent(cosThetaD, etaStar);
    const T wc = kPi<T> / 180 * T(parameters.wc), gammaC = bent.TurningPoint(2);
    Glint glint{0, wc, 1, 0, {}};
    T dh = T(parameters.maxH);
    if (gammaC > 0) {
        glint.phiC = WrapAngle(bent.Phi(2, gammaC));
        const T curvature = std::abs(bent.PhiCurvature(2, std::sin(gammaC)));
        dh = std::min(dh, 2 * std::sqrt(2 * wc / std::max(curvature, T(1e-10L))));
    } else {
        const T x = std::clamp((bent.etaPrime - 2) / T(parameters.etaRange), T(0), T(1));
        glint.fade = 1 - x * x * (3 - 2 * x);
    }
    const std::array<T, 3> a =
        SmoothFiber<T>(cosThetaD, eta_).Attenuation(2, gammaC, sigmaA_, parameters.length);
    for (size_t c = 0; c < 3; ++c)
        glint.power[c] = T(parameters.kG) * glint.fade * a[c] * dh;
    glint.energy = 2 * Luminance(glint.power);
    return glint;
}
//<

//> Evaluate $N_p$ of a smooth fiber
// The Fresnel factors and lengths of TRT stay those of index eta, as the paper's conclusion says; only the
// paths are those of eta*.
template <typename T>
std::array<T, 3> Marschner<T>::Azimuthal(int p, T cosThetaD, T phi, T phiH) const {
    const SmoothFiber<T> fiber(cosThetaD, eta_);
    if (p < 2)
        return ThroughRoots(p, phi, fiber, fiber);
    const T etaStar = EtaStar(phiH);
    std::array<T, 3> n = ThroughRoots(2, phi, SmoothFiber<T>(cosThetaD, etaStar), fiber);
    const Glint glint = GlintOf(cosThetaD, etaStar);
    const T kept = glint.Kept(phi), lobes = glint.Lobes(phi);
    for (size_t c = 0; c < 3; ++c)
        n[c] = n[c] * kept + glint.power[c] * lobes;
    return n;
}
//<

//> Look at the fiber from one side
//> Say what depends on the viewer alone
// share: the chance to sample R, TT, TRT, the diffuse term; by luminance, of light that enters where most of
// a lobe is seen. trt: luminance of TRT without glints.
template <typename T>
struct Marschner<T>::View {
    FiberAngles<T> angles;
    Inclination<T> o;
    T phiO; // from the major axis
    std::array<T, 4> share;
    T trt, etaStar; // eta*, as if phi were 0: where TRT is sampled
};
//<
template <typename T>
typename Marschner<T>::View Marschner<T>::ViewOf(const Vector3<T> &wo) const {
    View view;
    view.angles = AnglesOf(wo.x, wo.y, wo.z);
    view.o = {view.angles.sinTheta, view.angles.cosTheta};
    view.phiO = std::atan2(view.angles.z, view.angles.y) - kPi<T> / 180 * T(parameters.axis);
    view.etaStar = EtaStar(view.phiO);
    const auto seen = [&](size_t p) { return along_[p].UsualCosThetaD(view.o.cos); };
    const SmoothFiber<T> fibers[] = {{seen(0), eta_}, {seen(1), eta_}, {seen(2), eta_}};
    const std::array<T, 3> mean = MeanOverWidth<3, T>([&](T gamma) {
        std::array<T, 3> a;
        for (size_t p = 0; p < 3; ++p)
            a[p] = Luminance(fibers[p].Attenuation(static_cast<int>(p), gamma, sigmaA_, parameters.length));
        return a;
    });
    view.trt = mean[2];
    view.share = {mean[0], mean[1], mean[2] + GlintOf(seen(2), view.etaStar).energy, Luminance(kd_)};
    for (size_t p = 0; p < 3; ++p)
        view.share[p] = Counts(p) ? view.share[p] : T(0);
    const T sum = view.share[0] + view.share[1] + view.share[2] + view.share[3];
    for (T &s : view.share)
        s = sum > 0 ? s / sum : T(0);
    return view;
}
//<

//> Sample the azimuth of a smooth fiber
// R: uniform, which N_R nearly is. TT: a ray at uniform h. TRT: that, or a glint, or uniform where the fiber
// is eccentric, since eta* then depends on the azimuth to be chosen and the ray is followed at another.
template <typename T>
T Marschner<T>::Path(int p, T gamma, const SmoothFiber<T> &fiber) const {
    return parameters.roots == RootMethod::Cubic
               ? PathCubic<T>(p, fiber.etaPrime).Value(gamma) + T(p) * kPi<T>
               : fiber.Phi(p, gamma);
}
template <typename T>
T Marschner<T>::PathDensity(int p, T phi, const SmoothFiber<T> &fiber) const {
    const RootMethod method = parameters.roots == RootMethod::Cubic ? RootMethod::Cubic : RootMethod::Exact;
    const PathRoots<T> roots = fiber.Roots(p, phi, method);
    T sum = 0;
    for (size_t r = 0; r < roots.count; ++r)
        sum += fiber.Density(p, roots.gamma[r], method);
    return sum;
}
//> Weigh the three ways of TRT
template <typename T>
T GlintShare(T glints, T trt) {
    return glints > 0 ? glints / (glints + trt) : T(0);
}
template <typename T>
T UniformShare(const MarschnerParameters &p) {
    return p.eccentricity == 1 ? T(0) : T(0.3L);
}
//<
template <typename T>
T Marschner<T>::TrtDensity(const View &view, T cosThetaD, T phi) const {
    const Glint glint = GlintOf(cosThetaD, view.etaStar);
    const T uniform = UniformShare<T>(parameters), byGlint = GlintShare(glint.energy, view.trt);
    const T path = PathDensity(2, phi, SmoothFiber<T>(cosThetaD, view.etaStar));
    return uniform / (2 * kPi<T>)+(1 - uniform) * (byGlint * glint.Lobes(phi) / 2 + (1 - byGlint) * path);
}
// rest in [0, 1) chooses the way, u the azimuth.
template <typename T>
T Marschner<T>::SampleTrt(const View &view, T cosThetaD, T rest, T u) const {
    const T uniform = UniformShare<T>(parameters);
    if (rest < uniform)
        return 2 * kPi<T> * u;
    const Glint glint = GlintOf(cosThetaD, view.etaStar);
    const T byGlint = GlintShare(glint.energy, view.trt);
    rest = (rest - uniform) / (1 - uniform);
    if (rest >= byGlint)
        return Path(2, std::asin(2 * u - 1), SmoothFiber<T>(cosThetaD, view.etaStar));
    const T deviation = glint.width * std::sqrt(T(2)) * InverseErf(2 * u - 1);
    return (rest < byGlint / 2 ? -glint.phiC : glint.phiC) + deviation;
}
//<

//> Add up the lobes of Marschner's model
template <typename T>
FiberValue<T> Marschner<T>::Gather(const View &view, const Inclination<T> &i, T phi) const {
    const T cosThetaD = std::sqrt(SquaredCosOfHalfDifference(view.o, i));
    const SmoothFiber<T> fiber(cosThetaD, eta_);
    const T diffuse = i.cos / Sqr(kPi<T>);
    FiberValue<T> value{{0, 0, 0}, view.share[3] * diffuse};
    for (size_t c = 0; c < 3; ++c)
        value.fCos[c] = kd_[c] * diffuse;
    for (size_t p = 0; p < 3; ++p) {
        if (!Counts(p))
            continue;
        const T m = along_[p].Value(view.o, i);
        const std::array<T, 3> n = Azimuthal(static_cast<int>(p), cosThetaD, phi, view.phiO + phi / 2);
        for (size_t c = 0; c < 3; ++c)
            value.fCos[c] += m * n[c];
        const T around = p == 0   ? 1 / (2 * kPi<T>)
                         : p == 1 ? PathDensity(1, phi, fiber)
                                  : TrtDensity(view, cosThetaD, phi);
        value.pdf += view.share[p] * along_[p].Density(view.o, i) * around;
    }
    return value;
}
template <typename T>
FiberValue<T> Marschner<T>::Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const {
    const View view = ViewOf(wo);
    const FiberAngles<T> i = AnglesOf(wi.x, wi.y, wi.z);
    const SinCosine<T> phi = RelativeAzimuth(view.angles, i);
    return Gather(view, {i.sinTheta, i.cosTheta}, std::atan2(phi.sin, phi.cos));
}
//<

//> Draw a direction from Marschner's model
template <typename T>
FiberValue<T> Marschner<T>::Sample(const Vector3<T> &wo, std::array<T, 4> u, Vector3<T> *wi) const {
    const View view = ViewOf(wo);
    //> Choose the lobe, and make u[0] new
    size_t p = 0;
    while (p < 3 && u[0] >= view.share[p])
        u[0] -= view.share[p++];
    while (p > 0 && !(view.share[p] > 0)) // rounding may lead past the last lobe that has light
        --p;
    if (!(view.share[p] > 0)) { // the orders that count are black
        *wi = wo;
        return {{0, 0, 0}, 0};
    }
    const T rest = std::clamp(u[0] / view.share[p], T(0), T(OneMinusEpsilon));
    //<
    Inclination<T> i;
    T phi = 2 * kPi<T> * u[1];
    if (p == 3) {
        const SinCosine<T> theta = SampleCosineSquared(u[2], u[3]);
        i = {theta.sin, theta.cos};
    } else {
        i = along_[p].Sample(view.o, u[2], u[3]);
        const T cosThetaD = std::sqrt(SquaredCosOfHalfDifference(view.o, i));
        if (p == 1)
            phi = Path(1, std::asin(2 * u[1] - 1), SmoothFiber<T>(cosThetaD, eta_));
        else if (p == 2)
            phi = SampleTrt(view, cosThetaD, rest, u[1]);
    }
    *wi = view.angles.Turned(i.sin, i.cos, std::sin(phi), std::cos(phi));
    return Gather(view, i, WrapAngle(phi));
}
template class Marschner<float>;
template class Marschner<double>;
//<

//> Offer Marschner's model as a BSDF
MarschnerBSDF::MarschnerBSDF(const MarschnerParameters &parameters)
    : BxDFOf(Marschner<Float>(CheckedMarschner(parameters))) {}

std::string MarschnerBSDF::ToString() const {
    const MarschnerParameters &p = model_.parameters;
    std::ostringstream out;
    const auto list = [&out](const char *name, const std::array<float, 3> &values) {
        out << " " << name << ": [ " << values[0] << ", " << values[1] << ", " << values[2] << " ]";
    };
    out << "[ MarschnerBSDF eta: " << p.eta;
    list("sigma_a", p.sigmaA), list("alpha", p.alpha), list("beta", p.beta), list("Kd", p.kd);
    out << " eccentricity: " << p.eccentricity << " axis: " << p.axis << " kG: " << p.kG << " wc: " << p.wc
        << " etaRange: " << p.etaRange << " maxH: " << p.maxH << " roots: " << static_cast<int>(p.roots)
        << " length: " << static_cast<int>(p.length) << " longitudinal: " << static_cast<int>(p.longitudinal)
        << " ]";
    return out.str();
}
//<

} // namespace cuticle
//<
