//> Enter the tabulated model in the table
#include "fibers/lobe_angles.h"
#include "fibers/tabulated.h"

#include <algorithm>

namespace cuticle {

namespace {

constexpr std::string_view kDistributions[] = {"beckmann", "ggx"}; // in the order of MicrofacetDistribution

//> Make the table of a fiber
// The surface, where the scene does not give it, is as rough as makes its reflection as wide as the default
// model's R (a slope turns light by twice its angle, and Beckmann's slopes deviate by roughness / sqrt(2)). A
// table has the scene's absorptions as its levels, or, where the colour varies, steps of sqrt(2), and below
// 0.0125 of 2. Everything else must be the same on the whole hair.
class TabulatedMaker final : public FiberMaker {
  public:
    explicit TabulatedMaker(const FiberSettings &settings) {
        for (const std::string_view name : {"eta", "alpha", "beta_n", "beta_m"})
            settings.MustNotVary(name);
        const auto number = [&settings](std::string_view name, float otherwise) {
            settings.MustNotVary(name);
            return settings.Number(name, otherwise);
        };
        const FiberInputs at = settings.AtOnePlace();
        const float betaM = std::clamp(at.betaM, 0.f, 1.f);
        FiberDescription fiber;
        fiber.eta = at.eta, fiber.alpha = Radians(at.alpha);
        fiber.roughnessU =
            number("roughness_u", std::min(1.f, std::sqrt(LongitudinalVariance(betaM)[0] / 2)));
        fiber.roughnessV =
            settings.Number("roughness_v", std::min(1.f, Radians(AzimuthalWidth(at.betaN)) / std::sqrt(2.f)));
        fiber.distribution = static_cast<MicrofacetDistribution>(settings.Choice("distribution"));
        fiber.axisRatio = number("eccentricity", 1);
        fiber.polarised = settings.Flag("polarised", false);
        fiber.medullaRatio = number("medulla_ratio", 0);
        fiber.medullaSigmaS = number("medulla_sigma_s", 0);
        fiber.medullaG = number("medulla_g", 0);
        fiber.sigmaA = settings.ColorVaries() ? StepsOfAbsorption() : LevelsOf(at.sigmaA);
        const int samples = settings.Integer("samples", static_cast<int>(FiberTable::UsualSamples(fiber)));
        if (samples < 1 || samples > 1'000'000) // per direction: a million take minutes
            throw settings.ErrorAt("samples",
                                   fmt::format("\"samples\" must be 1 to 1 million, not {}", samples));
        eccentric_ = fiber.axisRatio != 1;
        try {
            table_ = FiberTable::Cached(fiber, static_cast<uint64_t>(samples));
        } catch (const Error &e) { // from another thread, which knows no place
            throw settings.ErrorAt("", e.Message());
        }
    }
    bool NeedsAxis() const override { return eccentric_; }
    void Make(const FiberInputs &at, FiberStorage *fiber) const override {
        fiber->Emplace<TabulatedBSDF>(table_.get(), Spectrum(at.sigmaA[0], at.sigmaA[1], at.sigmaA[2]),
                                      eccentric_ ? at.axis : 0);
    }
    std::unique_ptr<FiberInDouble> MakeInDouble(const FiberInputs &at) const override {
        const std::array<double, 3> sigmaA = {at.sigmaA[0], at.sigmaA[1], at.sigmaA[2]};
        return InDouble(Tabulated<double>(table_.get(), sigmaA, eccentric_ ? at.axis : 0), table_);
    }

  private:
    static std::vector<double> StepsOfAbsorption() {
        std::vector<double> levels = {0, 0.05 / 16, 0.05 / 8}; // grazing light goes far
        for (int i = -4; i <= 16; ++i)
            levels.push_back(0.05 * std::pow(2., i / 2.));
        return levels;
    }
    static std::vector<double> LevelsOf(const std::array<float, 3> &sigmaA) {
        std::vector<double> levels;
        for (const float sigma : sigmaA)
            levels.push_back(double(std::min(sigma, 1e18f)));
        std::sort(levels.begin(), levels.end());
        levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
        return levels;
    }
    bool eccentric_ = false;
    std::shared_ptr<const FiberTable> table_;
};
//<

//> Describe the fiber that a table is made of
// Nothing is free: the table is of the very fiber that is asked for.
void Fit(const std::vector<double> &, const SimulatedFiber &fiber, FiberInputs *at,
         std::vector<OwnValue> *own) {
    FiberDescription description;
    description.axisRatio = fiber.axisRatio;
    const double samples = fiber.effort * static_cast<double>(FiberTable::UsualSamples(description));
    const auto roughness = static_cast<float>(fiber.roughness);
    at->alpha = static_cast<float>(fiber.alpha);
    *own = {{"roughness_u", roughness},
            {"roughness_v", roughness},
            {"eccentricity", static_cast<float>(fiber.axisRatio)},
            {"samples", static_cast<int>(samples)}};
}
//<

//> List the parameters of a tabulated fiber in a scene
// The simulator refuses what is beyond its range.
constexpr ParamInfo kParams[] = {
    {"roughness_u", "float", "", "from beta_m", "roughness of the surface along the fiber, 0 to 1"},
    {"roughness_v", "float", "", "from beta_n", "roughness of the surface across the fiber, 0 to 1"},
    {.name = "distribution",
     .type = "string",
     .unit = "",
     .defaultValue = "beckmann",
     .meaning = "of the surface's slopes",
     .choices = kDistributions},
    {"eccentricity", "float", "", "1", "second over first axis of the section, 0.05 to 20"},
    {"polarised", "bool", "", "false", "follow polarisation, instead of averaging over it at every bounce"},
    {"medulla_ratio", "float", "", "0", "radius of a core over the fiber's, 0 to 1; 0: none"},
    {"medulla_sigma_s", "float", "1/radius", "0", "scattering of the core, 0 to 1000"},
    {"medulla_g", "float", "", "0", "mean cosine of the core's scattering, -1 to 1"},
    {"samples", "integer", "", "16384, eccentric 2048", "rays for each direction of the viewer", 1, 1e6},
};
//<

} // namespace

//> State the tabulated model's row
FiberModel TabulatedRow() {
    return {
        .name = "tabulated",
        .title = "Table",
        .paper = "ours, after exercises of Pharr 2016",
        .year = 2026,
        .meaning =
            "what the fiber simulator finds for this fiber, far field, from a table made when the scene is "
            "read (2 seconds of one core, eccentric fibers 4)",
        .params = {std::begin(kParams), std::end(kParams)},
        .prepare = [](const FiberSettings &settings) -> std::unique_ptr<FiberMaker> {
            return std::make_unique<TabulatedMaker>(settings);
        },
        .published = {.absent = {"There is none:", "the simulator's table is our own."}},
        .forms = {{.name = "", .own = {{"samples", 1024}}, .lawful = false}},
        .fits = {{"tabulated", 2, {}, Fit}},
        .inCells = true,
        .coarse = "\"integer samples\" 1024",
    };
}
//<

} // namespace cuticle
//<
