#include "materials/hair_models.h"

#include "fibers/hair_model.h"
#include "fibers/smooth_fiber.h"

#include <atomic>
#include <limits>
#include <sstream>

namespace cuticle {

namespace {

using FloatTexture = std::shared_ptr<const Texture<float>>;
using SpectrumTexture = std::shared_ptr<const Texture<Spectrum>>;

// A parameter of one model, null where the scene does not give it.
FloatTexture OwnFloat(const ParamSet &params, const TextureTable &textures, const char *name) {
    return params.Find(name) ? textures.GetFloatTexture(params, name, 0) : nullptr;
}

// A share of the light, each colour in [0, 1]; values beyond are taken as these, with one warning at the parameter's place.
class ShareOfLight final : public Texture<Spectrum> {
  public:
    ShareOfLight(SpectrumTexture texture, const Param &p)
        : texture_(std::move(texture)), loc_(p.loc), name_(p.name) {}
    Spectrum Evaluate(const TexturePoint &point) const override {
        const Spectrum given = texture_->Evaluate(point), used = given.Clamp(0, 1);
        if (given.IsFinite() && !(given == used) && !warned_.exchange(true))
            Warning(loc_, "colour of a fiber out of range",
                    "\"" + name_ + "\" is a share of the light, from 0 to 1; values beyond are set to these");
        return used;
    }

  private:
    SpectrumTexture texture_;
    FileLoc loc_;
    std::string name_;
    mutable std::atomic<bool> warned_ = false;
};
SpectrumTexture OwnShare(const ParamSet &params, const TextureTable &textures, const char *name) {
    const Param *p = params.Find(name);
    return p ? std::make_shared<ShareOfLight>(textures.GetSpectrumTexture(params, name, Spectrum(0)), *p)
             : nullptr;
}

// "kajiya-kay". Own parameters: Kd, Ks, exponent. Derived: Ks is the light that a smooth fiber of this eta, met square to
// its axis, reflects at once, and Kd all that passes through it and is not absorbed; exponent is 1 / v of beta_m's R lobe,
// since cos^n x is nearly exp(-n x^2 / 2). beta_n and alpha mean nothing to this model.
class KajiyaKayMaterial : public Material {
  public:
    KajiyaKayMaterial(const ParamSet &params, const TextureTable &textures, const MaterialOptions &)
        : color_(params, textures), shape_(params, textures), kd_(OwnShare(params, textures, "Kd")),
          ks_(OwnShare(params, textures, "Ks")), exponent_(OwnFloat(params, textures, "exponent")) {}

    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        const TexturePoint point{si.p, si.uv, si.strandColors};
        const float eta = std::clamp(shape_.eta->Evaluate(point), 1.f, 1e3f);
        const SmoothFiber<float> fiber(1, eta);
        const std::array<float, 3> sigmaA = color_.SigmaA(point, shape_.betaN->Evaluate(point)).c;
        Spectrum kd, ks;
        if (kd_)
            kd = kd_->Evaluate(point);
        else
            kd.c = MeanOverWidth<8, float>(
                [&](float gamma) { return fiber.Tail(1, gamma, sigmaA, SegmentLength::Chord); });
        if (ks_)
            ks = ks_->Evaluate(point);
        else
            ks.c = MeanOverWidth<8, float>(
                [&](float gamma) { return fiber.Attenuation(0, gamma, sigmaA, SegmentLength::Chord); });
        const float exponent =
            exponent_ ? exponent_->Evaluate(point)
                      : 1 / LongitudinalVariance(std::clamp(shape_.betaM->Evaluate(point), 0.f, 1.f))[0];
        bsdf->SetFiber<KajiyaKayBSDF>(kd, ks, exponent);
    }

