//> Define the table of $N_p$
#include "core/error.h"
#include "core/parallel.h"
#include "fibers/ap.h"
#include "fibers/deon.h"
#include "fibers/np.h"

#include <mutex>

namespace cuticle {

namespace {
//> Choose the table's resolution
// Columns: a tenth of the narrowest width apart, or a degree. Rows: 64, and more for narrow lobes, since
// caustics move from row to row.
float NarrowestOf(const DEonParameters &p) { return std::min({p.betaN[0], p.betaN[1], p.betaN[2]}); }
size_t ColumnsFor(float degrees) { return 1 + static_cast<size_t>(180 / std::min(1.f, degrees / 10)); }
size_t RowsFor(const DEonParameters &p) {
    return static_cast<size_t>(64 * std::max(1.f, 4 / NarrowestOf(p)));
}
//<

//> Space the rows
// x in [0, 1] over theta_d in [0, pi/2], denser toward grazing, where Fresnel's factor rises steeply.
double ThetaOfRow(double x) { return std::numbers::pi / 2 * x * (2 - x); }
template <typename T>
T RowOfCosTheta(T cosTheta) {
    const T theta = std::acos(std::min(cosTheta, T(1)));
    return 1 - std::sqrt(std::max(T(0), 1 - theta / (kPi<T> / 2)));
}
//<
//> Find the columns near an azimuth
// The first and the last of the columns on [0, pi], `step` apart, within `reach` of an azimuth or of its
// mirror image in the plane of the viewer. The image on the same side is the nearer of the two for all of
// them.
std::pair<size_t, size_t> ColumnsNear(double turn, double reach, double step, size_t columns) {
    const double at = std::abs(WrapAngle(turn)), last = static_cast<double>(columns - 1);
    return {static_cast<size_t>(std::max(std::ceil((at - reach) / step), 0.)),
            static_cast<size_t>(std::min(std::floor((at + reach) / step), last))};
}
//<
} // namespace

//> Say which fibers a table holds
template <typename T>
std::string DEonTableOf<T>::WhyNot(const DEonParameters &given) {
    const DEonParameters p = CheckedDEon(given);
    if (const float narrowest = NarrowestOf(p); narrowest < kNarrowest)
        return fmt::format("lobes of {:.3g} degrees around the fiber are too narrow for a table, which holds "
                           "those of {} degree and more",
                           narrowest, kNarrowest);
    if (const size_t cells = RowsFor(p) * ColumnsFor(NarrowestOf(p)) * p.AllLobes(); cells > kMaxCells)
        return fmt::format("{} lobes of {:.3g} degrees make a table of {} cells, more than {}", p.AllLobes(),
                           NarrowestOf(p), cells, kMaxCells);
    return {};
}
//<

//> Fill the table
template <typename T>
DEonTableOf<T>::DEonTableOf(const DEonParameters &given)
    : rows_(RowsFor(CheckedDEon(given))), columns_(ColumnsFor(NarrowestOf(CheckedDEon(given)))) {
    const DEonParameters p = CheckedDEon(given);
    if (p.h)
        throw Error("DEonTable: tables are of far-field fibers, without h");
    if (const std::string why = WhyNot(p); !why.empty())
        throw Error("DEonTable: {}", why);
    lobes_ = p.AllLobes();
    n_.resize(rows_ * lobes_ * columns_);
    luminance_.resize(n_.size());
    cumulated_.resize(n_.size());
    mean_.resize(rows_ * lobes_);
    share_.resize(mean_.size());
    const DEonQuadrature<double> exact(p);
    // Isolated: a thread that waits here with a lock must not take up work that asks for the same lock.
    Isolated([&] { ParallelFor(rows_ * lobes_, [&](size_t k) { Fill(exact, k / lobes_, k % lobes_); }); });
}
// Rays are seen at the columns that a table of the lobe's own width would have; the table's, which may be ten
// times as many where another lobe is narrow, lie on the chords between. Linear between columns, so that the
// integral of a table's row is the sum of its trapezia.
template <typename T>
void DEonTableOf<T>::Fill(const DEonQuadrature<double> &exact, size_t row, size_t p) {
    const double x = static_cast<double>(row) / static_cast<double>(rows_ - 1),
                 step = std::numbers::pi / static_cast<double>(columns_ - 1), beta = exact.Width(p);
    const size_t own = ColumnsFor(exact.parameters.betaN[std::min(p, size_t(2))]);
    const SmoothFiber<double> fiber = exact.At(std::cos(ThetaOfRow(x)));
    std::vector<std::pair<double, std::array<double, 3>>> rays;
    if (!exact.parameters.IsTail(p))
        exact.ForEachRay(p, fiber, [&](double turn, const std::array<double, 3> &light) {
            rays.emplace_back(turn, light);
        });
    //> Spread each ray over the columns that see it
    std::vector<std::array<double, 3>> n(own,
                                         rays.empty() ? exact.Value(p, fiber, 0).n : std::array<double, 3>{});
    const double reach = 9 * beta; // beyond, a Gaussian is below the last digit of a double
    const double ownStep = std::numbers::pi / static_cast<double>(own - 1);
    for (const auto &[turn, light] : rays) {
        const auto [from, to] = ColumnsNear(turn, reach, ownStep, own);
        for (size_t j = from; j <= to; ++j) {
            const double seen = exact.Seen(beta, ownStep * static_cast<double>(j), turn);
            for (size_t c = 0; c < 3; ++c)
                n[j][c] += light[c] * seen;
        }
    }
    //<
    const size_t first = Row(row, p) * columns_;
    double sum = 0, before = 0;
    for (size_t j = 0; j < columns_; ++j) {
        const double at = static_cast<double>(j * (own - 1)) / static_cast<double>(columns_ - 1);
        const size_t k = std::min(static_cast<size_t>(at), own - 2);
        const double across = at - static_cast<double>(k);
        std::array<double, 3> value;
        for (size_t c = 0; c < 3; ++c)
            value[c] = (1 - across) * n[k][c] + across * n[k + 1][c];
        const double y = Luminance(value);
        sum += j > 0 ? step / 2 * (y + before) : 0;
        before = y;
        for (size_t c = 0; c < 3; ++c)
            n_[first + j][c] = static_cast<T>(value[c]);
        luminance_[first + j] = static_cast<T>(y);
        cumulated_[first + j] = static_cast<T>(sum);
    }
    mean_[Row(row, p)] = static_cast<T>(2 * sum);
    share_[Row(row, p)] = static_cast<T>(Luminance(exact.Mean(p, fiber)));
}
//<

//> Share tables between fibers
template <typename T>
std::shared_ptr<const DEonTableOf<T>> DEonTableOf<T>::Cached(const DEonParameters &parameters) {
    static std::mutex mutex;
    static std::vector<std::pair<DEonParameters, std::weak_ptr<const DEonTableOf>>> tables;
    DEonParameters key = CheckedDEon(parameters);
    key.alpha = {}, key.betaM = {}, key.longitudinal = {}; // of no effect on the table
    const std::lock_guard lock(mutex);
    std::erase_if(tables, [](const auto &entry) { return entry.second.expired(); });
    for (const auto &[known, table] : tables)
        if (known == key)
            if (auto shared = table.lock())
                return shared;
    auto made = std::make_shared<const DEonTableOf>(key);
    tables.emplace_back(key, made);
    return made;
}
template <typename T>
size_t DEonTableOf<T>::MemoryBytes() const {
    return n_.size() * sizeof(n_[0]) +
           (luminance_.size() + cumulated_.size() + mean_.size() + share_.size()) * sizeof(T);
}
//<

//> Look up the table
namespace {
// The interval of [0, intervals] in which x lies; 0 for NaN.
template <typename T>
size_t Below(T x, size_t intervals) {
    return x > 0 ? std::min(static_cast<size_t>(x), intervals - 1) : 0;
}
} // namespace
template <typename T>
typename DEonTableOf<T>::View::Inside DEonTableOf<T>::View::At(T cosThetaD) const {
    const T x = RowOfCosTheta(cosThetaD) * static_cast<T>(table_->rows_ - 1);
    const size_t row = Below(x, table_->rows_ - 1);
    return {row, x - static_cast<T>(row)};
}
template <typename T>
T DEonTableOf<T>::View::Between(const std::vector<T> &values, size_t p, const Inside &inside) const {
    return (1 - inside.fraction) * values[table_->Row(inside.row, p)] +
           inside.fraction * values[table_->Row(inside.row + 1, p)];
}
template <typename T>
T DEonTableOf<T>::View::Share(size_t p, const Inside &inside) const {
    return Between(table_->share_, p, inside);
}
// Bilinear. The density is that of Sample exactly: interpolation is linear, and so is luminance.
template <typename T>
AroundValue<T> DEonTableOf<T>::View::Value(size_t p, const Inside &inside, T phi) const {
    const T x = std::abs(WrapAngle(phi)) / kPi<T> * static_cast<T>(table_->columns_ - 1);
    const size_t j = Below(x, table_->columns_ - 1);
    const T across = x - static_cast<T>(j), weight[] = {1 - inside.fraction, inside.fraction};
    AroundValue<T> value{{0, 0, 0}, 0};
    for (size_t k = 0; k < 2; ++k) {
        const size_t at = table_->Row(inside.row + k, p) * table_->columns_ + j;
        for (size_t c = 0; c < 3; ++c)
            value.n[c] += weight[k] * ((1 - across) * table_->n_[at][c] + across * table_->n_[at + 1][c]);
        value.density +=
            weight[k] * ((1 - across) * table_->luminance_[at] + across * table_->luminance_[at + 1]);
    }
    const T mean = Between(table_->mean_, p, inside);
    value.density = mean > 0 ? value.density / mean : 0;
    return value;
}
//<

//> Draw an azimuth from the table
// A row of the two by what it holds, a column by the cumulated sums, a place in it by the linear density; the
// sign comes from u's upper bit.
template <typename T>
T DEonTableOf<T>::View::Sample(size_t p, const Inside &inside, T rest, T u) const {
    const T low = (1 - inside.fraction) * table_->mean_[table_->Row(inside.row, p)],
            high = inside.fraction * table_->mean_[table_->Row(inside.row + 1, p)];
    const size_t row = table_->Row(inside.row + (rest * (low + high) < low ? 0 : 1), p);
    const T *cumulated = table_->cumulated_.data() + row * table_->columns_;
    const T sign = u < T(0.5L) ? T(-1) : T(1),
            target = (u < T(0.5L) ? 2 * u : 2 * u - 1) * table_->mean_[row] / 2;
    const auto j = static_cast<size_t>(std::clamp<std::ptrdiff_t>(
        std::upper_bound(cumulated, cumulated + table_->columns_, target) - cumulated - 1, 0,
        static_cast<std::ptrdiff_t>(table_->columns_) - 2));
    const T a = table_->luminance_[row * table_->columns_ + j],
            b = table_->luminance_[row * table_->columns_ + j + 1],
            step = kPi<T> / static_cast<T>(table_->columns_ - 1);
    // a t + (b - a) t^2 / 2 = y, by the root that does not cancel.
    const T y = (target - cumulated[j]) / step;
    const T root = std::sqrt(std::max(T(0), a * a + 2 * (b - a) * y));
    const T t = a + root > 0 ? std::clamp(2 * y / (a + root), T(0), T(1)) : T(0.5L);
    return sign * step * (static_cast<T>(j) + t);
}
template class DEonTableOf<float>;
template class DEonTableOf<double>;
//<

} // namespace cuticle
//<
