// The scattering at one surface point: a hair model, or a few lobes for everything that is not hair.
#pragma once

#include "fibers/deon.h"
#include "fibers/hair.h"
#include "fibers/kajiya_kay.h"
#include "fibers/marschner.h"
#include "fibers/tabulated.h"
#include "materials/surface_lobes.h"

#include <variant>

namespace cuticle {

class BSDF {
  public:
    // x, y, z: shading frame; n: geometric normal on the same side as the shading one.
    void SetFrame(const Frame &shading, const Normal3f &n) { frame_ = shading, n_ = n; }
    const Frame &ShadingFrame() const { return frame_; }
    template <class... Args>
    void SetHair(Args &&...args) {
        model_.template emplace<HairBSDF>(std::forward<Args>(args)...);
    }
    // Any other model of a fiber, one of those in model_.
    template <class Model, class... Args>
    void SetFiber(Args &&...args) {
        model_.template emplace<Model>(std::forward<Args>(args)...);
    }
    SurfaceLobes &SetSurface() { return model_.template emplace<SurfaceLobes>(); }

    // A factor on everything that the model scatters, 1 at first.
    void SetScale(const Spectrum &scale) { scale_ = scale; }
    const Spectrum &Scale() const { return scale_; }

    // True if light sampling can contribute.
    bool HasNonSpecular() const;
    bool IsHair() const { return std::holds_alternative<HairBSDF>(model_) || Fiber(); }
    // The model of a fiber; null for everything else.
    const FiberBxDF *Fiber() const {
        return std::visit(
            [](const auto &model) -> const FiberBxDF * {
                if constexpr (std::is_base_of_v<FiberBxDF, std::decay_t<decltype(model)>>)
                    return &model;
                else
                    return nullptr;
            },
            model_);
    }
    // f times |cos theta_i| and the density of Sample_f, for world directions of unit length.
    Spectrum FCos(const Vector3f &woW, const Vector3f &wiW, float *pdf) const;
    // Chooses a direction; weight = f |cos| / pdf. False where there is none.
    bool Sample_f(const Vector3f &woW, const std::array<float, 4> &u, BSDFSample *sample,
                  Spectrum *weight) const;

  private:
    Frame frame_;
    Normal3f n_;
    Spectrum scale_{1};
    std::variant<std::monostate, SurfaceLobes, HairBSDF, KajiyaKayBSDF, MarschnerBSDF, DEonBSDF,
                 TabulatedDEonBSDF, ChosenLobesBSDF, TabulatedBSDF>
        model_;
};

} // namespace cuticle