  private:
    HairColor color_;
    HairShape shape_;
    SpectrumTexture kd_, ks_;
    FloatTexture exponent_;
};

// One of a few names; the first is the default.
template <class Choice, size_t n>
Choice ChoiceOf(const ParamSet &params, const char *parameter, const std::array<std::string_view, n> &names) {
    const std::string name = params.FindString(parameter, std::string(names[0]));
    for (size_t i = 0; i < n; ++i)
        if (names[i] == name)
            return static_cast<Choice>(i);
    throw Error(params.Find(parameter)->loc, "\"" + std::string(parameter) + "\" cannot be \"" + name +
                                                 "\". " + Suggestion(name, names.data(), n));
}

// The standard deviations and shifts of theta_i + theta_o of the lobes R, TT, TRT, degrees: "beta_R" and so on where the
// scene gives them, times `unit`; else those of the default model.
class LobeAngles {
  public:
    LobeAngles(const ParamSet &params, const TextureTable &textures, float unit) : unit_(unit) {
        constexpr const char *kBeta[] = {"beta_R", "beta_TT", "beta_TRT"},
                             *kAlpha[] = {"alpha_R", "alpha_TT", "alpha_TRT"};
        for (size_t p = 0; p < 3; ++p) {
            beta_[p] = OwnFloat(params, textures, kBeta[p]);
            alpha_[p] = OwnFloat(params, textures, kAlpha[p]);
        }
    }
    float Width(size_t p, const TexturePoint &point, float betaM) const {
        return beta_[p] ? unit_ * beta_[p]->Evaluate(point)
                        : Degrees(std::sqrt(LongitudinalVariance(std::clamp(betaM, 0.f, 1.f))[p]));
    }
    float Shift(size_t p, const TexturePoint &point, float otherwise) const {
        return alpha_[p] ? unit_ * alpha_[p]->Evaluate(point) : otherwise;
    }

  private:
    float unit_;
    std::array<FloatTexture, 3> beta_, alpha_;
};

// The standard deviation around the fiber that the default model's logistic has, degrees.
float AzimuthalWidth(float betaN) {
    return 180 / std::sqrt(3.f) * AzimuthalScale(std::clamp(betaN, 0.f, 1.f));
}

// The azimuth of the section's first axis, which the strand carries, in the local frame, radians.
float AxisOf(const SurfaceInteraction &si) {
    return std::atan2(Dot(si.strandNormal, Vector3f(si.shading.z)), Dot(si.strandNormal, si.shading.y));
}

// Whether any of these parameters is a texture.
bool Varies(const ParamSet &params, std::initializer_list<std::string_view> names) {
    return std::any_of(names.begin(), names.end(), [&](std::string_view name) {
        const Param *p = params.Find(name);
        return p && p->type == ParamType::Texture;
    });
}

constexpr std::array<std::string_view, 2> kLengths = {"chord", "printed"};

// "marschner". Own parameters: Table 1's, angles in degrees of theta_h; Kd; and the choices of MarschnerParameters by name.
// Derived: beta_R ... from beta_m; alpha_R = -alpha, TT and TRT in Table 1's proportion; w_c is the width that beta_n
// gives the default model's lobes.
class MarschnerMaterial : public Material {
  public:
    MarschnerMaterial(const ParamSet &params, const TextureTable &textures, const MaterialOptions &)
        : color_(params, textures), shape_(params, textures), angles_(params, textures, 2),
          kd_(OwnShare(params, textures, "Kd")), wc_(OwnFloat(params, textures, "w_c")),
          eccentricity_(OwnFloat(params, textures, "eccentricity")) {
        choices_.kG = params.FindFloat("k_G", choices_.kG);
        choices_.etaRange = params.FindFloat("delta_eta", choices_.etaRange);
        choices_.maxH = params.FindFloat("delta_h_M", choices_.maxH);
        constexpr std::array<std::string_view, 3> kRoots = {"exact", "cubic", "polished"},
                                                  kForms = {"full-angle", "half-angle", "spherical"};
        constexpr LongitudinalForm kFormOf[] = {LongitudinalForm::FullAngle, LongitudinalForm::HalfAngle,
                                                LongitudinalForm::Spherical};
        choices_.roots = ChoiceOf<RootMethod>(params, "roots", kRoots);
        choices_.length = ChoiceOf<SegmentLength>(params, "path", kLengths);
        choices_.longitudinal = kFormOf[ChoiceOf<size_t>(params, "longitudinal", kForms)];
        choices_.printedEccentricity = params.FindBool("printed_eccentricity", false);
    }
    bool WantsStrandNormals() const override { return eccentricity_ != nullptr; }

    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        const TexturePoint point{si.p, si.uv, si.strandColors};
        const float betaM = shape_.betaM->Evaluate(point), betaN = shape_.betaN->Evaluate(point);
        const float alpha = shape_.alpha->Evaluate(point), shift[] = {-2 * alpha, alpha, 3 * alpha};
        MarschnerParameters p = choices_;
        p.eta = shape_.eta->Evaluate(point);
        p.sigmaA = color_.SigmaA(point, betaN).c;
        for (size_t i = 0; i < 3; ++i) {
            p.beta[i] = angles_.Width(i, point, betaM) / 2;
            p.alpha[i] = angles_.Shift(i, point, shift[i]) / 2;
        }
        p.wc = wc_ ? wc_->Evaluate(point) : AzimuthalWidth(betaN);
        if (kd_)
            p.kd = kd_->Evaluate(point).c;
        if (eccentricity_) {
            p.eccentricity = eccentricity_->Evaluate(point);
            p.axis = Degrees(AxisOf(si));
        }
        bsdf->SetFiber<MarschnerBSDF>(p);
    }

