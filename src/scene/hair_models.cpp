#include "scene/hair_models.h"

#include "fibers/hair_model.h"
#include "fibers/smooth_fiber.h"

namespace cuticle {

namespace {

using FloatTexture = std::shared_ptr<const Texture<float>>;
using SpectrumTexture = std::shared_ptr<const Texture<Spectrum>>;

// A parameter of one model, null where the scene does not give it.
FloatTexture OwnFloat(const ParamSet &params, const TextureTable &textures, const char *name) {
    return params.Find(name) ? textures.GetFloatTexture(params, name, 0) : nullptr;
}
SpectrumTexture OwnSpectrum(const ParamSet &params, const TextureTable &textures, const char *name) {
    return params.Find(name) ? textures.GetSpectrumTexture(params, name, Spectrum(0)) : nullptr;
}

// "kajiya-kay". Own parameters: Kd, Ks, exponent. Derived: Ks is the light that a smooth fiber of this eta, met square to
// its axis, reflects at once, and Kd all that passes through it and is not absorbed; exponent is 1 / v of beta_m's R lobe,
// since cos^n x is nearly exp(-n x^2 / 2). beta_n and alpha mean nothing to this model.
class KajiyaKayMaterial : public Material {
  public:
    KajiyaKayMaterial(const ParamSet &params, const TextureTable &textures, const MaterialOptions &)
        : color_(params, textures), shape_(params, textures), kd_(OwnSpectrum(params, textures, "Kd")),
          ks_(OwnSpectrum(params, textures, "Ks")), exponent_(OwnFloat(params, textures, "exponent")) {}

    void MakeBSDF(const SurfaceInteraction &si, BSDF *bsdf) const override {
        const TexturePoint point{si.p, si.uv, si.strandColors};
        const float eta = std::clamp(shape_.eta->Evaluate(point), 1.f, 1e3f);
        const SmoothFiber<float> fiber(1, eta);
        const std::array<float, 3> sigmaA = color_.SigmaA(point, shape_.betaN->Evaluate(point)).c;
        Spectrum kd, ks;
        if (kd_)
            kd = kd_->Evaluate(point).Clamp();
        else
            kd.c = MeanOverWidth<8, float>(
                [&](float gamma) { return fiber.Tail(1, gamma, sigmaA, SegmentLength::Chord); });
        if (ks_)
            ks = ks_->Evaluate(point).Clamp();
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

using Maker = std::unique_ptr<Material> (*)(const ParamSet &, const TextureTable &, const MaterialOptions &);

template <class M>
std::unique_ptr<Material> Make(const ParamSet &p, const TextureTable &t, const MaterialOptions &o) {
    return std::make_unique<M>(p, t, o);
}

constexpr std::string_view kNames[] = {"chiang", "kajiya-kay"};
constexpr Maker kMakers[] = {Make<HairMaterial>, Make<KajiyaKayMaterial>};
static_assert(std::size(kNames) == std::size(kMakers));

} // namespace

std::span<const std::string_view> HairModelNames() { return kNames; }

std::unique_ptr<Material> MakeHairMaterial(const ParamSet &params, const TextureTable &textures,
                                           const MaterialOptions &options) {
    const std::string asked = params.FindString("model", "chiang");
    const std::string &name = options.hairModel.empty() ? asked : options.hairModel;
    for (size_t i = 0; i < std::size(kNames); ++i)
        if (kNames[i] == name)
            return kMakers[i](params, textures, options);
    const Param *given = params.Find("model");
    throw Error(given ? given->loc : params.loc,
                "unknown hair model \"" + name + "\"." + Suggestion(name, kNames, std::size(kNames)));
}

} // namespace cuticle
