//> Define random numbers, warps and tabulated distributions
#include "core/sampling.h"

#include "core/error.h"

#include <bit>
#include <string>

namespace cuticle {

//> Split one random number into two
namespace {
//> Gather the even bits of a 64-bit word
// Pairs of bits close up, then pairs of pairs, until the 32 bits of even rank lie side by side.
constexpr uint32_t EvenBits(uint64_t v) {
    v &= 0x5555555555555555ull;
    v = (v | (v >> 1)) & 0x3333333333333333ull;
    v = (v | (v >> 2)) & 0x0f0f0f0f0f0f0f0full;
    v = (v | (v >> 4)) & 0x00ff00ff00ff00ffull;
    v = (v | (v >> 8)) & 0x0000ffff0000ffffull;
    return static_cast<uint32_t>(v | (v >> 16));
}
//<
} // namespace

Point2f DemuxFloat(Float u) {
    if (std::isnan(u))
        return {u, u};
    u = std::clamp(u, 0.f, OneMinusEpsilon);
    //> Write $u$ with 46 binary places, the unknown ones filled from a hash
    // u 2^46 is exact in a double. What lies below the last place of u is open: any number there is the same
    // u.
    const double scaled = std::ldexp(static_cast<double>(u), 46);
    const double spacing =
        std::ldexp(static_cast<double>(std::nextafter(u, 1.f)) - static_cast<double>(u), 46);
    const auto cell = static_cast<uint64_t>(std::max(spacing, 1.));
    const uint64_t hash = MixBits(std::bit_cast<uint32_t>(u) + 0x9e3779b97f4a7c15ull);
    const uint64_t bits = static_cast<uint64_t>(scaled) | (hash & (cell - 1));
    //<
    //> Place each half at the middle of its cell of width $2^{-23}$
    const auto place = [](uint32_t half) { return (static_cast<float>(half) + 0.5f) * 0x1p-23f; };
    return {place(EvenBits(bits)), place(EvenBits(bits >> 1))};
    //<
}
//<

//> Warp the square to the disk
Point2f ConcentricSampleDisk(const Point2f &u) {
    const Float x = 2 * u.x - 1, y = 2 * u.y - 1;
    if (x == 0 && y == 0)
        return {0, 0};
    // Squares around the centre become circles: the longer coordinate is the radius, the shorter one the
    // angle.
    if (std::abs(x) > std::abs(y)) {
        const Float phi = (Pi / 4) * (y / x);
        return {x * std::cos(phi), x * std::sin(phi)};
    }
    const Float phi = (Pi / 4) * (x / y);
    return {y * std::sin(phi), y * std::cos(phi)};
}
//<

//> Warp the square to hemisphere, sphere and cone
Vector3f CosineSampleHemisphere(const Point2f &u) {
    const Point2f d = ConcentricSampleDisk(u);
    return {d.x, d.y, std::sqrt(std::max(0.f, 1 - d.x * d.x - d.y * d.y))};
}
// Archimedes: equal steps of z hold equal areas, so these three differ only in the range of z. 1 - z is the
// number that is sampled, and sin^2 = (1 - z)(1 + z) keeps its precision near the pole.
Vector3f UniformSampleCone(const Point2f &u, Float cosThetaMax) {
    const Float oneMinusZ = u.x * (1 - cosThetaMax);
    const Float r = std::sqrt(std::max(0.f, oneMinusZ * (2 - oneMinusZ)));
    const Float phi = 2 * Pi * u.y;
    return {r * std::cos(phi), r * std::sin(phi), 1 - oneMinusZ};
}
Vector3f UniformSampleHemisphere(const Point2f &u) { return UniformSampleCone(u, 0); }
Vector3f UniformSampleSphere(const Point2f &u) { return UniformSampleCone(u, -1); }
//<

//> Warp the square to a triangle
Point2f UniformSampleTriangle(const Point2f &u) {
    const Float root = std::sqrt(u.x), x = 1 - root;
    return {x, std::min(u.y * root, 1 - x)}; // the third is not negative, though 1 - root was rounded
}
//<

//> Tabulate a one-dimensional density
Distribution1D::Distribution1D(const Float *f, size_t n) : func_(f, f + n), cdf_(n + 1) {
    const double cells = static_cast<double>(n);
    //> Sum the function, in double
    double sum = 0;
    for (const Float value : func_) {
        if (!(value >= 0 && value < Infinity))
            throw Error("a tabulated density has the value {:f}", value)
                .WithRemedy("it must be finite and not negative");
        sum += static_cast<double>(value);
    }
    integral_ = static_cast<Float>(sum / cells);
    //<
    //> Without any mass, be uniform
    if (sum == 0) {
        std::fill(func_.begin(), func_.end(), 1.f);
        sum = cells;
    }
    //<
    //> Scale the function to a density and sum it up to the distribution function
    // Values so small that their density underflows are never chosen; values whose sum exceeds binary32 are
    // fine.
    double below = 0;
    for (size_t i = 0; i < func_.size(); ++i) {
        cdf_[i] = static_cast<Float>(below / sum);
        below += static_cast<double>(func_[i]);
        func_[i] = static_cast<Float>(static_cast<double>(func_[i]) / sum * cells);
    }
    cdf_.back() = 1;
    //<
}

//> Find the cell of a random number by bisection
size_t Distribution1D::FindCell(Float u) const {
    // The last cell that begins at or before u: cells of width zero are passed over. u < 1 = cdf_.back(), so
    // trailing cells of width zero are never met.
    // NaN finds the first cell, and stays in the place within it.
    u = std::min(std::max(0.f, u), OneMinusEpsilon);
    const auto after = std::upper_bound(cdf_.begin(), cdf_.end(), u);
    return static_cast<size_t>(after - cdf_.begin()) - 1;
}
//<

//> Sample the one-dimensional density
Float Distribution1D::Density(size_t cell) const { return func_[cell]; }

size_t Distribution1D::SampleDiscrete(Float u, Float *probability, Float *uRemapped) const {
    const size_t cell = FindCell(u);
    const Float low = cdf_[cell], high = cdf_[cell + 1];
    if (probability)
        *probability = DiscretePDF(cell);
    if (uRemapped)
        *uRemapped = std::clamp((u - low) / (high - low), 0.f, OneMinusEpsilon);
    return cell;
}

Float Distribution1D::SampleContinuous(Float u, Float *pdf, size_t *offset) const {
    Float within = 0;
    const size_t cell = SampleDiscrete(u, nullptr, &within);
    if (pdf)
        *pdf = Density(cell);
    if (offset)
        *offset = cell;
    Float x = std::min((static_cast<Float>(cell) + within) / static_cast<Float>(Count()), OneMinusEpsilon);
    // At a border rounding may reach the next cell, whose density is another one, or 0
    if (CellAt(x) > cell)
        x = std::nextafter(x, 0.f);
    if (CellAt(x) < cell)
        x = std::nextafter(x, 1.f);
    return x;
}

size_t Distribution1D::CellAt(Float x) const {
    const Float n = static_cast<Float>(Count());
    return static_cast<size_t>(std::min(std::max(0.f, x * n), n - 1));
}
Float Distribution1D::Pdf(Float x) const { return Density(CellAt(x)); }
//<
//<

//> Tabulate and sample a two-dimensional density
std::vector<Distribution1D> Distribution2D::Rows(const Float *f, size_t nu, size_t nv) {
    std::vector<Distribution1D> rows;
    rows.reserve(nv);
    for (size_t v = 0; v < nv; ++v)
        rows.emplace_back(f + v * nu, nu);
    return rows;
}

std::vector<Float> Distribution2D::RowIntegrals(const std::vector<Distribution1D> &rows) {
    std::vector<Float> integrals;
    integrals.reserve(rows.size());
    for (const Distribution1D &row : rows)
        integrals.push_back(row.Integral());
    return integrals;
}

Distribution2D::Distribution2D(const Float *f, size_t nu, size_t nv)
    : conditional_(Rows(f, nu, nv)), marginal_(RowIntegrals(conditional_).data(), nv) {}

Point2f Distribution2D::SampleContinuous(const Point2f &u, Float *pdf) const {
    Float pdfU = 0, pdfV = 0;
    size_t row = 0;
    const Float v = marginal_.SampleContinuous(u.y, &pdfV, &row);
    const Float x = conditional_[row].SampleContinuous(u.x, &pdfU);
    if (pdf)
        *pdf = pdfU * pdfV;
    return {x, v};
}

Float Distribution2D::Pdf(const Point2f &p) const {
    const Float nv = static_cast<Float>(marginal_.Count());
    const size_t row = static_cast<size_t>(std::min(std::max(0.f, p.y * nv), nv - 1));
    return conditional_[row].Pdf(p.x) * marginal_.Pdf(p.y);
}
//<

} // namespace cuticle
//<