  private:
    HairColor color_;
    HairShape shape_;
    LobeAngles angles_;
    SpectrumTexture kd_;
    FloatTexture wc_, eccentricity_;
    MarschnerParameters choices_;
};

// How many orders have a lobe of their own.
constexpr int kMaxSceneLobes = 16;
int LobesOf(const ParamSet &params, int otherwise) {
    const int lobes = params.FindInt("lobes", otherwise);
    if (lobes < 1 || lobes > kMaxSceneLobes)
        throw Error(params.Find("lobes")->loc, "\"lobes\" must be 1 to 16, not " + std::to_string(lobes));
    return lobes;
}

// How many nodes the quadrature around the fiber has; 0: as many as the roughness asks for.
int OrderOf(const ParamSet &params) {
    const int order = params.FindInt("order", 0);
    if (order < 0 || order > static_cast<int>(kMaxNodes))
        throw Error(params.Find("order")->loc, "\"order\" must be 1 to " + std::to_string(kMaxNodes) +
                                                   ", or 0 for as many nodes as the widths ask for, not " +
                                                   std::to_string(order));
    return order;
}

// "deon". Own parameters, degrees of theta_i + theta_o: alpha_R ..., beta_R ...; around the fiber azimuth_R ...; lobes,
// tail, and the choices of DEonParameters by name; "string field" "near" takes h from the place across the fiber.
// Derived: alpha and widths are those of the default model. N_p comes from a table where nothing that it depends on
// varies over the hair, else from quadrature ("string evaluation" chooses).
class DEonMaterial : public Material {
  public:
    DEonMaterial(const ParamSet &params, const TextureTable &textures, const MaterialOptions &)
        : color_(params, textures), shape_(params, textures), angles_(params, textures, 1) {
        constexpr std::array<std::string_view, 4> kForms = {"spherical", "full-angle", "half-angle",
                                                            "printed"};
        constexpr std::array<std::string_view, 3> kEvaluations = {"auto", "table", "quadrature"};
        constexpr std::array<std::string_view, 2> kInclinations = {"half-difference", "viewer"},
                                                  kDetectors = {"wrapped", "nearest"},
                                                  kFields = {"far", "near"};
        constexpr LongitudinalForm kFormOf[] = {LongitudinalForm::Spherical, LongitudinalForm::FullAngle,
                                                LongitudinalForm::HalfAngle, LongitudinalForm::Printed};
        choices_.order = OrderOf(params);
        choices_.lobes = LobesOf(params, choices_.lobes);
        choices_.tail = params.FindBool("tail", true);
        choices_.halfAngleFresnel = params.FindBool("half_angle_fresnel", false);
        choices_.longitudinal = kFormOf[ChoiceOf<size_t>(params, "longitudinal", kForms)];
        choices_.length = ChoiceOf<SegmentLength>(params, "path", kLengths);
        choices_.inclination = ChoiceOf<AttenuationInclination>(params, "inclination", kInclinations);
        choices_.detector = ChoiceOf<AzimuthalDetector>(params, "detector", kDetectors);
        near_ = ChoiceOf<int>(params, "field", kFields) == 1;
        constexpr const char *kAzimuth[] = {"azimuth_R", "azimuth_TT", "azimuth_TRT"};
        for (size_t p = 0; p < 3; ++p)
            azimuth_[p] = OwnFloat(params, textures, kAzimuth[p]);
        const int evaluation = ChoiceOf<int>(params, "evaluation", kEvaluations);
        const bool varies = Varies(params, {"sigma_a", "color", "reflectance", "eumelanin", "pheomelanin",
                                            "eta", "beta_n", "azimuth_R", "azimuth_TT", "azimuth_TRT"});
        if (evaluation == 1 && (near_ || varies))
            throw Error(
                params.Find("evaluation")->loc,
                "a table needs a far field, and a colour, eta and widths around the fiber that are the same "
                "everywhere");
        if (evaluation != 2 && !near_ && !varies)
            table_ = DEonTable::Cached(At({}));
    }

    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        DEonParameters p = At({si.p, si.uv, si.strandColors});
        if (near_)
            p.h = std::clamp(1 - 2 * si.uv.y, -1.f, 1.f);
        if (table_)
            bsdf->SetFiber<TabulatedDEonBSDF>(p, table_.get());
        else
            bsdf->SetFiber<DEonBSDF>(p);
    }

  private:
    DEonParameters At(const TexturePoint &point) const {
        const float betaM = shape_.betaM->Evaluate(point), betaN = shape_.betaN->Evaluate(point);
        DEonParameters p = choices_;
        p.eta = shape_.eta->Evaluate(point);
        p.sigmaA = color_.SigmaA(point, betaN).c;
        for (size_t i = 0; i < 3; ++i) {
            p.betaM[i] = angles_.Width(i, point, betaM);
            p.alpha[i] = angles_.Shift(i, point, -kTiltInAlpha[i] * shape_.alpha->Evaluate(point));
            p.betaN[i] = azimuth_[i] ? azimuth_[i]->Evaluate(point) : AzimuthalWidth(betaN);
        }
        return p;
    }
    HairColor color_;
    HairShape shape_;
    LobeAngles angles_;
    std::array<FloatTexture, 3> azimuth_;
    DEonParameters choices_;
    bool near_ = false;
    std::shared_ptr<const DEonTable> table_;
};

