// Textures: values of parameters that vary over surfaces.
#pragma once

#include "materials/interaction.h"
#include "parser/plugins.h"
#include "parser/scene_description.h"

#include <memory>
#include <string_view>
#include <vector>

namespace cuticle {

// A parameter that varies over surfaces; T is float or Spectrum. Evaluate() is safe from any number of
// threads. A coordinate that is NaN gives NaN.
template <class T>
class Texture {
  public:
    virtual ~Texture() = default;
    virtual T Evaluate(const TexturePoint &point) const = 0;
};

template <class T>
class ConstantTexture final : public Texture<T> {
  public:
    explicit ConstantTexture(const T &value) : value_(value) {}
    T Evaluate(const TexturePoint &) const override { return value_; }

  private:
    T value_;
};

// The table of texture classes, in texture.cpp.
const PluginTable &TexturePlugins();

// The textures that a scene declares, made in the order of the file, and the look-up of parameters that may
// be a value or a texture. An image file that several textures use is read once.
//
// Images are looked up bilinearly at one point a camera sample. Many samples a pixel filter the picture
// instead of pbrt-v3's MIP maps, so that the parameters of its filters ("trilinear", "maxanisotropy",
// "aamode") are read and have no effect. For the same reason fbm, windy, wrinkled, marble and dots sum all
// octaves of their noise (see noise.h).
//
// "strandcolor" is ours: the colour that a groom gives the strand at that place (its luminance as a float
// texture), and "default" (0.5) on all other surfaces.
//
// Throws Error with the place in the scene file for an unknown class, mapping or wrap mode; an image that is
// missing or damaged; octaves below 0 or above 100; uv and marble declared as float, which pbrt-v3 does not
// have either.
class TextureTable {
  public:
    TextureTable() = default;
    TextureTable(const std::vector<TextureEntity> &floatTextures,
                 const std::vector<TextureEntity> &spectrumTextures);

    // The texture bound to a parameter, or a constant of its value or of the default; marks the parameter as
    // used. Error at the parameter when its texture does not exist or is of the other kind. Never null.
    std::shared_ptr<const Texture<float>> GetFloatTexture(const ParamSet &params, std::string_view name,
                                                          float defaultValue) const;
    std::shared_ptr<const Texture<Spectrum>> GetSpectrumTexture(const ParamSet &params, std::string_view name,
                                                                const Spectrum &defaultValue) const;

    // The texture of an index into SceneDescription::floatTextures or spectrumTextures.
    std::shared_ptr<const Texture<float>> FloatTexture(size_t index) const { return floats_.at(index); }
    std::shared_ptr<const Texture<Spectrum>> SpectrumTexture(size_t index) const {
        return spectra_.at(index);
    }

    size_t ImageFilesRead() const { return imageFilesRead_; }

  private:
    std::vector<std::shared_ptr<const Texture<float>>> floats_;
    std::vector<std::shared_ptr<const Texture<Spectrum>>> spectra_;
    size_t imageFilesRead_ = 0;
};

} // namespace cuticle
