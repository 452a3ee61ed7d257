// A path tracer of its own for a block of parallel hairs, in double precision: the truth that the program's
// is held against. It includes nothing of the program.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

namespace block_truth {

constexpr double kTurn = 6.283185307179586476925;

// A vector; y runs along the hairs, from root to tip.
struct V {
    double x, y, z;
};
inline V operator+(V a, V b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline V operator*(V a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline V Outer(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double Inner(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline V Unit(V a) { return a * (1 / std::sqrt(Inner(a, a))); }

// How a path goes on from a hair.
enum class Leave {
    Facing, // from anywhere on the half of the tube that faces the new direction
    Tube,   // from the tube's surface: where the ray came in, or where it comes out after p chords inside
    Ribbon, // from the ribbon that the last ray saw; its own hair is not met again
    Skip,   // as in pbrt-v3: from the ribbon, moved by two widths and more along its normal
    Along   // from the ribbon, where the first two widths along the ray meet nothing
};
struct Rule {
    Leave leave;
    bool mirrored;  // h with pbrt-v3's sign
    bool tiltToTip; // the tilt of the scales with pbrt-v3's sign
};

// A matte disk; its normal is along an axis. A radius of 0: none.
struct Disk {
    V at = {0, 0, 0}, normal = {0, 1, 0};
    double radius = 0;
};
// The path tracer of n x n hairs of unit length around the origin, on a lattice with cells of 1 / n, and of a
// matte disk. The light is 1 from everywhere.
class BlockTruth {
  public:
    static constexpr int kHairs = 100, kMaxDepth = 32;
    static constexpr double kWidth = 0.0075, kDisk = 0.1, kEta = 1.55;

    // The absorption is found from a colour as Chiang et al. do.
    BlockTruth(double color, double betaM, double betaN, double alphaDegrees, const Disk &disk, Rule rule)
        : rule_(rule), disk_(disk), alpha_(alphaDegrees * kTurn / 360 * (rule.tiltToTip ? -1 : 1)) {
        const double b = betaN, d = 5.969 - 0.215 * b + 2.532 * b * b - 10.73 * std::pow(b, 3) +
                                    5.574 * std::pow(b, 4) + 0.245 * std::pow(b, 5);
        sigma_ = std::pow(std::log(color) / d, 2);
        const double root = 0.726 * betaM + 0.812 * betaM * betaM + 3.7 * std::pow(betaM, 20);
        v_[0] = root * root, v_[1] = v_[0] / 4, v_[2] = v_[3] = 4 * v_[0];
        s_ = std::sqrt(kTurn / 16) * (0.265 * b + 1.194 * b * b + 5.372 * std::pow(b, 22));
    }

    // One path's share of the light along a ray.
    double Path(V o, V d, std::mt19937_64 *engine) {
        engine_ = engine;
        double throughput = 1;
        int own = -1;    // the hair that is not met
        double skip = 0; // what is nearer is not met
        for (int scattered = 0;; ++scattered) {
            Hit hit;
            const bool found = NearestHair(o, d, own, skip, &hit);
            const double toDisk = Inner(disk_.at + o * -1, disk_.normal) / Inner(d, disk_.normal);
            const V onDisk = o + d * toDisk, from = onDisk + disk_.at * -1;
            if (toDisk > 1e-9 && (!found || toDisk < hit.t) &&
                Inner(from, from) < disk_.radius * disk_.radius) {
                if (scattered == kMaxDepth)
                    return 0;
                const double r = std::sqrt(U()), phi = kTurn * U();
                const V n = disk_.normal * (Inner(d, disk_.normal) > 0 ? -1 : 1);
                const V t = std::abs(n.x) > 0.5 ? V{0, 1, 0} : V{1, 0, 0}, b = Outer(n, t);
                o = onDisk;
                d = t * (r * std::cos(phi)) + b * (r * std::sin(phi)) + n * std::sqrt(1 - r * r);
                throughput *= kDisk;
                own = -1, skip = 0;
                continue;
            }
            if (!found)
                return throughput;
            if (scattered == kMaxDepth)
                return 0;
            throughput *= Scatter(hit, &o, &d, &own);
            skip = rule_.leave == Leave::Along ? 2 * kWidth : 0;
        }
    }

  private:
    struct Hit {
        double t;      // where the ray comes nearest to the hair's axis
        double offset; // of the ray from the axis there, in radii, in the sense in which azimuths grow
        double cx, cz; // the axis
        int hair;
    };
    double U() { return std::uniform_real_distribution<double>(0, 1)(*engine_); }

    // Walks through the lattice cell by cell; a cell holds one hair and all of it.
    bool NearestHair(V o, V d, int own, double skip, Hit *hit) const {
        const double across2 = d.x * d.x + d.z * d.z;
        if (!(across2 > 0))
            return false; // straight along the hairs
        // Where is the ray in the block?
        double in = 0, out = INFINITY;
        const auto clip = [&](double p, double v) {
            if (v == 0) {
                if (std::abs(p) > 0.5)
                    out = -1;
                return;
            }
            const double a = (-0.5 - p) / v, b = (0.5 - p) / v;
            in = std::max(in, std::min(a, b)), out = std::min(out, std::max(a, b));
        };
        clip(o.x, d.x), clip(o.z, d.z);
        if (!(in <= out))
            return false;
        const auto cell = [](double p) {
            return std::clamp(static_cast<int>(std::floor((p + 0.5) * kHairs)), 0, kHairs - 1);
        };
        int i = cell(o.x + in * d.x), k = cell(o.z + in * d.z);
        const auto middle = [](int c) { return (c + 0.5) / kHairs - 0.5; };
        const auto wall = [&](int c, double p, double v) {
            return v == 0 ? INFINITY : (middle(c) + (v > 0 ? 0.5 : -0.5) / kHairs - p) / v;
        };
        const double across = std::sqrt(across2);
        while (i >= 0 && i < kHairs && k >= 0 && k < kHairs) {
            const double cx = middle(i), cz = middle(k), px = cx - o.x, pz = cz - o.z;
            const double t = (px * d.x + pz * d.z) / across2;
            const double offset = (pz * d.x - px * d.z) / across / (kWidth / 2);
            const int hair = i * kHairs + k;
            if (hair != own && std::abs(offset) <= 1 && t > skip && std::abs(o.y + t * d.y) <= 0.5) {
                *hit = {t, offset, cx, cz, hair};
                return true;
            }
            if (wall(i, o.x, d.x) < wall(k, o.z, d.z))
                i += d.x > 0 ? 1 : -1;
            else
                k += d.z > 0 ? 1 : -1;
        }
        return false;
    }

    static double Fresnel(double cosine) {
        const double ct = std::sqrt(1 - (1 - cosine * cosine) / (kEta * kEta));
        const double s = (cosine - kEta * ct) / (cosine + kEta * ct),
                     p = (kEta * cosine - ct) / (kEta * cosine + ct);
        return (s * s + p * p) / 2;
    }

    // Scatters by the model of Chiang et al., sampled exactly: the share is the sum of the lobes' energies.
    double Scatter(const Hit &hit, V *o, V *d, int *own) {
        const double r = kWidth / 2;
        // Azimuths count from x to z. The ray came from the azimuth phiO and meets the circle at phiO + turn.
        const double across = std::sqrt(d->x * d->x + d->z * d->z), phiO = std::atan2(-d->z, -d->x);
        const double sinO = -d->y, thetaO = std::atan2(sinO, across), cosO = across;
        const double turn = std::asin(std::clamp(hit.offset, -1., 1.));
        // A mirror there has its normal at phiO + turn, so it sends the light to phiO + 2 turn. The model's
        // Phi(0) = -2 gammaO says the same if gammaO = -turn.
        const double gammaO = rule_.mirrored ? turn : -turn;
        const double etaPrime = std::sqrt(kEta * kEta - sinO * sinO) / cosO;
        const double gammaT = std::asin(std::sin(gammaO) / etaPrime);
        const double sinT = sinO / kEta, cosT = std::sqrt(1 - sinT * sinT);
        const double f = Fresnel(cosO * std::cos(gammaO)),
                     T = std::exp(-sigma_ * 2 * std::cos(gammaT) / cosT);
        const double a[4] = {f, (1 - f) * (1 - f) * T, (1 - f) * (1 - f) * f * T * T,
                             (1 - f) * (1 - f) * f * f * T * T * T / (1 - f * T)};
        const double sum = a[0] + a[1] + a[2] + a[3];
        double choice = U() * sum;
        int p = 0;
        while (p < 3 && choice >= a[p])
            choice -= a[p++];
        // The cone of the lobe, tilted by the scales: theta_i + theta_o = -2 alpha, +alpha, +4 alpha.
        const double tilt[4] = {2, -1, -4, 0}, theta = thetaO + tilt[p] * alpha_;
        const double u = U(), cosCone = 1 + v_[p] * std::log(u + (1 - u) * std::exp(-2 / v_[p]));
        const double sinI =
            std::clamp(-cosCone * std::sin(theta) + std::sqrt(std::max(0., 1 - cosCone * cosCone)) *
                                                        std::cos(kTurn * U()) * std::abs(std::cos(theta)),
                       -1., 1.);
        double phi = phiO + kTurn * U();
        if (p < 3) {
            const double edge = 1 / (1 + std::exp(kTurn / 2 / s_)), q = edge + U() * (1 - 2 * edge);
            phi = phiO + 2 * p * gammaT - 2 * gammaO + p * kTurn / 2 + s_ * std::log(q / (1 - q));
        }
        const double cosI = std::sqrt(1 - sinI * sinI);
        const V wi = {cosI * std::cos(phi), sinI, cosI * std::sin(phi)};

        // Where does the new ray start?
        V at = *o + *d * hit.t; // on the ribbon
        *own = hit.hair;
        if (rule_.leave == Leave::Tube) {
            const double inside = 2 * r * std::cos(gammaT) * sinT / cosT;
            const int chords = std::min(p, 3);
            const double place = phiO + turn + chords * (kTurn / 2 + 2 * gammaT);
            const double entered = at.y - d->y * r * std::cos(turn) / across;
            at = {hit.cx + r * std::cos(place), std::clamp(entered - chords * inside, -0.5, 0.5),
                  hit.cz + r * std::sin(place)};
        } else if (rule_.leave == Leave::Facing) {
            const double place = phi + std::asin(2 * U() - 1);
            at = {hit.cx + r * std::cos(place), at.y, hit.cz + r * std::sin(place)};
        } else if (rule_.leave == Leave::Along) {
            *own = -1;
        } else if (rule_.leave == Leave::Skip) {
            // The ribbon's normal: square to the hair, in the plane of hair and ray.
            const V n = {d->x / across, 0, d->z / across};
            // An error of two widths in each coordinate.
            const double way = 2 * kWidth * (std::abs(n.x) + std::abs(n.z));
            at = at + n * (Inner(n, wi) < 0 ? -way : way);
            *own = -1;
        }
        *o = at;
        *d = wi;
        return sum;
    }

    Rule rule_;
    Disk disk_;
    double alpha_, sigma_, s_, v_[4];
    std::mt19937_64 *engine_ = nullptr;
};

} // namespace block_truth
