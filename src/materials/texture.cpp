#include "materials/texture.h"

#include "core/error.h"
#include "images/image.h"
#include "materials/noise.h"
#include "parser/lexer.h"

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

namespace cuticle {

namespace {

constexpr float NaN = std::numeric_limits<float>::quiet_NaN();

[[noreturn]] void Fail(const FileLoc &loc, const std::string &message) {
    throw Error(loc, message).WithSourceLine(SourceLine(loc));
}

// The place of a parameter, or of the directive where it was not given.
const FileLoc &LocOf(const ParamSet &params, std::string_view name) {
    const Param *p = params.Find(name);
    return p ? p->loc : params.loc;
}

// --- where on a texture a point lies -----------------------------------------------------------------------------

class TextureMapping2D {
  public:
    virtual ~TextureMapping2D() = default;
    virtual Point2f Map(const TexturePoint &point) const = 0;
};

class UVMapping2D final : public TextureMapping2D {
  public:
    UVMapping2D(float su, float sv, float du, float dv) : su_(su), sv_(sv), du_(du), dv_(dv) {}
    Point2f Map(const TexturePoint &point) const override {
        return {su_ * point.uv.x + du_, sv_ * point.uv.y + dv_};
    }

  private:
    float su_, sv_, du_, dv_;
};

// (theta / pi, phi / 2 pi) of the direction from the texture's origin; the origin itself maps to (0, 0).
class SphericalMapping2D final : public TextureMapping2D {
  public:
    explicit SphericalMapping2D(const Transform &worldToTexture) : worldToTexture_(worldToTexture) {}
    Point2f Map(const TexturePoint &point) const override {
        const Vector3f v = worldToTexture_.Point(point.p);
        const float theta = std::atan2(std::hypot(v.x, v.y), v.z), phi = std::atan2(v.y, v.x);
        return {theta / Pi, (phi < 0 ? phi + 2 * Pi : phi) / (2 * Pi)};
    }

  private:
    Transform worldToTexture_;
};

// Angle about z and the cosine to z. That t is the cosine and not the height is pbrt-v3's doing: it normalises first.
// The origin itself, where no cosine is, takes 0.
class CylindricalMapping2D final : public TextureMapping2D {
  public:
    explicit CylindricalMapping2D(const Transform &worldToTexture) : worldToTexture_(worldToTexture) {}
    Point2f Map(const TexturePoint &point) const override {
        const Vector3f v = worldToTexture_.Point(point.p);
        const float length = v.Length();
        return {(Pi + std::atan2(v.y, v.x)) / (2 * Pi), length == 0 ? 0 : v.z / length};
    }

  private:
    Transform worldToTexture_;
};

class PlanarMapping2D final : public TextureMapping2D {
  public:
    PlanarMapping2D(const Vector3f &vs, const Vector3f &vt, float ds, float dt)
        : vs_(vs), vt_(vt), ds_(ds), dt_(dt) {}
    Point2f Map(const TexturePoint &point) const override {
        return {ds_ + Dot(point.p, vs_), dt_ + Dot(point.p, vt_)};
    }

  private:
    Vector3f vs_, vt_;
    float ds_, dt_;
};

// pbrt-v3 carries the world's point through the texture's transformation itself where one would look for its inverse:
// Scale 2 halves a pattern. Scenes are made for what it does, so this does the same.
class IdentityMapping3D {
  public:
    explicit IdentityMapping3D(const Transform &ctm) : ctm_(ctm) {}
    Point3f Map(const TexturePoint &point) const { return ctm_.Point(point.p); }

  private:
    Transform ctm_;
};

// --- textures ----------------------------------------------------------------------------------------------------

template <class T>
using TexturePtr = std::shared_ptr<const Texture<T>>;

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

// A scene's texture as others see it: where the numbers of the scene drive a value beyond binary32 it is 0, with one
// warning at the texture's place. At a point that is not finite itself the value is left alone: such a fault is ours,
// and is to be seen in the picture's count of lost samples.
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
                    "texture \"" + name_ + "\" has values that are not finite, which are set to 0");
        return T(0);
    }

  private:
    TexturePtr<T> texture_;
    FileLoc loc_;
    std::string name_;
    mutable std::atomic<bool> warned_ = false;
};

