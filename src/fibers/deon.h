//> Declare the model of d'Eon and colleagues
#pragma once

#include "fibers/bxdf.h"
#include "fibers/longitudinal.h"
#include "fibers/smooth_fiber.h"

#include <array>
#include <memory>
#include <optional>

namespace cuticle {

//> Choose how an azimuth is seen
// Wrapped: the Gaussian detector, all images of an angle. Nearest: Zinke and Weber's treatment, differences
// of azimuths in (-pi, pi] as they are, so that half of a lobe at +-pi is lost. For comparison. Logistic:
// that of Chiang et al. 2016, of the same standard deviation before it is trimmed to [-pi, pi]; in the near
// field at the viewer's inclination this is HairBSDF, with as many lobes as one likes.
enum class AzimuthalDetector { Wrapped, Nearest, Logistic };
//<

//> Choose where attenuation is taken
// HalfDifference: N_p at theta_d, as published: reciprocal, and conserves energy if all lobes are equally
// wide along the fiber. Viewer: at theta_o, as HairBSDF does: conserves energy for any widths, and is not
// reciprocal.
enum class AttenuationInclination { HalfDifference, Viewer };
//<

//> List the parameters of d'Eon's model
// Angles in degrees, in the order R, TT, TRT; orders beyond have TRT's widths and no shift. Values that are
// not finite throw Error; others out of range are clamped.
//
//   eta      1.001 to 1e3
//   sigmaA   absorption per fiber radius, at least 0
//   alpha    mean of theta_i + theta_o: negative toward the root. Twice Marschner's
//   betaM    its standard deviation, the paper's beta_p; at least 0.006
//   betaN    standard deviation around the fiber, 0.05 to 1e3
//   lobes    orders with a lobe of their own, 1 to 16
//   tail     whether all orders beyond share one more lobe, uniform around the fiber. The paper has none
//   h        near field: the offset across the fiber, [-1, 1]. None: the mean over the width
struct DEonParameters {
    float eta = 1.55f;
    std::array<float, 3> sigmaA = {0.2f, 0.2f, 0.2f};
    std::array<float, 3> alpha = {-6, 3, 12};
    std::array<float, 3> betaM = {8, 4, 16};
    std::array<float, 3> betaN = {8, 8, 16};
    int lobes = 4;
    bool tail = true;
    std::optional<float> h;
    uint32_t orders = ~0u; // bit p: whether order p counts; bit `lobes`: the tail

    // As published: F of the half angle for R (equation 12) in place of F at h.
    bool halfAngleFresnel = false;
    AttenuationInclination inclination = AttenuationInclination::HalfDifference;
    AzimuthalDetector detector = AzimuthalDetector::Wrapped;
    SegmentLength length = SegmentLength::Chord;
    LongitudinalForm longitudinal = LongitudinalForm::Spherical;
    // Nodes in h of one Gauss rule over the whole width, 1 to 64; the paper takes 35. 0: as many as the
    // roughness asks for.
    int order = 0;

    size_t AllLobes() const { return static_cast<size_t>(lobes) + (tail ? 1 : 0); }
    bool Counts(size_t p) const { return (orders >> p & 1) != 0; }
    bool IsTail(size_t p) const { return p == static_cast<size_t>(lobes); }
    bool operator==(const DEonParameters &) const = default;
};
// The parameters, clamped to their ranges.
DEonParameters CheckedDEon(DEonParameters parameters);
//<

//> Describe one lobe around the fiber
template <typename T>
struct AroundValue {
    std::array<T, 3> n; // N_p
    T density;          // of the azimuth that is sampled
};
//<

//> Declare $N_p$ by quadrature
// Equation 10. Lobes are numbered from 0; the one after the last order is the tail. T is float or double.
template <typename T>
class DEonQuadrature {
  public:
    explicit DEonQuadrature(const DEonParameters &parameters);

    using Inside = SmoothFiber<T>;
    Inside At(T cosThetaD) const { return {cosThetaD, T(parameters.eta)}; }
    AroundValue<T> Value(size_t p, const Inside &fiber, T phi) const;
    // Chooses phi, not wrapped, from two numbers in [0, 1).
    T Sample(size_t p, const Inside &fiber, T rest, T u) const;
    // The mean of A_p over the width, in luminance, by few nodes.
    T Share(size_t p, const Inside &fiber) const;
    // The integral of N_p over phi, by the nodes that N_p has.
    std::array<T, 3> Mean(size_t p, const Inside &fiber) const;

    // N_p by a Gauss-Legendre rule of `order` nodes in h, over [-1, 1] as printed, or over [0, 1] with both
    // signs of phi.
    std::array<T, 3> ByFixedOrder(int p, const Inside &fiber, T phi, size_t order, bool half) const;
    // Visits what Value sums over: f(turn, light), light that leaves at +turn and -turn, half each (all of it
    // at turn if h is given). Not for the tail.
    template <typename F>
    void ForEachRay(size_t p, const Inside &fiber, F f) const;
    T Width(size_t p) const { return betaN_[std::min(p, size_t(2))]; }
    // The light of one ray that is seen at phi.
    T Seen(T beta, T phi, T turn) const;
    // How many nodes Value takes for a lobe.
    size_t Nodes(int p, const Inside &fiber) const;

