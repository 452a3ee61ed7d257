// The writer of moving strands against our reader: what goes in comes back.
#include "grooms/usd_writer.h"

#include "grooms/groom_file.h"
#include "message_of.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace cuticle {
namespace {

Groom TwoStrands(StrandSpline spline, float shift) {
    Groom g;
    g.spline = spline;
    g.points = {{0, 0, 0}, {0, 1, 0},     {0.1f, 2, 0},     {0, 3, 0.3f},
                {1, 0, 0}, {1, 1, shift}, {1, 2, 2 * shift}};
    g.strandOffsets = {0, 4, 7};
    return g;
}

class UsdWriting : public testing::Test {
  protected:
    void SetUp() override {
        folder_ =
            std::filesystem::temp_directory_path() /
            (std::string("cuticle_usd_") + testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    std::string File() const { return (folder_ / "a.usda").string(); }
    std::filesystem::path folder_;
};

TEST_F(UsdWriting, FramesComeBack) {
    for (const StrandSpline spline : {StrandSpline::Linear, StrandSpline::CatmullRom}) {
        UsdWriter writer(File(), 24);
        for (size_t frame : {0, 1, 2})
            writer.AddFrame(frame, TwoStrands(spline, static_cast<float>(frame) / 3));
        writer.Finish();
        for (const double time : {-1., 0., 1., 1.5, 2., 9.}) {
            GroomFileOptions options;
            options.time = time;
            const Groom read = ReadGroomFile(File(), options);
            const Groom wrote =
                TwoStrands(spline, static_cast<float>(std::clamp(std::floor(time), 0., 2.)) / 3);
            ASSERT_EQ(read.StrandCount(), 2u);
            EXPECT_EQ(read.width, wrote.width);
            const size_t step = read.spline == StrandSpline::Bezier ? 3 : 1; // ends of the pieces
            for (size_t s = 0; s < 2; ++s) {
                ASSERT_EQ((read.PointCount(s) - 1) / step + 1, wrote.PointCount(s));
                for (size_t i = 0; i < wrote.PointCount(s); ++i)
                    EXPECT_EQ(read.Strand(s)[step * i], wrote.Strand(s)[i]) << "time " << time;
            }
        }
    }
}

TEST_F(UsdWriting, WidthsAndColoursComeBack) {
    Groom g = TwoStrands(StrandSpline::Linear, 0);
    g.strandWidths = {{0.1f, 0.05f}, {0.2f, 0.f}};
    g.hasColor = true;
    for (size_t i = 0; i < g.points.size(); ++i)
        g.pointColors.push_back(Spectrum(static_cast<float>(i) / 7));
    UsdWriter writer(File(), 24);
    writer.AddFrame(0, g);
    writer.Finish();
    const Groom read = ReadGroomFile(File());
    for (size_t s = 0; s < 2; ++s)
        for (size_t i = 0; i < g.PointCount(s); ++i)
            EXPECT_FLOAT_EQ(read.Width(s, i), g.Width(s, i));
    ASSERT_EQ(read.pointColors.size(), g.pointColors.size());
    for (size_t i = 0; i < g.points.size(); ++i)
        EXPECT_FLOAT_EQ(read.pointColors[i][1], g.pointColors[i][1]);
}

TEST_F(UsdWriting, OtherStrandsAreRefusedAndNothingIsLeft) {
    {
        UsdWriter writer(File(), 24);
        writer.AddFrame(0, TwoStrands(StrandSpline::Linear, 0));
        Groom other = TwoStrands(StrandSpline::Linear, 0);
        other.strandOffsets = {0, 3, 7};
        EXPECT_NE(MessageOf([&] { writer.AddFrame(1, other); }).find("other strands"), std::string::npos);
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

} // namespace
} // namespace cuticle
