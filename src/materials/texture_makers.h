// The makers of textures, for the table in texture.cpp: what they share, and those that stand in files of
// their own.
#pragma once

#include "core/error.h"
#include "images/image.h"
#include "materials/texture.h"
#include "parser/lexer.h"
#include "parser/scene_description.h"

#include <array>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace cuticle {

template <class T>
using TexturePtr = std::shared_ptr<const Texture<T>>;

// An Error at a place of the scene that quotes the scene's line there.
template <typename... Args>
Error ErrorAtLine(const FileLoc &loc, fmt::format_string<Args...> format, Args &&...args) {
    return Error(loc, fmt::format(format, std::forward<Args>(args)...)).WithSourceLine(SourceLine(loc));
}

// The place of a parameter, or that of the directive where the parameter was not given.
inline const FileLoc &LocOf(const ParamSet &params, std::string_view name) {
    const Param *p = params.Find(name);
    return p ? p->loc : params.loc;
}

// The texels of an image as a texture reads them: decoded, scaled, row 0 at t = 0.
template <class T>
struct Texels {
    int width = 0, height = 0;
    std::vector<T> values; // row by row
};

// Everything that decides the values of texels: textures that differ in their mapping alone share them.
struct TexelKey {
    std::string filename;
    bool gamma;
    float scale;
    auto operator<=>(const TexelKey &) const = default; // NOLINT(modernize-use-nullptr): misread
};

// The state that makers share while the textures of a scene are made.
class TextureContext {
  public:
    explicit TextureContext(const TextureTable &t) : table(t) {}
    const TextureTable &table; // the textures that are made already

    // The image of a file, not decoded; read at the first call for it. Error at `loc` where it cannot be
    // read.
    const Image &ReadOnce(const std::string &filename, const FileLoc &loc);
    size_t FilesRead() const { return images_.size(); }

    template <class T>
    auto &TexelCache() {
        if constexpr (std::is_same_v<T, float>)
            return floatTexels_;
        else
            return spectrumTexels_;
    }

    // The texture bound to a parameter of the texture's own type, or a constant.
    template <class T>
    TexturePtr<T> Get(const ParamSet &params, std::string_view name, float defaultValue) const {
        if constexpr (std::is_same_v<T, float>)
            return table.GetFloatTexture(params, name, defaultValue);
        else
            return table.GetSpectrumTexture(params, name, Spectrum(defaultValue));
    }

  private:
    std::map<std::string, Image> images_;
    std::map<TexelKey, std::shared_ptr<const Texels<float>>> floatTexels_;
    std::map<TexelKey, std::shared_ptr<const Texels<Spectrum>>> spectrumTexels_;
};

// A plain value of the texture's type.
template <class T>
T FindValue(const ParamSet &params, std::string_view name, float defaultValue) {
    if constexpr (std::is_same_v<T, float>)
        return params.FindFloat(name, defaultValue);
    else
        return params.FindSpectrum(name, Spectrum(defaultValue));
}

// Each maker reads its parameters from e and throws Error at the one that is wrong. T: float and Spectrum.
// In procedural_textures.cpp:
template <class T>
TexturePtr<T> MakeCheckerboard(const TextureEntity &e, TextureContext &context);
template <class T>
TexturePtr<T> MakeBilerp(const TextureEntity &e, TextureContext &context);
TexturePtr<Spectrum> MakeUV(const TextureEntity &e, TextureContext &context);
template <class T>
TexturePtr<T> MakeDots(const TextureEntity &e, TextureContext &context);
template <class T>
TexturePtr<T> MakeFBm(const TextureEntity &e, TextureContext &context);
template <class T>
TexturePtr<T> MakeWrinkled(const TextureEntity &e, TextureContext &context);
template <class T>
TexturePtr<T> MakeWindy(const TextureEntity &e, TextureContext &context);
TexturePtr<Spectrum> MakeMarble(const TextureEntity &e, TextureContext &context);
// In image_texture.cpp:
inline constexpr std::array<std::string_view, 3> kImageWraps = {"repeat", "black", "clamp"}; // of "wrap"
template <class T>
TexturePtr<T> MakeImageMap(const TextureEntity &e, TextureContext &context);

} // namespace cuticle
