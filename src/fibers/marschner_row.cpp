//> Enter Marschner's model in the table
#include "fibers/lobe_angles.h"
#include "fibers/marschner.h"

namespace cuticle {

namespace {

//> Name the choices of Marschner's model
// The names stand in the order of their enumerations; the first is the default.
constexpr std::string_view kRoots[] = {"exact", "cubic", "polished"};
constexpr std::string_view kPaths[] = {"chord", "printed"};
constexpr std::string_view kForms[] = {"full-angle", "half-angle", "spherical"};
constexpr LongitudinalForm kFormOf[] = {LongitudinalForm::FullAngle, LongitudinalForm::HalfAngle,
                                        LongitudinalForm::Spherical};
//<

//> Make Marschner's model of a fiber
// Derives what the scene does not give: beta_R ... from beta_m; alpha_R = -alpha, TT and TRT in Table 1's
// proportion; w_c is the width that beta_n gives the default model's lobes. LobeAngles are of theta_i +
// theta_o, Table 1's of half of that.
class MarschnerMaker final : public FiberMaker {
  public:
    explicit MarschnerMaker(const FiberSettings &settings)
        : angles_(settings, 2), kd_(settings.Slot("Kd")), wc_(settings.Slot("w_c")),
          eccentricity_(settings.Slot("eccentricity")) {
        choices_.kG = settings.Number("k_G", choices_.kG);
        choices_.etaRange = settings.Number("delta_eta", choices_.etaRange);
        choices_.maxH = settings.Number("delta_h_M", choices_.maxH);
        choices_.roots = static_cast<RootMethod>(settings.Choice("roots"));
        choices_.length = static_cast<SegmentLength>(settings.Choice("path"));
        choices_.longitudinal = kFormOf[settings.Choice("longitudinal")];
        choices_.printedEccentricity = settings.Flag("printed_eccentricity", false);
        choices_.orders = OrdersOf(settings, 3, false);
    }
    bool NeedsAxis() const override { return eccentricity_.has_value(); }
    void Make(const FiberInputs &at, FiberStorage *fiber) const override {
        fiber->Emplace<MarschnerBSDF>(ParametersAt(at));
    }
    std::unique_ptr<FiberInDouble> MakeInDouble(const FiberInputs &at) const override {
        return InDouble(Marschner<double>(CheckedMarschner(ParametersAt(at))));
    }