    DEonParameters parameters;

  private:
    template <typename F>
    void ForEachNode(int p, const Inside &fiber, F f) const;
    std::array<T, 3> Attenuation(int p, T gamma, const Inside &fiber) const;
    std::array<T, 3> Tail(const Inside &fiber) const;
    T Deviation(T beta, T x) const;
    T Other(T turn) const { return parameters.h ? turn : -turn; }
    std::array<T, 3> sigmaA_, betaN_;
};
//<

//> Lay out the nodes
//> Choose the order from the roughness
// A Gaussian of width beta is integrated over Phi by nodes about 1.7 widths apart in the middle of a panel,
// where a Gauss rule's lie pi / 2 times as far from each other as on average; 5 more are for the ends.
// Measured: an RMS error of N_p below 1e-3 from beta = 0.5 to 80 degrees. reach: how far Phi runs over the
// panel.
template <typename T>
size_t NodesFor(T reach, T beta) {
    const T spacings = T(0.9L) * reach / beta;
    return 5 + (spacings > 0 ? static_cast<size_t>(std::min(spacings, T(1e5))) : 0); // NaN counts as 0
}
//<
// One rule in h over [-1, 1], as printed, or over [0, 1]: f(gamma, weight) with weights that add up to 1.
template <typename T, typename F>
void NodesOfOrder(size_t order, bool half, F f) {
    const GaussLegendreRule &rule = GaussLegendre(order);
    for (size_t i = 0; i < order; ++i)
        f(std::asin(half ? (T(rule.x[i]) + 1) / 2 : T(rule.x[i])), T(rule.w[i]) / 2);
}
// Over half of the width, gamma in [0, pi/2], dh = cos gamma dgamma: f(gamma, weight) with weights that add
// up to 1. Split at the turning point, and into rules of at most kMaxNodes.
template <typename T, typename F>
void NodesOnPanel(T low, T high, size_t nodes, F f) {
    const size_t pieces = (nodes + kMaxNodes - 1) / kMaxNodes;
    const GaussLegendreRule &rule = GaussLegendre((nodes + pieces - 1) / pieces);
    const T half = (high - low) / (2 * T(pieces));
    for (size_t k = 0; k < pieces; ++k)
        for (size_t i = 0; i < rule.x.size(); ++i) {
            const T gamma = low + half * (T(2 * k + 1) + T(rule.x[i]));
            f(gamma, half * T(rule.w[i]) * std::cos(gamma));
        }
}
template <typename T>
template <typename F>
void DEonQuadrature<T>::ForEachNode(int p, const Inside &fiber, F f) const {
    if (parameters.h) {
        f(std::asin(T(*parameters.h)), T(1));
        return;
    }
    if (parameters.order > 0) { // h and -h are one ray, seen from both sides
        NodesOfOrder<T>(static_cast<size_t>(parameters.order), false, [&](T gamma, T weight) {
            if (gamma > T(-1e-9L))
                f(gamma, gamma < T(1e-9L) ? weight : 2 * weight);
        });
        return;
    }
    const T turn = fiber.TurningPoint(p), ends[] = {0, turn, kPi<T> / 2};
    for (size_t k = 0; k < 2; ++k) {
        const T low = ends[k], high = ends[k + 1];
        if (!(high > low))
            continue;
        const T slope = std::max(std::abs(fiber.PhiSlope(p, low)), std::abs(fiber.PhiSlope(p, high)));
        NodesOnPanel(low, high, NodesFor(slope * (high - low), Width(static_cast<size_t>(p))), f);
    }
}
//<

//> Follow the rays of one lobe
template <typename T>
template <typename F>
void DEonQuadrature<T>::ForEachRay(size_t lobe, const Inside &fiber, F f) const {
    const int p = static_cast<int>(lobe);
    ForEachNode(p, fiber, [&](T gamma, T weight) {
        std::array<T, 3> light = Attenuation(p, gamma, fiber);
        for (T &c : light)
            c *= weight;
        f(fiber.Phi(p, gamma), light);
    });
}
//<

//> Declare the model over either form of $N_p$
// Around is DEonQuadrature<T> or DEonTable::View.
template <typename T, class Around>
class DEon {
  public:
    DEon(const DEonParameters &parameters, const Around &around);

    FiberValue<T> Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const;
    // Chooses *wi from four numbers in (0, 1).
    FiberValue<T> Sample(const Vector3<T> &wo, std::array<T, 4> u, Vector3<T> *wi) const;

    DEonParameters parameters;
    Around around;

