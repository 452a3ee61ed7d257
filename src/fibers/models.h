//> Declare the table of fiber models
#pragma once

#include "core/error.h"
#include "core/param_info.h"
#include "fibers/bxdf.h"

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace cuticle {

//> Say what every model starts from
// One place of one fiber: the common parameters of Material "hair" there, and where across its width it is
// met. Models clamp what is out of their range.
inline constexpr size_t kMaxOwnNumbers = 16, kMaxOwnColors = 4;
struct FiberInputs {
    float h = 0;                             // offset across the fiber, [-1, 1]
    float eta = 1.55f;                       // index of refraction
    std::array<float, 3> sigmaA = {0, 0, 0}; // absorption per fiber radius
    float betaM = 0.3f, betaN = 0.3f;        // roughness along and around, [0, 1]
    float alpha = 2;                         // tilt of the scales, degrees
    float axis = 0;      // azimuth of the section's first axis in the local frame, radians
    bool pbrtV3 = false; // tilt the scales to pbrt-v3's side, which we hold to be wrong (--compat)
    std::array<float, kMaxOwnNumbers>
        numbers; // the model's own textures that are given, by FiberSettings::Slot
    std::array<std::array<float, 3>, kMaxOwnColors> colors;
};
//<

//> Ask for a model's own parameters
// A model reads its own parameters from this when it is prepared: a scene's material, or FiberValues below.
// Names are those of the model's row. Rows of type "float texture" and "spectrum texture" may differ from
// place to place: such a parameter has a slot, under which FiberInputs hold its value. All others are one
// value for the whole hair.
struct FiberModel;
class FiberSettings {
  public:
    explicit FiberSettings(const FiberModel &model) : model_(model) {}
    virtual ~FiberSettings() = default;

    virtual bool Has(std::string_view name) const = 0;       // is it given?
    virtual bool IsTexture(std::string_view name) const = 0; // may it vary? Common parameters, too
    virtual bool ColorVaries() const = 0;
    virtual float Number(std::string_view name, float otherwise) const = 0;
    virtual int Integer(std::string_view name, int otherwise) const = 0;
    virtual bool Flag(std::string_view name, bool otherwise) const = 0;
    virtual std::string Word(std::string_view name, std::string_view otherwise) const = 0;
    // All that is given, at one place: for tables of what is the same everywhere. h is 0.
    virtual FiberInputs AtOnePlace() const = 0;
    // An error at the parameter, or at the material where it is not given.
    virtual Error ErrorAt(std::string_view name, const std::string &message) const = 0;

    // The place of a given texture in FiberInputs::numbers or colors; none where it is not given.
    std::optional<size_t> Slot(std::string_view name) const;
    // Which of its row's choices a string is, from 0; Error for none of them.
    size_t Choice(std::string_view name) const;
    // Error where the parameter is a texture.
    void MustNotVary(std::string_view name) const;

  protected:
    const FiberModel &model_;
};
//<

//> Prepare a model for one hair
// Made once for a material, asked at every hit. What Make puts into `fiber` may refer to tables of the maker,
// which must outlive it; what MakeInDouble returns stands by itself.
class FiberMaker {
  public:
    virtual ~FiberMaker() = default;
    virtual bool NeedsAxis() const { return false; }   // reads FiberInputs::axis
    virtual bool NeedsOffset() const { return false; } // reads FiberInputs::h
    virtual void Make(const FiberInputs &at, FiberStorage *fiber) const = 0;
    // Makes the fiber that `made` is at another offset, at.h; all else of `at` is as it was.
    virtual void MakeBeside(const FiberBxDF & /*made*/, const FiberInputs &at, FiberStorage *fiber) const {
        Make(at, fiber);
    }
    // The same formulas in double.
    virtual std::unique_ptr<FiberInDouble> MakeInDouble(const FiberInputs &at) const = 0;
};
//<

//> Give parameters from a program
// Tests, benchmarks and charts have no scene and use this. A texture of the row's is given as a number or a
// colour.
struct OwnValue {
    std::string_view name;
    std::variant<float, int, bool, std::string_view, std::array<float, 3>> value;
};
class FiberValues final : public FiberSettings {
  public:
    // at: the common parameters. own: by name; Error for a name that the model does not have.
    FiberValues(const FiberModel &model, const FiberInputs &at, std::vector<OwnValue> own);
    bool Has(std::string_view name) const override { return Find(name) != nullptr; }
    bool IsTexture(std::string_view) const override { return false; }
    bool ColorVaries() const override { return false; }
    float Number(std::string_view name, float otherwise) const override;
    int Integer(std::string_view name, int otherwise) const override;
    bool Flag(std::string_view name, bool otherwise) const override;
    std::string Word(std::string_view name, std::string_view otherwise) const override;
    FiberInputs AtOnePlace() const override { return inputs_; }
    Error ErrorAt(std::string_view name, const std::string &message) const override;

  private:
    const OwnValue *Find(std::string_view name) const;
    std::vector<OwnValue> own_;
    FiberInputs inputs_;
};
//<

//> Say how a model was published
// One of three. A maker of its own: code that keeps the formulas as printed. Parameters of a scene with which
// ours is the published form (the default: ours as it comes). Or, of a model that nobody published, why there
// is no such form, in lines for a figure.
struct PublishedForm {
    std::unique_ptr<FiberInDouble> (*make)(const FiberInputs &at) = nullptr;
    std::string_view parameters = {};
    std::vector<std::string> absent = {};
};
//<

//> Name the forms that laws and benchmarks measure
// A model with some own parameters set; the first form of a row is the model as it comes. Laws that do not
// hold are stated as broken: see tests/fibers/model_laws.h.
struct FiberForm {
    std::string_view name = {}; // "six lobes"; empty for the first
    std::vector<OwnValue> own = {};
    float h = 0.4f;
    double energyTolerance = 0; // a white fiber returns all light, to within this; 0: it promises nothing
    bool reciprocal = false;    // without tilt, in the measure of its paper
    bool lawful = true; // false: too narrow, or in too many cells, for the laws' quadrature; it is timed only
};
//<

//> Say how a model is fitted to a fiber
// The chart "models" varies these numbers so that the model comes near to a simulated fiber.
struct SimulatedFiber {
    double roughness, alpha, axisRatio; // Beckmann's; degrees; second over first axis of the section
    double effort;                      // of tables: the share of the usual rays
};
struct FiberFit {
    std::string_view title;
    int color;                 // of the plot
    std::vector<double> start; // of the free numbers x: logarithms, but for tilts in degrees
    // Sets the common parameters but h, eta and sigmaA, and the own ones.
    void (*set)(const std::vector<double> &x, const SimulatedFiber &fiber, FiberInputs *at,
                std::vector<OwnValue> *own);
    bool asPrevious = false; // takes x of the fit before it, another form of the same
    bool drawn = true;       // false: in the table of numbers alone
};
//<

//> Describe a model in a row
struct FiberModel {
    std::string_view name;    // in a scene, and of --hair-model
    std::string_view title;   // for readers
    std::string_view paper;   // "Chiang et al. 2016"
    int year;                 // of the paper; charts are in this order
    std::string_view meaning; // one line for the manual
    std::vector<ParamInfo>
        params; // its own; numbers beyond their range are taken as the nearest, with a warning
    std::unique_ptr<FiberMaker> (*prepare)(const FiberSettings &settings);
    PublishedForm published = {};
    std::vector<FiberForm> forms = {{""}};
    std::vector<FiberFit> fits = {};
    bool farField = true;     // does not know h
    bool inCells = false;     // linear from cell to cell of a FiberTable
    bool caustics = false;    // the density has peaks where paths turn back
    bool cosineInside = true; // f |cos| is what is reciprocal; else f |cos| / cos theta_i
    double minEta = 1.001;    // smallest index of refraction that it takes
    std::string_view coarse =
        {}; // parameters of a scene that make it sooner and coarser, where thousands are made

    const ParamInfo *FindParam(std::string_view param) const; // null if it has none of that name
};
// All models, the default first. A row keeps its place as long as the program runs.
const std::deque<FiberModel> &FiberModels();
// Null for an unknown name.
const FiberModel *FindFiberModel(std::string_view name);
// Adds a row at the end: how a program (a test) brings a model of its own. Before scenes are read, from one
// thread. Error if the name is taken, or if it has more textures of its own than FiberInputs hold.
const FiberModel &AddFiberModel(FiberModel model);
//<

//> Prepare a model without a scene
// A maker with the parameters that a program gives it. Throws Error where the model refuses them.
struct PreparedFiber {
    PreparedFiber(const FiberModel &model, const FiberInputs &at, const std::vector<OwnValue> &own);
    // The model at an offset across the fiber; `fiber` must not outlive this.
    void Make(float h, FiberStorage *fiber) const { maker->Make(At(h), fiber); }
    std::unique_ptr<FiberInDouble> MakeInDouble(float h) const { return maker->MakeInDouble(At(h)); }
    FiberInputs At(float h) const {
        FiberInputs at = inputs;
        at.h = h;
        return at;
    }

    FiberInputs inputs; // own textures among them
    std::unique_ptr<FiberMaker> maker;
};
//<

} // namespace cuticle
//<
