//> Enter Kajiya and Kay's model in the table
#include "fibers/kajiya_kay.h"
#include "fibers/models.h"
#include "fibers/mp.h"
#include "fibers/smooth_fiber.h"

namespace cuticle {

namespace {

//> Make Kajiya and Kay's two terms of a fiber
// Derives what the scene does not give: Ks is the light that a smooth fiber of this eta, met square to its
// axis, reflects at once, and Kd all that passes through it and is not absorbed; exponent is 1 / v of
// beta_m's R lobe, since cos^n x is nearly exp(-n x^2 / 2). beta_n and alpha mean nothing to this model.
class KajiyaKayMaker final : public FiberMaker {
  public:
    explicit KajiyaKayMaker(const FiberSettings &settings)
        : kd_(settings.Slot("Kd")), ks_(settings.Slot("Ks")), exponent_(settings.Slot("exponent")) {}
    void Make(const FiberInputs &at, FiberStorage *fiber) const override { Emplace(at, fiber); }
    std::unique_ptr<FiberInDouble> MakeInDouble(const FiberInputs &at) const override {
        FiberStorage storage;
        const KajiyaKay<float> &m = Emplace(at, &storage).Numeric();
        const auto doubles = [](const std::array<float, 3> &c) {
            return std::array<double, 3>{c[0], c[1], c[2]};
        };
        return InDouble(KajiyaKay<double>(doubles(m.kd), doubles(m.ks), m.exponent));
    }

  private:
    const KajiyaKayBSDF &Emplace(const FiberInputs &at, FiberStorage *fiber) const {
        const SmoothFiber<float> smooth(1, std::clamp(at.eta, 1.f, 1e3f));
        Spectrum kd, ks;
        kd.c = kd_ ? at.colors[*kd_] : MeanOverWidth<8, float>([&](float gamma) {
            return smooth.Tail(1, gamma, at.sigmaA, SegmentLength::Chord);
        });
        ks.c = ks_ ? at.colors[*ks_] : MeanOverWidth<8, float>([&](float gamma) {
            return smooth.Attenuation(0, gamma, at.sigmaA, SegmentLength::Chord);
        });
        const float exponent =
            exponent_ ? at.numbers[*exponent_] : 1 / LongitudinalVariance(std::clamp(at.betaM, 0.f, 1.f))[0];
        return fiber->Emplace<KajiyaKayBSDF>(kd, ks, exponent);
    }
    std::optional<size_t> kd_, ks_, exponent_;
};
//<

//> Fit Kajiya and Kay's model
void Fit(const std::vector<double> &x, const SimulatedFiber &, FiberInputs *, std::vector<OwnValue> *own) {
    const auto grey = [](double logarithm) {
        const auto g = static_cast<float>(std::exp(logarithm));
        return std::array<float, 3>{g, g, g};
    };
    *own = {{"Kd", grey(x[0])},
            {"Ks", grey(x[1])},
            {"exponent", static_cast<float>(std::exp(std::min(x[2], 12.)))}};
}
//<

} // namespace

//> State Kajiya and Kay's row
FiberModel KajiyaKayRow() {
    return {
        .name = "kajiya-kay",
        .title = "Kajiya and Kay",
        .paper = "Kajiya and Kay 1989",
        .year = 1989,
        .meaning = "a diffuse cylinder and a highlight on a cone; conserves no energy",
        .params = {{"Kd", "spectrum texture", "", "what passes through a smooth fiber of this colour",
                    "share of the light in the diffuse term", 0, 1},
                   {"Ks", "spectrum texture", "", "what a smooth fiber of this eta reflects",
                    "share of the light in the highlight, for a view square to the fiber", 0, 1},
                   {"exponent", "float texture", "", "from beta_m",
                    "of the highlight's cosine; its width is about 1 / sqrt(exponent) radians", 0, 1e6}},
        .prepare = [](const FiberSettings &settings) -> std::unique_ptr<FiberMaker> {
            return std::make_unique<KajiyaKayMaker>(settings);
        },
        .published = {.absent = {"The same as ours:", "the two terms of 1989,",
                                 "their constants normalised."}},
        .forms = {{.name = "",
                   .own = {{"Kd", std::array{0.6f, 0.6f, 0.6f}},
                           {"Ks", std::array{0.4f, 0.4f, 0.4f}},
                           {"exponent", 20.f}}}},
        .fits = {{"Kajiya-Kay", 1, {-1, -3, 4}, Fit}},
    };
}
//<

} // namespace cuticle
//<