// Even and odd cells of the integer lattice. The cell's number is kept in double, where it is exact, and never goes
// through int, which it may not fit.
template <class T>
T EvaluateChecker(double cellSum, const TexturePtr<T> &tex1, const TexturePtr<T> &tex2,
                  const TexturePoint &point) {
    if (!std::isfinite(cellSum))
        return T(NaN);
    return std::fmod(cellSum, 2) == 0 ? tex1->Evaluate(point) : tex2->Evaluate(point);
}

template <class T>
class Checkerboard2DTexture final : public Texture<T> {
  public:
    Checkerboard2DTexture(std::unique_ptr<TextureMapping2D> mapping, TexturePtr<T> tex1, TexturePtr<T> tex2)
        : mapping_(std::move(mapping)), tex1_(std::move(tex1)), tex2_(std::move(tex2)) {}
    T Evaluate(const TexturePoint &point) const override {
        const Point2f st = mapping_->Map(point);
        return EvaluateChecker(std::floor(double(st.x)) + std::floor(double(st.y)), tex1_, tex2_, point);
    }

  private:
    std::unique_ptr<TextureMapping2D> mapping_;
    TexturePtr<T> tex1_, tex2_;
};

template <class T>
class Checkerboard3DTexture final : public Texture<T> {
  public:
    Checkerboard3DTexture(const Transform &ctm, TexturePtr<T> tex1, TexturePtr<T> tex2)
        : mapping_(ctm), tex1_(std::move(tex1)), tex2_(std::move(tex2)) {}
    T Evaluate(const TexturePoint &point) const override {
        const Point3f p = mapping_.Map(point);
        return EvaluateChecker(std::floor(double(p.x)) + std::floor(double(p.y)) + std::floor(double(p.z)),
                               tex1_, tex2_, point);
    }

  private:
    IdentityMapping3D mapping_;
    TexturePtr<T> tex1_, tex2_;
};

template <class T>
class BilerpTexture final : public Texture<T> {
  public:
    // Values at (s, t) = (0, 0), (0, 1), (1, 0), (1, 1); outside of the unit square they go on as they do inside.
    BilerpTexture(std::unique_ptr<TextureMapping2D> mapping, const T &v00, const T &v01, const T &v10,
                  const T &v11)
        : mapping_(std::move(mapping)), v00_(v00), v01_(v01), v10_(v10), v11_(v11) {}
    T Evaluate(const TexturePoint &point) const override {
        const Point2f st = mapping_->Map(point);
        return (v00_ * (1 - st.y) + v01_ * st.y) * (1 - st.x) + (v10_ * (1 - st.y) + v11_ * st.y) * st.x;
    }

  private:
    std::unique_ptr<TextureMapping2D> mapping_;
    T v00_, v01_, v10_, v11_;
};

// The fractions of s and t in red and green.
class UVTexture final : public Texture<Spectrum> {
  public:
    explicit UVTexture(std::unique_ptr<TextureMapping2D> mapping) : mapping_(std::move(mapping)) {}
    Spectrum Evaluate(const TexturePoint &point) const override {
        const Point2f st = mapping_->Map(point);
        return {st.x - std::floor(st.x), st.y - std::floor(st.y), 0};
    }

  private:
    std::unique_ptr<TextureMapping2D> mapping_;
};

// Disks of one size in the cells of the integer lattice; noise decides which cells have one and where it lies.
template <class T>
class DotsTexture final : public Texture<T> {
  public:
    DotsTexture(std::unique_ptr<TextureMapping2D> mapping, TexturePtr<T> outside, TexturePtr<T> inside)
        : mapping_(std::move(mapping)), outside_(std::move(outside)), inside_(std::move(inside)) {}
    T Evaluate(const TexturePoint &point) const override {
        const Point2f st = mapping_->Map(point);
        if (!std::isfinite(st.x) || !std::isfinite(st.y))
            return T(NaN);
        const float s = std::floor(st.x + 0.5f), t = std::floor(st.y + 0.5f);
        const auto noise = [&](float ds, float dt) { return Noise({s + ds, t + dt, 0.5f}); };
        if (noise(0.5f, 0.5f) > 0) {
            constexpr float radius = 0.35f, maxShift = 0.5f - radius;
            const float dx = st.x - (s + maxShift * noise(1.5f, 2.8f));
            const float dy = st.y - (t + maxShift * noise(4.5f, 9.8f));
            if (dx * dx + dy * dy < radius * radius)
                return inside_->Evaluate(point);
        }
        return outside_->Evaluate(point);
    }

