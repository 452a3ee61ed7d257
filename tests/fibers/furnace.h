// Deterministic integration of a fiber's scattering over the sphere, for lobes of any width.
//
// Gauss-Legendre panels, uniform in a variable t that passes slowly over the peaks: t = k u + sum asinh((x -
// c) / w) over the centres c and widths w. Directions of binary32 are known to 6e-8 only, which is 1/500 of
// the narrowest lobe: the integrand is therefore evaluated at the rounded direction and carried to the node
// by its derivative along the panel.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace cuticle::furnace {

inline constexpr size_t kNodes = 8;   // in a panel
inline constexpr double kPanel = 0.9; // in t; 8 nodes in it integrate lobes to 1e-9

struct Rule {
    std::array<double, kNodes> x, w; // on [-1, 1]
    std::array<std::array<double, kNodes>, kNodes>
        d; // d[i][j]: the derivative at x_i of the polynomial that is 1 at x_j
};
inline const Rule &GaussLegendre() {
    static const Rule rule = [] {
        Rule r;
        for (size_t i = 0; i < kNodes; ++i) {
            double x = std::cos(std::numbers::pi * (static_cast<double>(i) + 0.75) / (kNodes + 0.5)), dp = 0;
            for (int step = 0; step < 50; ++step) {
                double p0 = 1, p1 = x;
                for (size_t n = 2; n <= kNodes; ++n) {
                    const double k = static_cast<double>(n);
                    const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                    p0 = p1, p1 = p2;
                }
                dp = static_cast<double>(kNodes) * (x * p1 - p0) / (x * x - 1);
                x -= p1 / dp;
            }
            r.x[i] = x, r.w[i] = 2 / ((1 - x * x) * dp * dp);
        }
        for (size_t i = 0; i < kNodes; ++i) {
            r.d[i][i] = 0;
            for (size_t j = 0; j < kNodes; ++j) {
                if (j == i)
                    continue;
                double weight = 1;
                for (size_t k = 0; k < kNodes; ++k)
                    if (k != i && k != j)
                        weight *= (r.x[i] - r.x[k]) / (r.x[j] - r.x[k]);
                r.d[i][j] = weight / (r.x[j] - r.x[i]);
                r.d[i][i] += 1 / (r.x[i] - r.x[j]);
            }
        }
        return r;
    }();
    return rule;
}

struct Peak {
    double centre, width;
};

// Nodes in x with the weights of dx, a whole number of panels.
struct Mesh {
    std::vector<double> x, weight;
    std::vector<double> edges;   // of the panels, one more than there are
    std::vector<double> perUnit; // dx for one unit of the panel's own variable
};

// Over u in [a, b], x = position(u), dx/du = slope(u).
template <typename Position, typename Slope>
Mesh MakeMesh(double a, double b, double k, const std::vector<Peak> &peaks, double panelInT,
              Position position, Slope slope) {
    const auto t = [&](double u, double *slopeOfT) {
        double sum = k * u, rate = k;
        const double x = position(u), dx = slope(u);
        for (const Peak &p : peaks) {
            sum += std::asinh((x - p.centre) / p.width);
            rate += dx / std::hypot(x - p.centre, p.width);
        }
        *slopeOfT = rate;
        return sum;
    };
    double rate = 0;
    const double t0 = t(a, &rate), t1 = t(b, &rate);
    const auto panels = static_cast<size_t>(std::ceil((t1 - t0) / panelInT));
    const double half = (t1 - t0) / static_cast<double>(panels) / 2;
    // Finds t(u) = target: Newton's method, kept inside the interval that is known to hold the place.
    const auto solve = [&](double target, double from) {
        double to = b, u = from;
        for (int step = 0; step < 200; ++step) {
            const double miss = t(u, &rate) - target, previous = u;
            (miss < 0 ? from : to) = u;
            u -= miss / rate;
            if (!(u > from && u < to))
                u = (from + to) / 2;
            if (std::abs(u - previous) <= 1e-15 * (1e-3 + std::abs(u)))
                break;
        }
        t(u, &rate);
        return u;
    };
    Mesh mesh;
    const Rule &rule = GaussLegendre();
    double low = a;
    for (size_t panel = 0; panel < panels; ++panel) {
        const double middle = t0 + half * (2 * static_cast<double>(panel) + 1);
        mesh.edges.push_back(position(low));
        for (size_t i = kNodes; i-- > 0;) { // the rule's nodes fall
            const double u = solve(middle + half * rule.x[i], low);
            mesh.x.push_back(position(u));
            mesh.perUnit.push_back(half * slope(u) / rate);
            mesh.weight.push_back(rule.w[i] * half * slope(u) / rate);
        }
        low = panel + 1 < panels ? solve(middle + half, low) : b;
    }
    mesh.edges.push_back(position(b));
    return mesh;
}

// theta over (-pi/2, pi/2), through sin theta = tanh u: towards the poles the nodes close up.
inline Mesh ThetaMesh(const std::vector<Peak> &peaks, double panelInT = kPanel) {
    return MakeMesh(
        -20, 20, 1, peaks, panelInT, [](double u) { return std::atan(std::sinh(u)); },
        [](double u) { return 1 / std::cosh(u); });
}
// An azimuth once around, beginning opposite the mean of the peaks.
inline Mesh PhiMesh(std::vector<Peak> peaks, double from, double panelInT = kPanel) {
    constexpr double turn = 2 * std::numbers::pi;
    for (Peak &p : peaks)
        p.centre -= turn * std::floor((p.centre - from) / turn);
    // The peaks' images beside the interval count too.
    const std::vector<Peak> inside = peaks;
    for (const Peak &p : inside) {
        peaks.push_back({p.centre - turn, p.width});
        peaks.push_back({p.centre + turn, p.width});
    }
    return MakeMesh(
        from, from + turn, 2, peaks, panelInT, [](double u) { return u; }, [](double) { return 1.; });
}

// The derivative of tabulated values at node i along its panel, in x; stride: from node to node.
inline double Slope(const Mesh &mesh, const double *values, size_t stride, size_t i) {
    const Rule &rule = GaussLegendre();
    const size_t first = i - i % kNodes;
    double sum = 0;
    for (size_t j = 0; j < kNodes; ++j) // nodes were laid down from the rule's last to its first
        sum += rule.d[kNodes - 1 - (i - first)][kNodes - 1 - j] * values[(first + j) * stride];
    return sum / mesh.perUnit[i];
}

// Integrates f over the mesh, where f(x, &actual) evaluates near x and tells where.
template <typename F>
double Integrate(const Mesh &mesh, F f) {
    std::vector<double> values(mesh.x.size()), off(mesh.x.size());
    for (size_t i = 0; i < mesh.x.size(); ++i) {
        double actual = mesh.x[i];
        values[i] = f(mesh.x[i], &actual);
        off[i] = actual - mesh.x[i];
    }
    double sum = 0;
    for (size_t i = 0; i < mesh.x.size(); ++i)
        sum += mesh.weight[i] * (values[i] - off[i] * Slope(mesh, values.data(), 1, i));
    return sum;
}

} // namespace cuticle::furnace
