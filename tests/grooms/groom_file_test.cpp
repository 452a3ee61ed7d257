// Strands from files of every format: told apart, and the same.
#include "grooms/groom_file.h"
#include "warnings.h"

#include "grooms/hair_file.h"
#include "strand_files.h"

#include <sstream>

namespace cuticle {
namespace {

using GroomFile = StrandFiles;

// Three strands of four points that wander, with colours.
Groom Wandering() {
    Groom g;
    g.width = 0.125f;
    g.hasColor = true;
    for (int strand = 0; strand < 3; ++strand) {
        for (int k = 0; k < 4; ++k) {
            const auto s = static_cast<float>(strand), t = static_cast<float>(k);
            g.points.push_back({s + 0.25f * t * t, t, 0.5f * s * t});
            g.pointColors.push_back({0.25f * t, 0.5f, 0.25f * s});
        }
        g.strandOffsets.push_back(static_cast<uint32_t>(g.points.size()));
    }
    return g;
}

std::string AsTfx(const Groom &g) {
    std::string s;
    Put(&s, 4.f);
    const auto n = static_cast<uint32_t>(g.points.size());
    for (const uint32_t v :
         {static_cast<uint32_t>(g.StrandCount()), 4u, 160u, 0u, 0u, 160 + 16 * n, 172 + 16 * n})
        Put(&s, v);
    s.resize(160, '\0');
    for (const Point3f &p : g.points) {
        Put(&s, p);
        Put(&s, 1.f);
    }
    for (size_t i = 0; i < g.StrandCount(); ++i)
        Put(&s, g.width);
    for (const Spectrum &c : g.pointColors) {
        Put(&s, c);
        Put(&s, 1.f);
    }
    return s;
}

std::string AsUsd(const Groom &g) {
    std::ostringstream s;
    s << "#usda 1.0\ndef BasisCurves \"hair\" {\n uniform token type = \"linear\"\n int[] curveVertexCounts "
         "= [4, 4, "
         "4]\n point3f[] points = [";
    for (const Point3f &p : g.points)
        s << "(" << p.x << ", " << p.y << ", " << p.z << "), ";
    s << "]\n float[] widths = [" << g.width << "]\n color3f[] primvars:displayColor = [";
    for (const Spectrum &c : g.pointColors)
        s << "(" << c[0] << ", " << c[1] << ", " << c[2] << "), ";
    s << "] (interpolation = \"vertex\")\n}\n";
    return s.str();
}

TEST_F(GroomFile, TheSameStrandsOfEveryFormatAreTheSameCurves) {
    const Groom g = Wandering();
    WriteHairFile(Path("a.hair"), g);
    const Groom hair = ReadGroomFile(Path("a.hair"));
    for (const std::string &other : {Write("a.tfx", AsTfx(g)), Write("a.usda", AsUsd(g))}) {
        const Groom o = ReadGroomFile(other);
        ASSERT_EQ(o.StrandCount(), 3u);
        for (const StrandSpline spline :
             {StrandSpline::CatmullRom, StrandSpline::BSpline, StrandSpline::Linear})
            for (const int segments : {0, 7})
                for (size_t i = 0; i < 3; ++i) {
                    const SegmentOptions options{spline, segments};
                    std::vector<BezierSegment> a, b;
                    AppendSegments(hair, i, options, &a);
                    AppendSegments(o, i, options, &b);
                    ASSERT_EQ(a.size(), segments > 0 ? 7u : 3u);
                    ASSERT_EQ(a.size(), b.size());
                    for (size_t k = 0; k < a.size(); ++k) {
                        for (int c = 0; c < 4; ++c)
                            EXPECT_EQ(a[k].cp[c], b[k].cp[c]);
                        for (int e = 0; e < 2; ++e) {
                            EXPECT_EQ(a[k].width[e], b[k].width[e]);
                            EXPECT_EQ(hair.Color(i, a[k].at[e]), o.Color(i, b[k].at[e]));
                        }
                    }
                }
    }
    EXPECT_EQ(FlushWarnings(), 0u);
}

TEST_F(GroomFile, ContentGoesBeforeTheName) {
    const Groom g = Wandering();
    WriteHairFile(Path("a.hair"), g);
    std::filesystem::copy_file(Path("a.hair"), Path("hair.tfx"));
    EXPECT_EQ(ReadGroomFile(Path("hair.tfx")).points, g.points);
    EXPECT_EQ(ReadGroomFile(Write("tfx.usda", AsTfx(g))).points, g.points);
    EXPECT_EQ(ReadGroomFile(Write("usd", AsUsd(g))).points, g.points);
    const auto message = [&](const std::string &name, const std::string &bytes) {
        const std::string file = Write(name, bytes);
        const std::string m = MessageOf([&] { ReadGroomFile(file); });
        EXPECT_EQ(m.find(file), 0u) << m;
        return m;
    };
    EXPECT_NE(message("x.tfx", std::string(200, 'x')).find("byte 0"), std::string::npos);
    EXPECT_NE(message("x.usda", "hello").find(":1:1: error"), std::string::npos);
    EXPECT_NE(message("x.dat", "hello").find(".hair"), std::string::npos);
    EXPECT_NE(message("x.usda", "PXR-USDC........").find("usdcat"), std::string::npos);
    EXPECT_NE(message("empty.hair", "").find("byte 0"), std::string::npos);
}

// A hole of a terabyte costs nothing to refuse.
TEST_F(GroomFile, HugeFilesOfNothingAreRefusedUnread) {
    for (const char *name : {"huge.hair", "huge.tfx", "huge.usda", "huge"}) {
        Write(name, "x");
        std::filesystem::resize_file(Path(name), uint64_t(1) << 37);
        EXPECT_THROW(ReadGroomFile(Path(name)), Error) << name;
    }
}

TEST_F(GroomFile, WidthsThatAreLackingAndWidthsThatAreGiven) {
    const std::string text =
        "#usda 1.0\ndef BasisCurves \"a\" {\n uniform token type = \"linear\"\n int[] "
        "curveVertexCounts = [2, 2]\n point3f[] points = [(0,0,0),(0,0,1),(0,0,0),(0,3,0)]\n}";
    const std::string file = Write("a.usda", text);
    EXPECT_FLOAT_EQ(ReadGroomFile(file).width, 2.f / 500) << "a fraction of the mean length";
    EXPECT_EQ(FlushWarnings(), 1u);
    EXPECT_EQ(ReadGroomFile(file, {0.25f}).Width(1, 0), 0.25f);
    Groom g = Wandering();
    g.strandWidths.assign(3, {1, 0.5f});
    WriteHairFile(Path("a.hair"), g);
    EXPECT_EQ(ReadGroomFile(Path("a.hair")).Width(2, 3), 0.5f);
    EXPECT_EQ(ReadGroomFile(Path("a.hair"), {0.25f}).Width(2, 3), 0.25f);
    EXPECT_EQ(FlushWarnings(), 0u);
}

// Cubic curves written as the points of a .hair file stay within a hundredth of their size.
TEST_F(GroomFile, CubicCurvesAsPoints) {
    const std::string file = Write(
        "a.usda",
        "#usda 1.0\ndef BasisCurves \"a\" {\n uniform token basis = \"bspline\"\n int[] curveVertexCounts = "
        "[6]\n point3f[] points = [(0,0,0),(0,1,0),(1,2,0),(2,2,1),(3,3,1),(3,5,0)]\n float[] widths = "
        "[1,2,3,4,5,6]\n color3f[] primvars:displayColor = [(0,0,0),(1,1,1),(2,2,2),(3,3,3),(4,4,4),"
        "(5,5,5)] (interpolation = \"vertex\")\n}");
    const Groom cubic = ReadGroomFile(file);
    EXPECT_THROW(WriteHairFile(Path("a.hair"), cubic), Error) << "control points are no points";
    WriteHairFile(Path("a.hair"), PointsOnCurves(cubic));
    const Groom points = ReadGroomFile(Path("a.hair"));
    ASSERT_EQ(points.points.size(), 7u);
    std::vector<Point3f> a, b;
    std::vector<float> wa, wb, ta, tb;
    ResampleStrand(cubic.Strand(0), cubic.pointWidths, StrandSpline::Bezier, 40, &a, &wa, &ta);
    ResampleStrand(points.Strand(0), points.pointWidths, StrandSpline::CatmullRom, 40, &b, &wb, &tb);
    for (size_t i = 0; i <= 40; ++i) {
        EXPECT_LT((a[i] - b[i]).Length(), 0.05f) << i;
        EXPECT_NEAR(wa[i], wb[i], 0.05f) << i;
        EXPECT_NEAR(cubic.Color(0, ta[i])[0], points.Color(0, tb[i])[0], 0.05f) << i;
    }
    SegmentOptions smooth;
    smooth.spline = StrandSpline::CatmullRom;
    std::vector<BezierSegment> out;
    EXPECT_THROW(AppendSegments(cubic, 0, smooth, &out), Error);
}

// Points in a row, 100 to a strand where nobody says; anything else is answered with what would be right.
TEST_F(GroomFile, PlyPointsAreStrands) {
    const auto ply = [](int count, const std::string &format = "ascii", const std::string &more = "") {
        return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(count) +
               "\nproperty float x\nproperty float y\nproperty float z\n" + more + "end_header\n";
    };
    const auto ascii = [&](int count) {
        std::string s = ply(count);
        for (int i = 0; i < count; ++i)
            s += std::to_string(i / 100) + " " + std::to_string(i % 100) + " -0.5\n";
        return s;
    };
    const Groom g = ReadGroomFile(Write("a.ply", ascii(300)), {0.5f});
    ASSERT_EQ(g.StrandCount(), 3u);
    EXPECT_EQ(g.PointCount(2), 100u);
    EXPECT_EQ(g.Strand(1)[99], (Point3f{1, 99, -0.5f}));
    EXPECT_EQ(g.Width(1, 5), 0.5f);
    EXPECT_EQ(ReadGroomFile(Path("a.ply"), {0.5f, 50}).StrandCount(), 6u);
    EXPECT_EQ(FlushWarnings(), 0u);
    ReadGroomFile(Path("a.ply"));
    EXPECT_EQ(FlushWarnings(), 1u) << "of its widths";
    // Binary of both byte orders, points of doubles, other properties between
    for (const bool big : {false, true}) {
        std::string s =
            "ply\nformat binary_" + std::string(big ? "big" : "little") +
            "_endian 1.0\nelement vertex 4\nproperty uchar red\nproperty double x\nproperty double "
            "y\nproperty double z\nend_header\n";
        for (int i = 0; i < 4; ++i) {
            Put(&s, static_cast<char>(7));
            for (const double v : {1., 2. + i, 3.}) {
                std::string bytes;
                Put(&bytes, v);
                if (big)
                    std::reverse(bytes.begin(), bytes.end());
                s += bytes;
            }
        }
        const Groom b = ReadGroomFile(Write("b.ply", s), {1, 2});
        ASSERT_EQ(b.StrandCount(), 2u);
        EXPECT_EQ(b.Strand(1)[1], (Point3f{1, 5, 3}));
    }
    const auto message = [&](const std::string &bytes, size_t run = 0) {
        const std::string path = Write("c.ply", bytes);
        return MessageOf([&] { ReadGroomFile(path, {1, run}); });
    };
    EXPECT_NE(
        message(ascii(250)).find("250 points, which are no strands of 100, the usual number; say how many"),
        std::string::npos);
    EXPECT_NE(message(ascii(300), 7).find("no strands of 7;"), std::string::npos);
    EXPECT_NE(message(ply(3, "ascii", "element face 1\nproperty list uchar int vertex_indices\n") +
                      "0 0 0 1 0 0 0 1 0 3 0 1 2\n")
                  .find("plymesh"),
              std::string::npos);
    EXPECT_NE(message(ply(100) + "0 0 nan " + std::string(600, '1')).find("vertex 0 is not finite"),
              std::string::npos);
    EXPECT_NE(message(ply(0)).find("no points"), std::string::npos);
    // A header is believed as far as bytes back it
    EXPECT_NE(message(ply(2000000000)).find("ends at vertex 0 of 2000000000"), std::string::npos);
    for (const std::string whole = ascii(100); const size_t n : {2u, 20u, 100u, 300u, 600u})
        EXPECT_NE(message(whole.substr(0, n)), "") << n;
}

} // namespace
} // namespace cuticle
