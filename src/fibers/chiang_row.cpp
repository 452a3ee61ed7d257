//> Enter the default model in the table
#include "fibers/deon.h"
#include "fibers/hair.h"
#include "fibers/hair_as_printed.h"
#include "fibers/hair_model.h"
#include "fibers/lobe_angles.h"

namespace cuticle {

namespace {

//> Make HairBSDF of a fiber
class ChiangMaker final : public FiberMaker {
  public:
    bool NeedsOffset() const override { return true; }
    void Make(const FiberInputs &at, FiberStorage *fiber) const override {
        fiber->Emplace<HairBSDF>(at.h, at.eta, Spectrum(at.sigmaA[0], at.sigmaA[1], at.sigmaA[2]), at.betaM,
                                 at.betaN, at.alpha, TiltOf(at));
    }
    void MakeBeside(const FiberBxDF &made, const FiberInputs &at, FiberStorage *fiber) const override {
        fiber->Emplace<HairBSDF>(static_cast<const HairBSDF &>(made), at.h);
    }
    std::unique_ptr<FiberInDouble> MakeInDouble(const FiberInputs &at) const override {
        return InDouble(HairLobes<double>(
            HairParameters{at.h, at.eta, at.sigmaA, at.betaM, at.betaN, at.alpha, TiltOf(at)}));
    }

  private:
    static ScaleTilt TiltOf(const FiberInputs &at) {
        return at.pbrtV3 ? ScaleTilt::PbrtV3 : ScaleTilt::RootToTip;
    }
};
//<

//> Make the same model with another number of lobes
// "lobes": as many of their own; "tail_share": as many as leave no more than this share of the light to the
// uniform lobe; "orders": only these lobes. The same model in general code, which is slower. eta below 1.001
// is taken as that.
class ManyLobesMaker final : public FiberMaker {
  public:
    ManyLobesMaker(const FiberSettings &settings, int lobes) {
        choices_.lobes = lobes;
        if (settings.Has("tail_share"))
            tailShare_ = settings.Number("tail_share", 0);
        if (tailShare_ && settings.Has("orders"))
            throw settings.ErrorAt("orders", "\"orders\" cannot be chosen where \"tail_share\" decides which "
                                             "orders have a lobe; leave one of them out");
        choices_.orders = OrdersOf(settings, lobes, true);
        choices_.detector = AzimuthalDetector::Logistic;
        choices_.inclination = AttenuationInclination::Viewer;
    }
    bool NeedsOffset() const override { return true; }
    void Make(const FiberInputs &at, FiberStorage *fiber) const override {
        if (tailShare_)
            fiber->Emplace<ChosenLobesBSDF>(ParametersAt(at), *tailShare_);
        else
            fiber->Emplace<DEonBSDF>(ParametersAt(at));
    }
    std::unique_ptr<FiberInDouble> MakeInDouble(const FiberInputs &at) const override {
        const DEonParameters p = CheckedDEon(ParametersAt(at));
        if (tailShare_)
            return InDouble(ChosenLobes<double>(p, static_cast<double>(std::clamp(*tailShare_, 0.f, 1.f))));
        return InDouble(DEon<double, DEonQuadrature<double>>(p, DEonQuadrature<double>(p)));
    }

  private:
    DEonParameters ParametersAt(const FiberInputs &at) const {
        const float towardRoot = at.pbrtV3 ? -1.f : 1.f;
        DEonParameters p = choices_;
        p.h = at.h;
        p.eta = at.eta;
        p.sigmaA = at.sigmaA;
        for (size_t i = 0; i < 3; ++i) {
            p.betaM[i] = LongitudinalWidth(i, at.betaM);
            p.betaN[i] = AzimuthalWidth(at.betaN);
            p.alpha[i] = towardRoot * ShiftOfTilt(i, at.alpha);
        }
        return p;
    }
    DEonParameters choices_;
    std::optional<float> tailShare_;
};
//<

//> Fit the default model
// Two roughnesses and the tilt.
void Fit(const std::vector<double> &x, const SimulatedFiber &, FiberInputs *at, std::vector<OwnValue> *) {
    const auto unit = [](double logarithm) { return static_cast<float>(std::min(1., std::exp(logarithm))); };
    at->betaM = unit(x[0]), at->betaN = unit(x[1]), at->alpha = static_cast<float>(x[2]);
}
//<

constexpr ParamInfo kParams[] = {
    {"lobes", "integer", "", "3", "orders with a lobe of their own; but 3, in general, slower code", 1,
     kMaxSceneLobes},
    {"tail_share", "float", "", "",
     "as many lobes, up to \"lobes\" or 16, as leave no more than this share of the light to the uniform one",
     0, 1},
    kOrdersParam,
};

} // namespace

//> State the default model's row
FiberModel ChiangRow() {
    return {
        .name = "chiang",
        .title = "Chiang",
        .paper = "Chiang et al. 2016",
        .year = 2016,
        .meaning = "near field, HairBSDF",
        .params = {std::begin(kParams), std::end(kParams)},
        .prepare = [](const FiberSettings &settings) -> std::unique_ptr<FiberMaker> {
            const bool chosen = settings.Has("tail_share");
            const int lobes = LobesOf(settings, chosen ? kMaxSceneLobes : HairBSDF::pMax);
            if (lobes == HairBSDF::pMax && !chosen && !settings.Has("orders"))
                return std::make_unique<ChiangMaker>();
            return std::make_unique<ManyLobesMaker>(settings, lobes);
        },
        .published = {.make =
                          [](const FiberInputs &at) {
                              return as_printed::PrintedFiber(at, as_printed::Tilt::OnThetaI);
                          }},
        .forms = {{.name = "", .energyTolerance = 1e-5},
                  {.name = "six lobes", .own = {{"lobes", 6}}, .energyTolerance = 1e-5}},
        .fits = {{"Chiang (ours)", 0, {-1.5, -1.5, 3}, Fit}},
        .farField = false,
        .minEta = 1e-3,
    };
}
//<

} // namespace cuticle
//<
