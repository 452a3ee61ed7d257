// The scattering at one surface point: a hair model, or a few lobes for everything that is not hair.
#pragma once

#include "core/error.h"
#include "fibers/bxdf.h"
#include "materials/surface_lobes.h"

#include <string_view>
#include <variant>

namespace cuticle {

// This is where the model of a fiber comes from, for whoever has to tell that it gave no number.
struct FiberOrigin {
    FileLoc loc; // of the material
    std::string_view model;
};

class BSDF {
  public:
    // x, y, z: shading frame; n: geometric normal on the same side as the shading one.
    void SetFrame(const Frame &shading, const Normal3f &n) { frame_ = shading, n_ = n; }
    const Frame &ShadingFrame() const { return frame_; }
    // For the model of a fiber, which the caller emplaces.
    FiberStorage &SetFiber() { return model_.template emplace<FiberStorage>(); }
    // origin must outlive the BSDF; null: not known.
    void SetFiberOrigin(const FiberOrigin *origin) { origin_ = origin; }
    SurfaceLobes &SetSurface() { return model_.template emplace<SurfaceLobes>(); }

    // A factor on everything that the model scatters, 1 at first.
    void SetScale(const Spectrum &scale) { scale_ = scale; }
    const Spectrum &Scale() const { return scale_; }

    // True if light sampling can contribute.
    bool HasNonSpecular() const;
    bool IsHair() const { return Fiber() != nullptr; }
    // The model of a fiber; null for everything else.
    const FiberBxDF *Fiber() const {
        const auto *fiber = std::get_if<FiberStorage>(&model_);
        return fiber ? fiber->Get() : nullptr;
    }
    // f times |cos theta_i| and the density of Sample_f, for world directions of unit length. Where a
    // fiber's model gives a number that is not finite, here or in Sample_f, a Warning says which model and
    // from where, and the number goes on into the sample, which the film then counts.
    Spectrum FCos(const Vector3f &woW, const Vector3f &wiW, float *pdf) const;
    // Chooses a direction; weight = f |cos| / pdf. False where there is none.
    bool Sample_f(const Vector3f &woW, const std::array<float, 4> &u, BSDFSample *sample,
                  Spectrum *weight) const;

  private:
    void Check(const Spectrum &f, float pdf) const {
        if (!std::isfinite(f[0] + f[1] + f[2] + pdf))
            TellNotFinite(f, pdf);
    }
    void TellNotFinite(const Spectrum &f, float pdf) const;

    Frame frame_;
    Normal3f n_;
    Spectrum scale_{1};
    const FiberOrigin *origin_ = nullptr;
    std::variant<std::monostate, SurfaceLobes, FiberStorage> model_;
};

} // namespace cuticle
