// A fiber model that no file of the program knows: one row, added here. It passes through a scene, the laws,
// a cell of the atlas and the manual. Appendix D of the book names these places.
#include "fibers/model_laws.h"
#include "figures/atlas/atlas_fibers.h"
#include "materials/hair_models.h"
#include "parser/scene_description.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <gtest/gtest.h>

namespace cuticle {
namespace {

// The model: light leaves evenly into all directions, but for what the fiber absorbs. T is float or double.
template <typename T>
struct Isotropic {
    std::array<T, 3> albedo;
    FiberValue<T> Evaluate(const Vector3<T> &, const Vector3<T> &) const {
        const T density = 1 / (4 * kPi<T>);
        return {{albedo[0] * density, albedo[1] * density, albedo[2] * density}, density};
    }
    FiberValue<T> Sample(const Vector3<T> &wo, const std::array<T, 4> &u, Vector3<T> *wi) const {
        const T z = 1 - 2 * u[0], r = std::sqrt(std::max(T(0), 1 - z * z)), phi = 2 * kPi<T> * u[1];
        *wi = {r * std::cos(phi), r * std::sin(phi), z};
        return Evaluate(wo, *wi);
    }
};
class IsotropicBSDF final : public BxDFOf<Isotropic<Float>> {
  public:
    explicit IsotropicBSDF(const std::array<Float, 3> &albedo) : BxDFOf({albedo}) {}
    std::string ToString() const override { return "[ IsotropicBSDF ]"; }
};

// How it is made of a fiber.
class ProbeMaker final : public FiberMaker {
  public:
    explicit ProbeMaker(const FiberSettings &settings) : gain_(settings.Slot("gain")) {}
    void Make(const FiberInputs &at, FiberStorage *fiber) const override {
        fiber->Emplace<IsotropicBSDF>(AlbedoAt(at));
    }
    std::unique_ptr<FiberInDouble> MakeInDouble(const FiberInputs &at) const override {
        const std::array<float, 3> a = AlbedoAt(at);
        return InDouble(Isotropic<double>{{a[0], a[1], a[2]}});
    }

  private:
    std::array<float, 3> AlbedoAt(const FiberInputs &at) const {
        std::array<float, 3> albedo;
        for (size_t c = 0; c < 3; ++c)
            albedo[c] = (gain_ ? at.numbers[*gain_] : 1.f) * std::exp(-at.sigmaA[c]);
        return albedo;
    }
    std::optional<size_t> gain_;
};

// And its row.
const FiberModel &kProbe = AddFiberModel({
    .name = "probe",
    .title = "Probe",
    .paper = "nobody, today",
    .year = 2030,
    .meaning = "light leaves evenly into all directions",
    .params = {{"gain", "float texture", "", "1", "a factor on all that leaves", 0, 1}},
    .prepare = [](const FiberSettings &settings) -> std::unique_ptr<FiberMaker> {
        return std::make_unique<ProbeMaker>(settings);
    },
    .published = {.absent = {"Nobody published it."}},
    .forms = {{.name = "", .energyTolerance = 1e-5, .reciprocal = true}},
});

// The same laws that the program's own models obey.
INSTANTIATE_TEST_SUITE_P(Probe, EveryFiberModel, testing::Values(FormCase{&kProbe, &kProbe.forms.front()}),
                         [](const auto &model) { return model.param.Name(); });

// The mean of a few pixels of a fiber that fills the view, under a white dome.
double RenderedMean(const std::string &hair, const std::string &override = "") {
    const std::string text =
        "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 4\n"
        "LookAt 0 0 3 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 10\n"
        "Sampler \"halton\" \"integer pixelsamples\" 16 Integrator \"path\" \"integer maxdepth\" 1\n"
        "WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1] Material \"hair\" " +
        hair +
        " Shape \"curve\" \"point P\" [-9 0 0 -3 0 0 3 0 0 9 0 0] \"float width\" 4\n"
        "WorldEnd\n";
    SceneDescription description = ParseSceneText(AllPlugins(), text, "probe.pbrt");
    SceneOptions sceneOptions;
    sceneOptions.materials.hairModel = override;
    const Scene scene(&description, sceneOptions);
    RenderStats stats;
    const Image image = Render(description, scene, {}, &stats);
    EXPECT_EQ(stats.nanSamples, 0u);
    double sum = 0;
    for (size_t i = 0; i < image.Pixels(); ++i)
        sum += double(image.data[i * image.Channels() + 1]) / double(image.Pixels());
    return sum;
}

TEST(AddedFiberModel, RendersInAScene) {
    const std::string white = "\"rgb sigma_a\" [0 0 0] ", probe = "\"string model\" \"probe\" ";
    const double all = RenderedMean(white + probe);
    EXPECT_GT(all, 0.2);
    EXPECT_LT(all, 1.1);
    EXPECT_NEAR(RenderedMean(white + probe + "\"float gain\" 0.5"), all / 2, 1e-5);
    EXPECT_NEAR(RenderedMean("\"rgb sigma_a\" [1 1 1] " + probe), all * std::exp(-1.), 1e-5);
    EXPECT_EQ(RenderedMean(white, "probe"), all); // --hair-model
    EXPECT_NE(RenderedMean(white), all);
}

TEST(AddedFiberModel, IsMeasuredByTheAtlas) {
    EXPECT_FALSE(HasForm(kProbe, AtlasForm::Published));
    for (const AtlasForm form : {AtlasForm::InFloat, AtlasForm::InDouble}) {
        const FiberFaults faults = MeasureFiber(kProbe, form, {}, 1.2, true);
        EXPECT_EQ(faults.bad, 0);
        EXPECT_LT(faults.energy, 1e-5);
        EXPECT_LT(faults.disagreement, 0.02);
        EXPECT_LT(faults.weight, 1.001);
    }
}

TEST(AddedFiberModel, IsInTheManual) {
    const PluginInfo *hair = MaterialPlugins().Find("hair");
    ASSERT_TRUE(hair);
    const ParamInfo *gain = hair->FindParam("gain");
    ASSERT_TRUE(gain);
    EXPECT_EQ(gain->meaning, "a factor on all that leaves");
    const std::vector<std::string_view> names = HairModelNames();
    EXPECT_EQ(names.back(), "probe"); // what --hair-model may be
}

} // namespace
} // namespace cuticle
