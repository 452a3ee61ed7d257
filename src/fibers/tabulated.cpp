//> Define the tabulated model
#include "fibers/tabulated.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "fibers/fiber_angles.h"
#include "fibers/np.h"

#include <mutex>
#include <numeric>
#include <sstream>

namespace cuticle {

//> Find the cells of a viewer
SphereCells FiberTable::Cells(double thetaO) {
    SphereCells cells = {kRows, kColumns};
    cells.middle = -std::clamp(thetaO, -LastTheta(), LastTheta());
    return cells;
}
//<

//> Build a table
FiberTable::FiberTable(const FiberDescription &fiber, uint64_t samples) : fiber_(fiber) {
    for (size_t i = 1; i < Levels().size(); ++i)
        if (!(Levels()[i] > Levels()[i - 1]))
            throw Error("a table's absorptions must ascend");
    const size_t entries = kThetas * PhiCount(), planes = entries * Levels().size();
    shares_.resize(planes * kRows * kColumns), rowShares_.resize(planes * kRows), totals_.resize(planes);
    ParallelFor(entries, [&](size_t entry) { Fill(entry, samples); });
}
//<

//> Simulate one direction of the viewer
// The viewer sends the light: what would leave toward wi is what comes from there. The fiber is turned
// instead of the viewer, so that columns are phi_i - phi_o. A circle looks alike from both sides, which
// halves the noise.
void FiberTable::Fill(size_t entry, uint64_t samples) {
    const size_t iTheta = entry / PhiCount(), iPhi = entry % PhiCount(), channels = Levels().size();
    FiberLight viewer;
    viewer.theta = kPi<double> * ((static_cast<double>(iTheta) + 0.5) / kThetas - 0.5);
    FiberDescription turned = fiber_;
    turned.rotation = -kPi<double> / 2 * static_cast<double>(iPhi) / (kPhis - 1);
    FiberMeasurement measurement;
    measurement.samples = samples, measurement.seed = MixBits(entry + 1), measurement.orders = 1;
    measurement.cells = Cells(viewer.theta);
    const FiberHistogram seen = SimulateFiber(turned, viewer, measurement);
    for (size_t level = 0; level < channels; ++level) {
        const size_t plane = entry * channels + level;
        for (size_t row = 0; row < kRows; ++row) {
            const double solidAngle = measurement.cells.SolidAngle(row);
            for (size_t j = 0; j < kColumns; ++j) {
                double density = seen.Density(seen.Sum(), level, row, j);
                if (PhiCount() == 1)
                    density = (density + seen.Density(seen.Sum(), level, row, kColumns - 1 - j)) / 2;
                const auto share = static_cast<float>(density * solidAngle);
                shares_[(plane * kRows + row) * kColumns + j] = share;
                rowShares_[plane * kRows + row] += share;
            }
            totals_[plane] += rowShares_[plane * kRows + row];
        }
    }
}
std::span<const float> FiberTable::Shares(size_t entry, size_t level) const {
    return {shares_.data() + (entry * Levels().size() + level) * kRows * kColumns, kRows * kColumns};
}
std::span<const float> FiberTable::RowShares(size_t entry, size_t level) const {
    return {rowShares_.data() + (entry * Levels().size() + level) * kRows, kRows};
}
//<

//> Find the entries around a viewer
namespace {
// The lower neighbour of x on 0, 1, ..., n - 1, n >= 2, and the upper one's weight.
std::pair<size_t, float> Between(double x, size_t n) {
    const double clamped = x > 0 ? std::min(x, static_cast<double>(n - 1)) : 0; // NaN: 0
    const size_t low = std::min(static_cast<size_t>(clamped), n - 2);
    return {low, static_cast<float>(clamped - static_cast<double>(low))};
}
} // namespace
FiberTable::Place FiberTable::At(double thetaO, double phiO) const {
    Place place{{}, 0, {}, false};
    size_t phi = 0;
    float phiFraction = 0;
    if (PhiCount() > 1) {
        // A half turn changes nothing; a mirror image at an axis turns phi round.
        const double folded = std::remainder(phiO, kPi<double>);
        place.mirrored = folded < 0;
        std::tie(phi, phiFraction) = Between(std::abs(folded) * 2 / kPi<double> * (kPhis - 1), kPhis);
    }
    const auto [theta, thetaFraction] = Between((thetaO / kPi<double> + 0.5) * kThetas - 0.5, kThetas);
    for (size_t i = 0; i < 2; ++i)
        for (size_t j = 0; j < (PhiCount() > 1 ? 2 : 1); ++j) {
            place.entry[place.count] = (theta + i) * PhiCount() + phi + j;
            place.weight[place.count++] =
                (i == 1 ? thetaFraction : 1 - thetaFraction) * (j == 1 ? phiFraction : 1 - phiFraction);
        }
    return place;
}
//<

//> Keep tables for those who ask again
std::shared_ptr<const FiberTable> FiberTable::Cached(const FiberDescription &fiber, uint64_t samples) {
    struct Known {
        FiberDescription fiber;
        uint64_t samples;
        std::weak_ptr<const FiberTable> table;
    };
    static std::mutex mutex;
    static std::vector<Known> known;
    static std::shared_ptr<const FiberTable> newest;
    const std::lock_guard lock(mutex);
    std::erase_if(known, [](const Known &k) { return k.table.expired(); });
    for (const Known &k : known)
        if (k.fiber == fiber && k.samples == samples)
            if (auto table = k.table.lock())
                return table;
    newest = std::make_shared<const FiberTable>(fiber, samples);
    known.push_back({fiber, samples, newest});
    return newest;
}
//<

//> Spread cells by hats
// A cell's share is spread by a hat: highest at the cell's middle, 0 at the middles of its neighbours. At the
// two poles, where the share for each step of theta ends at 0, the hat of the last row ends at the pole. Each
// integrates to 1.
namespace {
template <typename T>
struct Hat {
    T middle, below, above; // where it is highest, and how far it reaches
    T Height() const { return 2 / (below + above); }
    // A place under it: its sides are straight, so that the distance from the middle is reach (1 - sqrt(u)).
    T Sample(T u) const {
        const T share = below / (below + above);
        return u < share ? middle - below * (1 - std::sqrt(u / share))
                         : middle + above * (1 - std::sqrt((1 - u) / (1 - share)));
    }
};
// The cells whose hats lie over a place, and their densities there.
template <typename T>
struct Covers {
    size_t cell[2];
    T density[2];
};
//<

//> Lay hats over the rows
// Half of the rows lie on each side of the specular cone, which their hats cross.
template <typename T>
class RowHats {
  public:
    explicit RowHats(T cone)
        : cone_(cone), lower_((kPi<T> / 2 + cone) / kHalf), upper_((kPi<T> / 2 - cone) / kHalf) {}
    Hat<T> Of(size_t row) const {
        const T k = static_cast<T>(row) + T(0.5) - kHalf, step = k < 0 ? lower_ : upper_;
        const T across = (lower_ + upper_) / 2;
        return {cone_ + k * step,
                row == 0       ? step / 2
                : row == kHalf ? across
                               : step,
                row + 1 == 2 * kHalf ? step / 2
                : row + 1 == kHalf   ? across
                                     : step};
    }
    Covers<T> Over(T theta) const {
        const T x = (theta - cone_) / (theta < cone_ ? lower_ : upper_) + kHalf - T(0.5);
        const size_t low = x > 0 ? std::min(static_cast<size_t>(x), size_t(2 * kHalf - 1)) : 0;
        const Hat<T> hat = Of(low);
        if (theta < hat.middle) // below the first row's middle
            return {{low, low}, {hat.Height() * std::max(T(0), 1 - (hat.middle - theta) / hat.below), 0}};
        const T fraction = std::min(T(1), (theta - hat.middle) / hat.above);
        const size_t high = std::min(low + 1, size_t(2 * kHalf - 1));
        return {{low, high}, {(1 - fraction) * hat.Height(), high == low ? 0 : fraction * Of(high).Height()}};
    }

