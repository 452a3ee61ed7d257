// Reconstruction filters, and sampling the film by them.
#pragma once

#include "parser/scene_description.h"

#include <vector>

namespace cuticle {

enum class FilterKind : uint8_t { Box, Triangle, Gaussian, Mitchell, Sinc };

// A place in the filter's footprint, relative to the pixel's centre (in pixels), and the weight of a sample
// taken there: exactly 1 for filters that are nowhere negative, else the sign of the filter there times the
// ratio of the integrals of |f| and f.
struct FilterSample {
    Point2f offset;
    float weight = 1;
};

// f(x, y) = g(x) g(y) on |x| <= radius.x, |y| <= radius.y, 0 outside. Drawing offsets in proportion to |f|,
// the mean of weight * L has the expectation of pbrt-v3's filtered pixel, integral of f L over integral of f,
// and every sample is used by one pixel alone (Ernst et al. 2006). Mean weight is 1; a film that divides by
// the sum of weights keeps constants exact under mitchell and sinc too.
class Filter {
  public:
    // alpha: gaussian; b, c: mitchell; tau: sinc. Error if a radius is not above 0 or the integral is not.
    struct Parameters {
        Vector2f radius{0.5f, 0.5f};
        float alpha = 2, b = 1.f / 3, c = 1.f / 3, tau = 3;
    };
    Filter() : Filter(FilterKind::Box, Parameters{}) {}
    Filter(FilterKind kind, const Parameters &parameters);

    float Evaluate(Point2f p) const; // not normalised, pbrt-v3's values
    double Integral() const { return integral_; }
    double AbsIntegral() const { return absIntegral_; } // of |f|
    FilterSample Sample(Point2f u) const;               // u in [0,1)^2
    FilterKind Kind() const { return kind_; }
    Vector2f Radius() const { return parameters_.radius; }

  private:
    // |g| at equal steps over one axis, linear between, and its running integral.
    struct Axis {
        double radius = 0, tabulated = 0; // tabulated: what lies farther out is nothing
        double integral = 0, absIntegral = 0;
        std::vector<float> density, cdf;
        std::vector<uint32_t> guide; // the last step whose cdf is at most i / guide.size()
    };
    double Evaluate1D(double x, double radius) const;
    void Tabulate(Axis *axis) const; // given its radius
    float Sample1D(const Axis &axis, float u, float *sign) const;

    FilterKind kind_;
    Parameters parameters_;
    Axis axis_[2];
    double integral_ = 0, absIntegral_ = 0;
    float weight_ = 1;
};

// PixelFilter directives, with pbrt-v3's names, parameters (xwidth ywidth, alpha, B C, tau) and defaults. An
// unknown name is an Error.
Filter MakeFilter(const Entity &entity);

} // namespace cuticle
