#include "grooms/groom_file.h"
#include "grooms/hash.h"
#include "grooms/tfx_file.h"
#include "strand_files.h"
#include "warnings.h"

#include <cstring>

namespace cuticle {
namespace {

using TfxFile = StrandFiles;

struct TfxHeader {
    float version = 4;
    uint32_t strands = 2, points = 3, positions = 160, strandUV = 0, pointUV = 0, thickness = 0, colors = 0;
    uint32_t reserved[32] = {};
};
static_assert(sizeof(TfxHeader) == 160);

// Two strands of three points with every array that is read.
std::string Complete() {
    TfxHeader h;
    h.thickness = 160 + 6 * 16;
    h.colors = h.thickness + 8;
    std::string s;
    Put(&s, h);
    for (int i = 0; i < 6; ++i)
        for (const float v : {1.f, 2.f, 3.f, 0.f})
            Put(&s, v * static_cast<float>(i + 1));
    Put(&s, 0.1f);
    Put(&s, 0.2f);
    for (int i = 0; i < 6; ++i)
        for (const float v : {0.1f, 0.2f, 0.3f, 1.f})
            Put(&s, v == 1 ? 1 : v * static_cast<float>(i));
    return s;
}

std::string Message(const std::string &bytes) {
    return MessageOf([&] { ParseTfxFile(bytes, "x.tfx"); });
}

TEST_F(TfxFile, ReadsEveryArray) {
    const Groom g = ParseTfxFile(Complete(), "x.tfx");
    ASSERT_EQ(g.StrandCount(), 2u);
    EXPECT_EQ(g.PointCount(1), 3u);
    EXPECT_EQ(g.Strand(1)[2], (Point3f{6, 12, 18}));
    EXPECT_EQ(g.Width(0, 2), 0.1f);
    EXPECT_EQ(g.Width(1, 0), 0.2f);
    EXPECT_TRUE(g.hasColor);
    EXPECT_EQ(g.pointColors[4], Spectrum(0.4f, 0.8f, 1.2f));
    EXPECT_EQ(FlushWarnings(), 0u);
}

TEST_F(TfxFile, EveryTruncationIsAnErrorThatNamesFileAndByte) {
    const std::string whole = Complete();
    for (size_t n = 0; n < whole.size(); ++n)
        EXPECT_EQ(Message(whole.substr(0, n)).find("x.tfx: error: byte " + std::to_string(n) + ":"), 0u) << n;
    EXPECT_EQ(Message(whole), "");
}

TEST_F(TfxFile, AbsurdHeadersAreRefusedBeforeMemoryIsTaken) {
    for (const size_t at : {4u, 8u, 12u, 24u, 28u})
        for (const uint32_t absurd : {0xffffffffu, 0x80000000u, 0x10000000u, 100000u}) {
            std::string s = Complete();
            std::memcpy(s.data() + at, &absurd, 4);
            EXPECT_EQ(Message(s).find("x.tfx: error: byte "), 0u)
                << at << " " << absurd << ": " << Message(s);
        }
    const auto with = [](size_t at, uint32_t value) {
        std::string s = Complete();
        std::memcpy(s.data() + at, &value, 4);
        return Message(s);
    };
    EXPECT_NE(with(8, 0).find("byte 8: "), std::string::npos);
    EXPECT_NE(with(12, 0).find("byte 12: "), std::string::npos);
    EXPECT_NE(with(12, 100).find("within the header"), std::string::npos);
    EXPECT_NE(with(0, 0x40400000).find("byte 0: this is not a .tfx file of version 4"), std::string::npos);
    EXPECT_EQ(with(4, 0), "") << "no strands are no harm";
}

TEST_F(TfxFile, BadValuesAreNamedWithTheirByte) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const size_t at : {160u, 160u + 92u, 256u, 264u + 4u}) {
        std::string s = Complete();
        std::memcpy(s.data() + at, &nan, 4);
        EXPECT_EQ(Message(s).find("x.tfx: error: byte " + std::to_string(at) + ": "), 0u) << Message(s);
    }
    std::string s = Complete();
    const float half = 0.5f;
    std::memcpy(s.data() + 264 + 12, &half, 4);
    ParseTfxFile(s, "x.tfx");
    EXPECT_EQ(FlushWarnings(), 1u) << "an alpha below 1";
}

// Whatever the bytes, an Error or a groom whose numbers are finite.
TEST_F(TfxFile, RandomDamageNeverGivesBadStrands) {
    size_t errors = 0, grooms = 0;
    for (uint64_t i = 0; i < 20000; ++i) {
        const HashStream r(12, 5, i);
        std::string s = Complete();
        for (uint64_t k = 0; k <= i % 4; ++k)
            s[static_cast<size_t>(r.Uniform(2 * k) * static_cast<float>(s.size()))] =
                static_cast<char>(static_cast<int>(r.Uniform(2 * k + 1) * 256));
        try {
            const Groom g = ParseTfxFile(s, "x.tfx");
            ++grooms;
            ASSERT_EQ(g.strandOffsets.back(), g.points.size());
            for (const Point3f &p : g.points)
                ASSERT_TRUE(IsFinite(p)) << "case " << i;
        } catch (const Error &) {
            ++errors;
        }
    }
    EXPECT_GT(errors, 1000u);
    EXPECT_GT(grooms, 1000u);
}

TEST_F(TfxFile, RealMohawk) {
    const std::optional<std::string> file = RealModel("Ratboy_mohawk.tfx");
    if (!file)
        return;
    const Groom g = ReadGroomFile(*file);
    EXPECT_EQ(FlushWarnings(), 1u) << "it has no widths";
    ASSERT_EQ(g.StrandCount(), 2228u);
    EXPECT_EQ(g.points.size(), 2228u * 32u);
    EXPECT_FALSE(g.hasColor);
    // The strands hold together: no step is longer than a tenth of the whole
    const float whole = g.Bounds().Diagonal().Length();
    EXPECT_GT(whole, 0.5f);
    EXPECT_LT(whole, 2.f);
    for (size_t i = 0; i < g.StrandCount(); ++i)
        for (size_t k = 1; k < g.PointCount(i); ++k)
            ASSERT_LT((g.Strand(i)[k] - g.Strand(i)[k - 1]).Length(), 0.1f * whole) << i << " " << k;
}

} // namespace
} // namespace cuticle
