#include "materials/texture.h"

#include "core/error.h"
#include "materials/texture_makers.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace cuticle {

namespace {

template <class T>
class ScaleTexture final : public Texture<T> {
  public:
    ScaleTexture(TexturePtr<T> tex1, TexturePtr<T> tex2) : tex1_(std::move(tex1)), tex2_(std::move(tex2)) {}
    T Evaluate(const TexturePoint &point) const override {
        return tex1_->Evaluate(point) * tex2_->Evaluate(point);
    }

  private:
    TexturePtr<T> tex1_, tex2_;
};

template <class T>
class MixTexture final : public Texture<T> {
  public:
    MixTexture(TexturePtr<T> tex1, TexturePtr<T> tex2, TexturePtr<float> amount)
        : tex1_(std::move(tex1)), tex2_(std::move(tex2)), amount_(std::move(amount)) {}
    T Evaluate(const TexturePoint &point) const override {
        const float amount = amount_->Evaluate(point);
        return tex1_->Evaluate(point) * (1 - amount) + tex2_->Evaluate(point) * amount;
    }

  private:
    TexturePtr<T> tex1_, tex2_;
    TexturePtr<float> amount_;
};

bool IsFiniteValue(float v) { return std::isfinite(v); }
bool IsFiniteValue(const Spectrum &s) { return s.IsFinite(); }

// Guards a texture of the scene: a value beyond binary32 becomes 0, with one warning at the texture's place.
// At a point that is not finite itself the value is left alone: such a fault is ours, and must show in the
// picture's count of lost samples.
template <class T>
class FiniteTexture final : public Texture<T> {
  public:
    FiniteTexture(TexturePtr<T> texture, const TextureEntity &e)
        : texture_(std::move(texture)), loc_(e.params.loc), name_(e.name) {}
    T Evaluate(const TexturePoint &point) const override {
        const T v = texture_->Evaluate(point);
        if (IsFiniteValue(v)) [[likely]]
            return v;
        if (!IsFinite(point.p) || !std::isfinite(point.uv.x) || !std::isfinite(point.uv.y))
            return v;
        if (!warned_.exchange(true))
            Warning(loc_, "texture value out of range",
                    fmt::format("texture \"{}\" has values that are not finite, which are set to 0", name_));
        return T(0);
    }

  private:
    TexturePtr<T> texture_;
    FileLoc loc_;
    std::string name_;
    mutable std::atomic<bool> warned_ = false;
};

// Gives the colour of the strand, as its groom has it.
template <class T>
class StrandColorTexture final : public Texture<T> {
  public:
    explicit StrandColorTexture(TexturePtr<T> elsewhere) : elsewhere_(std::move(elsewhere)) {}
    T Evaluate(const TexturePoint &point) const override {
        if (!point.strandColors)
            return elsewhere_->Evaluate(point);
        const auto &[first, last] = *point.strandColors;
        const Spectrum color = first * (1 - point.segmentU) + last * point.segmentU;
        if constexpr (std::is_same_v<T, float>)
            return color.y();
        else
            return color;
    }

  private:
    TexturePtr<T> elsewhere_;
};

// Looks another texture up at the root of the strand: in space, or at its u = 0. So a value varies over the
// scalp and not along the hairs.
template <class T>
class StrandRootTexture final : public Texture<T> {
  public:
    explicit StrandRootTexture(TexturePtr<T> texture) : texture_(std::move(texture)) {}
    T Evaluate(const TexturePoint &point) const override {
        if (!point.root)
            return texture_->Evaluate(point);
        return texture_->Evaluate({*point.root, {0, 0.5f}, point.strandColors, 0, point.root});
    }

