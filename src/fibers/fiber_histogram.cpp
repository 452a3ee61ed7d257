//> Define the histogram of scattered light
#include "fibers/fiber_histogram.h"

#include <cstdio>

namespace cuticle {

//> Find edges and cells on the sphere
double SphereCells::ThetaEdge(size_t row) const {
    const double t = 2 * static_cast<double>(row) / static_cast<double>(rows) - 1;
    return equalSolidAngle ? std::asin(std::clamp(t, -1., 1.))
                           : middle + t * (kPi<double> / 2 + (t < 0 ? middle : -middle));
}
double SphereCells::SolidAngle(size_t row) const {
    return (std::sin(ThetaEdge(row + 1)) - std::sin(ThetaEdge(row))) * 2 * kPi<double> /
           static_cast<double>(columns);
}

static size_t CellIn(double t, size_t n) { // of t in [0, 1]
    return std::min(n - 1, static_cast<size_t>(std::max(0., t * static_cast<double>(n))));
}
size_t SphereCells::RowOf(double theta) const {
    const double reach = kPi<double> / 2 + (theta < middle ? middle : -middle);
    return CellIn(((equalSolidAngle ? std::sin(theta) : (theta - middle) / reach) + 1) / 2, rows);
}
size_t SphereCells::ColumnOf(double phi) const {
    const double turns = phi / (2 * kPi<double>)+0.5;
    return CellIn(turns - std::floor(turns), columns);
}
size_t SphereCells::CellOf(const Vector3d &w) const {
    const double theta = std::atan2(w.x, std::hypot(w.y, w.z));
    return RowOf(theta) * columns + ColumnOf(std::atan2(w.z, w.y));
}
//<

FiberHistogram::FiberHistogram(const SphereCells &cells, int orders, size_t channels)
    : cells_(cells), orders_(static_cast<size_t>(orders)), channels_(channels),
      sums_(Classes() * (cells.Count() + 1) * channels), squares_(sums_.size()) {}

std::string FiberHistogram::ClassName(size_t c) const {
    if (c >= orders_)
        return c == Rest() ? "rest" : c == Medulla() ? "medulla" : "sum";
    constexpr std::array<const char *, 3> known = {"R", "TT", "TRT"};
    return c < known.size() ? known[c] : "TR" + std::to_string(c - 1) + "T";
}

//> Add a sample's share
void FiberHistogram::Add(size_t c, size_t cell, const double *share) {
    for (size_t i = Index(c, 0, cell), k = 0; k < channels_; ++i, ++k) {
        sums_[i] += share[k];
        squares_[i] += share[k] * share[k];
    }
}
//<

//> Estimate the mean and its standard error
double FiberHistogram::ErrorOf(double sum, double squares) const {
    if (samples_ < 2)
        return Infinity;
    const double n = static_cast<double>(samples_), mean = sum / n;
    return std::sqrt(std::max(0., squares / n - mean * mean) / (n - 1));
}
double FiberHistogram::Mean(size_t c, size_t channel, size_t cell) const {
    return samples_ > 0 ? sums_[Index(c, channel, cell)] / static_cast<double>(samples_) : 0;
}
double FiberHistogram::Error(size_t c, size_t channel, size_t cell) const {
    const size_t i = Index(c, channel, cell);
    return ErrorOf(sums_[i], squares_[i]);
}
double FiberHistogram::Density(size_t c, size_t channel, size_t row, size_t column) const {
    return Mean(c, channel, row * cells_.columns + column) / cells_.SolidAngle(row);
}
double FiberHistogram::DensityError(size_t c, size_t channel, size_t row, size_t column) const {
    return Error(c, channel, row * cells_.columns + column) / cells_.SolidAngle(row);
}
double FiberHistogram::Density(size_t c, size_t channel, const Vector3d &w) const {
    const size_t cell = cells_.CellOf(w);
    return Density(c, channel, cell / cells_.columns, cell % cells_.columns);
}
//<

//> Average the cells of a cut
// inside is called with a function to be called for each row and column of the point. Sums and sums of
// squares add up as if no sample had a share in two of the cells, which is as good as true for narrow cuts.
template <typename Inside>
void FiberHistogram::AddPoint(LobeSlice *slice, double angle, size_t c, size_t channel,
                              const Inside &inside) const {
    double sum = 0, squares = 0, solidAngle = 0;
    inside([&](size_t row, size_t column) {
        const size_t i = Index(c, channel, row * cells_.columns + column);
        sum += sums_[i], squares += squares_[i], solidAngle += cells_.SolidAngle(row);
    });
    slice->angle.push_back(angle);
    slice->value.push_back(samples_ > 0 ? sum / static_cast<double>(samples_) / solidAngle : 0);
    slice->error.push_back(ErrorOf(sum, squares) / solidAngle);
}
//<

//> Cut along the fiber and around it
LobeSlice FiberHistogram::AlongTheta(size_t c, size_t channel, double phi, double halfWidth) const {
    std::vector<size_t> columns;
    for (size_t j = 0; j < cells_.columns; ++j)
        if (std::abs(std::remainder(cells_.Phi(j) - phi, 2 * kPi<double>)) <= halfWidth)
            columns.push_back(j);
    if (columns.empty())
        columns.push_back(cells_.ColumnOf(phi));
    LobeSlice slice;
    for (size_t row = 0; row < cells_.rows; ++row)
        AddPoint(&slice, cells_.Theta(row), c, channel, [&](const auto &cell) {
            for (const size_t column : columns)
                cell(row, column);
        });
    return slice;
}
LobeSlice FiberHistogram::AroundPhi(size_t c, size_t channel, double theta, double halfWidth) const {
    std::vector<size_t> rows;
    for (size_t i = 0; i < cells_.rows; ++i)
        if (std::abs(cells_.Theta(i) - theta) <= halfWidth)
            rows.push_back(i);
    if (rows.empty())
        rows.push_back(cells_.RowOf(theta));
    LobeSlice slice;
    for (size_t column = 0; column < cells_.columns; ++column)
        AddPoint(&slice, cells_.Phi(column), c, channel, [&](const auto &cell) {
            for (const size_t row : rows)
                cell(row, column);
        });
    return slice;
}
//<

//> Cut through the plane of fiber and light
LobeSlice FiberHistogram::IncidencePlane(size_t c, size_t channel, double phi, double halfWidth) const {
    LobeSlice slice = AlongTheta(c, channel, phi, halfWidth);
    const LobeSlice behind = AlongTheta(c, channel, phi + kPi<double>, halfWidth);
    for (size_t i = behind.angle.size(); i-- > 0;) {
        slice.angle.push_back(kPi<double> - behind.angle[i]);
        slice.value.push_back(behind.value[i]);
        slice.error.push_back(behind.error[i]);
    }
    return slice;
}
//<

//> Export a histogram
std::string FiberHistogram::ToCsv() const {
    std::string text = "class,theta_min_deg,theta_max_deg,phi_min_deg,phi_max_deg,solid_angle_sr";
    for (size_t k = 0; k < channels_; ++k)
        text += ",density_" + std::to_string(k) + "_per_sr,error_" + std::to_string(k) + "_per_sr";
    text += '\n';
    const double degrees = 180 / kPi<double>;
    std::array<char, 160> line;
    for (size_t c = 0; c < Classes(); ++c)
        for (size_t cell = 0; cell < cells_.Count(); ++cell) {
            const size_t row = cell / cells_.columns, column = cell % cells_.columns;
            std::snprintf(line.data(), line.size(), ",%.6g,%.6g,%.6g,%.6g,%.8g",
                          cells_.ThetaEdge(row) * degrees, cells_.ThetaEdge(row + 1) * degrees,
                          cells_.PhiEdge(column) * degrees, cells_.PhiEdge(column + 1) * degrees,
                          cells_.SolidAngle(row));
            text += ClassName(c) + line.data();
            for (size_t k = 0; k < channels_; ++k) {
                std::snprintf(line.data(), line.size(), ",%.6g,%.3g", Density(c, k, row, column),
                              DensityError(c, k, row, column));
                text += line.data();
            }
            text += '\n';
        }
    return text;
}
//<

} // namespace cuticle
//<
