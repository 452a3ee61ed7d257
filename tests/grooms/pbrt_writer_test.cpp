#include "core/error.h"
#include "core/parallel.h"
#include "files/file.h"
#include "grooms/pbrt_writer.h"
#include "grooms/procedural.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace cuticle {
namespace {

namespace fs = std::filesystem;

class PbrtWriter : public ::testing::Test {
  protected:
    void SetUp() override {
        std::string pattern = (fs::temp_directory_path() / "cuticle-pbrt-XXXXXX").string();
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string Path(const std::string &name) const { return (folder_ / name).string(); }
    std::string Write(const Groom &groom, const PbrtCurveOptions &options, const std::string &name,
                      PbrtCurveCounts *counts) const {
        OutputFile out(Path(name));
        WritePbrtCurves(groom, options, &out, counts);
        out.Commit();
        std::ifstream in(Path(name));
        std::ostringstream text;
        text << in.rdbuf();
        return text.str();
    }
    fs::path folder_;
};

// One statement as the test reads it back: by the words of the language, with nothing of the writer's.
struct Statement {
    std::vector<double> p;
    double width0 = 0, width1 = 0;
};
std::vector<Statement> ReadBack(const std::string &text) {
    std::vector<Statement> all;
    for (size_t at = text.find("Shape \"curve\""); at != std::string::npos;
         at = text.find("Shape \"curve\"", at + 1)) {
        Statement s;
        const size_t open = text.find('[', at), close = text.find(']', at);
        std::istringstream numbers(text.substr(open + 1, close - open - 1));
        for (double v; numbers >> v;)
            s.p.push_back(v);
        s.width0 = std::stod(text.substr(text.find("width0\" ", at) + 8));
        s.width1 = std::stod(text.substr(text.find("width1\" ", at) + 8));
        all.push_back(s);
    }
    return all;
}

TEST_F(PbrtWriter, TextHoldsTheCurves) {
    GroomParams p = MakeGroomParams("head", "curly");
    p.strands = 40;
    const Groom g = MakeGroom(p);
    PbrtCurveCounts counts;
    const std::vector<Statement> statements = ReadBack(Write(g, {}, "a.pbrt", &counts));
    ASSERT_EQ(statements.size(), 40u);
    EXPECT_EQ(counts.strands, 40u);
    EXPECT_EQ(counts.statements, 40u);
    EXPECT_EQ(counts.segments, 40 * (g.PointCount(0) - 1));
    double worst = 0;
    for (size_t i = 0; i < 40; ++i) {
        std::vector<BezierSegment> pieces;
        AppendSegments(g, i, {}, &pieces);
        ASSERT_EQ(statements[i].p.size(), 3 * (3 * pieces.size() + 1));
        EXPECT_EQ(static_cast<float>(statements[i].width0), g.Width(i, 0));
        EXPECT_EQ(static_cast<float>(statements[i].width1), g.Width(i, g.PointCount(i) - 1));
        for (size_t k = 0; k < pieces.size(); ++k)
            for (size_t j = 0; j < 4; ++j)
                for (size_t c = 0; c < 3; ++c)
                    worst =
                        std::max(worst, std::abs(statements[i].p[3 * (3 * k + j) + c] -
                                                 static_cast<double>(pieces[k].cp[j][static_cast<int>(c)])));
    }
    EXPECT_LE(worst, static_cast<double>(p.width) / 200) << "coordinates are rounded to 1/200 of a width";
}

TEST_F(PbrtWriter, OneStatementPerSegmentSaysTheSame) {
    GroomParams p = MakeGroomParams("head", "wavy");
    p.strands = 10;
    const Groom g = MakeGroom(p);
    PbrtCurveOptions split;
    split.perSegment = true;
    PbrtCurveCounts whole, parts;
    const auto a = ReadBack(Write(g, {}, "a.pbrt", &whole)), b = ReadBack(Write(g, split, "b.pbrt", &parts));
    ASSERT_EQ(b.size(), whole.segments);
    EXPECT_EQ(parts.segments, whole.segments);
    size_t at = 0;
    for (const Statement &s : a)
        for (size_t k = 0; 9 * k + 12 <= s.p.size(); ++k, ++at)
            for (size_t c = 0; c < 12; ++c)
                ASSERT_EQ(s.p[9 * k + c], b[at].p[c]);
    EXPECT_EQ(at, b.size());
}

TEST_F(PbrtWriter, WidthsPerPointAreKept) {
    Groom g;
    g.strandOffsets = {0, 5};
    g.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}};
    g.pointWidths = {0.5f, 0.4f, 0.3f, 0.6f, 0.6f};
    PbrtCurveCounts counts;
    const auto s = ReadBack(Write(g, {}, "a.pbrt", &counts));
    ASSERT_EQ(s.size(), 3u); // linear from 0.5 to 0.3, to 0.6, level
    EXPECT_NEAR(s[0].width0, 0.5, 1e-7);
    EXPECT_NEAR(s[0].width1, 0.3, 1e-7);
    EXPECT_NEAR(s[1].width1, 0.6, 1e-7);
    EXPECT_NEAR(s[2].width0, 0.6, 1e-7);
}