  private:
    std::unique_ptr<TextureMapping2D> mapping_;
    TexturePtr<T> outside_, inside_;
};

// What fbm and wrinkled share: a sum of octaves of noise.
template <class T>
class NoiseTexture final : public Texture<T> {
  public:
    using Sum = float (*)(const Point3f &p, float omega, int octaves);
    NoiseTexture(const Transform &ctm, Sum sum, float omega, int octaves)
        : mapping_(ctm), sum_(sum), omega_(omega), octaves_(octaves) {}
    T Evaluate(const TexturePoint &point) const override {
        return T(sum_(mapping_.Map(point), omega_, octaves_));
    }

  private:
    IdentityMapping3D mapping_;
    Sum sum_;
    float omega_;
    int octaves_;
};

// Waves, where a slow noise says how strongly the wind blows.
template <class T>
class WindyTexture final : public Texture<T> {
  public:
    explicit WindyTexture(const Transform &ctm) : mapping_(ctm) {}
    T Evaluate(const TexturePoint &point) const override {
        const Point3f p = mapping_.Map(point);
        return T(std::abs(FBm(p * 0.1f, 0.5f, 3)) * FBm(p, 0.5f, 6));
    }

  private:
    IdentityMapping3D mapping_;
};

// Layers across y, disturbed by noise, through a row of colours.
class MarbleTexture final : public Texture<Spectrum> {
  public:
    MarbleTexture(const Transform &ctm, float omega, int octaves, float scale, float variation)
        : mapping_(ctm), omega_(omega), scale_(scale), variation_(variation), octaves_(octaves) {}
    Spectrum Evaluate(const TexturePoint &point) const override {
        const Point3f p = mapping_.Map(point) * scale_;
        const float layer = p.y + variation_ * FBm(p, omega_, octaves_);
        return Color(0.5f + 0.5f * std::sin(layer));
    }

  private:
    // Bezier segments over four neighbouring colours each, for t in [0, 1]; they do not meet, which makes the veins sharp.
    // pbrt-v3 takes std::min(1, ...) for the segment's number where the last one, 5, is meant (its issue 252, pull
    // request 341), and so runs far out of the second segment, to reflectances of 40. We take what is meant.
    static Spectrum Color(float t) {
        static const std::array<Spectrum, 9> colors = {
            Spectrum(0.58f, 0.58f, 0.6f), Spectrum(0.58f, 0.58f, 0.6f), Spectrum(0.58f, 0.58f, 0.6f),
            Spectrum(0.5f, 0.5f, 0.5f),   Spectrum(0.6f, 0.59f, 0.58f), Spectrum(0.58f, 0.58f, 0.6f),
            Spectrum(0.58f, 0.58f, 0.6f), Spectrum(0.2f, 0.2f, 0.33f),  Spectrum(0.58f, 0.58f, 0.6f)};
        constexpr size_t segments = colors.size() - 3;
        if (std::isnan(t))
            return Spectrum(NaN);
        t *= static_cast<float>(segments);
        const size_t first = std::min(static_cast<size_t>(t), segments - 1);
        t -= static_cast<float>(first);
        const float s = 1 - t;
        const Spectrum *c = &colors[first];
        // The factor makes up for the colours' small contrast
        return (c[0] * (s * s * s) + c[1] * (3 * s * s * t) + c[2] * (3 * s * t * t) + c[3] * (t * t * t)) *
               1.5f;
    }

    IdentityMapping3D mapping_;
    float omega_, scale_, variation_;
    int octaves_;
};

// The colour of the strand, as its groom has it.
template <class T>
class StrandColorTexture final : public Texture<T> {
  public:
    explicit StrandColorTexture(TexturePtr<T> elsewhere) : elsewhere_(std::move(elsewhere)) {}
    T Evaluate(const TexturePoint &point) const override {
        if (!point.strandColors)
            return elsewhere_->Evaluate(point);
        const auto &[first, last] = *point.strandColors;
        const Spectrum color = first * (1 - point.uv.x) + last * point.uv.x;
        if constexpr (std::is_same_v<T, float>)
            return color.y();
        else
            return color;
    }

