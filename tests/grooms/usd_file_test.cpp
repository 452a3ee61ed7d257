#include "grooms/groom_file.h"
#include "grooms/hash.h"
#include "grooms/usd_file.h"
#include "strand_files.h"
#include "warnings.h"

#include <cmath>

namespace cuticle {
namespace {

using UsdFile = StrandFiles;

Groom Parse(const std::string &text) { return ParseUsdFile("#usda 1.0\n" + text, "x.usda"); }
// The message for text that begins on line 2.
std::string Message(const std::string &text) {
    return MessageOf([&] { Parse(text); });
}
std::string Curves(const std::string &inside) { return "def BasisCurves \"hair\" {\n" + inside + "\n}\n"; }

// Values of USD's bases, evaluated straight from their textbook polynomials.
double BasisValue(const std::string &basis, const double *p, double u) {
    const double v = 1 - u;
    if (basis == "bezier")
        return v * v * v * p[0] + 3 * v * v * u * p[1] + 3 * v * u * u * p[2] + u * u * u * p[3];
    if (basis == "bspline")
        return (v * v * v * p[0] + (3 * u * u * u - 6 * u * u + 4) * p[1] +
                (-3 * u * u * u + 3 * u * u + 3 * u + 1) * p[2] + u * u * u * p[3]) /
               6;
    return 0.5 * (2 * p[1] + (p[2] - p[0]) * u + (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]) * u * u +
                  (3 * p[1] - p[0] - 3 * p[2] + p[3]) * u * u * u);
}

Vector3d OnPiece(const BezierSegment &s, double u) {
    double v[3][4];
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 4; ++k)
            v[c][k] = static_cast<double>(s.cp[k][c]);
    return {BasisValue("bezier", v[0], u), BasisValue("bezier", v[1], u), BasisValue("bezier", v[2], u)};
}

std::vector<BezierSegment> PiecesOf(const Groom &g, size_t strand) {
    std::vector<BezierSegment> pieces;
    AppendSegments(g, strand, {}, &pieces);
    return pieces;
}

TEST_F(UsdFile, LinearCurvesKeepTheirPoints) {
    const Groom g =
        Parse(Curves("uniform token type = \"linear\"\n"
                     "int[] curveVertexCounts = [2, 3]\n"
                     "point3f[] points = [(0, 0, 0), (1, 2, 3), (-1, 0, .5), (1e1, +2, -3.), (4,5,6)]\n"
                     "float[] widths = [1, 2, 3, 4, 5]\n"
                     "color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] (\n"
                     "  interpolation = \"uniform\"\n)"));
    ASSERT_EQ(g.StrandCount(), 2u);
    EXPECT_EQ(g.spline, StrandSpline::Linear);
    EXPECT_EQ(g.Strand(1)[1], (Point3f{10, 2, -3}));
    EXPECT_EQ(g.pointWidths, (std::vector<float>{1, 2, 3, 4, 5}));
    EXPECT_EQ(g.StrandColor(0), Spectrum(1, 0, 0));
    EXPECT_EQ(g.StrandColor(1), Spectrum(0, 1, 0));
    const std::vector<BezierSegment> pieces = PiecesOf(g, 1);
    ASSERT_EQ(pieces.size(), 2u);
    for (const double u : {0., 0.25, 0.5, 1.}) // straight, at even speed
        EXPECT_LT(
            (OnPiece(pieces[0], u) - (Vector3d(-1, 0, 0.5) * (1 - u) + Vector3d(10, 2, -3) * u)).Length(),
            1e-6);
    EXPECT_EQ(FlushWarnings(), 0u);
}

