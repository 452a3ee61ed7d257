#include "grooms/groom_file.h"
#include "grooms/hair_file.h"
#include "grooms/hash.h"
#include "strand_files.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <cstring>

namespace cuticle {
namespace {

namespace fs = std::filesystem;

using HairFile = StrandFiles;

struct Header {
    char magic[4] = {'H', 'A', 'I', 'R'};
    uint32_t strands = 0, points = 0, arrays = 2, segments = 0;
    float thickness = 0.5f, transparency = 0, color[3] = {0.1f, 0.2f, 0.3f};
    char info[88] = {};
};
static_assert(sizeof(Header) == 128);

// Two strands of 3 and 2 points with every array.
std::string Complete() {
    Header h;
    h.strands = 2;
    h.points = 5;
    h.arrays = 31;
    std::string s;
    Put(&s, h);
    Put(&s, uint16_t(2));
    Put(&s, uint16_t(1));
    for (int i = 0; i < 15; ++i)
        Put(&s, static_cast<float>(i));
    for (int i = 0; i < 5; ++i)
        Put(&s, 0.01f * static_cast<float>(i + 1));
    for (int i = 0; i < 5; ++i)
        Put(&s, 0.f);
    for (int i = 0; i < 15; ++i)
        Put(&s, 0.05f * static_cast<float>(i));
    return s;
}

std::string Message(const std::string &bytes) {
    return MessageOf([&] { ParseHairFile(bytes, "x.hair"); });
}

TEST_F(HairFile, ReadsEveryArray) {
    const Groom g = ParseHairFile(Complete(), "x.hair");
    ASSERT_EQ(g.StrandCount(), 2u);
    EXPECT_EQ(g.PointCount(0), 3u);
    EXPECT_EQ(g.PointCount(1), 2u);
    EXPECT_EQ(g.Strand(1)[1], (Point3f{12, 13, 14}));
    EXPECT_EQ(g.Width(1, 0), 0.04f);
    EXPECT_EQ(g.pointColors[4], Spectrum(0.05f * 12, 0.05f * 13, 0.05f * 14));
}

TEST_F(HairFile, DefaultsStandForMissingArrays) {
    Header h;
    h.strands = 2;
    h.points = 4;
    h.segments = 1;
    std::string s;
    Put(&s, h);
    for (int i = 0; i < 12; ++i)
        Put(&s, 1.f);
    const Groom g = ParseHairFile(s, "x.hair");
    EXPECT_EQ(g.StrandCount(), 2u);
    EXPECT_EQ(g.Width(1, 1), 0.5f);
    EXPECT_FALSE(g.hasColor) << "a default colour in a header is no colour";
}

TEST_F(HairFile, EveryTruncationIsAnErrorThatNamesFileAndByte) {
    const std::string whole = Complete();
    for (size_t n = 0; n < whole.size(); ++n) {
        const std::string message = Message(whole.substr(0, n));
        EXPECT_EQ(message.find("x.hair: error: byte "), 0u) << n << " bytes: " << message;
        if (n >= 128) {
            EXPECT_NE(message.find("byte " + std::to_string(n) + ":"), std::string::npos) << message;
        }
    }
    EXPECT_EQ(Message(whole), "");
}

TEST_F(HairFile, AbsurdCountsAreRefusedBeforeMemoryIsTaken) {
    for (const size_t at : {4u, 8u, 16u}) // strands, points, default segments
        for (const uint32_t absurd : {0xffffffffu, 0x80000000u, 0x10000000u, 6u}) {
            for (const uint32_t arrays : {2u, 3u, 31u}) {
                std::string s = Complete();
                std::memcpy(s.data() + 12, &arrays, 4);
                std::memcpy(s.data() + at, &absurd, 4);
                if (at == 16 && (arrays & 1) != 0)
                    continue; // the default is not used beside the array
                EXPECT_EQ(Message(s).find("x.hair: error: byte "), 0u)
                    << "at " << at << " " << absurd << ": " << Message(s);
            }
        }
    // A product that wraps around in 32 bits: 65536 strands of 65536 points.
    Header h;
    h.strands = 65536;
    h.segments = 65535;
    h.points = 0;
    std::string s;
    Put(&s, h);
    EXPECT_NE(Message(s).find("4294967296 points"), std::string::npos) << Message(s);
}

TEST_F(HairFile, BadValuesAreNamedWithTheirByte) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = Infinity;
    struct Case {
        size_t at;
        float value;
    };
    const size_t points = 128 + 4, thickness = points + 60, transparency = thickness + 20,
                 colors = transparency + 20;
    for (const Case c : {Case{points + 4, nan}, Case{points + 56, inf}, Case{points, 1e30f},
                         Case{thickness, -1}, Case{thickness + 16, nan}, Case{transparency + 8, nan},
                         Case{colors + 56, nan}, Case{colors, -0.5f}, Case{colors, inf}}) {
        std::string s = Complete();
        std::memcpy(s.data() + c.at, &c.value, 4);
        EXPECT_EQ(Message(s).find("x.hair: error: byte " + std::to_string(c.at) + ": "), 0u) << Message(s);
    }
    // Defaults count only where they are used.
    std::string s = Complete();
    std::memcpy(s.data() + 20, &nan, 4);
    EXPECT_EQ(Message(s), "");
    const uint32_t onlyPoints = 2, strands = 5;
    std::memcpy(s.data() + 12, &onlyPoints, 4);
    std::memcpy(s.data() + 4, &strands, 4);
    EXPECT_EQ(Message(s).find("x.hair: error: byte 20: "), 0u) << Message(s);
}

TEST_F(HairFile, StrandsMustAddUpToThePoints) {
    std::string s = Complete();
    const uint16_t more = 3, less = 0;
    std::memcpy(s.data() + 130, &more, 2);
    EXPECT_EQ(Message(s).find("x.hair: error: byte 130: "), 0u) << Message(s);
    std::memcpy(s.data() + 130, &less, 2);
    EXPECT_EQ(Message(s).find("x.hair: error: byte 8: "), 0u) << Message(s);
    EXPECT_NE(Message("HAIX" + s.substr(4)).find("not a .hair file"), std::string::npos);
    s = Complete();
    const uint32_t noPoints = 29;
    std::memcpy(s.data() + 12, &noPoints, 4);
    EXPECT_NE(Message(s).find("no points"), std::string::npos);
}

TEST_F(HairFile, OpaqueFilesAreQuietAndTransparentOnesWarn) {
    ParseHairFile(Complete(), "x.hair");
    EXPECT_EQ(FlushWarnings(), 0u);
    std::string s = Complete();
    const float half = 0.5f;
    std::memcpy(s.data() + 128 + 4 + 60 + 20, &half, 4);
    ParseHairFile(s, "x.hair");
    EXPECT_EQ(FlushWarnings(), 1u);
}

// Damage of every kind: whatever the bytes, an Error or a groom whose numbers are finite.
TEST_F(HairFile, RandomDamageNeverGivesBadStrands) {
    size_t errors = 0, grooms = 0;
    for (uint64_t i = 0; i < 20000; ++i) {
        const HashStream r(11, 5, i);
        std::string s = Complete();
        for (uint64_t k = 0; k <= i % 4; ++k)
            s[static_cast<size_t>(r.Uniform(2 * k) * static_cast<float>(s.size()))] =
                static_cast<char>(static_cast<int>(r.Uniform(2 * k + 1) * 256));
        try {
            const Groom g = ParseHairFile(s, "x.hair");
            ++grooms;
            ASSERT_EQ(g.strandOffsets.back(), g.points.size());
            for (const Point3f &p : g.points)
                ASSERT_TRUE(IsFinite(p)) << "case " << i;
            for (const float w : g.pointWidths)
                ASSERT_TRUE(w >= 0 && std::isfinite(w)) << "case " << i;
        } catch (const Error &) {
            ++errors;
        }
    }
    EXPECT_GT(errors, 1000u);
    EXPECT_GT(grooms, 1000u);
    FlushWarnings();
}

TEST_F(HairFile, WrittenFilesReadBackBitForBit) {
    Groom uneven = ParseHairFile(Complete(), "x.hair");
    WriteHairFile(Path("a.hair"), uneven);
    const Groom a = ReadGroomFile(Path("a.hair"));
    EXPECT_EQ(a.strandOffsets, uneven.strandOffsets);
    EXPECT_EQ(a.points, uneven.points);
    EXPECT_EQ(a.pointWidths, uneven.pointWidths);
    EXPECT_EQ(a.pointColors, uneven.pointColors);

    Groom even;
    even.strandOffsets = {0, 2, 4};
    even.points = {{0, 0, 0}, {0.1f, 1e-20f, -3}, {4, 5, 6}, {1e10f, 0, 1}};
    even.strandWidths = {{1, 0.5f}, {2, 0}};
    even.color = Spectrum(0.1f, 0.6f, 0.9f);
    WriteHairFile(Path("b.hair"), even);
    EXPECT_EQ(fs::file_size(Path("b.hair")), 128u + 4 * 12 + 4 * 4);
    const Groom b = ReadGroomFile(Path("b.hair"));
    EXPECT_EQ(b.points, even.points);
    EXPECT_EQ(b.pointWidths, (std::vector<float>{1, 0.5f, 2, 0}));
    EXPECT_FALSE(b.hasColor);
    // One colour for all is written as everyone's
    even.hasColor = true;
    WriteHairFile(Path("c.hair"), even);
    const Groom c = ReadGroomFile(Path("c.hair"));
    EXPECT_TRUE(c.hasColor);
    EXPECT_EQ(c.StrandColor(1), even.color);
}

TEST_F(HairFile, WritingRefusesWhatTheFormatCannotHold) {
    Groom g;
    g.strandOffsets = {0, 0};
    EXPECT_THROW(WriteHairFile(Path("c.hair"), g), Error);
    g.points.resize(65537);
    g.strandOffsets = {0, 65537};
    EXPECT_THROW(WriteHairFile(Path("c.hair"), g), Error);
    EXPECT_TRUE(fs::is_empty(folder_)) << "a refused file left something behind";
    g.points.resize(2);
    g.strandOffsets = {0, 2};
    EXPECT_THROW(WriteHairFile(Path("no/such/folder/c.hair"), g), Error);
}

TEST_F(HairFile, WrongFilesAreNamed) {
    EXPECT_THROW(ReadGroomFile(Path("absent.hair")), Error);
    EXPECT_THROW(ReadGroomFile(folder_.string()), Error);
    std::ofstream(Path("text.hair")) << "WorldBegin\n";
    try {
        ReadGroomFile(Path("text.hair"));
        FAIL() << "text was read as hair";
    } catch (const Error &e) {
        EXPECT_EQ(std::string(e.what()).find(Path("text.hair") + ": error: byte 0"), 0u) << e.what();
    }
}

// A real model of 10,000 strands of 16 points, where it is at hand.
TEST_F(HairFile, RealModel) {
    const std::optional<std::string> file = RealModel("straight.hair");
    if (!file)
        return;
    const Groom g = ReadGroomFile(*file);
    EXPECT_EQ(g.StrandCount(), 10000u);
    EXPECT_EQ(g.points.size(), 160000u);
    EXPECT_EQ(g.pointColors.size(), 160000u);
    EXPECT_FLOAT_EQ(g.width, 0.1f);
    const Bounds3f b = g.Bounds();
    EXPECT_GT(b.Diagonal().z, 80);
    EXPECT_LT(b.Diagonal().z, 90);
    size_t segments = 0;
    ForEachSegment(g, {}, [&](const BezierSegment &s, size_t) {
        ++segments;
        for (const Point3f &p : s.cp)
            ASSERT_TRUE(IsFinite(p));
    });
    EXPECT_EQ(segments, 150000u);
    WriteHairFile(Path("copy.hair"), g);
    EXPECT_EQ(ReadGroomFile(Path("copy.hair")).points, g.points);
}

} // namespace
} // namespace cuticle