TEST_F(PbrtWriter, ColoursBecomeMaterials) {
    Groom g;
    g.points.resize(600);
    for (uint32_t i = 0; i < 300; ++i) {
        g.points[2 * i + 1] = {1, 0, 0};
        g.strandOffsets.push_back(2 * i + 2);
        for (int k = 0; k < 2; ++k)
            g.pointColors.push_back(i % 3 == 0 ? Spectrum(0.25f) : Spectrum(0.5f, 0.125f, 0));
    }
    g.hasColor = true;
    PbrtCurveOptions options;
    options.colors = true;
    PbrtCurveCounts counts;
    std::string text = Write(g, options, "a.pbrt", &counts);
    EXPECT_EQ(counts.materials, 2u);
    EXPECT_EQ(ReadBack(text).size(), 300u);
    const size_t grey = text.find("[0.25 0.25 0.25]"), red = text.find("[0.5 0.125 0]");
    ASSERT_NE(grey, std::string::npos);
    ASSERT_NE(red, std::string::npos);
    EXPECT_EQ(ReadBack(text.substr(grey, red - grey)).size(), 100u);
    // A colour for every strand: rounded to steps.
    for (uint32_t i = 0; i < 600; ++i)
        g.pointColors[i] = Spectrum(static_cast<float>(i / 2) / 300);
    options.colorLevels = 16;
    counts = {};
    text = Write(g, options, "b.pbrt", &counts);
    EXPECT_LE(counts.materials, 16u);
    EXPECT_GE(counts.materials, 12u);
    EXPECT_EQ(ReadBack(text).size(), 300u);
}

// Strands under an uneven scale are written under it, with the widths that they have before it.
TEST_F(PbrtWriter, PlacementsBecomeTransformations) {
    Groom g;
    g.width = 0.5f;
    for (int strand = 0; strand < 4; ++strand) {
        g.points.push_back({static_cast<float>(strand), 0, 0});
        g.points.push_back({static_cast<float>(strand), 1, 0});
        g.strandOffsets.push_back(static_cast<uint32_t>(g.points.size()));
    }
    g.placements.push_back({1, 3, Transform::Translate({5, 0, 0}) * Transform::Scale(1, 2, 3)});
    PbrtCurveCounts counts;
    const std::string text = Write(g, {}, "a.pbrt", &counts);
    EXPECT_EQ(counts.strands, 4u);
    const size_t begin = text.find("TransformBegin\nConcatTransform [1 0 0 0 0 2 0 0 0 0 3 0 5 0 0 1]\n"),
                 end = text.find("TransformEnd\n");
    ASSERT_NE(begin, std::string::npos) << text;
    ASSERT_NE(end, std::string::npos) << text;
    const std::vector<Statement> within = ReadBack(text.substr(begin, end - begin));
    ASSERT_EQ(within.size(), 2u);
    EXPECT_EQ(within[1].p[0], 2);
    EXPECT_EQ(within[1].width0, 0.5);
    EXPECT_EQ(ReadBack(text.substr(0, begin)).size(), 1u);
    EXPECT_EQ(ReadBack(text.substr(end)).size(), 1u);
}

TEST_F(PbrtWriter, SameTextForAnyThreads) {
    GroomParams p = MakeGroomParams("ball");
    p.strands = 3000;
    const Groom g = MakeGroom(p);
    PbrtCurveCounts counts;
    const std::string many = Write(g, {}, "a.pbrt", &counts);
    const ThreadLimit limit(1);
    EXPECT_EQ(many, Write(g, {}, "b.pbrt", &counts));
}

TEST_F(PbrtWriter, CompressedFilesAppearWholeOrNotAtAll) {
    const std::string name = Path("a.pbrt.gz");
    {
        OutputFile out(name);
        out.Write("never finished");
    }
    EXPECT_TRUE(fs::is_empty(folder_));
    {
        OutputFile out(name);
        out.Write("first ");
        out.Write("second");
        EXPECT_FALSE(fs::exists(name));
        out.Commit();
    }
    char text[64] = {};
    gzFile in = gzopen(name.c_str(), "rb");
    ASSERT_NE(in, nullptr);
    EXPECT_EQ(gzdirect(in), 0) << "not compressed";
    EXPECT_EQ(gzread(in, text, sizeof text), 12);
    gzclose(in);
    EXPECT_STREQ(text, "first second");
    {
        OutputFile again(name);
        again.Write("broken off");
    }
    in = gzopen(name.c_str(), "rb");
    EXPECT_EQ(gzread(in, text, sizeof text), 12) << "a broken-off write hurt what stood there";
    gzclose(in);
    EXPECT_THROW(OutputFile(Path("no/such/folder/x.pbrt")), Error);
}

} // namespace
} // namespace cuticle
