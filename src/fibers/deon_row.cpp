//> Enter d'Eon's model in the table
#include "fibers/deon.h"
#include "fibers/lobe_angles.h"

namespace cuticle {

namespace {

//> Name the choices of d'Eon's model
// The names stand in the order of their enumerations; the first is the default.
constexpr std::string_view kForms[] = {"spherical", "full-angle", "half-angle", "printed"};
constexpr LongitudinalForm kFormOf[] = {LongitudinalForm::Spherical, LongitudinalForm::FullAngle,
                                        LongitudinalForm::HalfAngle, LongitudinalForm::Printed};
constexpr std::string_view kEvaluations[] = {"auto", "table", "quadrature"};
constexpr std::string_view kInclinations[] = {"half-difference", "viewer"};
constexpr std::string_view kDetectors[] = {"wrapped", "nearest"};
constexpr std::string_view kFields[] = {"far", "near"};
constexpr std::string_view kPaths[] = {"chord", "printed"};
//<

//> Make d'Eon's model of a fiber
// Alpha and widths are those of the default model where the scene does not give them. N_p comes from a table
// where nothing that it depends on varies over the hair and a table holds it, else from quadrature;
// "evaluation" demands one of the two.
class DEonMaker final : public FiberMaker {
  public:
    explicit DEonMaker(const FiberSettings &settings) : angles_(settings, 1) {
        choices_.order = settings.Integer("order", 0);
        if (choices_.order < 0 || choices_.order > static_cast<int>(kMaxNodes))
            throw settings.ErrorAt("order",
                                   fmt::format("\"order\" must be 1 to {}, or 0 for as many nodes as the "
                                               "widths ask for, not {}",
                                               kMaxNodes, choices_.order));
        choices_.lobes = LobesOf(settings, choices_.lobes);
        choices_.tail = settings.Flag("tail", true);
        choices_.orders = OrdersOf(settings, choices_.lobes, choices_.tail);
        choices_.halfAngleFresnel = settings.Flag("half_angle_fresnel", false);
        choices_.longitudinal = kFormOf[settings.Choice("longitudinal")];
        choices_.length = static_cast<SegmentLength>(settings.Choice("path"));
        choices_.inclination = static_cast<AttenuationInclination>(settings.Choice("inclination"));
        choices_.detector = static_cast<AzimuthalDetector>(settings.Choice("detector"));
        near_ = settings.Choice("field") == 1;
        constexpr const char *kAzimuth[] = {"azimuth_R", "azimuth_TT", "azimuth_TRT"};
        bool varies = settings.ColorVaries() || settings.IsTexture("eta") || settings.IsTexture("beta_n");
        for (size_t p = 0; p < 3; ++p) {
            azimuth_[p] = settings.Slot(kAzimuth[p]);
            varies = varies || settings.IsTexture(kAzimuth[p]);
        }
        const size_t evaluation = settings.Choice("evaluation");
        if (evaluation == 1 && (near_ || varies))
            throw settings.ErrorAt(
                "evaluation", "a table needs a far field, and a colour, eta and widths around the fiber that "
                              "are the same everywhere");
        if (evaluation == 2 || near_ || varies)
            return;
        const DEonParameters p = ParametersAt(settings.AtOnePlace());
        if (const std::string why = DEonTable::WhyNot(p); why.empty())
            table_ = DEonTable::Cached(p);
        else if (evaluation == 1)
            throw settings.ErrorAt("evaluation", why + "; take \"auto\" or \"quadrature\"");
    }
    bool NeedsOffset() const override { return near_; }
    void Make(const FiberInputs &at, FiberStorage *fiber) const override {
        if (table_)
            fiber->Emplace<TabulatedDEonBSDF>(ParametersAt(at), table_.get());
        else
            fiber->Emplace<DEonBSDF>(ParametersAt(at));
    }
    std::unique_ptr<FiberInDouble> MakeInDouble(const FiberInputs &at) const override {
        const DEonParameters p = CheckedDEon(ParametersAt(at));
        if (!table_)
            return InDouble(DEon<double, DEonQuadrature<double>>(p, DEonQuadrature<double>(p)));
        using Table = DEonTableOf<double>;
        const std::shared_ptr<const Table> table = Table::Cached(p);
        return InDouble(DEon<double, Table::View>(p, Table::View(table.get())), table);
    }

