#include "materials/material.h"

#include "core/error.h"
#include "materials/hair_models.h"
#include "materials/material_makers.h"

namespace cuticle {

namespace {

std::unique_ptr<Material> MakeHair(const MaterialContext &in) {
    if (in.params.Find("bumpmap", ParamType::Texture))
        Warning(in.params.loc, "bump maps on hair are not rendered",
                "\"bumpmap\" is not rendered on hair; the fiber stays smooth");
    return MakeHairMaterial(in.params, in.textures, in.options);
}

// Makes the stand-in of a material that is known by a table of measurements, which is not read.
std::unique_ptr<Material> MakeFourier(const MaterialContext &in) {
    (void)in.params.FindString("bsdffile", "");
    return MakeMatte(in);
}

// --- the table of materials ---------------------------------------------------------------------------

constexpr ParamInfo kBumpMap{"bumpmap", "float texture", "lengths of the scene", "",
                             "height over the surface, along its normal (Blinn 1978)"};
constexpr ParamInfo kRemapRoughness{
    "remaproughness", "bool", "", "true",
    "whether roughness is perceptual, from 0 to 1; false: it is the alpha of Trowbridge and Reitz"};
constexpr std::string_view kDiffuse = "the share of light that is reflected diffusely";
constexpr std::string_view kGlossy = "factor on the glossy reflection";
constexpr std::string_view kRoughnessU = "roughness along u", kRoughnessV = "roughness along v";

constexpr ParamInfo kMatteParams[] = {
    {"Kd", "spectrum texture", "", "0.5", kDiffuse, 0, 1},
    {"sigma", "float texture", "degrees", "0", "roughness of the diffuse surface (Oren and Nayar 1994)", 0,
     90},
    kBumpMap,
};
constexpr ParamInfo kPlasticParams[] = {
    {"Kd", "spectrum texture", "", "0.25", kDiffuse, 0, 1},
    {"Ks", "spectrum texture", "", "0.25", kGlossy, 0, 1},
    {"roughness", "float texture", "", "0.1", "roughness of the coat"},
    kRemapRoughness,
    kBumpMap,
};
constexpr ParamInfo kMirrorParams[] = {
    {"Kr", "spectrum texture", "", "0.9", "the share of light that is reflected", 0, 1},
    kBumpMap,
};
constexpr ParamInfo kIndexOlderName{"index", "float texture", "", "1.5", "an older name of eta", 1e-3};
constexpr ParamInfo kGlassParams[] = {
    {"Kr", "spectrum texture", "", "1", "factor on reflection", 0, 1},
    {"Kt", "spectrum texture", "", "1", "factor on transmission", 0, 1},
    {"eta", "float texture", "", "1.5", "index of refraction, inside over outside", 1e-3},
    kIndexOlderName,
    {"uroughness", "float texture", "", "0", "roughness along u; 0 along both axes: smooth"},
    {"vroughness", "float texture", "", "0", kRoughnessV},
    kRemapRoughness,
    kBumpMap,
};
constexpr ParamInfo kUberParams[] = {
    {"Kd", "spectrum texture", "", "0.25", kDiffuse, 0, 1},
    {"Ks", "spectrum texture", "", "0.25", kGlossy, 0, 1},
    {"Kr", "spectrum texture", "", "0", "factor on mirror reflection", 0, 1},
    {"Kt", "spectrum texture", "", "0", "factor on sharp transmission", 0, 1},
    {"opacity", "spectrum texture", "", "1", "the share of light that does not pass straight through", 0, 1},
    {"eta", "float texture", "", "1.5", "index of refraction, inside over outside", 1e-3},
    kIndexOlderName,
    {"roughness", "float texture", "", "0.1", "roughness along both axes"},
    {"uroughness", "float texture", "", "roughness", kRoughnessU},
    {"vroughness", "float texture", "", "roughness", kRoughnessV},
    kRemapRoughness,
    kBumpMap,
};
constexpr ParamInfo kMetalParams[] = {
    {"eta", "spectrum texture", "", "that of copper", "real part of the index of refraction", 0},
    {"k", "spectrum texture", "", "that of copper", "imaginary part of the index of refraction", 0},
    {"roughness", "float texture", "", "0.01", "roughness along both axes"},
    {"uroughness", "float texture", "", "roughness", kRoughnessU},
    {"vroughness", "float texture", "", "roughness", kRoughnessV},
    kRemapRoughness,
    kBumpMap,
};
constexpr ParamInfo kSubstrateParams[] = {
    {"Kd", "spectrum texture", "", "0.5", "the reflectance of the diffuse base", 0, 1},
    {"Ks", "spectrum texture", "", "0.5", "the reflectance of the coat at normal incidence", 0, 1},
    {"uroughness", "float texture", "", "0.1", kRoughnessU},
    {"vroughness", "float texture", "", "0.1", kRoughnessV},
    kRemapRoughness,
    kBumpMap,
};
constexpr ParamInfo kTranslucentParams[] = {
    {"Kd", "spectrum texture", "", "0.25", "the share of light that is scattered diffusely", 0, 1},
    {"Ks", "spectrum texture", "", "0.25", "the share of light that is scattered by glossy facets", 0, 1},
    {"reflect", "spectrum texture", "", "0.5", "factor on reflection", 0, 1},
    {"transmit", "spectrum texture", "", "0.5", "factor on transmission", 0, 1},
    {"roughness", "float texture", "", "0.1", "roughness of the facets"},
    kRemapRoughness,
    kBumpMap,
};
constexpr ParamInfo kDisneyParams[] = {
    {"color", "spectrum texture", "", "0.5", "colour of the surface", 0, 1},
    {"metallic", "float texture", "", "0", "blend from a dielectric to a metal", 0, 1},
    {"eta", "float texture", "", "1.5", "index of refraction, inside over outside", 1e-3},
    {"roughness", "float texture", "", "0.5", "roughness of reflection and transmission; alpha is its square",
     0, 1},
    {"speculartint", "float texture", "", "0", "how far the reflection at normal incidence takes the colour",
     0, 1},
    {"anisotropic", "float texture", "", "0", "how far the roughness differs along u and v", 0, 1},
    {"sheen", "float texture", "", "0", "strength of a lobe at grazing angles, for cloth", 0},
    {"sheentint", "float texture", "", "0.5", "how far the sheen takes the colour", 0, 1},
    {"clearcoat", "float texture", "", "0", "strength of a second, white reflection", 0},
    {"clearcoatgloss", "float texture", "", "1", "gloss of the clear coat; 0: satin, 1: gloss", 0, 1},
    {"spectrans", "float texture", "", "0", "the share of light that is transmitted by facets", 0, 1},
    {"scatterdistance", "spectrum texture", "lengths of the scene", "0",
     "depth of subsurface scattering, which is not rendered"},
    {"thin", "bool", "", "false", "whether the surface is a thin sheet (Burley 2015)"},
    {"flatness", "float texture", "", "0", "thin: blend from diffuse to subsurface-like shading", 0, 1},
    {"difftrans", "float texture", "", "1", "thin: twice the share of diffuse light that is transmitted", 0,
     1},
    kBumpMap,
};
constexpr ParamInfo kMixParams[] = {
    {"namedmaterial1", "string", "", "", "name of the first material"},
    {"namedmaterial2", "string", "", "", "name of the second material"},
    {"amount", "spectrum texture", "", "0.5", "the share of the first material", 0, 1},
};
constexpr ParamInfo kBodyEta{"eta", "float", "", "1.33", "index of refraction, inside over outside", 1e-3};
constexpr ParamInfo kBodyKr{"Kr", "spectrum texture", "", "1", "factor on reflection at the boundary", 0, 1};
constexpr ParamInfo kBodyKt{
    "Kt", "spectrum texture", "", "1", "factor on the light that comes out of the body", 0, 1};
constexpr ParamInfo kBodyRoughnessU{"uroughness", "float texture", "", "0",
                                    "roughness along u; 0 along both axes: smooth"};
constexpr ParamInfo kBodyRoughnessV{"vroughness", "float texture", "", "0", kRoughnessV};
constexpr ParamInfo kBodyMfp{"mfp", "spectrum texture", "lengths of the scene", "1",
                             "mean free path; no effect on the stand-in"};
constexpr ParamInfo kBodyScale{"scale", "float", "", "1",
                               "factor on the coefficients; no effect on the stand-in"};
constexpr ParamInfo kSubsurfaceParams[] = {
    {"name", "string", "", "Wholemilk", "a measured medium of pbrt-v3 (\"Skin1\", \"Marble\", ...)"},
    {"sigma_a", "spectrum texture", "1/mm", "from name", "absorption", 0},
    {"sigma_s", "spectrum texture", "1/mm", "from name", "scattering", 0},
    {"g", "float", "", "0", "mean cosine of the scattering angle, where sigma_s is not of a named medium", -1,
     1},
    kBodyEta,
    kBodyKr,
    kBodyKt,
    kBodyRoughnessU,
    kBodyRoughnessV,
    kRemapRoughness,
    kBodyScale,
    kBumpMap,
};
constexpr ParamInfo kKdSubsurfaceParams[] = {
    {"Kd", "spectrum texture", "", "0.5", "the share of light that the body reflects", 0, 1},
    kBodyMfp,
    {"g", "float", "", "0", "mean cosine of the scattering angle; no effect on the stand-in"},
    kBodyEta,
    kBodyKr,
    kBodyKt,
    kBodyRoughnessU,
    kBodyRoughnessV,
    kRemapRoughness,
    kBodyScale,
    kBumpMap,
};
constexpr ParamInfo kFourierParams[] = {
    {"bsdffile", "string", "", "", "a table of measurements, which is not read"},
    kBumpMap,
};

using MaterialMaker = std::unique_ptr<Material> (*)(const MaterialContext &);

// To add a material: its class and its maker in a file beside this one, the maker declared in
// material_makers.h, its parameters above and a row here. The rows stand in the order of the manual; one
// without a maker is pbrt's null material, which light passes. The parameters of a row may also be written
// on a Shape, where they take precedence.
const std::vector<PluginRow<MaterialMaker>> &MaterialRows() {
    static const std::vector<ParamInfo> hairParams = HairMaterialParams(); // of all fiber models
    static const std::vector<PluginRow<MaterialMaker>> rows{
        {{"hair", hairParams, "fibers; \"model\" chooses how one scatters"}, MakeHair},
        {{"matte", kMatteParams, "a diffuse surface"}, MakeMatte},
        {{"plastic", kPlasticParams, "a diffuse surface under glossy facets of index 1.5"}, MakePlastic},
        {{"mirror", kMirrorParams, "a perfect mirror"}, MakeMirror},
        {{"glass", kGlassParams, "a dielectric boundary, smooth or rough"}, MakeGlass},
        {{"uber", kUberParams, "diffuse, glossy and mirror reflection, sharp transmission and opacity"},
         MakeUber},
        {{"metal", kMetalParams, "a rough conductor"}, MakeMetal},
        {{"substrate", kSubstrateParams, "a diffuse base under a glossy coat (Ashikhmin and Shirley 2000)"},
         MakeSubstrate},
        {{"translucent", kTranslucentParams, "diffuse and glossy light on both sides"}, MakeTranslucent},
        {{"disney", kDisneyParams, "Disney's model (Burley 2012 and 2015)"}, MakeDisney},
        {{"mix", kMixParams, "two materials"}, MakeMix},
        {{"", {}, "no surface: light passes"}, nullptr},
        {{"none", {}, "no surface: light passes"}, nullptr},
        {{"subsurface", kSubsurfaceParams, "a medium under a boundary",
          "a coated diffuse surface of the reflectance that the medium implies"},
         MakeSubsurface},
        {{"kdsubsurface", kKdSubsurfaceParams, "a medium of a known reflectance under a boundary",
          "a coated diffuse surface of the colour \"Kd\""},
         MakeKdSubsurface},
        {{"fourier", kFourierParams, "a table of measurements", "a matte surface of reflectance 0.5"},
         MakeFourier},
    };
    return rows;
}

} // namespace

Frame BumpedFrame(const SurfaceInteraction &si, const Texture<float> &height) {
    if (si.isCurve)
        return si.shading;
    // The tangents of the smooth surface that the shading normal describes
    const Vector3f &n = si.shading.z;
    const Vector3f u = si.dpdu - n * Dot(n, si.dpdu), v = si.dpdv - n * Dot(n, si.dpdv);
    // A step of about half a pixel as the ray sees it, far above the rounding of p, and never longer than
    // pbrt-v3's where it knows no pixel
    const float largest = std::max({std::abs(si.p.x), std::abs(si.p.y), std::abs(si.p.z)});
    const float step = std::max(5e-4f * si.t, 2e-4f * largest);
    const float du = std::min(step / u.Length(), 0.01f), dv = std::min(step / v.Length(), 0.01f);
    const float here = height.Evaluate(TexturePointOf(si));
    const float slopeU = (height.Evaluate({si.p + u * du, {si.uv.x + du, si.uv.y}}) - here) / du;
    const float slopeV = (height.Evaluate({si.p + v * dv, {si.uv.x, si.uv.y + dv}}) - here) / dv;

    const Vector3f bumpedU = u + n * slopeU, bumpedV = v + n * slopeV;
    const Vector3f across = Cross(bumpedU, bumpedV);
    const float length = across.Length();
    if (!(length > 0) || !std::isfinite(length))
        return si.shading;
    Frame frame;
    frame.z = across * ((Dot(across, si.n) < 0 ? -1 : 1) / length);
    frame.x = Normalize(bumpedU);
    frame.y = Cross(frame.z, frame.x);
    return frame;
}

const PluginTable &MaterialPlugins() {
    static const PluginTable table{PluginKind::Material,
                                   PluginInfos(MaterialRows()),
                                   {"coateddiffuse", "coatedconductor", "conductor", "dielectric", "diffuse",
                                    "diffusetransmission", "interface", "thindielectric", "measured"},
                                   {"shinymetal"},
                                   "bump maps on all surfaces but hair"};
    return table;
}

std::unique_ptr<Material> MakeMaterial(const MaterialEntity &entity, const TextureTable &textures,
                                       const MaterialOptions &options,
                                       std::span<const std::unique_ptr<Material>> made) {
    const PluginRow<MaterialMaker> *row = FindPluginRow(MaterialRows(), entity.type);
    if (!row) {
        const std::vector<std::string_view> names = MaterialPlugins().Names();
        throw Error(entity.params.loc, "unknown material \"{}\"", entity.type)
            .WithRemedy(Suggestion(entity.type, names.data(), names.size()));
    }
    if (!row->make)
        return nullptr;
    if (!row->info.standIn.empty())
        Warning(entity.params.loc, fmt::format("material \"{}\" is not rendered", entity.type),
                fmt::format("material \"{}\" is not rendered; {} is used instead", entity.type,
                            row->info.standIn));
    auto material = row->make({entity, entity.params, textures, options, made});
    entity.params.ReportUnused(fmt::format("Material \"{}\"", entity.type));
    return material;
}

} // namespace cuticle
