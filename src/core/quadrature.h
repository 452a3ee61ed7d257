//> Tabulate Gauss-Legendre rules
#pragma once

#include "core/vecmath.h"

#include <cmath>
#include <vector>

namespace cuticle {

// Nodes in (-1, 1), rising; weights add up to 2. n: 1 to kMaxNodes. All rules are computed once, by Newton's
// method on the Legendre polynomials.
struct GaussLegendreRule {
    std::vector<double> x, w;
};
inline constexpr size_t kMaxNodes = 64;
inline GaussLegendreRule MakeGaussLegendreRule(size_t n) {
    GaussLegendreRule rule{std::vector<double>(n), std::vector<double>(n)};
    const double degree = static_cast<double>(n);
    for (size_t i = 0; i < n; ++i) {
        double x = -std::cos(kPi<double> * (static_cast<double>(i) + 0.75) / (degree + 0.5)), slope = 1,
               step = 1;
        for (int k = 0; k < 20 && std::abs(step) > 1e-16; ++k) {
            double before = 1, p = x;
            for (size_t order = 2; order <= n; ++order) {
                const auto m = static_cast<double>(order);
                const double next = ((2 * m - 1) * x * p - (m - 1) * before) / m;
                before = p, p = next;
            }
            slope = degree * (x * p - before) / (x * x - 1);
            x -= step = p / slope;
        }
        rule.x[i] = x, rule.w[i] = 2 / ((1 - x * x) * slope * slope);
    }
    return rule;
}
inline const GaussLegendreRule &GaussLegendre(size_t n) {
    static const std::vector<GaussLegendreRule> rules = [] {
        std::vector<GaussLegendreRule> all;
        for (size_t k = 1; k <= kMaxNodes; ++k)
            all.push_back(MakeGaussLegendreRule(k));
        return all;
    }();
    return rules[n - 1];
}

} // namespace cuticle
//<
