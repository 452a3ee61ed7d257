//> Declare random numbers, warps and tabulated distributions
#pragma once

#include "core/vecmath.h"

#include <vector>

namespace cuticle {

//> Mix the bits of an integer
// A bijection of the 64-bit integers whose output bits all depend on all input bits (the finaliser of
// SplitMix64, Steele et al. 2014). 0 maps to 0.
constexpr uint64_t MixBits(uint64_t v) {
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
    return v ^ (v >> 31);
}
//<

//> Draw pseudo-random numbers from a permuted congruential generator
// PCG-XSH-RR of O'Neill 2014: 64 bits of state, 32 bits out, one stream of period 2^64 for each seq (of which
// the low 63 bits count). offset chooses where in the stream to start. Cheap to construct.
class RNG {
  public:
    explicit RNG(uint64_t seq, uint64_t offset = 0) : increment_((seq << 1) | 1) {
        Advance();
        state_ += MixBits(seq) + offset;
        Advance();
    }
    uint32_t UniformUInt32() {
        const uint64_t old = state_;
        Advance();
        const auto xorShifted = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
        const auto rotation = static_cast<uint32_t>(old >> 59);
        return (xorShifted >> rotation) | (xorShifted << ((32 - rotation) & 31));
    }
    // In [0, OneMinusEpsilon].
    float UniformFloat() { return std::min(OneMinusEpsilon, static_cast<float>(UniformUInt32()) * 0x1p-32f); }

  private:
    void Advance() { state_ = state_ * 6364136223846793005ull + increment_; }
    uint64_t state_ = 0, increment_;
};
//<

//> Declare how one random number becomes two
// Splits u into two numbers in (0, 1), the even bits and the odd bits of u (Pharr 2016, section 1.4.2, there
// called demultiplexing). u is clamped to [0, OneMinusEpsilon]; NaN gives two NaNs. A binary32 in [0.5, 1)
// has only 2^12 * 2^11 different halves: the bits that u cannot hold are filled from a hash of u, so that the
// results lie spread inside their cells and are never exactly 0 or 1. Where a sampler has real dimensions to
// spare, use those instead.
Point2f DemuxFloat(Float u);
//<

//> Declare the warps of the unit square
// u in [0,1]^2. Every warp keeps areas, so stratified points stay stratified; directions have |z| up the
// pole.
Point2f ConcentricSampleDisk(const Point2f &u); // uniform on the unit disk; Shirley and Chiu 1997
Vector3f CosineSampleHemisphere(const Point2f &u);
Vector3f UniformSampleHemisphere(const Point2f &u);
Vector3f UniformSampleSphere(const Point2f &u);
// Uniform in the cone around +z with cos theta >= cosThetaMax in [-1, 1].
Vector3f UniformSampleCone(const Point2f &u, Float cosThetaMax);
// The first two barycentric coordinates of a uniform point in a triangle (the third is 1 - x - y).
Point2f UniformSampleTriangle(const Point2f &u);
//<

//> Give the densities of the warps, in 1/sr
inline Float CosineHemispherePdf(Float cosTheta) { return std::max(cosTheta, 0.f) / Pi; }
inline Float UniformHemispherePdf() { return 1 / (2 * Pi); }
inline Float UniformSpherePdf() { return 1 / (4 * Pi); }
// Infinite for the empty cone cosThetaMax = 1.
inline Float UniformConePdf(Float cosThetaMax) { return 1 / (2 * Pi * (1 - cosThetaMax)); }
//<

//> Weigh two sampling strategies by the power heuristic
// pdfA^2 / (pdfA^2 + pdfB^2), Veach 1997 with exponent 2: the weight of a sample that was drawn from A.
// Formed from the ratio of the densities, so that neither squares overflow nor an infinite density gives NaN:
// infinity against a finite density weighs 1, two infinities weigh a half, pdfA = 0 weighs 0. NaN in gives
// NaN out.
inline Float PowerHeuristic(Float pdfA, Float pdfB) {
    if (pdfA == 0)
        return std::isnan(pdfB) ? pdfB : 0;
    if (pdfA == pdfB)
        return 0.5f;
    if (pdfA > pdfB) {
        const Float ratio = pdfB / pdfA;
        return 1 / (1 + ratio * ratio);
    }
    const Float ratio = pdfA / pdfB;
    return ratio * ratio / (1 + ratio * ratio);
}
//<

//> Declare a piecewise constant density on the unit interval
// pbrt-v3's Distribution1D: n equal cells over [0,1), each as likely as its function value, which must be
// finite and not negative (else Error). A function that is zero everywhere is taken as constant. n >= 1.
class Distribution1D {
  public:
    Distribution1D(const Float *f, size_t n);
    size_t Count() const { return func_.size(); }
    // The integral over [0,1] of the function as given: 0 if it is zero everywhere.
    Float Integral() const { return integral_; }
    // x in [0,1) with density *pdf at x; *offset: the cell. u in [0,1).
    Float SampleContinuous(Float u, Float *pdf, size_t *offset = nullptr) const;
    // A cell, with its probability, and u stretched over the cell for reuse.
    size_t SampleDiscrete(Float u, Float *probability = nullptr, Float *uRemapped = nullptr) const;
    Float DiscretePDF(size_t cell) const { return Density(cell) / static_cast<Float>(Count()); }
    // The density of SampleContinuous at x; x outside [0,1] counts as the nearest end.
    Float Pdf(Float x) const;

  private:
    Float Density(size_t cell) const;
    size_t FindCell(Float u) const;
    size_t CellAt(Float x) const; // that holds x; an x outside [0,1] counts as the nearest end
    std::vector<Float> func_, cdf_;
    Float integral_ = 0;
};
//<

//> Declare a piecewise constant density on the unit square
// pbrt-v3's Distribution2D: rows of f are v, nu values each; row v is chosen first, then u within it.
class Distribution2D {
  public:
    Distribution2D(const Float *f, size_t nu, size_t nv);
    // A point with density *pdf, relative to area on [0,1)^2. u in [0,1)^2.
    Point2f SampleContinuous(const Point2f &u, Float *pdf) const;
    Float Pdf(const Point2f &p) const;
    // The mean of f over the square.
    Float Integral() const { return marginal_.Integral(); }

  private:
    static std::vector<Float> RowIntegrals(const std::vector<Distribution1D> &rows);
    static std::vector<Distribution1D> Rows(const Float *f, size_t nu, size_t nv);
    std::vector<Distribution1D> conditional_;
    Distribution1D marginal_;
};
//<

} // namespace cuticle
//<
