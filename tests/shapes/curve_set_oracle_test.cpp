// CurveSet against an oracle that finds all roots in extended precision, for each instruction set that runs
// here.
#include "core/isa.h"
#include "core/sampling.h"
#include "shapes/curve_oracle.h"
#include "shapes/curve_set.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <random>

namespace cuticle {
namespace {

using oracle::Candidate;
using oracle::Real;

struct Random {
    explicit Random(uint64_t seed) : engine(seed) {}
    double operator()() { return std::uniform_real_distribution<double>(0, 1)(engine); }
    double operator()(double a, double b) { return a + (b - a) * (*this)(); }
    Vector3d Direction() {
        const double z = (*this)(-1, 1), phi = (*this)(0, 2 * kPi<double>),
                     r = std::sqrt(std::max(0., 1 - z * z));
        return {r * std::cos(phi), r * std::sin(phi), z};
    }
    std::mt19937_64 engine;
};

struct Model {
    std::vector<CurveSegment> segments;
    std::vector<CurveType> types{CurveType::Flat};
    std::unordered_map<uint32_t, RibbonNormals> ribbons;
};

CurveSegment MakeSegment(const Vector3d (&p)[4], double w0, double w1, uint32_t group = 0) {
    return {{Point3f(p[0]), Point3f(p[1]), Point3f(p[2]), Point3f(p[3])},
            {static_cast<float>(w0), static_cast<float>(w1)},
            group};
}

// A strand of `n` segments through smoothly turning directions, joined with a common tangent (a B-spline).
void AddStrand(Random *random, Model *m, int n, double step, double turn, double width) {
    std::vector<Point3f> points;
    Vector3d p = random->Direction() * std::cbrt((*random)()), d = random->Direction();
    for (int i = 0; i < n + 3; ++i) {
        points.push_back(Point3f(p));
        p += d * step;
        d = Normalize(d + random->Direction() * turn);
    }
    CurveList strand;
    AppendCurve(points.data(), points.size(), CurveBasis::BSpline, 3, static_cast<float>(width),
                static_cast<float>(0.3 * width), 0, &strand);
    m->segments.insert(m->segments.end(), strand.begin(), strand.end());
}

struct Case {
    const char *name;
    std::function<Model(Random *)> model;
    // A ray that aims at `target`, a point near a curve with radius r and tangent t.
    std::function<Ray(Random *, const Vector3d &target, double r, const Vector3d &t)> ray;
};

Ray AimFrom(const Vector3d &origin, const Vector3d &target, double stretch = 1) {
    Ray ray;
    ray.o = Point3f(origin);
    ray.d = Vector3f(Normalize(target - Vector3d(ray.o)) * stretch);
    return ray;
}
Ray AimFromAround(Random *random, const Vector3d &target, double, const Vector3d &) {
    return AimFrom(random->Direction() * 3., target, (*random)(0.1, 10));
}
// Starts among the curves, as a bounce does: a few radii to the whole model away.
Ray AimFromWithin(Random *random, const Vector3d &target, double r, const Vector3d &) {
    return AimFrom(target + random->Direction() * std::exp((*random)(std::log(0.5 * r), std::log(1.))),
                   target);
}
// Aims nearly along the curve: the angle between 1e-4 and 0.3.
Ray AimAlong(Random *random, const Vector3d &target, double, const Vector3d &t) {
    const double angle = std::exp((*random)(std::log(1e-4), std::log(0.3)));
    return AimFrom(target - Normalize(t + random->Direction() * angle) * (*random)(0.1, 3.), target);
}

const Case kCases[] = {
    {"straight",
     [](Random *random) {
         Model m;
         for (int i = 0; i < 40; ++i) {
             const Vector3d a = random->Direction(), e = random->Direction() * (*random)(0.1, 1);
             m.segments.push_back(
                 MakeSegment({a, a + e / 3., a + e * (2. / 3), a + e}, (*random)(0.001, 0.02), 0.002));
         }
         return m;
     },
     AimFromAround},
    {"curly",
     [](Random *random) {
         Model m;
         for (int i = 0; i < 8; ++i)
             AddStrand(random, &m, 8, 0.05, 0.9, 0.004);
         return m;
     },
     AimFromAround},
    {"bounce",
     [](Random *random) {
         Model m;
         for (int i = 0; i < 8; ++i)
             AddStrand(random, &m, 8, 0.05, 0.4, 0.01);
         return m;
     },
     AimFromWithin},
    {"thin", // 1e-6 of the scene
     [](Random *random) {
         Model m;
         for (int i = 0; i < 8; ++i)
             AddStrand(random, &m, 5, 0.2, 0.5, 1e-6);
         return m;
     },
     AimFromAround},
    {"far", // the camera 1e5 widths away
     [](Random *random) {
         Model m;
         for (int i = 0; i < 8; ++i)
             AddStrand(random, &m, 5, 0.1, 0.5, 0.01);
         return m;
     },
     [](Random *random, const Vector3d &target, double, const Vector3d &) {
         return AimFrom(random->Direction() * 1000., target);
     }},
    {"bent", // bends as tight as the curve is wide, cusps, loops
     [](Random *random) {
         Model m;
         for (int i = 0; i < 40; ++i) {
             const Vector3d c = random->Direction() * 0.7;
             Vector3d p[4];
             for (Vector3d &q : p)
                 q = c + random->Direction() * 0.2;
             m.segments.push_back(MakeSegment(p, (*random)(0.005, 0.2), (*random)(0.005, 0.2)));
         }
         return m;
     },
     AimFromAround},
    {"end-on",
     [](Random *random) {
         Model m;
         for (int i = 0; i < 8; ++i)
             AddStrand(random, &m, 5, 0.1, 0.05, 0.01);
         return m;
     },
     AimAlong},
    {"degenerate", // control points that coincide, widths that vanish at one end or both, closed loops
     [](Random *random) {
         Model m;
         for (int i = 0; i < 48; ++i) {
             const Vector3d c = random->Direction() * 0.7;
             const auto near = [&] { return c + random->Direction() * 0.3; };
             const Vector3d a = near(), b = near(), d = near();
             const double w0 = (*random)(0, 0.05), w1 = (*random)(0, 0.05);
             switch (i % 8) {
             case 0:
                 m.segments.push_back(MakeSegment({a, a, b, d}, w0, w1));
                 break;
             case 1:
                 m.segments.push_back(MakeSegment({a, b, d, d}, w0, w1));
                 break;
             case 2:
                 m.segments.push_back(MakeSegment({a, a, b, b}, w0, w1));
                 break;
             case 3:
                 m.segments.push_back(MakeSegment({a, b, d, a}, w0, w1));
                 break;
             case 4:
                 m.segments.push_back(MakeSegment({a, b, b, d}, 0, w1));
                 break;
             case 5:
                 m.segments.push_back(MakeSegment({a, a, a, b}, w0, 0));
                 break;
             case 6:
                 m.segments.push_back(MakeSegment({a, a, a, a}, w0, w1));
                 break;
             case 7:
                 m.segments.push_back(MakeSegment({a, b, a, b}, w0, w1));
                 break;
             }
         }
         return m;
     },
     AimFromAround},
    {"ribbon",
     [](Random *random) {
         Model m;
         m.types = {CurveType::Ribbon};
         for (int i = 0; i < 8; ++i)
             AddStrand(random, &m, 5, 0.1, 0.5, 0.02);
         for (uint32_t i = 0; i < m.segments.size(); ++i)
             m.ribbons[i] = {{Normal3f(random->Direction()), Normal3f(random->Direction())}};
         return m;
     },
     AimFromAround},
};

// How sharply the oracle's answer must stand for a ray to be judged. A ray that passes the edge of a curve
// within kEdge of half its width, or an end of a segment within kEnd in u, is on the border: either answer is
// right there.
constexpr Real kEdge = 1e-6L, kEnd = 5e-6L;

struct Tally {
    size_t rays = 0, hits = 0, border = 0, missed = 0, invented = 0, farther = 0;
    std::vector<double> vError, tError; // t as distance, in radii
    double Percentile(std::vector<double> &x, double p) const {
        if (x.empty())
            return 0;
        const auto at = x.begin() + static_cast<std::ptrdiff_t>(p * static_cast<double>(x.size() - 1));
        std::nth_element(x.begin(), at, x.end());
        return *at;
    }
};

void Judge(const Model &m, const CurveSet &set, const Ray &ray, Tally *tally) {
    std::vector<Candidate> all;
    for (uint32_t i = 0; i < m.segments.size(); ++i) {
        const auto normals = m.ribbons.find(i);
        oracle::FindAll(m.segments[i], i, normals == m.ribbons.end() ? nullptr : &normals->second, ray, kEnd,
                        10 * kEdge, &all);
    }
    const Real length = Vector3d(ray.d).Length();
    const auto radius = [&](const Candidate &c) {
        return static_cast<Real>(std::max(m.segments[c.segment].width[0], m.segments[c.segment].width[1])) /
               2;
    };
    // t is handed out in single precision.
    const auto allowance = [&](const Candidate &c) {
        return 0x1p-22L * std::abs(c.t) + 1e-4L * radius(c) / length;
    };
    const auto sure = [&](const Candidate &c) {
        return c.margin > kEdge && c.u >= 0 && c.u <= 1 && c.t - allowance(c) > ray.tMin &&
               c.nanTaint < 1e-7L;
    };
    const Candidate *nearest = nullptr;
    bool possible = false;
    for (const Candidate &c : all) {
        if (sure(c) && (!nearest || c.t < nearest->t))
            nearest = &c;
        possible |= c.t + allowance(c) > ray.tMin;
    }
    CurveHit hit;
    const bool found = set.Intersect(ray, nullptr, &hit);
    const bool occluded = set.Occluded(ray, nullptr);
    EXPECT_EQ(found, occluded);
    ++tally->rays;
    tally->hits += nearest != nullptr;
    if (!nearest && possible)
        ++tally->border;
    if (nearest && !found)
        ++tally->missed;
    if (!found)
        return;
    const Candidate *match = nullptr;
    for (const Candidate &c : all)
        if (c.segment == hit.segment && std::abs(c.t - hit.t) <= allowance(c) &&
            (!match || std::abs(c.t - hit.t) + std::abs(c.u - hit.u) <
                           std::abs(match->t - hit.t) + std::abs(match->u - hit.u)))
            match = &c;
    if (!match) {
        ++tally->invented;
        return;
    }
    if (nearest && match != nearest && match->t > nearest->t + allowance(*nearest))
        ++tally->farther;
    if (sure(*match)) {
        tally->vError.push_back(static_cast<double>(std::abs(match->v - hit.v)));
        tally->tError.push_back(static_cast<double>(std::abs(match->t - hit.t) * length / radius(*match)));
    }
}

class CurveSetOracle : public testing::TestWithParam<std::tuple<const char *, size_t>> {};

TEST_P(CurveSetOracle, AgreesWithAllRoots) {
    const auto [isa, index] = GetParam();
    const Case &c = kCases[index];
    CurveSetOptions options;
    options.isa = isa;
    const char *environment = std::getenv("CUTICLE_ORACLE_RAYS");
    const size_t wanted = environment ? static_cast<size_t>(std::atoll(environment)) : 12000;
    constexpr size_t kSets = 8;
    Tally tally;
    for (size_t set = 0; set < kSets; ++set) {
        Random random(1000 * index + set);
        const Model m = c.model(&random);
        options.split = static_cast<int>(set % 4);
        const CurveSet curves(m.segments, m.types, m.ribbons, options);
        for (size_t i = 0; i < wanted / kSets; ++i) {
            // Aim at a point across the width of each segment in turn.
            const CurveSegment &s = m.segments[i % m.segments.size()];
            const Vector3d cp[4] = {Vector3d(s.cp[0]), Vector3d(s.cp[1]), Vector3d(s.cp[2]),
                                    Vector3d(s.cp[3])};
            const double u = random();
            Vector3d tangent;
            const Vector3d p = EvalBezier(cp, u, &tangent);
            const double r = std::max(0.5 * Lerp<double>(u, s.width[0], s.width[1]), 1e-7);
            if (!(tangent.LengthSquared() > 0))
                tangent = random.Direction();
            tangent = Normalize(tangent);
            const Vector3d across = Normalize(Cross(tangent, random.Direction()));
            Judge(m, curves, c.ray(&random, p + across * (r * random(-1.3, 1.3)), r, tangent), &tally);
        }
    }
    const double perMillion = 1e6 / static_cast<double>(tally.rays);
    std::cout << c.name << ", " << isa << ": " << tally.rays << " rays, " << tally.hits << " hits, "
              << tally.border << " on the border, missed " << tally.missed << ", invented " << tally.invented
              << ", farther " << tally.farther << "; v error median " << tally.Percentile(tally.vError, 0.5)
              << ", p99 " << tally.Percentile(tally.vError, 0.99) << ", largest "
              << tally.Percentile(tally.vError, 1) << "; t error p99 " << tally.Percentile(tally.tError, 0.99)
              << " radii" << std::endl;
    EXPECT_LE(static_cast<double>(tally.missed) * perMillion, 3);
    EXPECT_LE(static_cast<double>(tally.invented) * perMillion, 3);
    EXPECT_LE(static_cast<double>(tally.farther) * perMillion, 3);
    EXPECT_LE(tally.Percentile(tally.vError, 0.99), 1e-4);
    EXPECT_GT(tally.hits, tally.rays / 4);
    EXPECT_LT(tally.border, 1 + tally.rays / 500);
}

std::vector<const char *> Isas() {
    std::vector<const char *> isas;
    for (const InstructionSet isa : SupportedIsas())
        isas.push_back(IsaName(isa));
    return isas;
}
INSTANTIATE_TEST_SUITE_P(Isas, CurveSetOracle,
                         testing::Combine(testing::ValuesIn(Isas()),
                                          testing::Range(size_t(0), std::size(kCases))),
                         [](const auto &param) {
                             std::string name = kCases[std::get<1>(param.param)].name;
                             std::replace(name.begin(), name.end(), '-', '_');
                             return std::string(std::get<0>(param.param)) + "_" + name;
                         });

} // namespace
} // namespace cuticle