  private:
    TexturePtr<T> texture_;
};

template <class T>
TexturePtr<T> Constant(const T &value) {
    return std::make_shared<ConstantTexture<T>>(value);
}

template <class T>
TexturePtr<T> MakeConstant(const TextureEntity &e, TextureContext &) {
    return Constant<T>(FindValue<T>(e.params, "value", 1));
}

template <class T>
TexturePtr<T> MakeScale(const TextureEntity &e, TextureContext &b) {
    return std::make_shared<ScaleTexture<T>>(b.Get<T>(e.params, "tex1", 1), b.Get<T>(e.params, "tex2", 1));
}

template <class T>
TexturePtr<T> MakeMix(const TextureEntity &e, TextureContext &b) {
    return std::make_shared<MixTexture<T>>(b.Get<T>(e.params, "tex1", 0), b.Get<T>(e.params, "tex2", 1),
                                           b.table.GetFloatTexture(e.params, "amount", 0.5f));
}

template <class T>
TexturePtr<T> MakeStrandColor(const TextureEntity &e, TextureContext &b) {
    return std::make_shared<StrandColorTexture<T>>(b.Get<T>(e.params, "default", 0.5f));
}

template <class T>
TexturePtr<T> MakeStrandRoot(const TextureEntity &e, TextureContext &b) {
    return std::make_shared<StrandRootTexture<T>>(b.Get<T>(e.params, "value", 1));
}

// The stand-in of a class that pbrt-v3 knows and this does not render.
constexpr std::string_view kPtexStandIn = "the constant 0.5";
template <class T>
TexturePtr<T> MakePtex(const TextureEntity &e, TextureContext &) {
    for (const Param &p : e.params.params)
        p.used = true; // one warning is enough
    Warning(e.params.loc, fmt::format("texture class \"{}\"", e.type),
            fmt::format("Texture \"ptex\" is not rendered; {} is used instead", kPtexStandIn));
    return Constant(T(0.5f));
}

// --- the table of textures ----------------------------------------------------------------------------

// The textures of a texture are of its own type, as it is declared; so are plain values.
constexpr std::string_view kTexture = "float or spectrum texture", kValue = "float or spectrum";
constexpr std::string_view kMappings[] = {"uv", "spherical", "cylindrical", "planar"};
constexpr auto kMappingParams = std::to_array<ParamInfo>({
    ChoiceParam("mapping", kMappings, "how a point of the surface becomes (s, t)"),
    {"uscale", "float", "", "1", "uv: factor on u"},
    {"vscale", "float", "", "1", "uv: factor on v"},
    {"udelta", "float", "", "0", "uv and planar: added to s"},
    {"vdelta", "float", "", "0", "uv and planar: added to t"},
    {"v1", "vector3", "1/lengths of the scene", "1 0 0", "planar: s is the product of the point with it"},
    {"v2", "vector3", "1/lengths of the scene", "0 1 0", "planar: t is the product of the point with it"},
});
// The parameters of a texture that has a mapping.
template <size_t n>
constexpr std::array<ParamInfo, n + kMappingParams.size()> WithMapping(const std::array<ParamInfo, n> &own) {
    std::array<ParamInfo, n + kMappingParams.size()> all{};
    std::copy(own.begin(), own.end(), all.begin());
    std::copy(kMappingParams.begin(), kMappingParams.end(), all.begin() + n);
    return all;
}

constexpr ParamInfo kConstantParams[] = {{"value", kValue, "", "1", "the value"}};
constexpr ParamInfo kScaleParams[] = {
    {"tex1", kTexture, "", "1", "one factor"},
    {"tex2", kTexture, "", "1", "the other factor"},
};
constexpr ParamInfo kMixParams[] = {
    {"tex1", kTexture, "", "0", "the value at amount 0"},
    {"tex2", kTexture, "", "1", "the value at amount 1"},
    {"amount", "float texture", "", "0.5", "the share of tex2"},
};
constexpr auto kImageMapParams = WithMapping(std::to_array<ParamInfo>({
    {"filename", "string", "", "", "the image, from the folder of the scene"},
    ChoiceParam("wrap", kImageWraps, "what lies beyond its borders"),
    {"scale", "float", "", "1", "factor on its values"},
    {"gamma", "bool", "", "true for png, tga, jpg", "whether its values are sRGB"},
    {"trilinear", "bool", "", "false", "no effect: the samples of a pixel filter the picture"},
    {"maxanisotropy", "float", "", "8", "no effect, as trilinear"},
}));
constexpr std::string_view kAAModes[] = {"closedform", "none"};
constexpr auto kCheckerboardParams = WithMapping(std::to_array<ParamInfo>({
    {"dimension", "integer", "", "2", "2: in (s, t); 3: in space", 2, 3},
    {"tex1", kTexture, "", "1", "the value in even cells"},
    {"tex2", kTexture, "", "0", "the value in odd cells"},
    ChoiceParam("aamode", kAAModes, "no effect: the samples of a pixel filter the picture"),
}));
constexpr auto kBilerpParams = WithMapping(std::to_array<ParamInfo>({
    {"v00", kValue, "", "0", "the value at (s, t) = (0, 0)"},
    {"v01", kValue, "", "1", "the value at (0, 1)"},
    {"v10", kValue, "", "0", "the value at (1, 0)"},
    {"v11", kValue, "", "1", "the value at (1, 1)"},
}));
constexpr auto kDotsParams = WithMapping(std::to_array<ParamInfo>({
    {"inside", kTexture, "", "1", "the value of the dots"},
    {"outside", kTexture, "", "0", "the value between them"},
}));
constexpr ParamInfo kOctaves{"octaves", "integer", "", "8", "octaves of noise that are summed", 0, 100};
constexpr ParamInfo kRoughness{"roughness", "float", "", "0.5", "factor on each further octave"};
constexpr ParamInfo kNoiseParams[] = {kOctaves, kRoughness};
constexpr ParamInfo kMarbleParams[] = {
    kOctaves,
    kRoughness,
    {"scale", "float", "", "1", "factor on the point"},
    {"variation", "float", "", "0.2", "how far the noise shifts the layers"},
};
constexpr ParamInfo kStrandRootParams[] = {
    {"value", kTexture, "", "1", "the texture that is looked up at the strand's root; elsewhere where it is"},
};
constexpr ParamInfo kStrandColorParams[] = {
    {"default", kTexture, "", "0.5", "the value on all but strands with colours of their own"},
};

// A class's makers as a float texture (null: it has colours only, as in pbrt-v3) and as one of colours.
struct TextureMaker {
    TexturePtr<float> (*makeFloat)(const TextureEntity &, TextureContext &);
    TexturePtr<Spectrum> (*makeSpectrum)(const TextureEntity &, TextureContext &);
};
#define CUTICLE_BOTH(Maker)                                                                                  \
    { Maker<float>, Maker<Spectrum> }

// To add a texture: its class and maker above or in a file beside this one (then declared in
// texture_makers.h), its parameters above and a row here, in the order of the manual.
constexpr PluginRow<TextureMaker> kTextures[] = {
    {{"constant", kConstantParams, "one value"}, CUTICLE_BOTH(MakeConstant)},
    {{"scale", kScaleParams, "the product of two textures"}, CUTICLE_BOTH(MakeScale)},
    {{"mix", kMixParams, "a blend of two textures"}, CUTICLE_BOTH(MakeMix)},
    {{"imagemap", kImageMapParams, "an image, looked up bilinearly"}, CUTICLE_BOTH(MakeImageMap)},
    {{"checkerboard", kCheckerboardParams, "alternating cells"}, CUTICLE_BOTH(MakeCheckerboard)},
    {{"bilerp", kBilerpParams, "four values, blended over the unit square"}, CUTICLE_BOTH(MakeBilerp)},
    {{"uv", kMappingParams, "the fractions of s and t as red and green"}, {nullptr, MakeUV}},
    {{"dots", kDotsParams, "dots at random in cells"}, CUTICLE_BOTH(MakeDots)},
    {{"fbm", kNoiseParams, "octaves of noise in space"}, CUTICLE_BOTH(MakeFBm)},
    {{"wrinkled", kNoiseParams, "octaves of the absolute value of noise"}, CUTICLE_BOTH(MakeWrinkled)},
    {{"windy", {}, "waves of varying strength"}, CUTICLE_BOTH(MakeWindy)},
    {{"marble", kMarbleParams, "veins of marble"}, {nullptr, MakeMarble}},
    {{"ptex", {}, "an image for each face", kPtexStandIn}, CUTICLE_BOTH(MakePtex)},
    {{"strandcolor", kStrandColorParams, "the colour that a groom gives the strand", {}, true},
     CUTICLE_BOTH(MakeStrandColor)},
    {{"strandroot",
      kStrandRootParams,
      "another texture at the strand's root: it varies over the scalp",
      {},
      true},
     CUTICLE_BOTH(MakeStrandRoot)},
};
#undef CUTICLE_BOTH

template <class T>
TexturePtr<T> MakeTexture(const TextureEntity &e, TextureContext &context) {
    const PluginRow<TextureMaker> *row = FindPluginRow(kTextures, e.type);
    if (!row) {
        const std::vector<std::string_view> names = TexturePlugins().Names();
        throw ErrorAtLine(e.params.loc, "there is no texture class \"{}\"", e.type)
            .WithRemedy(Suggestion(e.type, names.data(), names.size()));
    }
    TexturePtr<T> texture;
    if constexpr (std::is_same_v<T, float>) {
        if (!row->make.makeFloat)
            throw ErrorAtLine(
                e.params.loc,
                "Texture \"{}\" has colours, and \"{}\" is declared as float: declare it as \"color\"",
                e.type, e.name);
        texture = row->make.makeFloat(e, context);
    } else {
        texture = row->make.makeSpectrum(e, context);
    }
    e.params.ReportUnused(fmt::format("Texture \"{}\"", e.type));
    // The parser has checked the value of a constant
    if (dynamic_cast<const ConstantTexture<T> *>(texture.get()))
        return texture;
    return std::make_shared<FiniteTexture<T>>(std::move(texture), e);
}

// The texture that a parameter names: index is its number among those of type T; -1: none of that name and
// type, for which pbrt-v3 takes the default. Then a Warning, and null.
template <class T>
TexturePtr<T> Bound(const Param &p, int index, const std::vector<TexturePtr<T>> &textures) {
    const auto at = static_cast<size_t>(index);
    if (index >= 0 && at < textures.size())
        return textures[at];
    const char *type = std::is_same_v<T, float> ? "float" : "spectrum";
    Warning(
        p.loc, "texture of another type",
        fmt::format("texture \"{}\" is no {} texture, as \"{}\" needs; that is left at its default, as in "
                    "pbrt-v3",
                    p.strings.empty() ? p.name : p.strings[0], type, p.name));
    return nullptr;
}

// Measures how textures are made of others, since evaluating one evaluates those below it: a chain of
// thousands would not fit the stack, and one that uses its predecessor twice on each of fifty levels would
// never be done. Error at the texture that goes beyond.
class TextureNesting {
    struct NestingCost {
        int levels, evaluations;
    };