  private:
    DEonParameters ParametersAt(const FiberInputs &at) const {
        DEonParameters p = choices_;
        p.eta = at.eta;
        p.sigmaA = at.sigmaA;
        for (size_t i = 0; i < 3; ++i) {
            p.betaM[i] = angles_.Width(i, at);
            p.alpha[i] = angles_.Shift(i, at, ShiftOfTilt(i, at.alpha));
            p.betaN[i] = azimuth_[i] ? at.numbers[*azimuth_[i]] : AzimuthalWidth(at.betaN);
        }
        if (near_)
            p.h = at.h;
        return p;
    }
    LobeAngles angles_;
    std::array<std::optional<size_t>, 3> azimuth_;
    DEonParameters choices_;
    bool near_ = false;
    std::shared_ptr<const DEonTable> table_;
};
//<

//> Fit d'Eon's model
// Three widths along the fiber, one tilt, the width around the fiber of R and TT and that of TRT in
// proportion.
std::vector<OwnValue> Fitted(const std::vector<double> &x, std::string_view evaluation) {
    const auto exp = [](double logarithm) { return static_cast<float>(std::exp(logarithm)); };
    const auto alpha = static_cast<float>(x[3]);
    // Narrower than 2 degrees is nothing that the simulation's cells tell apart, and dear.
    const float around = std::max(2.f, exp(x[4])), aroundTrt = std::max(2.f, exp(x[4] + x[5]));
    return {{"beta_R", exp(x[0])},     {"beta_TT", exp(x[1])}, {"beta_TRT", exp(x[2])},
            {"alpha_R", -2 * alpha},   {"alpha_TT", alpha},    {"alpha_TRT", 4 * alpha},
            {"azimuth_R", around},     {"azimuth_TT", around}, {"azimuth_TRT", aroundTrt},
            {"evaluation", evaluation}};
}
void Fit(const std::vector<double> &x, const SimulatedFiber &, FiberInputs *, std::vector<OwnValue> *own) {
    *own = Fitted(x, "quadrature");
}
void FitTable(const std::vector<double> &x, const SimulatedFiber &, FiberInputs *,
              std::vector<OwnValue> *own) {
    *own = Fitted(x, "table");
}
//<

//> List the parameters of d'Eon's model in a scene
constexpr std::string_view kSum = "degrees of theta_i + theta_o";
constexpr ParamInfo kParams[] = {
    {"alpha_R", "float texture", kSum, "-2 alpha", "shift of R; negative toward the root"},
    {"alpha_TT", "float texture", kSum, "alpha", "shift of TT"},
    {"alpha_TRT", "float texture", kSum, "4 alpha", "shift of TRT"},
    {"beta_R", "float texture", kSum, "from beta_m", "standard deviation of R", 0, 1e3},
    {"beta_TT", "float texture", kSum, "from beta_m", "standard deviation of TT", 0, 1e3},
    {"beta_TRT", "float texture", kSum, "from beta_m", "standard deviation of TRT and beyond", 0, 1e3},
    {"azimuth_R", "float texture", "degrees", "from beta_n", "standard deviation of R around the fiber", 0,
     1e3},
    {"azimuth_TT", "float texture", "degrees", "from beta_n", "standard deviation of TT around the fiber", 0,
     1e3},
    {"azimuth_TRT", "float texture", "degrees", "from beta_n", "that of TRT and beyond", 0, 1e3},
    {"lobes", "integer", "", "4", "orders with a lobe of their own", 1, kMaxSceneLobes},
    {"tail", "bool", "", "true", "one more lobe for all orders beyond; the paper has none"},
    kOrdersParam,
    {"half_angle_fresnel", "bool", "", "false", "R by the reflectance at the half angle (equation 12)"},
    {.name = "field",
     .type = "string",
     .unit = "",
     .defaultValue = "far",
     .meaning = "the mean over the width, or the offset at which a ray meets the fiber",
     .choices = kFields},
    {.name = "evaluation",
     .type = "string",
     .unit = "",
     .defaultValue = "auto",
     .meaning =
         "N_p from a table where colour, eta and widths are the same everywhere and a table holds them "
         "(of 1 degree and more), or by quadrature",
     .choices = kEvaluations},
    {.name = "inclination",
     .type = "string",
     .unit = "",
     .defaultValue = "half-difference",
     .meaning = "where attenuation is taken: as published, or at the viewer's theta",
     .choices = kInclinations},
    {.name = "detector",
     .type = "string",
     .unit = "",
     .defaultValue = "wrapped",
     .meaning = "all images of an azimuth, or only the nearest (Zinke and Weber)",
     .choices = kDetectors},
    {.name = "longitudinal",
     .type = "string",
     .unit = "",
     .defaultValue = "spherical",
     .meaning = "the form of M_p; printed: the paper's formula with its short series",
     .choices = kForms},
    {"order", "integer", "", "0", "nodes of the quadrature; 0: by the widths; the paper has 35", 0,
     kMaxNodes},
    {.name = "path",
     .type = "string",
     .unit = "",
     .defaultValue = "chord",
     .meaning = "the length of a segment inside, or the square of it, as printed",
     .choices = kPaths},
};
//<

//> Set lobes of one width
// Energy is conserved only if all lobes are equally wide along the fiber.
std::vector<OwnValue> EqualLobes(float degreesAround, std::vector<OwnValue> more) {
    std::vector<OwnValue> own = {{"beta_R", 12.f},
                                 {"beta_TT", 12.f},
                                 {"beta_TRT", 12.f},
                                 {"azimuth_R", degreesAround},
                                 {"azimuth_TT", degreesAround},
                                 {"azimuth_TRT", degreesAround}};
    own.insert(own.end(), more.begin(), more.end());
    return own;
}
//<

} // namespace

//> State d'Eon's row
FiberModel DEonRow() {
    const OwnValue quadrature = {"evaluation", "quadrature"};
    return {
        .name = "deon",
        .title = "d'Eon",
        .paper = "d'Eon et al. 2011",
        .year = 2011,
        .meaning =
            "far field (or near): any number of lobes, each a Gaussian around the fiber integrated over its "
            "width; from a table where colour and widths are the same everywhere",
        .params = {std::begin(kParams), std::end(kParams)},
        .prepare = [](const FiberSettings &settings) -> std::unique_ptr<FiberMaker> {
            return std::make_unique<DEonMaker>(settings);
        },
        .published = {.parameters =
                          "\"string longitudinal\" \"printed\" \"integer order\" 35 \"string path\" "
                          "\"printed\" \"bool half_angle_fresnel\" \"true\" \"bool tail\" \"false\""},
        .forms = {{.name = "table", .own = EqualLobes(12, {}), .energyTolerance = 1e-3, .reciprocal = true},
                  {.name = "20 degrees",
                   .own = EqualLobes(20, {quadrature}),
                   .energyTolerance = 1e-5,
                   .reciprocal = true},
                  {.name = "10 degrees",
                   .own = EqualLobes(10, {quadrature}),
                   .energyTolerance = 1e-5,
                   .reciprocal = true},
                  {.name = "3 degrees", .own = EqualLobes(3, {quadrature}), .lawful = false},
                  {.name = "near",
                   .own = EqualLobes(10, {{"field", "near"}}),
                   .h = -0.7f,
                   .energyTolerance = 1e-5}},
        .fits =
            {{"d'Eon, quadrature", 3, {2, 2, 2.5, 3, 2, 0}, Fit},
             {.title = "d'Eon, table of N_p", .color = 6, .start = {}, .set = FitTable, .asPrevious = true}},
    };
}
//<

} // namespace cuticle
//<
