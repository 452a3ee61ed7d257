#include "core/error.h"
#include "core/parallel.h"
#include "grooms/head_mesh.h"
#include "grooms/head_shape.h"
#include "grooms/procedural.h"
#include "grooms/scalp.h"

#include <gtest/gtest.h>

#include <map>
#include <sys/resource.h>

namespace cuticle {
namespace {

struct Kind {
    const char *kind, *style;
};
constexpr Kind kAll[] = {{"head", "straight"}, {"head", "wavy"},  {"head", "curly"},
                         {"fur-ball", ""},     {"hair-cube", ""}, {"ball", ""}};
constexpr Kind kHeads[] = {kAll[0], kAll[1], kAll[2]}; // hair that hangs

// Every style of a head, as kinds.
std::vector<Kind> Styles() {
    std::vector<Kind> styles;
    for (const HeadStyleInfo &style : HeadStyleTable())
        styles.push_back({"head", style.name.data()});
    return styles;
}

GroomParams Small(const Kind &k, int strands = 400) {
    GroomParams p = MakeGroomParams(k.kind, k.style);
    p.strands = strands;
    return p;
}

double Length(std::span<const Point3f> strand) {
    double sum = 0;
    for (size_t i = 0; i + 1 < strand.size(); ++i)
        sum += static_cast<double>((strand[i + 1] - strand[i]).Length());
    return sum;
}

TEST(Procedural, CountsAndFiniteness) {
    for (const Kind &k : kAll)
        for (const int strands : {1, 100, 2500}) {
            const Groom g = MakeGroom(Small(k, strands));
            EXPECT_EQ(g.StrandCount(), static_cast<size_t>(strands)) << k.kind << k.style;
            for (const Point3f &p : g.points)
                ASSERT_TRUE(IsFinite(p)) << k.kind << k.style;
            for (size_t i = 0; i < g.StrandCount(); ++i) {
                ASSERT_GT(Length(g.Strand(i)), 0) << k.kind << k.style << " strand " << i;
                ASSERT_GT(g.Width(i, 0), 0);
            }
        }
}

TEST(Procedural, SameBitsForAnyThreadsAndAnyRange) {
    for (const Kind &k : kAll) {
        const GroomParams p = Small(k);
        Groom one;
        {
            const ThreadLimit limit(1);
            one = MakeGroom(p);
        }
        EXPECT_EQ(one.points, MakeGroom(p).points) << k.kind << k.style;
        const auto source = MakeStrandSource(p);
        Groom pieces = source->Range(0, 123);
        pieces.Append(source->Range(123, 124));
        pieces.Append(source->Range(124, 100000));
        EXPECT_EQ(one.points, pieces.points) << k.kind << k.style;
        EXPECT_EQ(one.strandOffsets, pieces.strandOffsets);
    }
}

TEST(Procedural, AnotherSeedIsAnotherGroom) {
    for (const Kind &k : kAll) {
        if (std::string(k.kind) == "hair-cube")
            continue; // nothing about it is random
        GroomParams p = Small(k, 50);
        const Groom a = MakeGroom(p);
        p.seed = 2;
        const Groom b = MakeGroom(p);
        size_t same = 0;
        for (size_t i = 0; i < a.points.size(); ++i)
            same += a.points[i] == b.points[i];
        EXPECT_EQ(same, 0u) << k.kind << k.style;
    }
}

// The stated bound: points keep kHeadClearance outside the head once they are a centimetre from the root, and
// none is deeper than kRootDepth. Between points the curve is checked at a coarser bound, where it bends over
// the head.
TEST(Procedural, HairStaysOutsideTheHead) {
    for (const Kind &k : Styles()) {
        const Groom g = MakeGroom(Small(k, 1500));
        double deepest = 0;
        size_t inside = 0, checked = 0;
        ForEachSegment(g, {}, [&](const BezierSegment &s, size_t) {
            for (int i = 0; i < 4; ++i) {
                const float u = static_cast<float>(i) / 4, v = 1 - u;
                const Point3f p = s.cp[0] * (v * v * v) + s.cp[1] * (3 * v * v * u) +
                                  s.cp[2] * (3 * v * u * u) + s.cp[3] * (u * u * u);
                const float d = HeadDistance(p);
                ++checked;
                inside += d < -kRootDepth;
                deepest = std::max(deepest, -static_cast<double>(d));
            }
        });
        for (size_t i = 0; i < g.StrandCount(); ++i) {
            const auto strand = g.Strand(i);
            double travelled = 0;
            for (size_t j = 0; j < strand.size(); ++j) {
                if (j > 0)
                    travelled += static_cast<double>((strand[j] - strand[j - 1]).Length());
                ASSERT_GE(HeadDistance(strand[j]), j == 0 ? -kRootDepth : -1e-3f)
                    << k.style << " strand " << i << " point " << j;
            }
        }
        std::cout << k.style << ": curves reach " << deepest << " cm under the skin, " << inside << " of "
                  << checked << " places deeper than a root\n";
        EXPECT_LT(deepest, 0.1) << k.style;
        EXPECT_LT(static_cast<double>(inside), 1e-4 * static_cast<double>(checked)) << k.style;
    }
}

TEST(Procedural, RootsLieOnTheScalpAndCoverIt) {
    const double expected = 4000 / static_cast<double>(Scalp().Area()); // per square centimetre
    for (const Kind &k : Styles()) {
        const Groom g = MakeGroom(Small(k, 4000));
        std::map<std::pair<int, int>, int> cells;
        for (size_t i = 0; i < g.StrandCount(); ++i) {
            const Point3f root = g.Strand(i)[0];
            EXPECT_LT(HeadDistance(root), 0);
            EXPECT_GE(HeadDistance(root), -kRootDepth);
            // Within the hairline, to the 3 mm of the scalp's cells.
            EXPECT_GT(HairDensity(root + Normalize(Point3f{0, 11, -1} - root) * 0.3f), 0) << root;
            EXPECT_LT(std::abs(root.x), 8);
            EXPECT_GT(root.y, -10);
            ++cells[{static_cast<int>(std::floor(root.x)), static_cast<int>(std::floor(root.z))}];
        }
        // The crown, seen from above: 12 cells of a square centimetre, about as many roots in each.
        for (int x = -2; x < 2; ++x)
            for (int z = -3; z < 0; ++z) {
                const double n = cells[{x, z}];
                EXPECT_GT(n, 0.4 * expected) << k.style << " at " << x << ", " << z;
                EXPECT_LT(n, 2.5 * expected) << k.style << " at " << x << ", " << z;
            }
    }
}

TEST(Procedural, FaceStaysFree) {
    for (const Kind &k : Styles()) {
        const Groom g = MakeGroom(Small(k, 3000));
        size_t over = 0;
        for (const Point3f &p : g.points)
            over += p.z > 7 && std::abs(p.x) < 4 && p.y < 4 && p.y > -9;
        EXPECT_LT(static_cast<double>(over), 2e-3 * static_cast<double>(g.points.size())) << k.style;
    }
}

TEST(Procedural, LengthsAndFall) {
    for (const Kind &k : kHeads) {
        const GroomParams p = Small(k, 1500);
        const Groom g = MakeGroom(p);
        double longest = 0, mean = 0;
        size_t down = 0;
        for (size_t i = 0; i < g.StrandCount(); ++i) {
            const auto strand = g.Strand(i);
            const double length = Length(strand);
            longest = std::max(longest, length);
            mean += length / static_cast<double>(g.StrandCount());
            down += strand.back().y < strand.front().y;
        }
        // A turn of a helix of radius a and pitch b is sqrt(b^2 + (2 pi a)^2) long.
        const double a = static_cast<double>(p.curlRadius), b = static_cast<double>(p.curlLength);
        const double longer = std::sqrt(1 + Sqr(2 * kPi<double> * 1.35 * a / b));
        EXPECT_LT(longest, 1.35 * longer * static_cast<double>(p.length)) << k.style;
        EXPECT_GT(mean, 0.35 * static_cast<double>(p.length)) << k.style;
        EXPECT_GT(static_cast<double>(down), 0.97 * static_cast<double>(g.StrandCount())) << k.style;
    }
    // Twice as long a groom has longer strands.
    GroomParams p = Small(kHeads[0], 300);
    const Groom shortHair = MakeGroom(p);
    p.length *= 2;
    const Groom longHair = MakeGroom(p);
    double ratio = 0;
    for (size_t i = 0; i < 300; ++i)
        ratio += Length(longHair.Strand(i)) / Length(shortHair.Strand(i)) / 300;
    EXPECT_GT(ratio, 1.5);
    EXPECT_LT(ratio, 2.5);
}

// Curls are what the style says: the angle that curly strands turn through is several times that of straight
// ones.
TEST(Procedural, StylesDiffer) {
    const auto turning = [](const Kind &k) {
        const Groom g = MakeGroom(Small(k, 300));
        double sum = 0;
        for (size_t i = 0; i < g.StrandCount(); ++i) {
            const auto s = g.Strand(i);
            for (size_t j = 1; j + 1 < s.size(); ++j) {
                const Vector3f a = s[j] - s[j - 1], b = s[j + 1] - s[j];
                sum += static_cast<double>(std::atan2(Cross(a, b).Length(), Dot(a, b)));
            }
        }
        return sum / 300;
    };
    const double straight = turning(kHeads[0]), wavy = turning(kHeads[1]), curly = turning(kHeads[2]);
    EXPECT_GT(wavy, 1.5 * straight);
    EXPECT_GT(curly, 1.5 * wavy);
}

// A style is what its name says: where the tips of nine hairs in ten are, whatever the way they took there.
TEST(Procedural, StylesAreWhatTheyAreCalled) {
    const auto share = [](const char *style, const auto &holds) {
        const Groom g = MakeGroom(Small({"head", style}, 1500));
        size_t n = 0;
        for (size_t i = 0; i < g.StrandCount(); ++i)
            n += holds(g.Strand(i));
        return static_cast<double>(n) / static_cast<double>(g.StrandCount());
    };
    using Points = std::span<const Point3f>;
    EXPECT_GT(share("bun",
                    [](Points s) {
                        return (s.back() - Point3f{0, 5.5f, -12}).Length() < 5;
                    }),
              0.85)
        << "behind the head, in a ball";
    EXPECT_GT(share("braid", [](Points s) { return std::abs(s.back().x) < 2.5f && s.back().y < -10; }), 0.8)
        << "in one string down the back";
    EXPECT_GT(share("short", [](Points s) { return Length(s) < 7.5 && s.back().y > -9; }), 0.95)
        << "no longer than two fingers, above the neck";
    EXPECT_GT(share("bob", [](Points s) { return s.back().y < -5 && s.back().y > -15; }), 0.7)
        << "cut at the height of the chin, which is at -10";
    EXPECT_GT(share("afro", [](Points s) { return HeadDistance(s.back()) > 4; }), 0.75) << "standing off";
    EXPECT_GT(share("combed-back", [](Points s) { return s.back().z < s.front().z; }), 0.9);
    EXPECT_LT(share("straight", [](Points s) { return s.back().y > -9; }), 0.35) << "long";
}

TEST(Procedural, WidthsTaperAndScale) {
    GroomParams p = Small(kHeads[0], 10);
    p.widthScale = 3;
    const Groom g = MakeGroom(p);
    for (size_t i = 0; i < g.StrandCount(); ++i) {
        // 70 micrometres, from hair to hair between 60 and 80, as human hair is
        EXPECT_GE(g.Width(i, 0), 3 * 0.0059f);
        EXPECT_LE(g.Width(i, 0), 3 * 0.0081f);
        EXPECT_FLOAT_EQ(g.Width(i, g.PointCount(i) - 1), g.Width(i, 0) * p.tip);
        EXPECT_LT(g.Width(i, 8), g.Width(i, 0));
    }
}

// Colours: none unless asked for, from root to tip, a part of the hairs without pigment.
TEST(Procedural, ColorsGoFromRootToTip) {
    GroomParams p = Small(kHeads[0], 4000);
    EXPECT_FALSE(MakeGroom(p).hasColor);
    EXPECT_TRUE(MakeGroom(p).pointColors.empty());
    p.tipColor = Spectrum(0.1f, 0.4f, 0.9f);
    EXPECT_THROW(MakeGroom(p), Error) << "dye on no hair";
    p.rootColor = Spectrum(0.2f, 0.1f, 0.05f);
    p.colorVariation = 0;
    Groom g = MakeGroom(p);
    ASSERT_TRUE(g.hasColor);
    for (size_t i = 0; i < g.StrandCount(); ++i) {
        EXPECT_EQ(g.Color(i, 0), *p.rootColor);
        EXPECT_EQ(g.Color(i, 1e9f), *p.tipColor);
    }
    EXPECT_EQ(g.points, MakeGroom(Small(kHeads[0], 4000)).points) << "colours move no hair";
    // Grey hairs: a binomial count, four standard deviations
    p.tipColor.reset();
    p.grey = 0.3f;
    g = MakeGroom(p);
    size_t grey = 0;
    for (size_t i = 0; i < g.StrandCount(); ++i)
        grey += g.Color(i, 0)[0] > 0.5f;
    EXPECT_NEAR(static_cast<double>(grey), 0.3 * 4000, 4 * std::sqrt(4000 * 0.3 * 0.7));
    // The variation is of the absorption, (ln c)^2: its mean stays, its range is what was asked for
    p.grey = 0;
    p.colorVariation = 0.4f;
    g = MakeGroom(p);
    double mean = 0;
    for (size_t i = 0; i < g.StrandCount(); ++i) {
        const double absorption = Sqr(std::log(static_cast<double>(g.Color(i, 0)[1])) / std::log(0.1));
        EXPECT_GT(absorption, 0.599);
        EXPECT_LT(absorption, 1.401);
        mean += absorption / 4000;
    }
    EXPECT_NEAR(mean, 1, 4 * 0.4 / std::sqrt(3. * 4000)) << "four standard deviations of the uniform mean";
    // A range of strands has the colours of the whole
    EXPECT_EQ(MakeStrandSource(p)->Range(100, 101).pointColors[0], g.Color(100, 0));
}

TEST(Procedural, FurStandsOnItsBall) {
    const GroomParams p = Small(kAll[3], 2000);
    const Groom g = MakeGroom(p);
    for (size_t i = 0; i < g.StrandCount(); ++i) {
        EXPECT_NEAR(g.Strand(i)[0].Length(), p.radius, 2 * kRootDepth);
        for (size_t k = 1; k < g.PointCount(i); ++k) {
            ASSERT_GE(g.Strand(i)[k].Length(), p.radius - 1e-4f);
            ASSERT_LE(g.Strand(i)[k].Length(), p.radius + 1.5f * p.length);
        }
    }
}

TEST(Procedural, HairCubeIsARegularCube) {
    const Groom g = MakeGroom(MakeGroomParams("hair-cube"));
    ASSERT_EQ(g.StrandCount(), 10000u);
    EXPECT_EQ(g.PointCount(0), 2u);
    const Bounds3f b = g.Bounds();
    // Hairs as wide as their spacing fill the side of 2.
    EXPECT_NEAR(b.Diagonal().y, 2, 1e-6);
    EXPECT_NEAR(b.Diagonal().x + g.Width(0, 0), 2, 1e-5);
    EXPECT_NEAR(b.Diagonal().z + g.Width(0, 0), 2, 1e-5);
}

TEST(Procedural, BallStaysInItsBall) {
    GroomParams p = Small(kAll[5], 5000);
    p.radius = 3;
    const Groom g = MakeGroom(p);
    EXPECT_EQ(g.PointCount(0), 9u);
    Vector3d centre;
    for (const Point3f &q : g.points) {
        ASSERT_LE(q.Length() + g.Width(0, 0), 3);
        centre += Vector3d(q) / static_cast<double>(g.points.size());
    }
    // Even all around: the centre of 45,000 points of a ball of radius 3, three standard deviations of 5,000
    // independent strands each axis.
    EXPECT_LT(centre.Length(), 3 * 3 / std::sqrt(5000.));
}

TEST(Procedural, ParametersAreChecked) {
    GroomParams colored = MakeGroomParams("ball");
    SetGroomColor(&colored, "root_color", std::string("0.5,1,0"));
    EXPECT_EQ(*colored.rootColor, Spectrum(0.5f, 1, 0));
    for (const char *wrong :
         {"", "1", "1,1", "1,1,", "1,1,1,", "1,1,1,1", "a,b,c", "1,1,2", "1,1,nan", "-1,0,0"})
        EXPECT_THROW(SetGroomColor(&colored, "root_color", std::string(wrong)), Error) << wrong;
    EXPECT_THROW(SetGroomColor(&colored, "mid_color", Spectrum(0.5f)), Error);
    EXPECT_THROW(MakeGroomParams("hat"), Error);
    EXPECT_THROW(MakeGroomParams("head", "permed"), Error);
    EXPECT_THROW(MakeGroomParams("ball", "curly"), Error);
    GroomParams p = MakeGroomParams("head", "curly");
    EXPECT_THROW(SetGroomParam(&p, "strands", 0), Error);
    EXPECT_THROW(SetGroomParam(&p, "strands", 1.5), Error);
    EXPECT_THROW(SetGroomParam(&p, "strands", std::nan("")), Error);
    EXPECT_THROW(SetGroomParam(&p, "strands", std::string("many")), Error);
    EXPECT_THROW(SetGroomParam(&p, "side", 1), Error);
    EXPECT_THROW(SetGroomParam(&p, "radius", 1), Error);
    try {
        SetGroomParam(&p, "strand", 1);
        FAIL() << "a misspelt parameter was taken";
    } catch (const Error &e) {
        EXPECT_NE(std::string(e.what()).find("strands"), std::string::npos) << e.what();
    }
    SetGroomParam(&p, "strands", std::string("1e3"));
    EXPECT_EQ(p.strands, 1000);
    p.strands = -5; // a struct filled by hand is checked as well
    EXPECT_THROW(MakeGroom(p), Error);
    for (const GroomParamInfo &info : GroomParamTable())
        for (const std::string_view kind : GroomKinds())
            if (GroomReads(kind, info)) {
                const double v = GetGroomParam(MakeGroomParams(kind), info.name);
                EXPECT_GE(v, info.min) << info.name << " of " << kind;
                EXPECT_LE(v, info.max) << info.name << " of " << kind;
            }
}

TEST(Procedural, ExtremeParametersStayFinite) {
    for (const Kind &k : kAll)
        for (const GroomParamInfo &info : GroomParamTable()) {
            if (!GroomReads(k.kind, info) || info.name == "strands" || info.name == "seed")
                continue;
            for (const double v : {info.min, std::min(info.max, 2000.)}) {
                GroomParams p = Small(k, 16);
                SetGroomParam(&p, info.name, v);
                if (info.name != "locks" && info.kinds != "all" && info.kinds != "side")
                    p.locks = 20;
                const Groom g = MakeGroom(p);
                for (const Point3f &q : g.points)
                    ASSERT_TRUE(IsFinite(q)) << k.kind << k.style << " " << info.name << " " << v;
            }
        }
}

// The mesh is the head: vertices on its surface, a closed surface, normals that look outward.
TEST(HeadShape, MeshLiesOnTheSurfaceAndIsClosed) {
    const SurfaceMesh mesh = MakeHeadMesh(0.8f);
    ASSERT_GT(mesh.indices.size(), 3000u);
    for (size_t i = 0; i < mesh.points.size(); ++i) {
        EXPECT_NEAR(mesh.normals[i].Length(), 1, 1e-4);
        EXPECT_LT(std::abs(HeadDistance(mesh.points[i])), mesh.points[i].y > -26 ? 1e-3f : 0.1f)
            << mesh.points[i];
    }
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    double volume = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const uint32_t t[3] = {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
        for (size_t k = 0; k < 3; ++k)
            ++edges[{t[k], t[(k + 1) % 3]}];
        volume +=
            static_cast<double>(Dot(mesh.points[t[0]], Cross(mesh.points[t[1]], mesh.points[t[2]]))) / 6;
    }
    size_t open = 0;
    for (const auto &[edge, n] : edges)
        open += edges.count({edge.second, edge.first}) == 0;
    EXPECT_EQ(open, 0u);
    // Litres of a head, neck and shoulders, positive when triangles face outward.
    EXPECT_GT(volume, 6500);
    EXPECT_LT(volume, 12000);
    EXPECT_THROW(MakeHeadMesh(0.001f), Error);
}

// No cube that the surface crosses is passed over: there are as many vertices as cubes of the whole lattice
// with corners on both sides, and they are the same for any number of threads.
TEST(HeadShape, MeshMissesNothing) {
    for (const float spacing : {0.25f, 0.37f, 1.7f, 5.f}) {
        const Point3f low{-24, -28.5f, -15}, high{24, 14, 14};
        size_t size[3];
        for (int axis = 0; axis < 3; ++axis)
            size[axis] = static_cast<size_t>((high[axis] - low[axis]) / spacing) + 2;
        std::vector<float> values;
        for (size_t z = 0; z < size[2]; ++z)
            for (size_t y = 0; y < size[1]; ++y)
                for (size_t x = 0; x < size[0]; ++x)
                    values.push_back(HeadDistance(
                        low + Vector3f{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)} *
                                  spacing));
        size_t crossed = 0;
        for (size_t z = 0; z + 1 < size[2]; ++z)
            for (size_t y = 0; y + 1 < size[1]; ++y)
                for (size_t x = 0; x + 1 < size[0]; ++x) {
                    int inside = 0;
                    for (size_t k = 0; k < 8; ++k)
                        inside +=
                            values[x + (k & 1) + size[0] * (y + (k >> 1 & 1) + size[1] * (z + (k >> 2)))] < 0;
                    crossed += inside > 0 && inside < 8;
                }
        const SurfaceMesh mesh = MakeHeadMesh(spacing);
        EXPECT_EQ(mesh.points.size(), crossed) << spacing;
        const ThreadLimit limit(1);
        const SurfaceMesh one = MakeHeadMesh(spacing);
        EXPECT_EQ(one.points, mesh.points);
        EXPECT_EQ(one.normals, mesh.normals);
        EXPECT_EQ(one.indices, mesh.indices);
    }
}

// A fine mesh costs what its surface costs: at a spacing of 1 mm the space around it has 57 million corners,
// of which memory holds next to none.
TEST(HeadShape, AFineMeshIsBoundedByItsSurface) {
    const auto peak = [] {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        return usage.ru_maxrss; // KB
    };
    const auto before = peak();
    const SurfaceMesh mesh = MakeHeadMesh(0.1f);
    EXPECT_GT(mesh.points.size(), 300000u);
    EXPECT_LT(peak() - before, 1024 * 200);
}

TEST(HeadShape, PushingOutGetsOut) {
    for (int i = 0; i < 2000; ++i) {
        const float t = static_cast<float>(i) / 2000;
        const Point3f p{6 * std::sin(50 * t), -8 + 18 * t, -6 + 12 * std::cos(31 * t)};
        EXPECT_GE(HeadDistance(PushOutOfHead(p, 0.1f)), 0.099f) << p;
    }
}

} // namespace
} // namespace cuticle
