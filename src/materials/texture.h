// Textures: values of parameters that vary over surfaces.
#pragma once

#include "materials/interaction.h"
#include "parser/plugins.h"
#include "parser/scene_description.h"

#include <memory>
#include <string_view>
#include <vector>

namespace cuticle {

// Where a texture is looked up: a point in world space and the surface's (u, v) there; on a strand that has colours,
// those of its segment.
struct TexturePoint {
    Point3f p;
    Point2f uv;
    const StrandColors *strandColors = nullptr;
};

// T is float or Spectrum. Evaluate() is safe from any number of threads. A coordinate that is NaN gives NaN.
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

// The textures that a scene declares, made in the order of the file, and the look-up of parameters that may be either a
// value or a texture. An image file that several textures use is read once.
//
// Images are looked up bilinearly at one point a camera sample: many samples a pixel filter the picture, so that the
// parameters of pbrt-v3's filters ("trilinear", "maxanisotropy", "aamode") are read and have no effect.
//
// fbm, windy, wrinkled, marble and dots are made of Perlin's noise with pbrt-v3's values (see noise.h); all octaves of it
// are summed, for the same reason.
//
// Ours beyond pbrt-v3: "strandcolor", the colour that a groom gives the strand at that place (its luminance as a float
// texture); "default" (0.5) on all other surfaces.
//
// Throws Error with the place in the scene file for: an unknown class, mapping or wrap mode; an image that is missing
// or damaged; octaves below 0 or above 100; uv and marble declared as float, which pbrt-v3 has not either. ptex is one
// warning and the constant 0.5.
class TextureTable {
  public:
    TextureTable() = default;
    TextureTable(const std::vector<TextureEntity> &floatTextures,
                 const std::vector<TextureEntity> &spectrumTextures);

    // The texture bound to a parameter, or a constant of its value or of the default; marks the parameter as used.
    // Error at the parameter when its texture does not exist or is of the other kind. Never null.
    std::shared_ptr<const Texture<float>> GetFloatTexture(const ParamSet &params, std::string_view name,
                                                          float defaultValue) const;
    std::shared_ptr<const Texture<Spectrum>> GetSpectrumTexture(const ParamSet &params, std::string_view name,
                                                                const Spectrum &defaultValue) const;

    // By index into SceneDescription::floatTextures and spectrumTextures.
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
