//> Define the hair material
#include "materials/hair_material.h"

#include "fibers/hair.h"

#include <atomic>

namespace cuticle {

//> Read the hair's colour from the scene
HairColor::HairColor(const ParamSet &params, const TextureTable &textures) {
    //> Take the colour from the first of sigma_a, color, melanin
    const bool hasSigmaA = params.Find("sigma_a") != nullptr;
    const bool hasColor = params.Find("color") || params.Find("reflectance");
    const bool hasMelanin = params.Find("eumelanin") || params.Find("pheomelanin");
    if (hasSigmaA)
        sigmaA_ = textures.GetSpectrumTexture(params, "sigma_a", Spectrum(0));
    if (hasColor)
        color_ =
            textures.GetSpectrumTexture(params, params.Find("color") ? "color" : "reflectance", Spectrum(0));
    if (hasMelanin || (!hasSigmaA && !hasColor)) {
        eumelanin_ = textures.GetFloatTexture(params, "eumelanin", hasMelanin ? 0.f : 1.3f);
        pheomelanin_ = textures.GetFloatTexture(params, "pheomelanin", 0.f);
    }
    //<
    for (const std::string_view name : {"sigma_a", "color", "reflectance", "eumelanin", "pheomelanin"})
        if (const Param *p = params.Find(name); p && p->type == ParamType::Texture)
            varies_ = true;
    //> Warn where the scene gives more than one colour
    if (params.Find("color") && params.Find("reflectance"))
        Warning(params.loc, "hair colour given twice",
                "\"color\" and \"reflectance\" are two names of one parameter; \"color\" is used. Give one "
                "of them.");
    if (hasSigmaA + hasColor + hasMelanin > 1)
        Warning(params.loc, "hair colour given twice",
                std::string("hair takes its colour from one of \"sigma_a\", \"color\" and melanin; \"") +
                    (hasSigmaA ? "sigma_a" : "color") + "\" is used, the rest ignored. Give one of them.");
    //<
}
//<

//> Read the shape of the lobes
HairShape::HairShape(const ParamSet &params, const TextureTable &textures)
    : eta(textures.GetFloatTexture(params, "eta", 1.55f)),
      betaM(textures.GetFloatTexture(params, "beta_m", 0.3f)),
      betaN(textures.GetFloatTexture(params, "beta_n", 0.3f)),
      alpha(textures.GetFloatTexture(params, "alpha", 2.f)) {}
//<

//> Read a model's own textures
namespace {
// A share of the light, each colour in [0, 1]; values beyond are taken as these, with one warning at the
// parameter's place.
class ShareOfLight final : public Texture<Spectrum> {
  public:
    ShareOfLight(std::shared_ptr<const Texture<Spectrum>> texture, const Param &p)
        : texture_(std::move(texture)), loc_(p.loc), name_(p.name) {}
    Spectrum Evaluate(const TexturePoint &point) const override {
        const Spectrum given = texture_->Evaluate(point), used = given.Clamp(0, 1);
        if (given.IsFinite() && !(given == used) && !warned_.exchange(true))
            Warning(loc_, "colour of a fiber out of range",
                    fmt::format("\"{}\" is a share of the light, from 0 to 1; values beyond are set to these",
                                name_));
        return used;
    }

  private:
    std::shared_ptr<const Texture<Spectrum>> texture_;
    FileLoc loc_;
    std::string name_;
    mutable std::atomic<bool> warned_ = false;
};
} // namespace

OwnTextures::OwnTextures(const FiberModel &model, const ParamSet &params, const TextureTable &textures) {
    size_t numbers = 0, colors = 0; // the slots of FiberInputs, in the order of the row
    for (const ParamInfo &row : model.params) {
        const Param *given = params.Find(row.name);
        if (row.type == "float texture") {
            if (given)
                numbers_.emplace_back(numbers, textures.GetFloatTexture(params, row.name, 0));
            ++numbers;
        } else if (row.type == "spectrum texture") {
            if (given)
                colors_.emplace_back(colors,
                                     std::make_shared<ShareOfLight>(
                                         textures.GetSpectrumTexture(params, row.name, Spectrum(0)), *given));
            ++colors;
        }
    }
}
void OwnTextures::EvaluateAt(const TexturePoint &point, FiberInputs *at) const {
    for (const auto &[slot, texture] : numbers_)
        at->numbers[slot] = texture->Evaluate(point);
    for (const auto &[slot, texture] : colors_)
        at->colors[slot] = texture->Evaluate(point).c;
}
//<

//> Prepare the model
namespace {
// The scene's parameters as a model asks for them.
class SceneSettings final : public FiberSettings {
  public:
    SceneSettings(const FiberModel &model, const ParamSet &params, bool colorVaries,
                  const FiberInputs &somewhere)
        : FiberSettings(model), params_(params), colorVaries_(colorVaries), somewhere_(somewhere) {}
    bool Has(std::string_view name) const override { return params_.Find(name) != nullptr; }
    bool IsTexture(std::string_view name) const override {
        const Param *p = params_.Find(name);
        return p && p->type == ParamType::Texture;
    }
    bool ColorVaries() const override { return colorVaries_; }
    float Number(std::string_view name, float otherwise) const override {
        return params_.FindFloat(name, otherwise);
    }
    int Integer(std::string_view name, int otherwise) const override {
        return params_.FindInt(name, otherwise);
    }
    bool Flag(std::string_view name, bool otherwise) const override {
        return params_.FindBool(name, otherwise);
    }
    std::string Word(std::string_view name, std::string_view otherwise) const override {
        return params_.FindString(name, std::string(otherwise));
    }
    FiberInputs AtOnePlace() const override { return somewhere_; }
    Error ErrorAt(std::string_view name, const std::string &message) const override {
        const Param *p = params_.Find(name);
        return Error(p ? p->loc : params_.loc, message);
    }