// Every basis and wrap gives the curve that its polynomials describe.
TEST_F(UsdFile, CubicBasesAreTheirPolynomials) {
    const std::vector<Vector3d> p{{0, 0, 0},   {1, 0.5, 0}, {1.5, 2, 1}, {3, 2, 2},
                                  {2, 4, 2.5}, {1, 5, 4},   {0, 6, 4}};
    std::string points = "[";
    for (const Vector3d &q : p)
        points += "(" + std::to_string(q.x) + "," + std::to_string(q.y) + "," + std::to_string(q.z) + "),";
    points += "]";
    for (const std::string basis : {"bezier", "bspline", "catmullRom"})
        for (const std::string wrap : {"nonperiodic", "pinned"}) {
            SCOPED_TRACE(basis + " " + wrap);
            const Groom g =
                Parse(Curves("uniform token basis = \"" + basis + "\"\nuniform token wrap = \"" + wrap +
                             "\"\nint[] curveVertexCounts = [7]\npoint3f[] points = " + points +
                             "\nfloat[] widths = [0.1]"));
            EXPECT_EQ(g.width, 0.1f);
            std::vector<Vector3d> q = p;
            if (wrap == "pinned" && basis != "bezier") {
                q.insert(q.begin(), p[0] * 2 - p[1]);
                q.push_back(p[6] * 2 - p[5]);
            }
            const size_t step = basis == "bezier" ? 3 : 1;
            const std::vector<BezierSegment> pieces = PiecesOf(g, 0);
            ASSERT_EQ(pieces.size(), (q.size() - 4) / step + 1);
            for (size_t i = 0; i < pieces.size(); ++i)
                for (const double u : {0., 0.3, 0.5, 0.9, 1.}) {
                    Vector3d expected;
                    for (int c = 0; c < 3; ++c) {
                        double four[4];
                        for (size_t k = 0; k < 4; ++k)
                            four[k] = q[i * step + k][c];
                        expected[c] = BasisValue(basis, four, u);
                    }
                    EXPECT_LT((OnPiece(pieces[i], u) - expected).Length(), 2e-6) << i << " " << u;
                }
            if (wrap == "pinned") {
                EXPECT_LT((Vector3d(pieces.front().cp[0]) - p.front()).Length(), 1e-6);
                EXPECT_LT((Vector3d(pieces.back().cp[3]) - p.back()).Length(), 1e-6);
            }
        }
}

// Widths of each interpolation, at the joints of a B-spline of 5 points: 2 segments, 3 joints.
TEST_F(UsdFile, InterpolationsOfWidths) {
    const std::string curves = "uniform token basis = \"bspline\"\nint[] curveVertexCounts = [5, 4]\n"
                               "point3f[] points = [(0,0,0),(0,0,1),(0,0,2),(0,0,3),(0,0,4),"
                               "(1,0,0),(1,0,1),(1,0,2),(1,0,3)]\n";
    const auto widths = [&](const std::string &values, const std::string &interpolation) {
        const Groom g = Parse(
            Curves(curves + "float[] widths = " + values + " (interpolation = \"" + interpolation + "\")"));
        std::vector<float> at;
        for (size_t i = 0; i < 2; ++i) {
            const std::vector<BezierSegment> pieces = PiecesOf(g, i);
            for (const BezierSegment &s : pieces)
                at.push_back(s.width[0]);
            at.push_back(pieces.back().width[1]);
        }
        return at;
    };
    const auto expect = [](const std::vector<float> &got, const std::vector<float> &wanted) {
        ASSERT_EQ(got.size(), wanted.size());
        for (size_t i = 0; i < got.size(); ++i)
            EXPECT_NEAR(got[i], wanted[i], 1e-6) << i;
    };
    expect(widths("[2]", "constant"), {2, 2, 2, 2, 2});
    expect(widths("[2, 3]", "uniform"), {2, 2, 2, 3, 3});
    expect(widths("[1, 2, 3, 4, 5]", "varying"), {1, 2, 3, 4, 5});
    // (w0 + 4 w1 + w2) / 6
    expect(widths("[6, 0, 0, 6, 0, 1, 2, 3, 4]", "vertex"), {1, 1, 4, 2, 3});
    EXPECT_NE(Message(Curves(curves + "float[] widths = [1, 2]")).find("x.usda:6:"), std::string::npos);
    EXPECT_NE(Message(Curves(curves + "float[] widths = [1, 2]")).find("vertex interpolation needs 9"),
              std::string::npos);
    EXPECT_NE(Message(Curves(curves + "float[] widths = [-1]")).find("negative"), std::string::npos);
}

