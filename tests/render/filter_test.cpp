// Filters against numeric quadrature of pbrt-v3's definitions, and their samples against the filters.
#include "render/filter.h"

#include "core/error.h"
#include "core/sampling.h"
#include "render/plugins.h"
#include "sampler_ends.h"

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <functional>
#include <gtest/gtest.h>

namespace cuticle {
namespace {

struct Case {
    FilterKind kind;
    Filter::Parameters p;
    std::string name;
};
std::vector<Case> Cases() {
    std::vector<Case> cases;
    const auto add = [&](FilterKind kind, const std::string &name, const Filter::Parameters &p) {
        cases.push_back({kind, p, name});
    };
    add(FilterKind::Box, "box", {.radius = {0.5f, 0.5f}});
    add(FilterKind::Box, "wide box", {.radius = {2, 0.75f}});
    add(FilterKind::Triangle, "triangle", {.radius = {2, 2}});
    add(FilterKind::Triangle, "oblong triangle", {.radius = {1, 3}});
    add(FilterKind::Gaussian, "gaussian", {.radius = {2, 2}});
    add(FilterKind::Gaussian, "narrow gaussian", {.radius = {1.5f, 3}, .alpha = 8});
    add(FilterKind::Mitchell, "mitchell", {.radius = {2, 2}});
    add(FilterKind::Mitchell, "Catmull-Rom", {.radius = {2, 1.5f}, .b = 0, .c = 0.5f});
    add(FilterKind::Mitchell, "B-spline", {.radius = {2, 2}, .b = 1, .c = 0});
    add(FilterKind::Sinc, "sinc", {.radius = {4, 4}});
    add(FilterKind::Sinc, "short sinc", {.radius = {2.5f, 4}, .tau = 2});
    return cases;
}

// One axis as pbrt-v3 (section 7.8) defines it, written independently of the class.
double Reference(const Case &c, double x, double r) {
    x = std::abs(x);
    if (x > r)
        return 0;
    const double alpha = static_cast<double>(c.p.alpha), B = static_cast<double>(c.p.b),
                 C = static_cast<double>(c.p.c);
    const auto sinc = [](double t) { return t == 0 ? 1 : std::sin(kPi<double> * t) / (kPi<double> * t); };
    switch (c.kind) {
    case FilterKind::Box:
        return 1;
    case FilterKind::Triangle:
        return r - x;
    case FilterKind::Gaussian:
        return std::exp(-alpha * x * x) - std::exp(-alpha * r * r);
    case FilterKind::Mitchell: {
        const double t = 2 * x / r;
        const double inner = (12 - 9 * B - 6 * C) * t * t * t + (-18 + 12 * B + 6 * C) * t * t + (6 - 2 * B);
        const double outer =
            (-B - 6 * C) * t * t * t + (6 * B + 30 * C) * t * t + (-12 * B - 48 * C) * t + (8 * B + 24 * C);
        return (t > 1 ? outer : inner) / 6;
    }
    case FilterKind::Sinc:
        break;
    }
    return sinc(x) * sinc(x / static_cast<double>(c.p.tau));
}
// In 64 panels, since |f| has kinks.
double Integrate(const std::function<double(double)> &f, double a, double b) {
    double sum = 0;
    for (int i = 0; i < 64; ++i)
        sum += boost::math::quadrature::gauss_kronrod<double, 31>::integrate(
            f, a + (b - a) * i / 64, a + (b - a) * (i + 1) / 64, 4, 1e-10);
    return sum;
}

TEST(Filter, ValuesAndIntegralAgreeWithQuadrature) {
    for (const Case &c : Cases()) {
        const Filter filter(c.kind, c.p);
        const double rx = static_cast<double>(c.p.radius.x), ry = static_cast<double>(c.p.radius.y);
        double f = 1, absF = 1;
        for (const double r : {rx, ry}) {
            f *= Integrate([&](double x) { return Reference(c, x, r); }, -r, r);
            absF *= Integrate([&](double x) { return std::abs(Reference(c, x, r)); }, -r, r);
        }
        EXPECT_NEAR(filter.Integral() / f, 1, 3e-6) << c.name;
        EXPECT_NEAR(filter.AbsIntegral() / absF, 1, 3e-6) << c.name;
        RNG rng(3);
        for (int i = 0; i < 1000; ++i) {
            const double x = rx * 1.2 * (2 * static_cast<double>(rng.UniformFloat()) - 1);
            const double y = ry * 1.2 * (2 * static_cast<double>(rng.UniformFloat()) - 1);
            const Point2f p{static_cast<float>(x), static_cast<float>(y)};
            const double expected =
                Reference(c, static_cast<double>(p.x), rx) * Reference(c, static_cast<double>(p.y), ry);
            EXPECT_NEAR(static_cast<double>(filter.Evaluate(p)), expected, 2e-7 * (1 + std::abs(expected)))
                << c.name;
        }
    }
}

// The mean of weight * g(offset) is the integral of f g over that of f, for waves g of several lengths and
// for powers of x. One axis at a time, on midpoints; the other axis stands at its centre, where f is
// positive, so that the weight holds its ratio of integrals of |f| and f as a factor.
TEST(Filter, SamplesHaveTheExpectationOfTheWeightedFilter) {
    for (const Case &c : Cases()) {
        const Filter filter(c.kind, c.p);
        for (int axis = 0; axis < 2; ++axis) {
            const double r = static_cast<double>(c.p.radius[axis]),
                         other = static_cast<double>(c.p.radius[1 - axis]);
            const std::function<double(double)> tests[] = {[](double) { return 1.; },
                                                           [](double x) { return x; },
                                                           [](double x) { return x * x; },
                                                           [](double x) { return x * x * x * x; },
                                                           [](double x) { return std::cos(2 * x + 0.3); },
                                                           [](double x) { return std::cos(7 * x); },
                                                           [](double x) { return std::exp(x); }};
            const double whole = Integrate([&](double x) { return Reference(c, x, r); }, -r, r);
            const double factor =
                Integrate([&](double x) { return std::abs(Reference(c, x, other)); }, -other, other) /
                Integrate([&](double x) { return Reference(c, x, other); }, -other, other);
            constexpr int n = 1 << 17;
            std::vector<FilterSample> samples;
            for (int i = 0; i < n; ++i) {
                const auto u = static_cast<float>((i + 0.5) / n);
                samples.push_back(filter.Sample(axis == 0 ? Point2f{u, 0.5f} : Point2f{0.5f, u}));
            }
            for (size_t k = 0; k < std::size(tests); ++k) {
                const auto &g = tests[k];
                const double exact =
                    Integrate([&](double x) { return Reference(c, x, r) * g(x); }, -r, r) / whole;
                double mean = 0;
                for (const FilterSample &s : samples)
                    mean += static_cast<double>(s.weight) *
                            g(static_cast<double>(axis == 0 ? s.offset.x : s.offset.y));
                mean /= n * factor;
                // Midpoints lose up to a cell where the weight changes sign, at eight places at most.
                const double largest = std::max({1., std::abs(g(r)), std::abs(g(-r))});
                const bool lobes = filter.AbsIntegral() > 1.001 * filter.Integral();
                EXPECT_NEAR(mean, exact, (lobes ? 10. / n : 1e-5) * largest)
                    << c.name << " axis " << axis << " function " << k;
            }
        }
    }
}

// Offsets stay inside, the weight's sign is the filter's, and the mean weight is 1: the product of the axes'
// means, of which each is taken with the other axis at its centre.
TEST(Filter, WeightsHaveMeanOne) {
    for (const Case &c : Cases()) {
        const Filter filter(c.kind, c.p);
        constexpr int n = 100000;
        double sum[2] = {};
        bool negative = false;
        for (int i = 0; i < n; ++i)
            for (int axis = 0; axis < 2; ++axis) {
                const float u = (static_cast<float>(i) + 0.5f) / n;
                const FilterSample s = filter.Sample(axis == 0 ? Point2f{u, 0.5f} : Point2f{0.5f, u});
                sum[axis] += static_cast<double>(s.weight) / n;
                const float f = filter.Evaluate(s.offset);
                negative |= f < -1e-4f;
                ASSERT_LE(std::abs(s.offset.x), c.p.radius.x) << c.name;
                ASSERT_LE(std::abs(s.offset.y), c.p.radius.y) << c.name;
                if (std::abs(f) > 1e-4f) {
                    ASSERT_GT(s.weight * f, 0) << c.name << " at " << s.offset;
                }
            }
        const double centre = static_cast<double>(filter.Sample({0.5f, 0.5f}).weight);
        EXPECT_NEAR(sum[0] * sum[1] / centre, 1, 2e-4) << c.name;
        // Exactly 1 where there is no negative lobe: white stays white without dividing.
        if (negative) {
            EXPECT_GT(centre, 1.01) << c.name;
        } else {
            EXPECT_EQ(centre, 1) << c.name;
        }
    }
}

Entity Named(const std::string &type) {
    Entity entity;
    entity.type = type;
    return entity;
}
Entity With(const std::string &type, const std::string &name, double value) {
    Entity entity = Named(type);
    Param p;
    p.type = ParamType::Float;
    p.name = name;
    p.numbers = {value};
    entity.params.params.push_back(std::move(p));
    return entity;
}

// At the ends of the unit square the samples of every filter of the table, at defaults, narrow and wide, lie
// in its footprint, on the side that the random number asks for: the share of |f| left of them is the number.
TEST(MakeFilter, SamplesHoldAtTheEnds) {
    for (const PluginInfo &row : FilterPlugins().rows)
        for (const double width : {0., 1e-3, 1.5, 1000.}) {
            const Filter filter = MakeFilter(width > 0 ? With(std::string(row.name), "xwidth", width)
                                                       : Named(std::string(row.name)));
            const double r{filter.Radius().x};
            const auto mass = [&](double a, double b) {
                return Integrate(
                    [&](double x) {
                        return std::abs(double{filter.Evaluate({static_cast<float>(x), 0})});
                    },
                    a, b);
            };
            const double total = mass(-r, 0) + mass(0, r);
            ForEachEnd([&](const Point2f &u) {
                const FilterSample s = filter.Sample(u);
                EXPECT_LE(std::abs(s.offset.x), filter.Radius().x) << row.name << width << u;
                EXPECT_LE(std::abs(s.offset.y), filter.Radius().y) << row.name << width << u;
                const float value = filter.Evaluate(s.offset);
                EXPECT_TRUE(std::isfinite(s.weight) && value * s.weight >= 0) << row.name << width << u;
            });
            for (const float u : kEndsOfU) {
                const double x{filter.Sample({u, 0.5f}).offset.x};
                const double left = x < 0 ? mass(-r, x) : mass(-r, 0) + mass(0, x);
                // A float holds a place within the footprint to 1.2e-7 of the radius
                EXPECT_NEAR(left / total, double{u}, 2e-5 + 1.2e-7 * r) << row.name << " " << width;
            }
        }
}

TEST(MakeFilter, HasPbrtsDefaults) {
    const struct {
        const char *name;
        FilterKind kind;
        float radius;
    } cases[] = {{"box", FilterKind::Box, 0.5f},
                 {"triangle", FilterKind::Triangle, 2},
                 {"gaussian", FilterKind::Gaussian, 2},
                 {"mitchell", FilterKind::Mitchell, 2},
                 {"sinc", FilterKind::Sinc, 4}};
    for (const auto &c : cases) {
        const Filter filter = MakeFilter(Named(c.name));
        EXPECT_EQ(filter.Kind(), c.kind);
        EXPECT_EQ(filter.Radius(), Vector2f(c.radius, c.radius));
        EXPECT_EQ(MakeFilter(With(c.name, "xwidth", 1.25)).Radius(), Vector2f(1.25f, c.radius));
        for (const double bad : {0., -1., std::numeric_limits<double>::quiet_NaN()})
            EXPECT_THROW(MakeFilter(With(c.name, "ywidth", bad)), Error) << c.name << " " << bad;
    }
    // Mitchell's recommended filter at the centre: (6 - 2 B) / 6 squared.
    EXPECT_NEAR(MakeFilter(Named("mitchell")).Evaluate({0, 0}), Sqr(8. / 9), 1e-6);
    EXPECT_NEAR(MakeFilter(With("mitchell", "B", 0)).Evaluate({0, 0}), 1, 1e-6);
    EXPECT_THROW(MakeFilter(With("gaussian", "alpha", 0)), Error);
    EXPECT_THROW(MakeFilter(With("sinc", "tau", -1)), Error);
    try {
        MakeFilter(Named("gausian"));
        FAIL() << "an unknown filter was taken";
    } catch (const Error &e) {
        EXPECT_NE(std::string(e.what()).find("\"gaussian\""), std::string::npos) << e.what();
    }
}

} // namespace
} // namespace cuticle