  private:
    MarschnerParameters ParametersAt(const FiberInputs &at) const {
        // Table 1's proportion, of theta_i + theta_o; an alpha of any size, without its whole turns.
        constexpr double kInAlpha[] = {-2, 1, 3};
        MarschnerParameters p = choices_;
        p.eta = at.eta;
        p.sigmaA = at.sigmaA;
        for (size_t i = 0; i < 3; ++i) {
            p.beta[i] = angles_.Width(i, at) / 2;
            p.alpha[i] =
                angles_.Shift(i, at,
                              static_cast<float>(std::remainder(kInAlpha[i] * double(at.alpha), 360.))) /
                2;
        }
        p.wc = wc_ ? at.numbers[*wc_] : AzimuthalWidth(at.betaN);
        if (kd_)
            p.kd = at.colors[*kd_];
        if (eccentricity_) {
            p.eccentricity = at.numbers[*eccentricity_];
            p.axis = Degrees(at.axis);
        }
        return p;
    }
    LobeAngles angles_;
    std::optional<size_t> kd_, wc_, eccentricity_;
    MarschnerParameters choices_;
};
//<

//> Fit Marschner's model
// Three widths, one tilt in Table 1's proportion, the glints' strength and width.
std::vector<OwnValue> Fitted(const std::vector<double> &x, float axisRatio) {
    const auto exp = [](double logarithm) { return static_cast<float>(std::exp(logarithm)); };
    const auto alpha = static_cast<float>(x[3]);
    return {{"beta_R", exp(x[0])}, {"beta_TT", exp(x[1])},  {"beta_TRT", exp(x[2])},
            {"alpha_R", -alpha},   {"alpha_TT", alpha / 2}, {"alpha_TRT", 3 * alpha / 2},
            {"k_G", exp(x[4])},    {"w_c", exp(x[5])},      {"eccentricity", axisRatio}};
}
void Fit(const std::vector<double> &x, const SimulatedFiber &fiber, FiberInputs *,
         std::vector<OwnValue> *own) {
    *own = Fitted(x, static_cast<float>(fiber.axisRatio));
}
void FitRound(const std::vector<double> &x, const SimulatedFiber &, FiberInputs *,
              std::vector<OwnValue> *own) {
    *own = Fitted(x, 1);
}
//<

//> List the parameters of Marschner's model in a scene
constexpr ParamInfo kParams[] = {
    {"alpha_R", "float texture", "degrees of theta_h", "-alpha", "shift of R; negative toward the root"},
    {"alpha_TT", "float texture", "degrees of theta_h", "alpha / 2", "shift of TT"},
    {"alpha_TRT", "float texture", "degrees of theta_h", "3 alpha / 2", "shift of TRT"},
    {"beta_R", "float texture", "degrees of theta_h", "from beta_m", "standard deviation of R", 0, 1e3},
    {"beta_TT", "float texture", "degrees of theta_h", "from beta_m", "standard deviation of TT", 0, 1e3},
    {"beta_TRT", "float texture", "degrees of theta_h", "from beta_m", "standard deviation of TRT", 0, 1e3},
    {"eccentricity", "float texture", "", "1", "minor over major axis of the section, a; 1 is a circle", 0.2,
     5},
    {"k_G", "float", "", "1", "strength of the glints", 0, 1e6},
    {"w_c", "float texture", "degrees", "from beta_n", "standard deviation of the glints around the fiber",
     0.1, 60},
    {"delta_eta", "float", "", "0.3", "the range of eta' over which glints fade after they have met", 1e-3,
     1e3},
    {"delta_h_M", "float", "", "0.5", "limit of the glints' power, of the width of the fiber", 0, 2},
    {"Kd", "spectrum texture", "", "0", "share of the light in a diffuse term (section 5.3)", 0, 1},
    {.name = "roots",
     .type = "string",
     .unit = "",
     .defaultValue = "exact",
     .meaning = "how paths are found: all; the paper's cubic; the cubic, polished",
     .choices = kRoots},
    {.name = "longitudinal",
     .type = "string",
     .unit = "",
     .defaultValue = "full-angle",
     .meaning = "the form of M_p: Zinke and Weber's; as printed, which doubles the light; d'Eon's",
     .choices = kForms},
    {.name = "path",
     .type = "string",
     .unit = "",
     .defaultValue = "chord",
     .meaning = "the length of a segment inside, or the square of it, as printed",
     .choices = kPaths},
    {"printed_eccentricity", "bool", "", "false",
     "the caustics of elliptical fibers the wrong way round, as printed"},
    kOrdersParam,
};
//<

} // namespace

//> State Marschner's row
FiberModel MarschnerRow() {
    return {
        .name = "marschner",
        .title = "Marschner",
        .paper = "Marschner et al. 2003",
        .year = 2003,
        .meaning = "far field: R, TT, TRT of a smooth fiber, blurred, with glints and eccentric fibers",
        .params = {std::begin(kParams), std::end(kParams)},
        .prepare = [](const FiberSettings &settings) -> std::unique_ptr<FiberMaker> {
            return std::make_unique<MarschnerMaker>(settings);
        },
        .published = {.parameters = "\"string longitudinal\" \"half-angle\" \"string roots\" \"cubic\" "
                                    "\"string path\" \"printed\""},
        .forms = {{.name = "", .reciprocal = true},
                  {.name = "half angle", .own = {{"longitudinal", "half-angle"}}, .reciprocal = true},
                  {.name = "cubic", .own = {{"roots", "cubic"}}, .lawful = false},
                  {.name = "polished", .own = {{"roots", "polished"}}, .reciprocal = true},
                  {.name = "eccentric", .own = {{"eccentricity", 0.9f}}, .reciprocal = true}},
        .fits = {{"Marschner", 4, {1.5, 1.5, 2, 3, 0, 2}, Fit},
                 {.title = "Marschner, section ignored",
                  .color = 4,
                  .start = {1.5, 1.5, 2, 3, 0, 2},
                  .set = FitRound,
                  .drawn = false}},
        .caustics = true,
        .cosineInside = false,
    };
}
//<

} // namespace cuticle
//<