TEST_F(UsdFile, ColorsByIndexAndTimeSamples) {
    const Groom g =
        Parse(Curves("uniform token type = \"linear\"\nint[] curveVertexCounts = [2, 2]\n"
                     "point3f[] points.timeSamples = {\n 1: [(0,0,0),(0,0,1),(1,0,0),(1,0,1)],\n"
                     " 2: [(9,9,9),(9,9,9),(9,9,9),(9,9,9)],\n}\n"
                     "float[] widths = [0.5] (interpolation = \"constant\")\n"
                     "color3f[] primvars:displayColor = [(1,0,0),(0,0,1)] (interpolation = \"uniform\")\n"
                     "int[] primvars:displayColor:indices = [1, 0]"));
    EXPECT_EQ(FlushWarnings(), 1u) << "of time samples";
    EXPECT_EQ(g.Strand(1)[1], (Point3f{1, 0, 1}));
    EXPECT_EQ(g.StrandColor(0), Spectrum(0, 0, 1));
    EXPECT_EQ(g.Color(1, 0.5f), Spectrum(1, 0, 0));
}

TEST_F(UsdFile, TransformsOfAllParentsApply) {
    const std::string curve =
        "def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2] "
        "point3f[] points = [(1, 0, 0), (0, 0, 1)] float[] widths = [1] ";
    // The first of the order is the outermost: scaled, then turned, then moved
    const Groom g = Parse("def Xform \"a\" {\n double3 xformOp:translate = (10, 20, 30)\n"
                          " uniform token[] xformOpOrder = [\"xformOp:translate\"]\n def Scope \"s\" {\n" +
                          curve +
                          "float3 xformOp:scale = (2, 2, 2)\n float xformOp:rotateZ = 90\n"
                          "uniform token[] xformOpOrder = [\"xformOp:rotateZ\", \"xformOp:scale\"] } } }");
    EXPECT_LT((g.points[0] - Point3f{10, 22, 30}).Length(), 1e-5f);
    EXPECT_LT((g.points[1] - Point3f{10, 20, 32}).Length(), 1e-5f);
    EXPECT_NEAR(g.width, 2, 1e-5) << "widths grow with the scale";

    const auto first = [&](const std::string &operations) {
        return Parse(curve + operations + "}").points[0];
    };
    EXPECT_LT((first("matrix4d xformOp:transform = ( (0,1,0,0), (-1,0,0,0), (0,0,1,0), (5,6,7,1) )\n"
                     "uniform token[] xformOpOrder = [\"xformOp:transform\"]") -
               Point3f{5, 7, 7})
                  .Length(),
              1e-6f);
    // X first, then Y, then Z: (1,0,0) stays, goes to -z, stays
    EXPECT_LT((first("float3 xformOp:rotateXYZ = (90, 90, 90) uniform token[] xformOpOrder = "
                     "[\"xformOp:rotateXYZ\"]") -
               Point3f{0, 0, -1})
                  .Length(),
              1e-6f);
    EXPECT_LT((first("quatf xformOp:orient = (0.70710678, 0, 0, 0.70710678) uniform token[] xformOpOrder = "
                     "[\"xformOp:orient\"]") -
               Point3f{0, 1, 0})
                  .Length(),
              1e-6f);
    EXPECT_LT((first("double3 xformOp:translate:pivot = (1, 0, 0) float xformOp:rotateZ = 90 uniform token[] "
                     "xformOpOrder = [\"xformOp:translate:pivot\", \"xformOp:rotateZ\", "
                     "\"!invert!xformOp:translate:pivot\"]") -
               Point3f{1, 0, 0})
                  .Length(),
              1e-6f);
    EXPECT_EQ(first("double3 xformOp:translate = (1, 0, 0)"), (Point3f{1, 0, 0}))
        << "not in the order: not applied";
    EXPECT_EQ(FlushWarnings(), 0u);
    EXPECT_EQ(first("double xformOp:shear = 1 uniform token[] xformOpOrder = [\"xformOp:shear\"]"),
              (Point3f{1, 0, 0}));
    EXPECT_EQ(FlushWarnings(), 1u);
}

