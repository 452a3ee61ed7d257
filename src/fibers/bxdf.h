//> Declare what a scattering function offers
// pbrt-v3's names and signatures.
#pragma once

#include "core/color.h"

#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <utility>

namespace cuticle {

//> Sort scattering into kinds
enum BxDFType {
    BSDF_REFLECTION = 1 << 0,
    BSDF_TRANSMISSION = 1 << 1,
    BSDF_DIFFUSE = 1 << 2,
    BSDF_GLOSSY = 1 << 3,
    BSDF_SPECULAR = 1 << 4,
    BSDF_ALL = BSDF_DIFFUSE | BSDF_GLOSSY | BSDF_SPECULAR | BSDF_REFLECTION | BSDF_TRANSMISSION,
};
//<

//> Evaluate, sample and weigh a pair of directions
// Directions are unit vectors in the local frame of the surface point and point away from it: z the normal;
// for a fiber x the tangent from root to tip and y across the width.
class BxDF {
  public:
    explicit BxDF(BxDFType t) : type(t) {}
    virtual ~BxDF() = default;
    // The value of the BSDF, 1/sr, without the cosine.
    virtual Spectrum f(const Vector3f &wo, const Vector3f &wi) const = 0;
    // Chooses wi from u in [0,1)^2; returns f and the density *pdf in 1/sr. *pdf = 0: no direction.
    virtual Spectrum Sample_f(const Vector3f &wo, Vector3f *wi, const Point2f &u, Float *pdf,
                              BxDFType *sampledType = nullptr) const = 0;
    // The density with which Sample_f chooses wi, 1/sr.
    virtual Float Pdf(const Vector3f &wo, const Vector3f &wi) const = 0;
    virtual std::string ToString() const = 0;

    const BxDFType type;
};
//<

//> Say what every model of a fiber offers beyond that
// Scatters over the whole sphere; needs four random numbers for a direction; gives value and density in one
// evaluation. pbrt-v3's methods are made of these two.
class FiberBxDF : public BxDF {
  public:
    FiberBxDF() : BxDF(static_cast<BxDFType>(BSDF_GLOSSY | BSDF_REFLECTION | BSDF_TRANSMISSION)) {}
    // f without the cosine |wi.z|, which the renderer multiplies by (where |wi.z| < 1e-20 it is taken as
    // 1e-20), and the density of Sample_f in *pdf.
    virtual Spectrum FPdf(const Vector3f &wo, const Vector3f &wi, Float *pdf) const = 0;
    // Chooses wi from four numbers in [0, 1). *pdf = 0 (and f black): no direction.
    virtual Spectrum Sample_f(const Vector3f &wo, Vector3f *wi, const std::array<Float, 4> &u,
                              Float *pdf) const = 0;

    Spectrum f(const Vector3f &wo, const Vector3f &wi) const final;
    Float Pdf(const Vector3f &wo, const Vector3f &wi) const final;
    // The four numbers are the halves of u (DemuxFloat), which holds only 2 x 24 bits: prefer the other.
    Spectrum Sample_f(const Vector3f &wo, Vector3f *wi, const Point2f &u, Float *pdf,
                      BxDFType *sampledType = nullptr) const final;

  protected:
    // f |wi.z|, as fiber models compute it, without the cosine.
    static Spectrum WithoutCosine(const std::array<Float, 3> &fCos, const Vector3f &wi);
    // The same for a sampled direction, which is first moved to where its cosine is not 0. Black where the
    // density has underflowed to 0: there is no such sample.
    static Spectrum WithoutCosineOfSample(const std::array<Float, 3> &fCos, Float pdf, Vector3f *wi);
};
//<

//> Hold any model of a fiber in place
// Whoever keeps a fiber's model needs to know none of them: no header of a model, no heap. Empty at first.
class FiberStorage {
  public:
    static constexpr size_t kBytes = 1024;