  private:
    // cos theta of the inclination at which N_p is taken.
    T CosThetaD(const Inclination<T> &o, const Inclination<T> &i) const {
        return parameters.inclination == AttenuationInclination::Viewer
                   ? o.cos
                   : std::sqrt(SquaredCosOfHalfDifference(o, i));
    }
    static constexpr size_t kMaxLobes = 17;
    using Shares = std::array<T, kMaxLobes>;
    Shares SharesOf(T cosThetaO) const;
    FiberValue<T> Gather(const Shares &shares, const Inclination<T> &o, const Inclination<T> &i, T phi) const;
    const LongitudinalLobe<T> &Along(size_t p) const { return along_[std::min(p, size_t(3))]; }
    std::array<LongitudinalLobe<T>, 4> along_;
};
//<

//> Say what d'Eon's class takes
// d'Eon, Francois, Hill, Letteri and Aubry 2011. Far field unless h is given. Throws Error for parameters
// that are not finite.
class DEonBSDF final : public BxDFOf<DEon<Float, DEonQuadrature<Float>>> {
  public:
    explicit DEonBSDF(const DEonParameters &parameters);
    std::string ToString() const override;
};
std::string DescribeDEon(const char *name, const DEonParameters &parameters);
//<

//> Declare the model whose lobes are counted by the light
// The model of a fiber with h given, whose attenuation is taken at the viewer's inclination: the first orders
// have a lobe each, as many as it takes until those beyond, which share the tail, hold no more than tailShare
// of the light that leaves; at least one, at most `lobes`. All light leaves, whatever the number.
template <typename T>
class ChosenLobes {
  public:
    // p: with h, AttenuationInclination::Viewer and the tail.
    ChosenLobes(const DEonParameters &p, T share) : parameters(p), tailShare(share) {}
    int LobesAt(T cosThetaO) const;

    FiberValue<T> Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const {
        return At(wo).Evaluate(wo, wi);
    }
    FiberValue<T> Sample(const Vector3<T> &wo, const std::array<T, 4> &u, Vector3<T> *wi) const {
        return At(wo).Sample(wo, u, wi);
    }

    const DEonParameters parameters;
    const T tailShare;

  private:
    DEon<T, DEonQuadrature<T>> At(const Vector3<T> &wo) const;
};
// Throws Error for parameters that are not finite, and for a fiber without h or without a tail, or at another
// inclination.
class ChosenLobesBSDF final : public BxDFOf<ChosenLobes<Float>> {
  public:
    ChosenLobesBSDF(const DEonParameters &parameters, Float tailShare);
    std::string ToString() const override;
};
//<

//> Tabulate $N_p$
// All lobes of one fiber over theta_d and phi; what is tabulated does not depend on alpha and betaM. Made
// with all threads of the current task arena, in hundredths of a second where lobes are wide, in about a
// second of one core where five of them are narrowest. Throws Error for a near-field fiber, and for one that
// a table does not hold. T is float or double.
template <typename T>
class DEonTableOf {
  public:
    explicit DEonTableOf(const DEonParameters &parameters);
    // Why a table would not hold the fiber: its lobes are narrower around it than kNarrowest, so that columns
    // and rows would be too far apart, or they are so many of them that it would be too large; else empty.
    static std::string WhyNot(const DEonParameters &parameters);
    static constexpr float kNarrowest = 1; // degree
    static constexpr size_t kMaxCells = 2'500'000;
    // The same table for the same parameters, while anyone holds it. Thread-safe.
    static std::shared_ptr<const DEonTableOf> Cached(const DEonParameters &parameters);

    // A view offers what the model asks of a table, which must outlive it.
    class View {
      public:
        explicit View(const DEonTableOf *table) : table_(table) {}
        struct Inside { // a place between two rows
            size_t row;
            T fraction;
        };
        Inside At(T cosThetaD) const;
        AroundValue<T> Value(size_t p, const Inside &inside, T phi) const;
        T Sample(size_t p, const Inside &inside, T rest, T u) const;
        T Share(size_t p, const Inside &inside) const;

      private:
        T Between(const std::vector<T> &values, size_t p, const Inside &inside) const;
        const DEonTableOf *table_;
    };
    size_t Rows() const { return rows_; }
    size_t Columns() const { return columns_; }
    size_t MemoryBytes() const;

  private:
    size_t Row(size_t row, size_t p) const { return row * lobes_ + p; }
    void Fill(const DEonQuadrature<double> &exact, size_t row, size_t p);

    size_t rows_, columns_, lobes_;        // columns over phi in [0, pi], ends included
    std::vector<std::array<T, 3>> n_;      // N_p, by row, lobe, column
    std::vector<T> luminance_, cumulated_; // of N_p, and its integral from 0 to the column
    std::vector<T> mean_;                  // its integral over the circle, by row and lobe
    std::vector<T> share_;                 // the light of the lobe, by which it is sampled
};
using DEonTable = DEonTableOf<Float>;
//<

//> Declare the fast form of the model
class TabulatedDEonBSDF final : public BxDFOf<DEon<Float, DEonTable::View>> {
  public:
    // table: of the same parameters; must outlive the BSDF.
    TabulatedDEonBSDF(const DEonParameters &parameters, const DEonTable *table);
    std::string ToString() const override;
};
//<

} // namespace cuticle
//<