  private:
    TexturePtr<T> elsewhere_;
};

enum class ImageWrap { Repeat, Black, Clamp };

// Texels as a texture wants them: decoded, scaled, t upwards.
template <class T>
struct Texels {
    int width = 0, height = 0;
    std::vector<T> values;
};

template <class T>
class ImageTexture final : public Texture<T> {
  public:
    ImageTexture(std::unique_ptr<TextureMapping2D> mapping, std::shared_ptr<const Texels<T>> texels,
                 ImageWrap wrap)
        : mapping_(std::move(mapping)), texels_(std::move(texels)), wrap_(wrap) {}

    T Evaluate(const TexturePoint &point) const override {
        // Bring the coordinates near [0, 1], where their texels are small integers
        const Point2f st = mapping_->Map(point);
        if (!std::isfinite(st.x) || !std::isfinite(st.y))
            return T(NaN);
        const auto nearby = [&](double v) {
            return wrap_ == ImageWrap::Repeat ? v - std::floor(v) : std::clamp(v, -2., 3.);
        };
        // Blend the four texels around the point; texel centres lie at half integers
        const double s = nearby(st.x) * texels_->width - 0.5, t = nearby(st.y) * texels_->height - 0.5;
        const double s0 = std::floor(s), t0 = std::floor(t);
        const float ds = static_cast<float>(s - s0), dt = static_cast<float>(t - t0);
        const int64_t i = static_cast<int64_t>(s0), j = static_cast<int64_t>(t0);
        return Texel(i, j) * ((1 - ds) * (1 - dt)) + Texel(i, j + 1) * ((1 - ds) * dt) +
               Texel(i + 1, j) * (ds * (1 - dt)) + Texel(i + 1, j + 1) * (ds * dt);
    }

  private:
    T Texel(int64_t s, int64_t t) const {
        const int64_t w = texels_->width, h = texels_->height;
        switch (wrap_) {
        case ImageWrap::Repeat:
            s = (s % w + w) % w, t = (t % h + h) % h;
            break;
        case ImageWrap::Black:
            if (s < 0 || s >= w || t < 0 || t >= h)
                return T(0);
            break;
        case ImageWrap::Clamp:
            s = std::clamp<int64_t>(s, 0, w - 1), t = std::clamp<int64_t>(t, 0, h - 1);
            break;
        }
        return texels_->values[static_cast<size_t>(t * w + s)];
    }

    std::unique_ptr<TextureMapping2D> mapping_;
    std::shared_ptr<const Texels<T>> texels_;
    ImageWrap wrap_;
};

// --- from a scene's words to textures --------------------------------------------------------------------------------

// What is shared while the textures of a scene are made.
class Builder {
  public:
    explicit Builder(const TextureTable &t) : table(t) {}
    const TextureTable &table;

    // The image of a file, not decoded; read at the first call for it.
    const Image &ReadOnce(const std::string &filename, const FileLoc &loc) {
        auto [at, isNew] = images_.try_emplace(filename);
        if (isNew) {
            try {
                at->second = ReadImage(filename, false);
            } catch (const Error &e) {
                Fail(loc, "the texture's image cannot be used: " + e.Message());
            }
        }
        return at->second;
    }
    size_t FilesRead() const { return images_.size(); }

    // Texels are kept by all that decides their values, so that textures that differ in mapping alone share them.
    template <class T>
    auto &TexelCache() {
        if constexpr (std::is_same_v<T, float>)
            return floatTexels_;
        else
            return spectrumTexels_;
    }

  private:
    struct TexelKey {
        std::string filename;
        bool gamma;
        float scale;
        auto operator<=>(const TexelKey &) const = default; // NOLINT(modernize-use-nullptr): misread
    };
    std::map<std::string, Image> images_;
    std::map<TexelKey, std::shared_ptr<const Texels<float>>> floatTexels_;
    std::map<TexelKey, std::shared_ptr<const Texels<Spectrum>>> spectrumTexels_;
};