    FiberStorage() = default;
    FiberStorage(const FiberStorage &other) : copy_(other.copy_) {
        fiber_ = other.fiber_ ? copy_(*other.fiber_, bytes_) : nullptr;
    }
    FiberStorage &operator=(const FiberStorage &) = delete;
    ~FiberStorage() {
        if (fiber_)
            fiber_->~FiberBxDF();
    }
    // Replaces what it holds by Model(args...). Tables that the model refers to must outlive it.
    template <class Model, class... Args>
    const Model &Emplace(Args &&...args) {
        static_assert(sizeof(Model) <= kBytes && alignof(Model) <= kAlignment);
        if (fiber_)
            std::exchange(fiber_, nullptr)->~FiberBxDF();
        const auto *model = new (bytes_) Model(std::forward<Args>(args)...);
        fiber_ = model;
        copy_ = [](const FiberBxDF &from, void *to) -> const FiberBxDF * {
            return new (to) Model(static_cast<const Model &>(from));
        };
        return *model;
    }
    // Null if there is none.
    const FiberBxDF *Get() const { return fiber_; }

  private:
    static constexpr size_t kAlignment = 16;
    alignas(kAlignment) std::byte bytes_[kBytes];
    const FiberBxDF *fiber_ = nullptr;
    const FiberBxDF *(*copy_)(const FiberBxDF &from, void *to) = nullptr;
};
//<

//> Turn a numeric model into a BSDF
// Model::Evaluate(wo, wi) and Model::Sample(wo, u, &wi) give a FiberValue. Numbers of a direction, or of u,
// that are not finite pass through minima and maxima unseen: nanTaint, 0 or NaN, carries them into the
// results, to be counted there.
template <typename T>
struct FiberValue {
    std::array<T, 3> fCos; // f |wi.z| in r, g, b
    T pdf;                 // 1/sr
};

template <class Model>
class BxDFOf : public FiberBxDF {
  public:
    using FiberBxDF::Sample_f;
    Spectrum FPdf(const Vector3f &wo, const Vector3f &wi, Float *pdf) const final {
        const FiberValue<Float> value = model_.Evaluate(wo, wi);
        const Float nanTaint = 0 * ((wo.x + wo.y + wo.z) + (wi.x + wi.y + wi.z));
        *pdf = value.pdf + nanTaint;
        return WithoutCosine(value.fCos, wi) + Spectrum(nanTaint);
    }
    Spectrum Sample_f(const Vector3f &wo, Vector3f *wi, const std::array<Float, 4> &u,
                      Float *pdf) const final {
        std::array<Float, 4> inside;
        for (size_t i = 0; i < 4; ++i)
            inside[i] = std::min(std::max(u[i], kMinU), OneMinusEpsilon);
        const FiberValue<Float> value = model_.Sample(wo, inside, wi);
        const Float nanTaint = 0 * ((wo.x + wo.y + wo.z) + ((u[0] + u[1]) + (u[2] + u[3])));
        *wi += Vector3f(nanTaint, nanTaint, nanTaint);
        *pdf = value.pdf + nanTaint;
        return WithoutCosineOfSample(value.fCos, value.pdf, wi) + Spectrum(nanTaint);
    }
    const Model &Numeric() const { return model_; }

  protected:
    explicit BxDFOf(const Model &model) : model_(model) {}
    const Model model_;
};
//<

//> Offer a model in double
// Value and density of a model by whatever code, behind one interface: references of charts and of the atlas.
class FiberInDouble {
  public:
    virtual ~FiberInDouble() = default;
    virtual FiberValue<double> Evaluate(const Vector3d &wo, const Vector3d &wi) const = 0;
    // Chooses *wi from four numbers in [0, 1). pdf 0: none.
    virtual FiberValue<double> Sample(const Vector3d &wo, const std::array<double, 4> &u,
                                      Vector3d *wi) const = 0;
};
// Any numeric model in double. table: what it looks things up in, kept as long as this.
template <class Model>
class NumericFiber final : public FiberInDouble {
  public:
    explicit NumericFiber(const Model &model, std::shared_ptr<const void> table = nullptr)
        : model_(model), table_(std::move(table)) {}
    FiberValue<double> Evaluate(const Vector3d &wo, const Vector3d &wi) const override {
        const auto value = model_.Evaluate(wo, wi);
        return {value.fCos, value.pdf};
    }
    FiberValue<double> Sample(const Vector3d &wo, const std::array<double, 4> &u,
                              Vector3d *wi) const override {
        const auto value = model_.Sample(wo, u, wi);
        return {value.fCos, value.pdf};
    }

  private:
    Model model_;
    std::shared_ptr<const void> table_;
};
template <class Model>
std::unique_ptr<FiberInDouble> InDouble(const Model &model, std::shared_ptr<const void> table = nullptr) {
    return std::make_unique<NumericFiber<Model>>(model, std::move(table));
}
//<

} // namespace cuticle
//<
