// The scattering at one surface point: a hair model, or a few lobes for everything that is not hair.
#pragma once

#include "core/error.h"
#include "fibers/bxdf.h"
#include "materials/surface_lobes.h"

#include <span>
#include <string_view>
#include <variant>

namespace cuticle {

// This is where the model of a fiber comes from, for whoever has to tell that it gave no number.
struct FiberOrigin {
    FileLoc loc; // of the material
    std::string_view model;
};

// These are fibers of one hit, met at other offsets across its width. The mean over the width is what a ray
// sees that is wider than the fiber.
struct FiberStrata {
    static constexpr size_t kMost = 7;
    std::array<FiberStorage, kMost> others;
};

class BSDF {
  public:
    // x, y, z: shading frame; n: geometric normal on the same side as the shading one.
    void SetFrame(const Frame &shading, const Normal3f &n) { frame_ = shading, n_ = n; }
    const Frame &ShadingFrame() const { return frame_; }
    // For the model of a fiber, which the caller emplaces.
    FiberStorage &SetFiber() { return model_.template emplace<FiberStorage>(); }
    // Asks whoever makes a fiber for the mean over this many offsets (1 to FiberStrata::kMost + 1), spread
    // evenly from that of the hit. *strata holds all but the first and must outlive the BSDF.
    void AskForMean(FiberStrata *strata, size_t offsets) { strata_ = strata, asked_ = offsets; }
    // For a material whose model depends on the offset, after SetFiber: the others, to be emplaced.
    std::span<FiberStorage> SetOtherFibers() {
        others_ = strata_ ? std::span(strata_->others).first(asked_ - 1) : std::span<FiberStorage>();
        return others_;
    }
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
    // f and its density of the fiber, in the local frame: the mean over all offsets.
    Spectrum FiberFPdf(const FiberBxDF &fiber, const Vector3f &wo, const Vector3f &wi, float *pdf) const;
    Spectrum SampleFiber(const FiberBxDF &fiber, const Vector3f &wo, const std::array<float, 4> &u,
                         Vector3f *wi, float *pdf) const;
    void Check(const Spectrum &f, float pdf) const {
        if (!std::isfinite(f[0] + f[1] + f[2] + pdf))
            TellNotFinite(f, pdf);
    }
    void TellNotFinite(const Spectrum &f, float pdf) const;

    Frame frame_;
    Normal3f n_;
    Spectrum scale_{1};
    const FiberOrigin *origin_ = nullptr;
    FiberStrata *strata_ = nullptr;
    size_t asked_ = 1;
    std::span<FiberStorage> others_;
    std::variant<std::monostate, SurfaceLobes, FiberStorage> model_;
};

} // namespace cuticle