template <class T>
TexturePtr<T> Get(const Builder &b, const ParamSet &params, std::string_view name, float defaultValue) {
    if constexpr (std::is_same_v<T, float>)
        return b.table.GetFloatTexture(params, name, defaultValue);
    else
        return b.table.GetSpectrumTexture(params, name, Spectrum(defaultValue));
}

// A plain value of the texture's type.
template <class T>
T FindValue(const ParamSet &params, std::string_view name, float defaultValue) {
    if constexpr (std::is_same_v<T, float>)
        return params.FindFloat(name, defaultValue);
    else
        return params.FindSpectrum(name, Spectrum(defaultValue));
}

template <class T>
TexturePtr<T> Constant(const T &value) {
    return std::make_shared<ConstantTexture<T>>(value);
}

std::unique_ptr<TextureMapping2D> MakeMapping(const TextureEntity &e) {
    const ParamSet &p = e.params;
    static constexpr std::array<std::string_view, 4> names = {"uv", "spherical", "cylindrical", "planar"};
    const std::string type = p.FindString("mapping", "uv");
    if (type == "uv")
        return std::make_unique<UVMapping2D>(p.FindFloat("uscale", 1), p.FindFloat("vscale", 1),
                                             p.FindFloat("udelta", 0), p.FindFloat("vdelta", 0));
    if (type == "planar")
        return std::make_unique<PlanarMapping2D>(p.FindVector3f("v1", {1, 0, 0}),
                                                 p.FindVector3f("v2", {0, 1, 0}), p.FindFloat("udelta", 0),
                                                 p.FindFloat("vdelta", 0));
    if (type != "spherical" && type != "cylindrical")
        Fail(LocOf(p, "mapping"),
             "there is no texture mapping \"" + type + "\". " + Suggestion(type, names.data(), names.size()));
    if (e.ctm.IsSingular())
        Fail(LocOf(p, "mapping"), "a " + type + " mapping needs a transformation that can be inverted");
    if (type == "spherical")
        return std::make_unique<SphericalMapping2D>(e.ctm.Inverse());
    return std::make_unique<CylindricalMapping2D>(e.ctm.Inverse());
}

template <class T>
TexturePtr<T> MakeConstant(const TextureEntity &e, Builder &) {
    return Constant<T>(FindValue<T>(e.params, "value", 1));
}

template <class T>
TexturePtr<T> MakeScale(const TextureEntity &e, Builder &b) {
    return std::make_shared<ScaleTexture<T>>(Get<T>(b, e.params, "tex1", 1), Get<T>(b, e.params, "tex2", 1));
}

template <class T>
TexturePtr<T> MakeMix(const TextureEntity &e, Builder &b) {
    return std::make_shared<MixTexture<T>>(Get<T>(b, e.params, "tex1", 0), Get<T>(b, e.params, "tex2", 1),
                                           b.table.GetFloatTexture(e.params, "amount", 0.5f));
}

template <class T>
TexturePtr<T> MakeStrandColor(const TextureEntity &e, Builder &b) {
    return std::make_shared<StrandColorTexture<T>>(Get<T>(b, e.params, "default", 0.5f));
}

template <class T>
TexturePtr<T> MakeCheckerboard(const TextureEntity &e, Builder &b) {
    const int dimension = e.params.FindInt("dimension", 2);
    if (dimension != 2 && dimension != 3)
        Fail(LocOf(e.params, "dimension"),
             "a checkerboard has 2 or 3 dimensions, not " + std::to_string(dimension));
    TexturePtr<T> tex1 = Get<T>(b, e.params, "tex1", 1), tex2 = Get<T>(b, e.params, "tex2", 0);
    if (dimension == 3)
        return std::make_shared<Checkerboard3DTexture<T>>(e.ctm, std::move(tex1), std::move(tex2));
    const std::string mode = e.params.FindString("aamode", "closedform");
    if (mode != "none" && mode != "closedform")
        Warning(LocOf(e.params, "aamode"), "unknown antialiasing mode of a checkerboard",
                "there is no antialiasing mode \"" + mode +
                    "\" (none and closedform are known); the samples of a pixel filter it here");
    return std::make_shared<Checkerboard2DTexture<T>>(MakeMapping(e), std::move(tex1), std::move(tex2));
}