// "tabulated". Own parameters: the roughness of the surface, roughness_u along and roughness_v across the fiber, and its
// distribution; eccentricity, second over first axis of the section; a medulla; samples, rays for each direction of the
// viewer. Derived: the surface is as rough as makes its reflection as wide as the default model's R (a slope turns
// light by twice its angle, and Beckmann's slopes deviate by roughness / sqrt(2)).
//
// A table has the scene's absorptions as its levels, or, where the colour varies, steps of sqrt(2). Everything else must be the
// same on the whole hair.
class TabulatedMaterial : public Material {
  public:
    TabulatedMaterial(const ParamSet &params, const TextureTable &textures, const MaterialOptions &)
        : color_(params, textures) {
        const HairShape shape(params, textures);
        const auto number = [&](const char *name, float value) {
            if (const Param *p = params.Find(name); p && p->type == ParamType::Texture)
                throw Error(p->loc, "the model \"tabulated\" needs one number for \"" + std::string(name) +
                                        "\", the same on the whole hair, not a texture");
            return params.FindFloat(name, value);
        };
        const float eta = number("eta", shape.eta->Evaluate({})),
                    alpha = number("alpha", shape.alpha->Evaluate({}));
        betaN_ = number("beta_n", shape.betaN->Evaluate({}));
        const float betaM = std::clamp(number("beta_m", shape.betaM->Evaluate({})), 0.f, 1.f);
        FiberDescription fiber;
        fiber.eta = eta, fiber.alpha = Radians(alpha);
        fiber.roughnessU =
            number("roughness_u", std::min(1.f, std::sqrt(LongitudinalVariance(betaM)[0] / 2)));
        fiber.roughnessV =
            number("roughness_v", std::min(1.f, Radians(AzimuthalWidth(betaN_)) / std::sqrt(2.f)));
        fiber.distribution = ChoiceOf<MicrofacetDistribution>(
            params, "distribution", std::array<std::string_view, 2>{"beckmann", "ggx"});
        fiber.axisRatio = number("eccentricity", 1);
        fiber.medullaRatio = number("medulla_ratio", 0);
        fiber.medullaSigmaS = number("medulla_sigma_s", 0), fiber.medullaG = number("medulla_g", 0);
        fiber.sigmaA = Levels(params);
        const int samples = params.FindInt("samples", static_cast<int>(FiberTable::UsualSamples(fiber)));
        if (samples < 1 || samples > 1'000'000) // per direction: a million take minutes
            throw Error(params.Find("samples")->loc,
                        "\"samples\" must be 1 to 1 million, not " + std::to_string(samples));
        eccentric_ = fiber.axisRatio != 1;
        try {
            table_ = FiberTable::Cached(fiber, static_cast<uint64_t>(samples));
        } catch (const Error &e) { // from another thread, which knows no place
            throw Error(params.loc, e.Message());
        }
    }
    bool WantsStrandNormals() const override { return eccentric_; }

    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        bsdf->SetFiber<TabulatedBSDF>(table_.get(), color_.SigmaA({si.p, si.uv, si.strandColors}, betaN_),
                                      eccentric_ ? AxisOf(si) : 0);
    }

  private:
    std::vector<double> Levels(const ParamSet &params) const {
        std::vector<double> levels;
        if (Varies(params, {"sigma_a", "color", "reflectance", "eumelanin", "pheomelanin"})) {
            levels.push_back(0);
            for (int i = 0; i <= 16; ++i)
                levels.push_back(0.05 * std::pow(2., i / 2.));
        } else {
            for (const float sigma : color_.SigmaA({}, betaN_).c)
                levels.push_back(double(std::min(sigma, 1e18f)));
            std::sort(levels.begin(), levels.end());
            levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
        }
        return levels;
    }
    HairColor color_;
    float betaN_ = 0;
    bool eccentric_ = false;
    std::shared_ptr<const FiberTable> table_;
};

