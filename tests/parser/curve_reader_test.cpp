#include "parser/test_scenes.h"
#include "shapes/curve.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace cuticle {
namespace {

TEST(ParserCurves, OneSegment) {
    const auto s = Parse(World("ReverseOrientation Material \"hair\"\n"
                               "Shape \"curve\" \"point P\" [ -2 -1 -1  2 2 0  -2 -2 0  2 1 -1 ] \"float "
                               "width0\" [.35] \"float width1\" [.15]\n"
                               "Shape \"curve\" \"float width\" .5 \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] "
                               "\"string type\" \"cylinder\" \"integer splitdepth\" 4\n"
                               "Shape \"curve\" \"float width1\" .25 \"float width\" .5 \"point P\" [0 0 0 1 "
                               "0 0 2 0 0 3 0 0] \"string type\" [\"flat\"]\n"
                               "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]"));
    const auto &seg = s.curves.segments;
    ASSERT_EQ(seg.size(), 4u);
    EXPECT_EQ(seg[0].cp[0], Point3f(-2, -1, -1));
    EXPECT_EQ(seg[0].cp[3], Point3f(2, 1, -1));
    const float widths[4][2] = {
        {.35f, .15f}, {.5f, .5f}, {.5f, .25f}, {1, 1}}; // pbrt-v3: width gives both defaults
    for (size_t i = 0; i < 4; ++i)
        for (int k = 0; k < 2; ++k)
            EXPECT_EQ(seg[i].width[k], widths[i][k]) << i << " " << k;
    ASSERT_EQ(s.curveGroups.size(), 2u);
    EXPECT_EQ(seg[0].group, seg[2].group);
    EXPECT_EQ(s.curveGroups[seg[0].group].type, CurveType::Flat);
    EXPECT_EQ(s.curveGroups[seg[1].group].type, CurveType::Cylinder);
    EXPECT_EQ(s.curveGroups[0].state.material, 1);
    EXPECT_TRUE(s.curveGroups[0].state.reverseOrientation);
}

TEST(ParserCurves, TransformationScalesPointsAndWidths) {
    const std::string curve = "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" .5\n";
    const auto s = Parse(World("Translate 1 2 3 Rotate 90 0 0 1 Scale -2 2 2 " + curve));
    ExpectNear(s.curves.segments.at(0).cp[3], {1, -4, 3}, 2e-6f);
    EXPECT_NEAR(s.curves.segments[0].width[0], 1, 1e-6);
    EXPECT_EQ(WarningOf(World("Rotate 30 1 2 3 Scale 2.001 2 2 " + curve)), "");
    // What scales unevenly leaves both as they are, and stands beside them
    EXPECT_TRUE(Parse(World("Scale 2.001 2 2 " + curve)).unevenCurves.empty());
    const auto uneven = Parse(World("Translate 0 0 1 Scale 1 1 8 " + curve + curve + "Identity " + curve));
    EXPECT_EQ(uneven.curves.segments.size(), 1u);
    ASSERT_EQ(uneven.unevenCurves.size(), 1u);
    ASSERT_EQ(uneven.unevenCurves[0].curves.segments.size(), 2u);
    EXPECT_EQ(uneven.unevenCurves[0].curves.segments[0].width[0], .5f);
    EXPECT_EQ(uneven.unevenCurves[0].curves.segments[0].cp[3], (Point3f{3, 0, 0}));
    EXPECT_EQ(uneven.unevenCurves[0].toParent.Point({1, 2, 1}), (Point3f{1, 2, 9}));
    EXPECT_EQ(FlushWarnings(), 0u);
}

TEST(ParserCurves, BasesDegreesAndRibbons) {
    const auto s = Parse(
        World("Shape \"curve\" \"integer degree\" 2 \"point P\" [0 0 0 1 1 0 2 0 0 3 -1 0 4 0 0]\n"
              "Shape \"curve\" \"string basis\" \"bspline\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0]\n"
              "Shape \"curve\" \"string type\" \"ribbon\" \"normal N\" [0 0 2 0 2 0] \"point P\" [0 0 0 1 0 "
              "0 2 0 0 3 0 0]\n"
              "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0 5 0 0 6 0 0] \"float width0\" 0"));
    const auto &seg = s.curves.segments;
    ASSERT_EQ(seg.size(), 2u + 2u + 1u + 2u);
    // Degree elevation: the cubic's inner points are 1/3 and 2/3 of the way to the quadratic's.
    ExpectNear(seg[0].cp[1], {2.0f / 3, 2.0f / 3, 0}, 1e-6f);
    // A uniform B-spline with evenly spaced points runs evenly from point 1 on.
    ExpectNear(seg[2].cp[0], {1, 0, 0}, 1e-6f);
    ExpectNear(seg[3].cp[3], {3, 0, 0}, 1e-6f);
    ASSERT_EQ(s.curves.ribbonNormals.size(), 1u);
    const RibbonNormals n = s.curves.ribbonNormals.at(4);
    ExpectNear(n.n[0], {0, 0, 1}, 1e-6f);
    ExpectNear(n.n[1], {0, 1, 0}, 1e-6f);
    EXPECT_NEAR(seg[5].width[1], 0.5, 1e-6);
    EXPECT_NEAR(seg[6].width[0], 0.5, 1e-6);
    EXPECT_NEAR(seg[6].width[1], 1, 1e-6);
}

TEST(ParserCurves, RibbonNormalsGoWithTheTransformation) {
    const auto s = Parse(World(
        "Scale 3 3 3 Rotate 90 1 0 0 Shape \"curve\" \"string type\" \"ribbon\" \"normal N\" [0 0 1 0 0 1] "
        "\"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]"));
    ExpectNear(s.curves.ribbonNormals.at(0).n[0], {0, -1, 0}, 1e-6f);
}

// Random statements in all spellings, those of the short way and others, under changing states: both readers
// must give the same bytes.
// Makes statements as files hold them, ordinary ones and some that only the general reader takes.
class RandomStatements {
  public:
    // One Shape "curve".
    std::string Curve() {
        const int degree = random_() % 4 ? 3 : 2,
                  segments = random_() % 3 ? 1 : 1 + static_cast<int>(random_() % 3);
        const bool spline = random_() % 4 == 0, ribbon = random_() % 6 == 0;
        const int points = spline ? segments + degree : segments * degree + 1;
        std::vector<std::string> parameters;
        std::string list = Pick("\"point P\" [", "\"point P\"[ ", "\"point3 P\" [ ", "\"point\tP\" [ ");
        for (int i = 0; i < 3 * points; ++i)
            list += Number() + Pick(" ", "  ", "\n", "\t", " # c\n", " ");
        parameters.push_back(list + "]");
        if (degree == 2)
            parameters.push_back(Pick("\"integer degree\" 2", "\"integer degree\" [ 2 ]"));
        else if (random_() % 8 == 0)
            parameters.push_back("\"integer degree\" 3");
        if (spline)
            parameters.push_back(Pick("\"string basis\" \"bspline\"", "\"string basis\" [\"bspline\"]"));
        if (ribbon) {
            list = "\"normal N\" [";
            for (int i = 0; i < 3 * (segments + 1); ++i)
                list += " " + Number();
            parameters.push_back(list + "]");
            parameters.push_back("\"string type\" \"ribbon\"");
        } else if (random_() % 2) {
            parameters.push_back(Pick("\"string type\" \"flat\"", "\"string type\" [ \"cylinder\" ]",
                                      "\"string type\" \"cylinder\""));
        }
        AddWidths(&parameters);
        std::shuffle(parameters.begin(), parameters.end(), random_);
        std::string statement = Pick("Shape \"curve\"", "Shape\t\"curve\"", "Shape \"curve\"\r\n");
        for (const std::string &p : parameters)
            statement += Pick(" ", "\n  ", "\r\n") + p;
        return statement + Pick("\n", " ", "\n# end\n");
    }
    // A change of state now and then, one in 20 times; else "". With a curve of its own where it is a block.
    std::string Change() {
        switch (random_() % 40) {
        case 0:
            return "Rotate " + Number() + " 1 2 3\n";
        case 1: {
            const std::string change =
                Pick("AttributeBegin\n", "TransformBegin\n", "Material \"hair\" \"float eumelanin\" 1\n",
                     "ReverseOrientation\n", "Identity\n", "Translate 1 2 3\n", "Scale 1 1.5 1\n",
                     "AreaLightSource \"diffuse\"\n");
            if (!change.ends_with("Begin\n"))
                return change;
            return change + "Scale 2 2 2\nShape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 " + Number() +
                   " 0 0]\n" + (change.starts_with("Attribute") ? "AttributeEnd\n" : "TransformEnd\n");
        }
        default:
            return "";
        }
    }