TEST_F(UsdFile, SeveralPrimsJoinAndHiddenOnesDoNot) {
    const std::string linear = "{ uniform token type = \"linear\" int[] curveVertexCounts = [2]; "
                               "point3f[] points = [(0,0,0),(3,0,0)] ";
    const std::string bezier =
        "{ int[] curveVertexCounts = [4] point3f[] points = [(0,0,0),(0,1,0),(0,2,1),(0,3,0)] ";
    const Groom g =
        Parse("# a comment\n(\n \"doc\"\n upAxis = \"Z\"\n customLayerData = { string a = \"}\" }\n)\n"
              "def BasisCurves \"a\" " +
              linear +
              "float[] widths = [1] }\n"
              "def BasisCurves \"b\" " +
              bezier +
              "float[] widths = [3] custom string note = \"\"\"a \"{\n\"\"\" "
              "rel material:binding = </m> }\n"
              "def BasisCurves \"gone\" (active = false) " +
              linear +
              "}\n"
              "def Xform \"x\" { token visibility = \"invisible\"\n def BasisCurves \"c\" " +
              linear +
              "} }\n"
              "class BasisCurves \"d\" " +
              linear + "}\n");
    ASSERT_EQ(g.StrandCount(), 2u);
    EXPECT_EQ(g.spline, StrandSpline::Bezier) << "one cubic curve makes all of them so";
    EXPECT_EQ(g.Strand(0)[1], (Point3f{1, 0, 0}));
    EXPECT_EQ(g.Width(0, 0), 1);
    EXPECT_EQ(g.Width(1, 2), 3);
    EXPECT_EQ(FlushWarnings(), 1u) << "of the axis that is up";
    EXPECT_NE(Message("def Xform \"x\" {}").find("no BasisCurves"), std::string::npos);
}

// A picture shows what is defined, active and visible in USD's sense, of purpose default or render. A purpose
// comes from the nearest prim above that gives one, invisibility from any.
TEST_F(UsdFile, OnlyWhatIsToBeSeenIsRead) {
    int place = 0;
    const auto hair = [&] { // each ten units farther
        ++place;
        return "def BasisCurves \"h\" { uniform token type = \"linear\" int[] curveVertexCounts = [2] "
               "point3f[] "
               "points = [(" +
               std::to_string(10 * place) + ",0,0),(" + std::to_string(10 * place) +
               ",1,0)] float[] widths = [1] ";
    };
    std::string text, purpose = "uniform token purpose = ";
    std::vector<int> shown;
    const auto add = [&](const std::string &before, const std::string &within, const std::string &after,
                         bool seen) {
        text += before + hair() + within + "}\n" + after;
        if (seen)
            shown.push_back(place);
    };
    const auto in = [](const std::string &what) { return "def Xform \"x\" { " + what + "\n"; };
    add("", "", "", true);
    add(in("token visibility = \"invisible\""), "", "}\n", false);
    add(in("token visibility = \"invisible\""), "token visibility = \"inherited\" ", "}\n", false);
    for (const char *hidden : {"guide", "proxy"}) {
        add("", purpose + '"' + hidden + "\" ", "", false);
        add(in(purpose + '"' + hidden + '"'), "", "}\n", false);
        add(in(purpose + '"' + hidden + '"') + in(""), "", "}}\n", false);
        add(in(purpose + '"' + hidden + '"'), purpose + "\"render\" ", "}\n", true);
    }
    for (const char *seen : {"default", "render"}) {
        add(in(purpose + '"' + seen + '"'), "", "}\n", true);
        add(in(purpose + '"' + seen + '"'), purpose + "\"guide\" ", "}\n", false);
    }
    add("class \"c\" {\n", "", "}\n", false);
    add("over \"o\" {\n", "", "}\n", false);
    add("def Xform \"off\" (active = false) {\n", "", "}\n", false);
    const Groom g = Parse(text);
    std::vector<int> read;
    for (size_t i = 0; i < g.StrandCount(); ++i)
        read.push_back(static_cast<int>(g.Strand(i)[0].x) / 10);
    EXPECT_EQ(read, shown);
    EXPECT_EQ(FlushWarnings(), 0u);
    EXPECT_EQ(Parse(text + "def PointInstancer \"p\" { " + hair() + "}\n}\n").StrandCount(), shown.size());
    EXPECT_EQ(FlushWarnings(), 1u);
}