// "chiang" with another number of lobes of their own than the paper's three, or with "tail_share": as many as leave no more
// than this share of the light to the uniform lobe. The same model in general code, which is slower. eta below 1.001 is
// taken as that.
class ManyLobesMaterial : public Material {
  public:
    ManyLobesMaterial(const ParamSet &params, const TextureTable &textures, const MaterialOptions &options,
                      int lobes)
        : color_(params, textures), shape_(params, textures), sign_(options.compatPbrtV3 ? -1.f : 1.f) {
        choices_.lobes = lobes;
        if (params.Find("tail_share"))
            tailShare_ = params.FindFloat("tail_share", 0);
        choices_.detector = AzimuthalDetector::Logistic;
        choices_.inclination = AttenuationInclination::Viewer;
    }
    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        const TexturePoint point{si.p, si.uv, si.strandColors};
        const float betaN = shape_.betaN->Evaluate(point);
        const auto v = LongitudinalVariance(std::clamp(shape_.betaM->Evaluate(point), 0.f, 1.f));
        DEonParameters p = choices_;
        p.h = sign_ * std::clamp(1 - 2 * si.uv.y, -1.f, 1.f);
        p.eta = shape_.eta->Evaluate(point);
        p.sigmaA = color_.SigmaA(point, betaN).c;
        for (size_t i = 0; i < 3; ++i) {
            p.betaM[i] = Degrees(std::sqrt(v[i]));
            p.betaN[i] = AzimuthalWidth(betaN);
            p.alpha[i] = -sign_ * kTiltInAlpha[i] * shape_.alpha->Evaluate(point);
        }
        if (tailShare_)
            bsdf->SetFiber<ChosenLobesBSDF>(p, *tailShare_);
        else
            bsdf->SetFiber<DEonBSDF>(p);
    }

  private:
    HairColor color_;
    HairShape shape_;
    float sign_;
    DEonParameters choices_;
    std::optional<float> tailShare_;
};