  public:
    // All textures of one type, in the order of the file; the float ones first.
    void Add(const std::vector<TextureEntity> &textures, bool isFloat) {
        std::vector<NestingCost> &costs = isFloat ? floats_ : spectra_;
        for (const TextureEntity &e : textures) {
            NestingCost cost{1, 1};
            for (const Param &p : e.params.params) {
                const int index = isFloat || p.spectrumTexture < 0 ? p.floatTexture : p.spectrumTexture;
                const std::vector<NestingCost> &from = isFloat || p.spectrumTexture < 0 ? floats_ : spectra_;
                const auto at = static_cast<size_t>(index);
                if (p.type != ParamType::Texture || index < 0 || at >= from.size())
                    continue;
                cost.levels = std::max(cost.levels, from[at].levels + 1);
                cost.evaluations += from[at].evaluations;
            }
            if (cost.levels > kMaxLevels || cost.evaluations > kMaxEvaluations)
                throw ErrorAtLine(
                    e.params.loc,
                    "texture \"{}\" is made of others more than {} levels deep, or more than {} times",
                    e.name, kMaxLevels, kMaxEvaluations);
            costs.push_back(cost);
        }
    }

  private:
    static constexpr int kMaxLevels = 200, kMaxEvaluations = 10000;
    std::vector<NestingCost> floats_, spectra_;
};

} // namespace