// The values as pbrt-v3 makes them: sRGB decoding first (of the luminance of a float texture, as there), then the
// scale; image row 0 is at t = 1.
template <class T>
std::shared_ptr<const Texels<T>> MakeTexels(const Image &image, bool gamma, float scale, const FileLoc &loc) {
    auto texels = std::make_shared<Texels<T>>();
    texels->width = image.width, texels->height = image.height;
    texels->values.reserve(static_cast<size_t>(image.width) * static_cast<size_t>(image.height));
    size_t bad = 0;
    for (int y = image.height - 1; y >= 0; --y)
        for (int x = 0; x < image.width; ++x) {
            const Spectrum rgb = image.RGB(x, y);
            const auto decode = [&](float v) {
                const float texel = scale * (gamma ? SRGBToLinear(v) : v);
                const bool good = std::isfinite(texel);
                bad += !good;
                return good ? texel : 0;
            };
            if constexpr (std::is_same_v<T, float>)
                texels->values.push_back(decode(rgb.y()));
            else
                texels->values.push_back({decode(rgb[0]), decode(rgb[1]), decode(rgb[2])});
        }
    if (bad > 0)
        Warning(loc, "texels out of range",
                std::to_string(bad) + " values of the texture's image are NaN or infinite, and set to 0");
    return texels;
}

bool HoldsEncodedValues(std::string filename) {
    for (char &c : filename)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return filename.ends_with(".png") || filename.ends_with(".tga") || filename.ends_with(".jpg") ||
           filename.ends_with(".jpeg");
}

template <class T>
TexturePtr<T> MakeImage(const TextureEntity &e, Builder &b) {
    const ParamSet &p = e.params;
    // Read what pbrt-v3's filter asks for and a point sample has no use for
    p.FindBool("trilinear", false);
    p.FindFloat("maxanisotropy", 8);

    const std::string wrapName = p.FindString("wrap", "repeat");
    static constexpr std::array<std::string_view, 3> wraps = {"repeat", "black", "clamp"};
    const auto found = std::find(wraps.begin(), wraps.end(), wrapName);
    if (found == wraps.end())
        Fail(LocOf(p, "wrap"), "there is no wrap mode \"" + wrapName + "\". " +
                                   Suggestion(wrapName, wraps.data(), wraps.size()));
    const ImageWrap wrap = static_cast<ImageWrap>(found - wraps.begin());

    const std::string filename = p.FindFilename("filename");
    if (filename.empty())
        Fail(LocOf(p, "filename"), "Texture \"imagemap\" needs \"string filename\"");
    const float scale = p.FindFloat("scale", 1);
    const bool gamma = p.FindBool("gamma", HoldsEncodedValues(filename));
    auto &texels = b.TexelCache<T>()[{filename, gamma, scale}];
    if (!texels)
        texels =
            MakeTexels<T>(b.ReadOnce(filename, LocOf(p, "filename")), gamma, scale, LocOf(p, "filename"));
    return std::make_shared<ImageTexture<T>>(MakeMapping(e), texels, wrap);
}

// How many octaves of noise: more than 100 are finer than any float.
int Octaves(const TextureEntity &e) {
    const int octaves = e.params.FindInt("octaves", 8);
    if (octaves < 0 || octaves > 100)
        Fail(LocOf(e.params, "octaves"), "\"octaves\" must be 0 to 100, not " + std::to_string(octaves));
    return octaves;
}

// For classes that pbrt-v3 has in colour alone.
[[noreturn]] void FailForFloat(const TextureEntity &e) {
    Fail(e.params.loc, "Texture \"" + e.type + "\" has colours, and \"" + e.name +
                           "\" is declared as float: declare it as \"color\"");
}

template <class T>
TexturePtr<T> MakeBilerp(const TextureEntity &e, Builder &) {
    const ParamSet &p = e.params;
    return std::make_shared<BilerpTexture<T>>(MakeMapping(e), FindValue<T>(p, "v00", 0),
                                              FindValue<T>(p, "v01", 1), FindValue<T>(p, "v10", 0),
                                              FindValue<T>(p, "v11", 1));
}

template <class T>
TexturePtr<T> MakeUV(const TextureEntity &e, Builder &) {
    if constexpr (std::is_same_v<T, float>)
        FailForFloat(e);
    else
        return std::make_shared<UVTexture>(MakeMapping(e));
}