  private:
    const ParamSet &params_;
    bool colorVaries_;
    const FiberInputs &somewhere_;
};
} // namespace

HairMaterial::HairMaterial(const FiberModel &model, const ParamSet &params, const TextureTable &textures,
                           const MaterialOptions &options)
    : color_(params, textures), shape_(params, textures), own_(model, params, textures),
      compatPbrtV3_(options.compatPbrtV3), origin_{params.loc, model.name} {
    maker_ = model.prepare(SceneSettings(model, params, color_.Varies(), InputsAt({})));
}
//<

//> Compute the absorption coefficient at a point of the fiber
Spectrum HairColor::SigmaA(const TexturePoint &point, Float betaN) const {
    if (sigmaA_)
        return sigmaA_->Evaluate(point).Clamp();
    if (color_)
        return HairBSDF::SigmaAFromReflectance(color_->Evaluate(point), betaN);
    return HairBSDF::SigmaAFromConcentration(std::max(0.f, eumelanin_->Evaluate(point)),
                                             std::max(0.f, pheomelanin_->Evaluate(point)));
}
//<

//> Make the BSDF of the fiber at a point
void HairMaterial::MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const {
    FiberInputs at = InputsAt(si);
    maker_->Make(at, &bsdf->SetFiber());
    bsdf->SetFiberOrigin(&origin_);
    //> Make the same fiber at other offsets, where the mean is asked for
    // pbrt-v3 knows no such mean.
    if (!maker_->NeedsOffset() || compatPbrtV3_)
        return;
    const std::span<FiberStorage> others = bsdf->SetOtherFibers();
    const float step = 2 / static_cast<float>(others.size() + 1);
    for (FiberStorage &other : others) {
        at.h += at.h + step > 1 ? step - 2 : step;
        at.h = std::clamp(at.h, -1.f, 1.f);
        maker_->MakeBeside(*bsdf->Fiber(), at, &other);
    }
    //<
}
FiberInputs HairMaterial::InputsAt(const SurfaceInteraction &si) const {
    const TexturePoint point = TexturePointOf(si);
    FiberInputs at;
    at.eta = shape_.eta->Evaluate(point);
    at.betaM = shape_.betaM->Evaluate(point), at.betaN = shape_.betaN->Evaluate(point);
    at.alpha = shape_.alpha->Evaluate(point);
    at.sigmaA = color_.SigmaA(point, at.betaN).c;
    at.pbrtV3 = compatPbrtV3_;
    //> Find the offset $h$ across the fiber from the ribbon's $v$
    // A ribbon's width is the fiber's diameter. In the local frame (x the tangent, z toward the viewer) v
    // grows toward -y. A mirror of a fiber sends light that meets it on the side of +y toward +y, and
    // $\Phi(0, h) = -2 \gamma_o$ does so where h has the sign of y: $h = 1 - 2 v$. pbrt-v3 takes -1 + 2 v and
    // so mirrors every fiber about its axis, but for shapes whose normals it has turned round.
    at.h = std::clamp(1 - 2 * si.uv.y, -1.f, 1.f);
    if (compatPbrtV3_ && !si.flipped)
        at.h = -at.h;
    //<
    own_.EvaluateAt(point, &at);
    //> Find the azimuth of the section's first axis, which the strand carries
    if (maker_ && maker_->NeedsAxis())
        at.axis =
            std::atan2(Dot(si.strandNormal, Vector3f(si.shading.z)), Dot(si.strandNormal, si.shading.y));
    //<
    return at;
}
//<

} // namespace cuticle
//<