const PluginTable &TexturePlugins() {
    static const PluginTable table{PluginKind::Texture,
                                   PluginInfos(kTextures),
                                   {"directionmix"},
                                   {},
                                   "all mappings; images from exr, pfm, png, tga, hdr, jpg"};
    return table;
}

TextureTable::TextureTable(const std::vector<TextureEntity> &floatTextures,
                           const std::vector<TextureEntity> &spectrumTextures) {
    // A texture refers only to earlier ones, and a float texture only to float ones
    TextureNesting nesting;
    nesting.Add(floatTextures, true);
    nesting.Add(spectrumTextures, false);
    TextureContext context(*this);
    for (const TextureEntity &e : floatTextures)
        floats_.push_back(MakeTexture<float>(e, context));
    for (const TextureEntity &e : spectrumTextures)
        spectra_.push_back(MakeTexture<Spectrum>(e, context));
    imageFilesRead_ = context.FilesRead();
}

std::shared_ptr<const Texture<float>>
TextureTable::GetFloatTexture(const ParamSet &params, std::string_view name, float defaultValue) const {
    if (const Param *p = params.Find(name, ParamType::Texture)) {
        auto texture = Bound<float>(*p, p->floatTexture, floats_);
        return texture ? texture : Constant(defaultValue);
    }
    return Constant(params.FindFloat(name, defaultValue));
}

std::shared_ptr<const Texture<Spectrum>>
TextureTable::GetSpectrumTexture(const ParamSet &params, std::string_view name,
                                 const Spectrum &defaultValue) const {
    if (const Param *p = params.Find(name, ParamType::Texture)) {
        auto texture = Bound<Spectrum>(*p, p->spectrumTexture, spectra_);
        return texture ? texture : Constant(defaultValue);
    }
    return Constant(params.FindSpectrum(name, defaultValue));
}

} // namespace cuticle