template <class T>
TexturePtr<T> MakeDots(const TextureEntity &e, Builder &b) {
    return std::make_shared<DotsTexture<T>>(MakeMapping(e), Get<T>(b, e.params, "outside", 0),
                                            Get<T>(b, e.params, "inside", 1));
}

template <class T>
TexturePtr<T> MakeFBm(const TextureEntity &e, Builder &) {
    return std::make_shared<NoiseTexture<T>>(e.ctm, FBm, e.params.FindFloat("roughness", 0.5f), Octaves(e));
}

template <class T>
TexturePtr<T> MakeWrinkled(const TextureEntity &e, Builder &) {
    return std::make_shared<NoiseTexture<T>>(e.ctm, Turbulence, e.params.FindFloat("roughness", 0.5f),
                                             Octaves(e));
}

template <class T>
TexturePtr<T> MakeWindy(const TextureEntity &e, Builder &) {
    return std::make_shared<WindyTexture<T>>(e.ctm);
}

template <class T>
TexturePtr<T> MakeMarble(const TextureEntity &e, Builder &) {
    const ParamSet &p = e.params;
    if constexpr (std::is_same_v<T, float>)
        FailForFloat(e);
    else
        return std::make_shared<MarbleTexture>(e.ctm, p.FindFloat("roughness", 0.5f), Octaves(e),
                                               p.FindFloat("scale", 1), p.FindFloat("variation", 0.2f));
}

// --- a stand-in for what pbrt-v3 knows and this does not render ------------------------------------------------------

constexpr std::string_view kPtexStandIn = "the constant 0.5";

template <class T>
TexturePtr<T> MakePtex(const TextureEntity &e, Builder &) {
    for (const Param &p : e.params.params)
        p.used = true; // one warning is enough
    Warning(e.params.loc, "texture class \"" + e.type + "\"",
            fmt::format("Texture \"ptex\" is not rendered; {} is used instead", kPtexStandIn));
    return Constant(T(0.5f));
}

// --- the table of names ------------------------------------------------------------------------------------------

// A class's makers as a float texture and as one of colours.
struct TextureMakers {
    TexturePtr<float> (*makeFloat)(const TextureEntity &, Builder &);
    TexturePtr<Spectrum> (*makeSpectrum)(const TextureEntity &, Builder &);
    template <class T>
    TexturePtr<T> Make(const TextureEntity &e, Builder &b) const {
        if constexpr (std::is_same_v<T, float>)
            return makeFloat(e, b);
        else
            return makeSpectrum(e, b);
    }
};

// To add a texture: its class and its Make function above, a row here.
const PluginRow<TextureMakers> kTextures[] = {
    {{.name = "constant"}, {MakeConstant<float>, MakeConstant<Spectrum>}},
    {{.name = "scale"}, {MakeScale<float>, MakeScale<Spectrum>}},
    {{.name = "mix"}, {MakeMix<float>, MakeMix<Spectrum>}},
    {{.name = "imagemap"}, {MakeImage<float>, MakeImage<Spectrum>}},
    {{.name = "checkerboard"}, {MakeCheckerboard<float>, MakeCheckerboard<Spectrum>}},
    {{.name = "bilerp"}, {MakeBilerp<float>, MakeBilerp<Spectrum>}},
    {{.name = "uv"}, {MakeUV<float>, MakeUV<Spectrum>}},
    {{.name = "dots"}, {MakeDots<float>, MakeDots<Spectrum>}},
    {{.name = "fbm"}, {MakeFBm<float>, MakeFBm<Spectrum>}},
    {{.name = "wrinkled"}, {MakeWrinkled<float>, MakeWrinkled<Spectrum>}},
    {{.name = "windy"}, {MakeWindy<float>, MakeWindy<Spectrum>}},
    {{.name = "marble"}, {MakeMarble<float>, MakeMarble<Spectrum>}},
    {{.name = "ptex", .standIn = kPtexStandIn}, {MakePtex<float>, MakePtex<Spectrum>}},
    {{.name = "strandcolor", .ours = true}, {MakeStrandColor<float>, MakeStrandColor<Spectrum>}},
};