  private:
    static constexpr size_t kHalf = FiberTable::kRows / 2;
    T cone_, lower_, upper_;
};
//<

//> Lay hats over the columns
// Around the fiber there is no end. Angles from -pi to pi.
template <typename T>
struct ColumnHats {
    static constexpr size_t kCount = FiberTable::kColumns;
    static constexpr T kStep = 2 * kPi<T> / kCount;
    static Hat<T> Of(size_t column) {
        return {(static_cast<T>(column) + T(0.5)) * kStep - kPi<T>, kStep, kStep};
    }
    static Covers<T> Over(T phi) {
        const T x = phi / kStep + T(kCount) / 2 - T(0.5), y = x < 0 ? x + kCount : x;
        const size_t low = y > 0 ? std::min(static_cast<size_t>(y), kCount - 1) : 0; // NaN: any
        const T fraction = y - static_cast<T>(low);
        return {{low, (low + 1) % kCount}, {(1 - fraction) / kStep, fraction / kStep}};
    }
};
//<

//> Choose a cell by its share
// Chooses by share; u becomes new.
template <typename T>
size_t Choose(std::span<const float> shares, float total, T *u) {
    T rest = *u * total;
    size_t chosen = 0, i = 0;
    for (; i < shares.size(); ++i)
        if (shares[i] > 0) { // rounding may lead past the last share
            chosen = i;
            if (rest < shares[i])
                break;
            rest -= shares[i];
        }
    *u = std::clamp(shares[chosen] > 0 ? rest / shares[chosen] : T(0.5), T(0), T(OneMinusEpsilon));
    return chosen;
}
} // namespace
//<

//> Blend the levels of absorption
// Light after length l is x^(l/2) of x = exp(-2 sigma); l is about 2 for TT, 4 for TRT, less where little is
// left: nearly linear in x.
template <typename T>
Tabulated<T>::Tabulated(const FiberTable *table, const std::array<double, 3> &sigmaA, double axis)
    : table_(table), axis_(static_cast<T>(axis)) {
    const std::vector<double> &levels = table->Levels();
    for (size_t c = 0; c < 3; ++c) {
        const double sigma = std::clamp(sigmaA[c], levels.front(), levels.back());
        const auto above =
            static_cast<size_t>(std::lower_bound(levels.begin(), levels.end(), sigma) - levels.begin());
        Blend &blend = blends_[c];
        blend.level = {above, above}, blend.above = 0;
        if (!(sigma < levels[above]))
            continue;
        const double low = levels[above - 1];
        blend.level = {above - 1, above};
        blend.above = static_cast<T>(std::expm1(-2 * (sigma - low)) / std::expm1(-2 * (levels[above] - low)));
        //> Weigh up to four levels for the total
        // Lagrange's polynomial in 1 / (1 + sigma), in which levels lie evenly enough from 0 to the greatest:
        // two on each side, as far as there are any.
        const size_t first = above >= 2 ? above - 2 : 0, end = std::min(above + 2, levels.size());
        const auto x = [](double s) { return 1 / (1 + s); };
        for (size_t i = first; i < end; ++i) {
            double share = 1;
            for (size_t j = first; j < end; ++j)
                if (j != i)
                    share *= (x(sigma) - x(levels[j])) / (x(levels[i]) - x(levels[j]));
            blend.near[blend.nearCount] = i;
            blend.share[blend.nearCount++] = static_cast<T>(share);
        }
        //<
    }
}
//<

//> Blend them so that the total is right
// Finds, of one entry, the weight of the upper level with which two totals give the third. A sum of
// exponentials falls, so that it lies between them; what rounding puts outside is stopped there.
template <typename T>
T Tabulated<T>::WeightAbove(size_t entry, const Blend &blend) const {
    if (blend.nearCount < 3)
        return blend.above;
    T total = 0;
    for (size_t i = 0; i < blend.nearCount; ++i)
        total += blend.share[i] * table_->Total(entry, blend.near[i]);
    const T low = table_->Total(entry, blend.level[0]), high = table_->Total(entry, blend.level[1]);
    return low > high ? std::clamp((low - total) / (low - high), T(0), T(1)) : blend.above;
}
//<

//> Prepare a view of the table
// total: what is scattered in all, for each colour.
template <typename T>
struct Tabulated<T>::View {
    FiberAngles<T> angles;
    T middle; // theta of the specular cone
    FiberTable::Place place;
    std::array<std::array<T, 3>, 4> above; // of each entry and colour: the weight of the upper level
    std::array<T, 3> total;
};
template <typename T>
template <typename F>
void Tabulated<T>::ForEachPart(const View &view, const F &f) const {
    for (size_t k = 0; k < view.place.count; ++k)
        for (size_t c = 0; c < 3; ++c)
            for (size_t b = 0; b < 2; ++b)
                if (const T weight =
                        view.place.weight[k] * (b == 1 ? view.above[k][c] : 1 - view.above[k][c]);
                    weight > 0)
                    f(view.place.entry[k], blends_[c].level[b], c, weight);
}
template <typename T>
typename Tabulated<T>::View Tabulated<T>::ViewOf(const Vector3<T> &wo) const {
    View view;
    view.angles = AnglesOf(wo.x, wo.y, wo.z);
    const T thetaO = std::atan2(wo.x, view.angles.cosTheta);
    view.middle = static_cast<T>(FiberTable::Cells(thetaO).middle);
    view.place = table_->At(thetaO, std::atan2(view.angles.z, view.angles.y) - axis_);
    view.total = {0, 0, 0};
    for (size_t k = 0; k < view.place.count; ++k)
        for (size_t c = 0; c < 3; ++c)
            view.above[k][c] = WeightAbove(view.place.entry[k], blends_[c]);
    ForEachPart(view, [&](size_t entry, size_t level, size_t c, T weight) {
        view.total[c] += weight * table_->Total(entry, level);
    });
    return view;
}
//<

//> Look a direction up
// The density in theta and phi, over cos theta: that for each steradian. Sampled in proportion to the mean of
// the three colours.
template <typename T>
FiberValue<T> Tabulated<T>::Look(const View &view, T thetaI, T cosThetaI, T phi) const {
    const Covers<T> row = RowHats<T>(view.middle).Over(thetaI),
                    column = ColumnHats<T>::Over(view.place.mirrored ? -phi : phi);
    FiberValue<T> value{{0, 0, 0}, 0};
    ForEachPart(view, [&](size_t entry, size_t level, size_t c, T weight) {
        const std::span<const float> shares = table_->Shares(entry, level);
        for (size_t i = 0; i < 2; ++i)
            for (size_t j = 0; j < 2; ++j)
                value.fCos[c] += weight * row.density[i] * column.density[j] *
                                 shares[row.cell[i] * FiberTable::kColumns + column.cell[j]];
    });
    const T perSteradian = 1 / std::max(cosThetaI, T(1e-6));
    T sum = 0, total = 0;
    for (size_t c = 0; c < 3; ++c) {
        value.fCos[c] *= perSteradian;
        sum += value.fCos[c], total += view.total[c];
    }
    value.pdf = total > 0 ? sum / total : 0;
    return value;
}
template <typename T>
FiberValue<T> Tabulated<T>::Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const {
    const View view = ViewOf(wo);
    const FiberAngles<T> i = AnglesOf(wi.x, wi.y, wi.z);
    const SinCosine<T> phi = RelativeAzimuth(view.angles, i);
    return Look(view, std::atan2(wi.x, i.cosTheta), i.cosTheta, std::atan2(phi.sin, phi.cos));
}
//<

//> Draw a direction from the table
template <typename T>
FiberValue<T> Tabulated<T>::Sample(const Vector3<T> &wo, const std::array<T, 4> &u, Vector3<T> *wi) const {
    const View view = ViewOf(wo);
    //> Choose entry and level, then row and column
    T rest = u[0] * (view.total[0] + view.total[1] + view.total[2]), across = T(0.5);
    size_t entry = 0, level = 0;
    bool found = false;
    ForEachPart(view, [&](size_t e, size_t l, size_t, T weight) {
        const T share = weight * table_->Total(e, l);
        if (found || !(share > 0))
            return;
        entry = e, level = l; // the last one, if rounding leads past it
        found = rest < share;
        across = std::min(rest / share, T(OneMinusEpsilon));
        rest -= share;
    });
    T uRow = u[1], uColumn = u[2];
    const std::span<const float> rowShares = table_->RowShares(entry, level);
    const size_t row = Choose(rowShares, table_->Total(entry, level), &uRow);
    const size_t column =
        Choose(table_->Shares(entry, level).subspan(row * FiberTable::kColumns, FiberTable::kColumns),
               rowShares[row], &uColumn);
    //<
    //> Draw a place under the cell's hat
    const T theta = RowHats<T>(view.middle).Of(row).Sample(u[3]);
    const T around = ColumnHats<T>::Of(column).Sample(across), phi = view.place.mirrored ? -around : around;
    //<
    const T cosTheta = std::max(std::cos(theta), T(0));
    *wi = view.angles.Turned(std::sin(theta), cosTheta, std::sin(phi), std::cos(phi));
    return Look(view, theta, cosTheta, WrapAngle(phi));
}
template class Tabulated<float>;
template class Tabulated<double>;
//<

//> Offer the tabulated model as a BSDF
namespace {
std::array<double, 3> CheckedAbsorption(const Spectrum &s, Float axis) {
    if (!std::isfinite(s[0] + s[1] + s[2] + axis))
        throw Error("TabulatedBSDF: sigma_a and the axis must be finite numbers");
    return {std::max(0., double(s[0])), std::max(0., double(s[1])), std::max(0., double(s[2]))};
}
} // namespace
TabulatedBSDF::TabulatedBSDF(const FiberTable *table, const Spectrum &sigmaA, Float axis)
    : BxDFOf(Tabulated<Float>(table, CheckedAbsorption(sigmaA, axis), axis)) {}

std::string TabulatedBSDF::ToString() const { return "[ TabulatedBSDF ]"; }
//<

} // namespace cuticle
//<
