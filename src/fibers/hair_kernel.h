//> Run the four lobes in the lanes of one register
// This text is included by one source file for each instruction set, which first defines CUTICLE_KERNEL: the
// name of the kernels and of the namespace that keeps them apart. Only inlined functions and functions of
// that namespace may be used here: a function shared with the rest of the program could be linked in the form
// that this file compiled, for a processor that the program does not run on.
#include "core/lanes.h"
#include "core/special.h"
#include "fibers/hair_lanes.h"
#include "fibers/hair_model.h"

#include <cmath>

namespace cuticle::CUTICLE_KERNEL {
namespace {

//> Wrap a register of four floats
// The type is of this namespace, so templates over it are compiled for this kernel alone.
struct Lanes {
    using Register = lanes::Pack<kLobes>::F;
    using Integers = lanes::Pack<kLobes>::I;
    CUTICLE_INLINE Lanes() : v{} {}
    CUTICLE_INLINE Lanes(Register r) : v(r) {}
    CUTICLE_INLINE explicit Lanes(float x) : v(lanes::Fill<Register>(x)) {}
    CUTICLE_INLINE explicit Lanes(const std::array<float, 4> &a) : v(lanes::Load<Register>(a.data())) {}
    // Four numbers just computed: through registers, for a load of four would wait until four stores are
    // done.
    CUTICLE_INLINE Lanes(float a, float b, float c, float d) : v{a, b, c, d} {}
    template <size_t lane>
    CUTICLE_INLINE float Get() const {
        return v[lane];
    }
    CUTICLE_INLINE Lanes LastFromThird() const { return __builtin_shufflevector(v, v, 0, 1, 2, 2); }
    CUTICLE_INLINE Integers Bits() const { return reinterpret_cast<Integers>(v); }
    CUTICLE_INLINE static Lanes FromBits(Integers bits) { return reinterpret_cast<Register>(bits); }
    CUTICLE_INLINE std::array<float, 4> Array() const {
        std::array<float, 4> a;
        __builtin_memcpy(a.data(), &v, sizeof(v));
        return a;
    }
    Register v;
};
using Integers = Lanes::Integers;
//<

//> Give registers the operations that the model asks for
CUTICLE_INLINE Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
CUTICLE_INLINE Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
CUTICLE_INLINE Lanes operator-(Lanes a) { return -a.v; }
CUTICLE_INLINE Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
CUTICLE_INLINE Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
CUTICLE_INLINE Integers operator<(Lanes a, Lanes b) { return a.v < b.v; }
CUTICLE_INLINE Lanes Sqrt(Lanes x) { return lanes::Sqrt(x.v); }
CUTICLE_INLINE Lanes Max(Lanes a, Lanes b) { return lanes::Max(a.v, b.v); }
CUTICLE_INLINE Lanes Min(Lanes a, Lanes b) { return lanes::Min(a.v, b.v); }
CUTICLE_INLINE Lanes Abs(Lanes a) { return lanes::Abs(a.v); }
CUTICLE_INLINE Lanes Select(Integers condition, Lanes yes, Lanes no) {
    return lanes::Select(condition, yes.v, no.v);
}
//<

//> Compute exponentials
//> Split off the power of two
// x = n ln 2 + r, |r| <= (ln 2)/2, ln 2 in two parts so that n times the first is exact. Adding 1.5 2^23
// leaves n in the low bits of the sum.
struct Reduced {
    Lanes r, twoToN;
};
CUTICLE_INLINE Reduced ReduceExp(Lanes x) {
    const Lanes shifted = x * Lanes(1.44269504f) + Lanes(12582912.f);
    const Lanes n = shifted - Lanes(12582912.f);
    const Lanes r = (x - n * Lanes(0.693359375f)) + n * Lanes(2.12194440e-4f);
    const Integers bits = (shifted.Bits() << 23) + (127 << 23);
    return {r, Lanes::FromBits(bits)};
}
// exp(r) - 1, fitted by core/fit_special.py with a relative error below 3e-8.
CUTICLE_INLINE Lanes ReducedExpm1(Lanes r) {
    return r + r * r * Polynomial(r, 0.5f, 0.1666657703f, 0.04166655466f, 0.008363173075f, 0.001392617612f);
}
//<
//> Put exponentials together again
// For x <= 80. Below -87 exp(x) leaves the normal numbers: 0.
struct ExpPair {
    Lanes exp, expm1;
};
CUTICLE_INLINE ExpPair ExpBoth(Lanes x) {
    const Reduced reduced = ReduceExp(Max(x, Lanes(-87.f)));
    const Lanes p = ReducedExpm1(reduced.r);
    return {Select(x < Lanes(-87.f), Lanes(0.f), reduced.twoToN + reduced.twoToN * p),
            (reduced.twoToN - Lanes(1.f)) + reduced.twoToN * p};
}
CUTICLE_INLINE Lanes Exp(Lanes x) { return ExpBoth(x).exp; }
//<
//<

//> Compute sines and cosines of turns
// Returns sine and cosine of 2 pi x. Quarters of a turn are taken off exactly; on the eighth that remains,
// core/fit_special.py fits with relative errors below 3e-10.
CUTICLE_INLINE SinCosine<Lanes> SinCosTurns(Lanes turns) {
    const Lanes shifted = turns * Lanes(4.f) + Lanes(12582912.f);
    const Lanes r = (turns - (shifted - Lanes(12582912.f)) * Lanes(0.25f)) * Lanes(6.28318531f);
    const Lanes y = r * r;
    const Lanes sine =
        r + r * y * Polynomial(y, -0.1666666666f, 0.008333331875f, -0.0001984008674f, 2.72499258e-6f);
    const Lanes cosine =
        Lanes(1.f) + y * Polynomial(y, -0.4999999997f, 0.04166665064f, -0.001388758916f, 2.446378829e-5f);
    //> Swap and negate by the quarter
    const Integers quarter = shifted.Bits();
    const Integers odd = -(quarter & 1);
    const Integers sineSign = (quarter & 2) << 30;
    const Integers cosineSign = ((quarter + 1) & 2) << 30;
    const auto flip = [](Lanes v, Integers sign) { return Lanes::FromBits(v.Bits() ^ sign); };
    return {flip(Select(odd, cosine, sine), sineSign), flip(Select(odd, sine, cosine), cosineSign)};
    //<
}
//<

//> Compute the size of an angle
// |atan2(sine, cosine)|, in [0, pi]; 0 for (0, 0). The arc tangent on [0, 1] is a fit of
// core/fit_special.py with a relative error of 2e-8.
CUTICLE_INLINE Lanes AbsAngle(Lanes sine, Lanes cosine) {
    const Lanes a = Abs(sine), b = Abs(cosine);
    const Lanes ratio = Min(a, b) / Max(Max(a, b), Lanes(1e-37f));
    const Lanes y = ratio * ratio;
    const Lanes arc =
        ratio * Polynomial(y, 0.9999999818f, -0.3333303671f, 0.1999187203f, -0.1419779779f, 0.1061837064f,
                           -0.07456854826f, 0.04213762359f, -0.01573124912f, 0.002766283502f);
    const Lanes eighths = Select(b < a, Lanes(1.57079633f) - arc, arc);
    return Select(cosine < Lanes(0.f), Lanes(3.14159265f) - eighths, eighths);
}
//<

//> Turn rows into columns
struct LaneRows {
    Lanes a, b, c, d;
};
CUTICLE_INLINE LaneRows Transpose(const LaneRows &m) {
    // Two rows' lanes in turn: from the lower halves, then from the upper ones.
    const auto low = [](Lanes x, Lanes y) { return Lanes(__builtin_shufflevector(x.v, y.v, 0, 4, 1, 5)); };
    const auto high = [](Lanes x, Lanes y) { return Lanes(__builtin_shufflevector(x.v, y.v, 2, 6, 3, 7)); };
    const Lanes ac = low(m.a, m.c), bd = low(m.b, m.d), ac2 = high(m.a, m.c), bd2 = high(m.b, m.d);
    return {low(ac, bd), high(ac, bd), low(ac2, bd2), high(ac2, bd2)};
}
// The sum over each of four rows, as one register.
CUTICLE_INLINE Lanes SumRows(const LaneRows &m) {
    const LaneRows t = Transpose(m);
    return (t.a + t.b) + (t.c + t.d);
}
//<

//> Set a fiber up
void SetUp(const HairParameters &parameters, HairSetup &setup) {
    setup.h = parameters.h, setup.eta = parameters.eta;
    setup.cosGammaO = std::sqrt((1 - parameters.h) * (1 + parameters.h));
    setup.etaSquaredMinusOne = (parameters.eta - 1) * (parameters.eta + 1);
    setup.sigmaA = Lanes(parameters.sigmaA[0], parameters.sigmaA[1], parameters.sigmaA[2], 0).Array();
    //> Compute what depends on the roughnesses
    // v of TRT serves the last lobe too. Its lane is free for the logistic, whose exp(-pi/s) is exp(-2/v) of
    // a v of 2s/pi.
    setup.s = AzimuthalScale(parameters.betaN);
    const Lanes v =
        Max(Lanes(UnscaledVariance(parameters.betaM)) * Lanes(1, 0.25f, 4, 0), Lanes(kMinV<float>)) +
        Lanes(0, 0, 0, (2 / Pi) * setup.s - kMinV<float>);
    const Lanes invV = Lanes(1.f) / v;
    const ExpPair e = ExpBoth(Lanes(-2.f) * invV);
    const Lanes mass = (-e.expm1).LastFromThird();
    setup.v = v.LastFromThird().Array(), setup.mpMass = mass.Array();
    setup.invV = invV.LastFromThird().Array(), setup.mpNorm = (invV.LastFromThird() / mass).Array();
    //<
    //> Compute the factors of the logistic
    // Trimmed to [-pi, pi] it is 1 / (1 - npTail) times larger; the last lobe is constant, 1 / (2 pi).
    const float invS = (2 / Pi) * invV.Get<3>(), beyond = e.exp.Get<3>(), onePlus = 1 + beyond;
    setup.npTail = 2 * beyond / onePlus;
    const float norm = invS * onePlus / -e.expm1.Get<3>();
    setup.invS = (Lanes(invS) * Lanes(1, 1, 1, 0)).Array();
    setup.npNorm = (Lanes(norm) * Lanes(1, 1, 1, 0) + Lanes(0, 0, 0, 2 / Pi)).Array();
    //<
    //> Compute the tilts of the scales
    // Up to an eighth of a turn no multiple needs a remainder, and one division serves all: the same bits.
    const float whole = parameters.tilt == ScaleTilt::RootToTip ? 360 : -360;
    const SinCosine<Lanes> tilt = SinCosTurns(std::abs(parameters.alpha) <= 45
                                                  ? Lanes(parameters.alpha / whole) * Lanes(kTiltInAlpha)
                                                  : Lanes(TiltsInTurns(parameters.alpha, parameters.tilt)));
    setup.sinTilt = tilt.sin.Array(), setup.cosTilt = tilt.cos.Array();
    //<
}
//<

//> Compute what depends on $\omega_o$
struct HairView {
    FiberAngles<float> o;
    SinCosine<Lanes> tilted; // of theta_o, for each lobe
    SinCosine<Lanes> phi;    // Phi of each lobe, in the plane
    Lanes r, g, b, y;        // A_p of each lobe in three colours, and its luminance
    float sumY, invSumY;     // invSumY is 0 where no light leaves
};
CUTICLE_INLINE HairView PrepareView(const HairSetup &setup, const Vector3f &wo) {
    HairView view;
    view.o = AnglesOf(wo.x, wo.y, wo.z);
    view.tilted =
        Tilted(Lanes(view.o.sinTheta), Lanes(view.o.cosTheta), Lanes(setup.sinTilt), Lanes(setup.cosTilt));
    const Refraction<float> inside =
        Refract(view.o.cosTheta, setup.h, setup.cosGammaO, setup.eta, setup.etaSquaredMinusOne);
    //> Attenuate, colours in the lanes, then turn the lobes into the lanes
    const FresnelPair<float> fresnel = Fresnel(inside.cosIncident, inside.t, setup.eta);
    const ExpPair t = ExpBoth(Lanes(setup.sigmaA) * Lanes(-inside.length));
    const std::array<Lanes, kLobes> ap = Ap(Lanes(fresnel.f), Lanes(fresnel.oneMinusF), t.exp, -t.expm1);
    const LaneRows byColor = Transpose({ap[0], ap[1], ap[2], ap[3]});
    view.r = byColor.a, view.g = byColor.b, view.b = byColor.c;
    view.y = Lanes(kLuminance[0]) * view.r + Lanes(kLuminance[1]) * view.g + Lanes(kLuminance[2]) * view.b;
    view.sumY = lanes::Sum(view.y.v);
    view.invSumY = view.sumY < kBlack ? 0 : 1 / view.sumY;
    //<
    const PhiInPlane<float> turn = TurnsOfPaths(setup.h, setup.cosGammaO, inside);
    view.phi = {Lanes(turn.sin[0], turn.sin[1], turn.sin[2], turn.sin[3]),
                Lanes(turn.cos[0], turn.cos[1], turn.cos[2], turn.cos[3])};
    return view;
}
//<

//> Add the lobes up in the lanes
// NaN and infinity in a direction pass through minima and maxima unseen: nanTaint carries them, 0 or NaN.
CUTICLE_INLINE HairValue SumLobes(const HairSetup &setup, const HairView &view, float sinThetaI,
                                  float cosThetaI, Lanes absDPhi, float nanTaint) {
    const Lanes density = ScaledMp(Lanes(cosThetaI), view.tilted.cos, Lanes(sinThetaI), view.tilted.sin,
                                   Lanes(setup.invV), Lanes(setup.mpNorm)) *
                          ScaledLogistic(absDPhi, Lanes(setup.invS), Lanes(setup.npNorm));
    const LaneRows parts = {view.r * density, view.g * density, view.b * density, view.y * density};
    const std::array<float, 4> sums = (SumRows(parts) + Lanes(nanTaint)).Array();
    return {{sums[0], sums[1], sums[2]}, sums[3] * view.invSumY};
}
//<

//> Measure the azimuth from the centre of each lobe
CUTICLE_INLINE Lanes DistanceFromCentre(const HairView &view, SinCosine<float> phi) {
    const Lanes sine(phi.sin), cosine(phi.cos);
    return AbsAngle(sine * view.phi.cos - cosine * view.phi.sin, cosine * view.phi.cos + sine * view.phi.sin);
}
//<

//> Evaluate for two directions
HairValue Evaluate(const HairSetup &setup, const Vector3f &wo, const Vector3f &wi) {
    const HairView view = PrepareView(setup, wo);
    const FiberAngles<float> i = AnglesOf(wi.x, wi.y, wi.z);
    const float nanTaint = 0 * ((wo.x + wo.y + wo.z) + (wi.x + wi.y + wi.z));
    return SumLobes(setup, view, i.sinTheta, i.cosTheta, DistanceFromCentre(view, RelativeAzimuth(view.o, i)),
                    nanTaint);
}
//<

//> Sample a direction
HairValue Sample(const HairSetup &setup, const Vector3f &wo, const std::array<float, 4> &random,
                 Vector3f *wi) {
    const HairView view = PrepareView(setup, wo);
    const std::array<float, 4> u = Min(Max(Lanes(random), Lanes(kMinU)), Lanes(OneMinusEpsilon)).Array();
    const float nanTaint = 0 * ((wo.x + wo.y + wo.z) + ((random[0] + random[1]) + (random[2] + random[3])));
    //> Choose the lobe $q$ by its share of the luminance
    const std::array<float, 4> y = view.y.Array();
    size_t q = 0;
    float rest = u[0] * view.sumY;
    for (size_t p = 0; p < kLobes && rest >= 0; ++p)
        if (y[p] > 0)
            q = p, rest -= y[p];
    //<
    //> Draw the angles about the centre of the lobe
    // The logarithm in double: what is near 1 in it needs no second form.
    const double inLog = 1 - (1 - static_cast<double>(u[2])) * static_cast<double>(setup.mpMass[q]);
    const float x = std::max(-2.f, setup.v[q] * static_cast<float>(std::log(std::max(inLog, 1e-30))));
    const float dPhi = q < 3 ? SampleTrimmedLogistic(u[1], setup.s, setup.npTail) : Pi * (2 * u[1] - 1);
    const SinCosine<Lanes> both = SinCosTurns(Lanes(u[3], dPhi / (2 * Pi), 0, 0));
    const std::array<float, 4> sines = both.sin.Array(), cosines = both.cos.Array();
    //<
    //> Turn from the tilted mirror direction to $\theta_i$
    const std::array<float, 4> sinTilted = view.tilted.sin.Array(), cosTilted = view.tilted.cos.Array();
    const SinCosine<float> theta = TurnFromAxis(x, sines[0], cosines[0], sinTilted[q], cosTilted[q]);
    //<
    //> Turn from $\phi_o$ by $\Phi$ and the drawn angle
    const std::array<float, 4> sinTurn = view.phi.sin.Array(), cosTurn = view.phi.cos.Array();
    const float cosine = cosines[1] * cosTurn[q] - sines[1] * sinTurn[q];
    const float sine = sines[1] * cosTurn[q] + cosines[1] * sinTurn[q];
    const SinCosine<float> phi = UnitVector(sine, cosine);
    const float size = theta.cos / (view.o.cosTheta > 0 ? view.o.cosTheta : 1);
    *wi = {theta.sin + nanTaint, size * (view.o.y * phi.cos - view.o.z * phi.sin) + nanTaint,
           size * (view.o.z * phi.cos + view.o.y * phi.sin) + nanTaint};
    //<
    //> Evaluate at the drawn angles
    const Lanes chosen(static_cast<float>(q)), lane(0, 1, 2, 3);
    const Lanes absDPhi =
        Select(Abs(lane - chosen) < Lanes(0.5f), Lanes(std::abs(dPhi)), DistanceFromCentre(view, phi));
    return SumLobes(setup, view, theta.sin, theta.cos, absDPhi, nanTaint);
    //<
}
//<

} // namespace

//> Offer the kernels
#define CUTICLE_QUOTE(x) #x
#define CUTICLE_NAME(x) CUTICLE_QUOTE(x)
extern const HairKernels kKernels;
const HairKernels kKernels = {CUTICLE_NAME(CUTICLE_KERNEL), SetUp, Evaluate, Sample};
//<

} // namespace cuticle::CUTICLE_KERNEL
//<