template <class T>
TexturePtr<T> Make(const TextureEntity &e, Builder &b) {
    const PluginRow<TextureMakers> *row = FindPluginRow(kTextures, e.type);
    if (!row) {
        const std::vector<std::string_view> names = TexturePlugins().Names();
        Fail(e.params.loc, fmt::format("there is no texture class \"{}\". {}", e.type,
                                       Suggestion(e.type, names.data(), names.size())));
    }
    TexturePtr<T> texture = row->make.Make<T>(e, b);
    e.params.ReportUnused(fmt::format("Texture \"{}\"", e.type));
    // A constant is what the parser let pass
    if (dynamic_cast<const ConstantTexture<T> *>(texture.get()))
        return texture;
    return std::make_shared<FiniteTexture<T>>(std::move(texture), e);
}

// The texture that a parameter names: index is the one of the asked-for kind, other that of the other kind.
template <class T>
const TexturePtr<T> &Bound(const Param &p, int index, int other, const std::vector<TexturePtr<T>> &textures) {
    const std::string name = p.strings.empty() ? p.name : p.strings[0];
    const bool isFloat = std::is_same_v<T, float>;
    if (index < 0 && other >= 0)
        Fail(p.loc, "texture \"" + name + "\" is declared as " + (isFloat ? "spectrum" : "float") +
                        ", but \"" + p.name + "\" needs a " + (isFloat ? "float" : "spectrum") + " texture");
    if (index < 0 || static_cast<size_t>(index) >= textures.size())
        Fail(p.loc,
             "there is no texture \"" + name + "\"; a Texture directive must declare it before its use");
    return textures[static_cast<size_t>(index)];
}

// How textures are made of others: evaluating one evaluates those below it. A chain of thousands would not fit the
// stack, and one that uses its predecessor twice on each of fifty levels would never be done.
class Nesting {
  public:
    void Add(const std::vector<TextureEntity> &textures, bool isFloat) {
        std::vector<Cost> &costs = isFloat ? floats_ : spectra_;
        for (const TextureEntity &e : textures) {
            Cost cost{1, 1};
            for (const Param &p : e.params.params) {
                const int index = isFloat || p.spectrumTexture < 0 ? p.floatTexture : p.spectrumTexture;
                const std::vector<Cost> &from = isFloat || p.spectrumTexture < 0 ? floats_ : spectra_;
                if (p.type != ParamType::Texture || index < 0 || static_cast<size_t>(index) >= from.size())
                    continue;
                cost.levels = std::max(cost.levels, from[static_cast<size_t>(index)].levels + 1);
                cost.evaluations += from[static_cast<size_t>(index)].evaluations;
            }
            if (cost.levels > kMaxLevels || cost.evaluations > kMaxEvaluations)
                Fail(e.params.loc, "texture \"" + e.name + "\" is made of others more than " +
                                       std::to_string(kMaxLevels) + " levels deep, or more than " +
                                       std::to_string(kMaxEvaluations) + " times");
            costs.push_back(cost);
        }
    }

  private:
    static constexpr int kMaxLevels = 200, kMaxEvaluations = 10000;
    struct Cost {
        int levels, evaluations;
    };
    std::vector<Cost> floats_, spectra_;
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
    Nesting nesting;
    nesting.Add(floatTextures, true);
    nesting.Add(spectrumTextures, false);
    Builder builder(*this);
    for (const TextureEntity &e : floatTextures)
        floats_.push_back(Make<float>(e, builder));
    for (const TextureEntity &e : spectrumTextures)
        spectra_.push_back(Make<Spectrum>(e, builder));
    imageFilesRead_ = builder.FilesRead();
}

std::shared_ptr<const Texture<float>>
TextureTable::GetFloatTexture(const ParamSet &params, std::string_view name, float defaultValue) const {
    if (const Param *p = params.Find(name, ParamType::Texture))
        return Bound<float>(*p, p->floatTexture, p->spectrumTexture, floats_);
    return Constant(params.FindFloat(name, defaultValue));
}

std::shared_ptr<const Texture<Spectrum>>
TextureTable::GetSpectrumTexture(const ParamSet &params, std::string_view name,
                                 const Spectrum &defaultValue) const {
    if (const Param *p = params.Find(name, ParamType::Texture))
        return Bound<Spectrum>(*p, p->spectrumTexture, p->floatTexture, spectra_);
    return Constant(params.FindSpectrum(name, defaultValue));
}

} // namespace cuticle