std::unique_ptr<Material> MakeChiang(const ParamSet &p, const TextureTable &t, const MaterialOptions &o) {
    const bool chosen = p.Find("tail_share") != nullptr;
    const int lobes = LobesOf(p, chosen ? kMaxSceneLobes : HairBSDF::pMax);
    if (lobes == HairBSDF::pMax && !chosen)
        return std::make_unique<HairMaterial>(p, t, o);
    return std::make_unique<ManyLobesMaterial>(p, t, o, lobes);
}

using Maker = std::unique_ptr<Material> (*)(const ParamSet &, const TextureTable &, const MaterialOptions &);

template <class M>
std::unique_ptr<Material> Make(const ParamSet &p, const TextureTable &t, const MaterialOptions &o) {
    return std::make_unique<M>(p, t, o);
}

constexpr std::string_view kNames[] = {"chiang", "kajiya-kay", "marschner", "deon", "tabulated"};
constexpr Maker kMakers[] = {MakeChiang, Make<KajiyaKayMaterial>, Make<MarschnerMaterial>, Make<DEonMaterial>,
                             Make<TabulatedMaterial>};
static_assert(std::size(kNames) == std::size(kMakers));

// What a number may be, where the models say: beyond it they take the nearest that has a meaning.
struct Range {
    std::string_view name;
    double low, high;
};
constexpr double kNoLimit = std::numeric_limits<double>::infinity();
constexpr Range kRanges[] = {
    {"beta_m", 0, 1},           {"beta_n", 0, 1},
    {"eumelanin", 0, kNoLimit}, {"pheomelanin", 0, kNoLimit},
    {"sigma_a", 0, kNoLimit},   {"color", 0, 1},
    {"reflectance", 0, 1},      {"exponent", 0, 1e6},
    {"eccentricity", 0.2, 5},   {"k_G", 0, 1e6},
    {"w_c", 0.1, 60},           {"delta_eta", 1e-3, 1e3},
    {"delta_h_M", 0, 2},        {"beta_R", 0, 1e3},
    {"beta_TT", 0, 1e3},        {"beta_TRT", 0, 1e3},
    {"azimuth_R", 0, 1e3},      {"azimuth_TT", 0, 1e3},
    {"azimuth_TRT", 0, 1e3},    {"tail_share", 0, 1},
};

// Textures are clamped where they are looked up, and nothing is said of them.
void WarnOfNumbersOutOfRange(const ParamSet &params, double leastEta) {
    std::vector<Range> ranges(std::begin(kRanges), std::end(kRanges));
    ranges.push_back({"eta", leastEta, 1e3});
    for (const Range &range : ranges) {
        const Param *p = params.Find(range.name);
        if (!p || (p->type != ParamType::Float && p->type != ParamType::Spectrum))
            continue;
        for (const double x : p->numbers)
            if (!(x >= range.low && x <= range.high)) {
                std::ostringstream says;
                says << "hair: \"" << range.name << "\" is " << x << " and is taken as "
                     << (x < range.low ? range.low : range.high) << "; it may be " << range.low
                     << (range.high < kNoLimit ? " to " : " or more");
                if (range.high < kNoLimit)
                    says << range.high;
                Warning(p->loc, "hair parameter out of range: " + p->name, says.str());
                break;
            }
    }
}

} // namespace

std::span<const std::string_view> HairModelNames() { return kNames; }

std::unique_ptr<Material> MakeHairMaterial(const ParamSet &params, const TextureTable &textures,
                                           const MaterialOptions &options) {
    const std::string asked = params.FindString("model", "chiang");
    const std::string &name = options.hairModel.empty() ? asked : options.hairModel;
    for (size_t i = 0; i < std::size(kNames); ++i)
        if (kNames[i] == name) {
            WarnOfNumbersOutOfRange(params, kMakers[i] == MakeChiang ? 1e-3 : 1.001);
            return kMakers[i](params, textures, options);
        }
    const Param *given = params.Find("model");
    throw Error(given ? given->loc : params.loc,
                "unknown hair model \"" + name + "\". " + Suggestion(name, kNames, std::size(kNames)));
}

} // namespace cuticle