  private:
    template <typename... Options>
    std::string Pick(Options... options) {
        const std::string list[] = {std::string(options)...};
        return list[random_() % sizeof...(options)];
    }
    std::string Number() {
        static constexpr const char *kFormats[] = {"%.3g", "%.9g", "%.17g", "%.6f", "%.2e", "%+.4f"};
        char text[64];
        const double v = (static_cast<double>(random_()) / 4294967296.0 - 0.5) *
                         std::pow(10, static_cast<int>(random_() % 9) - 3);
        std::snprintf(text, sizeof text, kFormats[random_() % std::size(kFormats)], v);
        return text;
    }
    void AddWidths(std::vector<std::string> *parameters) {
        if (random_() % 2)
            parameters->push_back(Pick("\"float width\" ", "\"float  width\" ") + Number());
        if (random_() % 2)
            parameters->push_back("\"float width0\" [" + Number() + Pick("]", " ]"));
        if (random_() % 2)
            parameters->push_back("\"float width1\" " + Number());
        if (random_() % 6 == 0)
            parameters->push_back("\"integer splitdepth\" 2");
        if (random_() % 10 == 0)
            parameters->push_back(
                Pick("\"float eumelanin\" .5", "\"texture beta_m\" \"t\"", "\"float unheard\" 1"));
    }
    std::mt19937 random_{11};
};

TEST(ParserCurves, FastAndGeneralReaderAgreeBitForBit) {
    RandomStatements make;
    std::string body = "Texture \"t\" \"float\" \"constant\" \"float value\" 1\n";
    constexpr size_t kStatements = 20000;
    for (size_t i = 0; i < kStatements; ++i)
        body += make.Change() + make.Curve();
    ParseOptions slow;
    slow.fastCurves = false;
    const SceneDescription a = Parse(World(body)), b = Parse(World(body), slow);
    FlushWarnings();
    static_assert(sizeof(CurveSegment) == 64, "no padding, so that bytes can be compared");
    size_t segments = 0, ribbons = 0;
    const auto expectSame = [&](const CurvePool &x, const CurvePool &y) {
        ASSERT_EQ(x.segments.size(), y.segments.size());
        segments += x.segments.size();
        for (size_t i = 0; i < x.segments.size(); ++i) {
            const CurveSegment s = x.segments[i], t = y.segments[i];
            ASSERT_EQ(std::memcmp(&s, &t, sizeof(CurveSegment)), 0) << "segment " << i;
        }
        ASSERT_EQ(x.ribbonNormals.size(), y.ribbonNormals.size());
        ribbons += x.ribbonNormals.size();
        for (const auto &[i, n] : x.ribbonNormals)
            ASSERT_EQ(std::memcmp(&n, &y.ribbonNormals.at(i), sizeof n), 0) << "ribbon " << i;
    };
    expectSame(a.curves, b.curves);
    ASSERT_EQ(a.unevenCurves.size(), b.unevenCurves.size());
    for (size_t k = 0; k < a.unevenCurves.size(); ++k) {
        EXPECT_EQ(a.unevenCurves[k].toParent, b.unevenCurves[k].toParent);
        expectSame(a.unevenCurves[k].curves, b.unevenCurves[k].curves);
    }
    EXPECT_GT(segments, kStatements);
    EXPECT_GT(ribbons, 1000u);
    EXPECT_GT(a.curves.segments.size(), 1000u);
    EXPECT_FALSE(a.unevenCurves.empty());
    ASSERT_EQ(a.curveGroups.size(), b.curveGroups.size());
    for (size_t i = 0; i < a.curveGroups.size(); ++i) {
        EXPECT_EQ(a.curveGroups[i].type, b.curveGroups[i].type);
        EXPECT_EQ(a.curveGroups[i].state, b.curveGroups[i].state);
    }
    EXPECT_EQ(a.materials.size(), b.materials.size());
}

TEST(ParserCurves, MemoryOfManyCurvesIsTheSegmentsAndLittleMore) {
    std::string body;
    for (int i = 0; i < 100000; ++i)
        body += "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" .01\n";
    const auto s = Parse(World(body));
    ASSERT_EQ(s.curves.segments.size(), 100000u);
    EXPECT_EQ(s.curveGroups.size(), 1u);
    const double held = static_cast<double>(s.curves.segments.MemoryBytes()) / 100000;
    EXPECT_LE(held, 64 + 8 + 21) << "bytes a curve, whose points have 64, with up to a large page to spare";

    // Strands of eight segments: 25 points of 16 bytes
    std::string strands, points;
    for (int k = 0; k < 25; ++k)
        points += fmt::format("{} 0 0 ", k);
    for (int i = 0; i < 20000; ++i)
        strands += "Shape \"curve\" \"point P\" [" + points + "] \"float width\" .01\n";
    const auto t = Parse(World(strands));
    ASSERT_EQ(t.curves.segments.size(), 160000u);
    EXPECT_LE(static_cast<double>(t.curves.segments.MemoryBytes()) / 160000, 50 + 2 + 13.2);
}

} // namespace
} // namespace cuticle
