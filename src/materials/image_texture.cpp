#include "core/error.h"
#include "core/memory_budget.h"
#include "materials/texture_makers.h"
#include "materials/texture_mapping.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace cuticle {

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

enum class ImageWrap { Repeat, Black, Clamp }; // in the order of kImageWraps

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
            return T(kNaN);
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

// Decodes sRGB first (of the luminance of a float texture), then scales, as pbrt-v3 does; image row 0 is at
// t = 1.
template <class T>
std::shared_ptr<const Texels<T>> MakeTexels(const Image &image, bool gamma, float scale, const FileLoc &loc) {
    auto texels = std::make_shared<Texels<T>>();
    texels->width = image.width, texels->height = image.height;
    ClaimMemory(fmt::format("the texels of a picture of {} x {}", image.width, image.height),
                image.Pixels() * sizeof(T), loc);
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
                fmt::format("{} values of the texture's image are NaN or infinite, and set to 0", bad));
    return texels;
}

// Whether a file of that name holds sRGB values, pbrt-v3's default of "gamma".
bool HoldsEncodedValues(std::string filename) {
    for (char &c : filename)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return filename.ends_with(".png") || filename.ends_with(".tga") || filename.ends_with(".jpg") ||
           filename.ends_with(".jpeg");
}

} // namespace

const Image &TextureContext::ReadOnce(const std::string &filename, const FileLoc &loc) {
    auto [at, isNew] = images_.try_emplace(filename);
    if (isNew) {
        try {
            const PlaceScope here(loc);
            if (filename.empty())
                throw Error("Texture \"imagemap\" needs \"string filename\"");
            at->second = ReadImage(filename, false);
        } catch (const Error &e) {
            Error(e)
                .WithPbrtInstead("a grey of 0.5 takes the place of the texture's image")
                .GoOnAsPbrt("texture without its image");
            at->second = Image(1, 1, {"R", "G", "B"});
            at->second.data = {0.5f, 0.5f, 0.5f};
        }
    }
    return at->second;
}

template <class T>
TexturePtr<T> MakeImageMap(const TextureEntity &e, TextureContext &b) {
    const ParamSet &p = e.params;
    // Read the parameters of pbrt-v3's filter, for which a point sample has no use
    p.FindBool("trilinear", false);
    p.FindFloat("maxanisotropy", 8);

    const std::string wrapName = p.FindString("wrap", "repeat");
    const auto found = std::find(kImageWraps.begin(), kImageWraps.end(), wrapName);
    if (found == kImageWraps.end())
        Warning(LocOf(p, "wrap"), "unknown wrap mode",
                fmt::format("there is no wrap mode \"{}\"; the image repeats, as in pbrt-v3. {}", wrapName,
                            Suggestion(wrapName, kImageWraps.data(), kImageWraps.size())));
    const ImageWrap wrap =
        found == kImageWraps.end() ? ImageWrap::Repeat : static_cast<ImageWrap>(found - kImageWraps.begin());

    const std::string filename = p.FindFilename("filename");
    const float scale = p.FindFloat("scale", 1);
    const bool gamma = p.FindBool("gamma", HoldsEncodedValues(filename));
    auto &texels = b.TexelCache<T>()[{filename, gamma, scale}];
    if (!texels)
        texels =
            MakeTexels<T>(b.ReadOnce(filename, LocOf(p, "filename")), gamma, scale, LocOf(p, "filename"));
    return std::make_shared<ImageTexture<T>>(MakeMapping(e), texels, wrap);
}

template TexturePtr<float> MakeImageMap<float>(const TextureEntity &, TextureContext &);
template TexturePtr<Spectrum> MakeImageMap<Spectrum>(const TextureEntity &, TextureContext &);

} // namespace cuticle