TEST_F(UsdFile, AxesAndUnitsAreSaid) {
    struct Sink : WarningSink {
        std::string all;
        void Warn(const FileLoc &, const std::string &, const std::string &message) override {
            all += message;
        }
    } sink;
    const WarningScope scope(&sink);
    const std::string hair =
        Curves("uniform token type = \"linear\" int[] curveVertexCounts = [2] point3f[] points = "
               "[(1,2,-0.5),(1,2,0.5)] float[] widths = [1]");
    EXPECT_EQ(Parse("( upAxis = \"Y\" )\n" + hair).Strand(0)[1], (Point3f{1, 2, 0.5f}));
    EXPECT_EQ(sink.all, "");
    // Up stays up, and right stays right: from (x, y, z) with z up to (x, z, -y)
    const Groom turned = Parse("( upAxis = \"Z\" metersPerUnit = 0.01 )\n" + hair);
    EXPECT_EQ(turned.Strand(0)[0], (Point3f{1, -0.5f, -2}));
    EXPECT_EQ(turned.Strand(0)[1], (Point3f{1, 0.5f, -2}));
    EXPECT_TRUE(turned.placements.empty());
    EXPECT_NE(sink.all.find("z axis is up"), std::string::npos) << sink.all;
    EXPECT_NE(sink.all.find("a unit of this layer is 0.01 m"), std::string::npos) << sink.all;
    EXPECT_NE(Message("( upAxis = \"X\" )\n" + hair).find("not \"X\""), std::string::npos);
    EXPECT_NE(Message("( metersPerUnit = 0 )\n" + hair).find("above 0"), std::string::npos);
}

// Under a scale that is uneven the strands stay in their own coordinates, and the groom says where they
// belong; every other one is transformed, and widths with it.
TEST_F(UsdFile, UnevenScalesBecomePlacements) {
    const auto under = [](const std::string &scale) {
        return "def Xform \"x\" { float3 xformOp:scale = " + scale +
               "\n uniform token[] xformOpOrder = [\"xformOp:scale\"]\n" +
               Curves("uniform token type = \"linear\" int[] curveVertexCounts = [2, 2] point3f[] points = "
                      "[(1,0,0),(1,2,0),(2,0,0),(2,2,0)] float[] widths = [0.5]") +
               "}\n";
    };
    const Groom g = Parse(under("(2,2,2)") + under("(1,3,1)") + under("(-1,1,1)"));
    ASSERT_EQ(g.StrandCount(), 6u);
    ASSERT_EQ(g.placements.size(), 1u);
    EXPECT_EQ(g.placements[0].begin, 2u);
    EXPECT_EQ(g.placements[0].end, 4u);
    EXPECT_EQ(g.placements[0].toGroom.Point(g.Strand(2)[1]), (Point3f{1, 6, 0}));
    EXPECT_EQ(g.Strand(2)[1], (Point3f{1, 2, 0}));
    EXPECT_EQ(g.Width(0, 0), 1);
    EXPECT_EQ(g.Width(2, 0), 0.5f);
    EXPECT_EQ(g.Width(4, 0), 0.5f);
    EXPECT_EQ(g.Bounds().pMax, (Point3f{4, 6, 0}));
    // A format without transformations takes the mean factor, and says so
    EXPECT_EQ(FlushWarnings(), 0u);
    const Groom flat = WithoutPlacements(g, "x.usda");
    EXPECT_EQ(FlushWarnings(), 1u);
    EXPECT_EQ(flat.Strand(2)[1], (Point3f{1, 6, 0}));
    EXPECT_NEAR(flat.Width(2, 1), 0.5 * std::cbrt(3.), 1e-6);
    EXPECT_EQ(flat.Width(0, 0), 1);
    // Joined to others they keep their places
    Groom joined = g;
    joined.Append(g);
    ASSERT_EQ(joined.placements.size(), 2u);
    EXPECT_EQ(joined.placements[1].begin, 8u);
}

