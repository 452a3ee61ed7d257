//> Define the hair material
#include "materials/hair_material.h"

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

HairMaterial::HairMaterial(const ParamSet &params, const TextureTable &textures,
                           const MaterialOptions &options)
    : color_(params, textures), shape_(params, textures), options_(options) {}
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
    const TexturePoint point{si.p, si.uv, si.strandColors};
    const Float betaM = shape_.betaM->Evaluate(point), betaN = shape_.betaN->Evaluate(point);
    //> Find the offset $h$ across the fiber from the ribbon's $v$
    // A ribbon's width is the fiber's diameter. In the local frame (x the tangent, z toward the viewer) v grows toward
    // -y. A mirror of a fiber sends light that meets it on the side of +y toward +y, and $\Phi(0, h) = -2 \gamma_o$
    // does so where h has the sign of y: $h = 1 - 2 v$. pbrt-v3 takes -1 + 2 v and so mirrors every fiber about
    // its axis. The mean over the width stays; on a fiber wider than a pixel the highlight changes sides.
    Float h = std::clamp(1 - 2 * si.uv.y, -1.f, 1.f);
    if (options_.compatPbrtV3)
        h = -h;
    //<
    const Float eta = shape_.eta->Evaluate(point), alpha = shape_.alpha->Evaluate(point);
    const Spectrum sigmaA = color_.SigmaA(point, betaN);
    bsdf->SetHair(h, eta, sigmaA, betaM, betaN, alpha,
                  options_.compatPbrtV3 ? ScaleTilt::PbrtV3 : ScaleTilt::RootToTip);
}
//<

} // namespace cuticle
//<
