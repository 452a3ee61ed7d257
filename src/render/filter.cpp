#include "render/filter.h"

#include "core/error.h"
#include "render/plugins.h"

namespace cuticle {

namespace {

constexpr ParamInfo Width(std::string_view name, std::string_view value) {
    return {name, "float", "pixels", value, "half of the footprint", 0, 1000};
}
constexpr ParamInfo kBoxParams[] = {Width("xwidth", "0.5"), Width("ywidth", "0.5")};
constexpr ParamInfo kTriangleParams[] = {Width("xwidth", "2"), Width("ywidth", "2")};
constexpr ParamInfo kGaussianParams[] = {
    Width("xwidth", "2"),
    Width("ywidth", "2"),
    {"alpha", "float", "1/pixels^2", "2", "exp(-alpha x^2), less its value at the border"}};
constexpr ParamInfo kMitchellParams[] = {Width("xwidth", "2"),
                                         Width("ywidth", "2"),
                                         {"B", "float", "", "1/3", "blur (Mitchell and Netravali 1988)"},
                                         {"C", "float", "", "1/3", "ringing"}};
constexpr ParamInfo kSincParams[] = {
    Width("xwidth", "4"),
    Width("ywidth", "4"),
    {"tau", "float", "pixels", "3", "the window's width (Lanczos), above 0", 0}};

// To add a filter: a row here, its FilterKind, its shape in Filter::Evaluate1D, its parameters in MakeFilter.
const PluginRow<FilterKind> kFilters[] = {
    {{"box", kBoxParams, "1 everywhere"}, FilterKind::Box},
    {{"gaussian", kGaussianParams, "a bell"}, FilterKind::Gaussian},
    {{"mitchell", kMitchellParams, "a cubic with negative lobes"}, FilterKind::Mitchell},
    {{"sinc", kSincParams, "a windowed sinc, with negative lobes"}, FilterKind::Sinc},
    {{"triangle", kTriangleParams, "a tent"}, FilterKind::Triangle},
};

std::string_view NameOf(FilterKind kind) {
    for (const PluginRow<FilterKind> &row : kFilters)
        if (row.make == kind)
            return row.info.name;
    return "";
}

// Steps of the tables: linear interpolation is then off by less than 2e-6 of the peak for every filter of
// the usual widths. Wide sincs, which ripple by the pixel and by tau, take more, up to kMaxSteps.
constexpr size_t kSteps = 4096, kMaxSteps = size_t{1} << 20;
constexpr double kWidest = 1000;   // pixels; rays from farther off the picture have no meaning
constexpr float kMaxWeight = 1000; // 1.3 for pbrt-v3's filters as they are

double Sinc(double x) {
    x = std::abs(x) * kPi<double>;
    return x < 1e-5 ? 1 : std::sin(x) / x;
}

} // namespace

double Filter::Evaluate1D(double x, double radius) const {
    x = std::abs(x);
    if (!(x <= radius))
        return 0;
    switch (kind_) {
    case FilterKind::Box:
        return 1;
    case FilterKind::Triangle:
        return radius - x;
    case FilterKind::Gaussian: {
        const double alpha = static_cast<double>(parameters_.alpha);
        return std::max(0., std::exp(-alpha * x * x) - std::exp(-alpha * radius * radius));
    }
    case FilterKind::Mitchell: {
        const double b = static_cast<double>(parameters_.b), c = static_cast<double>(parameters_.c);
        // Defined on [-2, 2], stretched to the radius.
        const double t = 2 * x / radius;
        if (t > 1)
            return (((-b - 6 * c) * t + (6 * b + 30 * c)) * t * t + (-12 * b - 48 * c) * t +
                    (8 * b + 24 * c)) /
                   6;
        return (((12 - 9 * b - 6 * c) * t + (-18 + 12 * b + 6 * c)) * t * t + (6 - 2 * b)) / 6;
    }
    case FilterKind::Sinc:
        break;
    }
    return Sinc(x) * Sinc(x / static_cast<double>(parameters_.tau));
}

Filter::Filter(FilterKind kind, const Parameters &parameters) : kind_(kind), parameters_(parameters) {
    const std::string_view name = NameOf(kind);
    for (const float v : {parameters.alpha, parameters.b, parameters.c, parameters.tau})
        if (!std::isfinite(v))
            throw Error("filter {}: a parameter is not finite", name);
    if (kind == FilterKind::Sinc && !(parameters.tau > 0))
        throw Error("filter sinc: tau must be above 0");
    for (int i = 0; i < 2; ++i) {
        axis_[i].radius = static_cast<double>(parameters.radius[i]);
        if (!(axis_[i].radius > 0 && axis_[i].radius <= kWidest))
            throw Error("filter {}: its width must be above 0 and at most 1000 pixels", name);
        Tabulate(&axis_[i]);
    }
    integral_ = axis_[0].integral * axis_[1].integral;
    absIntegral_ = axis_[0].absIntegral * axis_[1].absIntegral;
    bool negative = false;
    for (const Axis &axis : axis_)
        negative |= axis.integral < axis.absIntegral;
    weight_ = negative ? static_cast<float>(absIntegral_ / integral_) : 1;
    if (!(weight_ <= kMaxWeight))
        throw Error("filter {}: its negative lobes all but cancel its positive ones", name);
}

void Filter::Tabulate(Axis *axis) const {
    const double radius = axis->radius;
    axis->tabulated = radius;
    size_t steps = kSteps;
    if (kind_ == FilterKind::Gaussian && parameters_.alpha > 0) // beyond, the bell is 2^-40 of its peak
        axis->tabulated = std::min(radius, std::sqrt(40 * std::numbers::ln2 / double{parameters_.alpha}));
    if (kind_ == FilterKind::Sinc) {
        const double finer = radius / 4 / std::min(1., double{parameters_.tau});
        steps = std::min(kSteps * static_cast<size_t>(std::ceil(std::clamp(finer, 1., 1e6))), kMaxSteps);
    }
    // Tabulate |g|, and integrate g and |g| by the trapezoid rule, exact for the table's straight lines
    std::vector<double> g(steps + 1), running(steps + 1);
    const double step = 2 * axis->tabulated / static_cast<double>(steps);
    for (size_t k = 0; k <= steps; ++k)
        g[k] = Evaluate1D(-axis->tabulated + step * static_cast<double>(std::min(k, steps - k)), radius);
    for (size_t k = 0; k < steps; ++k) {
        axis->integral += step * (g[k] + g[k + 1]) / 2;
        running[k + 1] = running[k] + step * (std::abs(g[k]) + std::abs(g[k + 1])) / 2;
    }
    axis->absIntegral = running[steps];
    if (!(axis->integral > 0 && axis->absIntegral < HUGE_VAL))
        throw Error("filter {}: its integral is not above 0", NameOf(kind_));
    axis->density.resize(steps + 1);
    axis->cdf.resize(steps + 1);
    for (size_t k = 0; k <= steps; ++k) {
        axis->density[k] = static_cast<float>(std::abs(g[k]) * step / axis->absIntegral);
        axis->cdf[k] = static_cast<float>(running[k] / axis->absIntegral);
    }
    axis->guide.resize(steps);
    for (size_t slot = 0, k = 0; slot < steps; ++slot) {
        while (k + 1 < steps && axis->cdf[k + 1] <= static_cast<float>(slot) / static_cast<float>(steps))
            ++k;
        axis->guide[slot] = static_cast<uint32_t>(k);
    }
}

float Filter::Evaluate(Point2f p) const {
    return static_cast<float>(Evaluate1D(static_cast<double>(p.x), axis_[0].radius) *
                              Evaluate1D(static_cast<double>(p.y), axis_[1].radius));
}

float Filter::Sample1D(const Axis &axis, float u, float *sign) const {
    const auto radius = static_cast<float>(axis.tabulated);
    const size_t steps = axis.guide.size();
    *sign = 1;
    // Two filters have a closed form
    if (kind_ == FilterKind::Box)
        return (2 * u - 1) * radius;
    if (kind_ == FilterKind::Triangle)
        return u < 0.5f ? radius * (std::sqrt(2 * u) - 1) : radius * (1 - std::sqrt(2 * (1 - u)));
    // Find the step with cdf[k] <= u < cdf[k + 1], then solve for the place within, where the density is a +
    // (b - a) s: a s + (b - a) s^2 / 2 = rest, in the form that does not cancel.
    size_t k = axis.guide[static_cast<size_t>(u * static_cast<float>(steps))];
    while (k + 1 < steps && axis.cdf[k + 1] <= u)
        ++k;
    const float rest = std::max(0.f, u - axis.cdf[k]), a = axis.density[k], b = axis.density[k + 1];
    const float root = a + std::sqrt(std::max(0.f, a * a + 2 * (b - a) * rest));
    const float s = root > 0 ? std::min(2 * rest / root, 1.f) : 0.5f;
    const float x = radius * (2 * (static_cast<float>(k) + s) / static_cast<float>(steps) - 1);
    if (weight_ != 1)
        *sign = Evaluate1D(static_cast<double>(x), axis.radius) < 0 ? -1.f : 1.f;
    return x;
}

FilterSample Filter::Sample(Point2f u) const {
    float signX, signY;
    FilterSample sample;
    sample.offset.x = Sample1D(axis_[0], u.x, &signX);
    sample.offset.y = Sample1D(axis_[1], u.y, &signY);
    sample.weight = weight_ * signX * signY;
    return sample;
}

const PluginTable &FilterPlugins() {
    static const PluginTable table{PluginKind::Filter, PluginInfos(kFilters)};
    return table;
}

Filter MakeFilter(const Entity &entity) {
    const ParamSet &params = entity.params;
    const PlaceScope here(params.loc);
    const PluginRow<FilterKind> *row = FindPluginRow(kFilters, entity.type);
    if (!row) {
        const std::vector<std::string_view> names = FilterPlugins().Names();
        throw Error(params.loc, "unknown filter \"{}\"", entity.type)
            .WithRemedy(Suggestion(entity.type, names.data(), names.size()));
    }
    const FilterKind kind = row->make;
    const float width = kind == FilterKind::Box ? 0.5f : kind == FilterKind::Sinc ? 4.f : 2.f;
    Filter::Parameters p;
    p.radius = {params.FindFloat("xwidth", width), params.FindFloat("ywidth", width)};
    if (kind == FilterKind::Gaussian)
        p.alpha = params.FindFloat("alpha", 2);
    if (kind == FilterKind::Mitchell) {
        p.b = params.FindFloat("B", 1.f / 3);
        p.c = params.FindFloat("C", 1.f / 3);
    }
    if (kind == FilterKind::Sinc)
        p.tau = params.FindFloat("tau", 3);
    return {kind, p};
}

} // namespace cuticle