TEST_F(UsdFile, WhatIsNotRenderedWarnsOnce) {
    const std::string good =
        Curves("uniform token type = \"linear\" int[] curveVertexCounts = [2] point3f[] points = "
               "[(0,0,0),(3,0,0)] float[] widths = [1]");
    for (const std::string extra :
         {"def NurbsCurves \"n\" {}",
          "def Xform \"r\" (prepend references = @a.usda@</p> (offset = 1) doc = \"d\") {}",
          "def \"v\" { variantSet \"lod\" = { \"high\" { def \"q\" {} } } }",
          "def BasisCurves \"p\" { uniform token wrap = \"periodic\" }",
          "def BasisCurves \"o\" { float[] primvars:displayOpacity = [0.5, 0.4] }",
          "def BasisCurves \"s\" { uniform token basis = \"bspline\" int[] curveVertexCounts = [3] point3f[] "
          "points = "
          "[(0,0,0),(1,0,0),(2,0,0)] }"}) {
        EXPECT_EQ(Parse(good + extra).StrandCount(), 1u);
        EXPECT_EQ(FlushWarnings(), 1u) << extra;
    }
}

// Each mistake is answered with its line, quickly.
TEST_F(UsdFile, MistakesAreNamedWithTheirLine) {
    struct Case {
        std::string text;
        int line;
        std::string says;
    };
    const std::string linear = "uniform token type = \"linear\"\n";
    for (const Case &c : {
             Case{Curves(linear +
                         "int[] curveVertexCounts = [2, 2]\npoint3f[] points = [(0,0,0),(1,0,0),(2,0,0)]"),
                  5, "adds up to 4 points"},
             Case{Curves(linear + "int[] curveVertexCounts = [-2]\npoint3f[] points = []"), 4,
                  "whole numbers"},
             Case{Curves(linear + "int[] curveVertexCounts = [4000000000]\npoint3f[] points = []"), 4,
                  "whole numbers"},
             Case{Curves(linear + "int[] curveVertexCounts = [16000000, 16000000]\npoint3f[] points = []"), 5,
                  "32000000 points"},
             Case{Curves("int[] curveVertexCounts = [5]\npoint3f[] points = [(0,0,0)]"), 3, "3 n + 1"},
             Case{Curves("point3f[] points = [(0,0,nan)]"), 3, "finite"},
             Case{Curves("point3f[] points = [(0,0,1e39)]"), 3, "finite"},
             Case{Curves("point3f[] points = [(0,0,x)]"), 3, "a number was expected"},
             Case{Curves("point3f[] points = [(0,0,1]"), 3, "does not close"},
             Case{Curves("point3f[] points = [(0 0,1)]"), 3, "','"},
             Case{Curves("uniform token type = \"cubical\"\nint[] curveVertexCounts = []"), 2,
                  "linear or cubic"},
             Case{Curves("uniform token basis = \"power\""), 2, "bezier, bspline or catmullRom"},
             Case{Curves("uniform token wrap = \"round\""), 2, "nonperiodic or pinned"},
             Case{Curves("float[] widths = [1] (interpolation = \"faceVarying\")"), 3, "vertex was expected"},
             Case{Curves("string a = \"b\n\""), 3, "no end"},
             Case{Curves("string a = { ) }"), 3, "does not close"},
             Case{"def BasisCurves hair { }", 2, "a string in quotes"},
             Case{"def BasisCurves \"hair\" {\n", 2, "no '}' closes"},
             Case{"\n\nCube \"a\" {}", 4, "begins no prim"},
             Case{"}", 2, "\"def\""},
         }) {
        const std::string message = Message(c.text);
        EXPECT_EQ(message.find("x.usda:" + std::to_string(c.line) + ":"), 0u) << c.text << "\n" << message;
        EXPECT_NE(message.find(c.says), std::string::npos) << c.text << "\n" << message;
    }
    EXPECT_NE(MessageOf([] { ParseUsdFile("#usdb", "x.usda"); }).find("begins with #usda"),
              std::string::npos);
}

TEST_F(UsdFile, HostileDepthsEndInAnError) {
    std::string prims, brackets(1 << 20, '[');
    for (int i = 0; i < 100000; ++i)
        prims += "def \"a\" {";
    EXPECT_NE(Message(prims).find("deep"), std::string::npos);
    EXPECT_NE(Message("def \"a\" { int[] a = " + brackets).find("never closed"), std::string::npos);
    EXPECT_NE(Message(Curves("int[] points = " + brackets)).find("four brackets"), std::string::npos);
}

std::string Whole() {
    return "(\n upAxis = \"Z\"\n)\ndef Xform \"a\" {\n double3 xformOp:translate = (1, 2, 3)\n uniform "
           "token[] "
           "xformOpOrder = [\"xformOp:translate\"]\n" +
           Curves(
               "uniform token basis = \"bspline\"\nint[] curveVertexCounts = [4]\npoint3f[] points = "
               "[(0,0,0),(1,0,0),(2,0,0),(3,0,0)]\nfloat[] widths = [0.1] (interpolation = \"constant\")") +
           "}\n";
}

TEST_F(UsdFile, EveryTruncationIsAnError) {
    const std::string whole = Whole();
    for (size_t n = 0; n + 2 < whole.size(); ++n)
        EXPECT_NE(Message(whole.substr(0, n)), "") << whole.substr(0, n);
    EXPECT_EQ(Message(whole), "");
}

TEST_F(UsdFile, RandomDamageNeverGivesBadStrands) {
    const std::string whole = Whole();
    size_t errors = 0, grooms = 0;
    for (uint64_t i = 0; i < 20000; ++i) {
        const HashStream r(13, 5, i);
        std::string s = whole;
        for (uint64_t k = 0; k <= i % 3; ++k)
            s[static_cast<size_t>(r.Uniform(2 * k) * static_cast<float>(s.size()))] =
                "\"{}[]()#,;=@<x1-e.\n\\:"[static_cast<size_t>(r.Uniform(2 * k + 1) * 21)];
        try {
            const Groom g = Parse(s);
            ++grooms;
            ASSERT_EQ(g.strandOffsets.back(), g.points.size());
            for (const Point3f &p : g.points)
                ASSERT_TRUE(IsFinite(p)) << s;
        } catch (const Error &) {
            ++errors;
        }
    }
    EXPECT_GT(errors, 1000u);
    EXPECT_GT(grooms, 100u);
}

TEST_F(UsdFile, RealBlenderHair) {
    const std::optional<std::string> file = RealModel("hair-blender-3.0.1.usda");
    if (!file)
        return;
    const Groom g = ReadGroomFile(*file);
    EXPECT_EQ(FlushWarnings(), 3u) << "z is up, a unit is a metre, and it has no widths";
    ASSERT_EQ(g.StrandCount(), 1000u);
    EXPECT_EQ(g.spline, StrandSpline::Bezier);
    EXPECT_EQ(g.color, Spectrum(0.8f));
    size_t pieces = 0;
    ForEachSegment(g, {}, [&](const BezierSegment &, size_t) { ++pieces; });
    EXPECT_EQ(pieces, 6000u) << "9 points of a B-spline make 6 pieces";
}

} // namespace
} // namespace cuticle
