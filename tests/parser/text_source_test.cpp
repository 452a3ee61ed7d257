#include "parser/text_source.h"

#include "parser/test_scenes.h"

#include <gtest/gtest.h>

#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <unistd.h>

namespace cuticle {
namespace {

std::string Gzip(const std::string &text) {
    z_stream z{};
    deflateInit2(&z, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&z, static_cast<uLong>(text.size())) + 64, '\0');
    z.next_in = reinterpret_cast<Bytef *>(const_cast<char *>(text.data()));
    z.avail_in = static_cast<uInt>(text.size());
    z.next_out = reinterpret_cast<Bytef *>(out.data());
    z.avail_out = static_cast<uInt>(out.size());
    deflate(&z, Z_FINISH);
    out.resize(z.total_out);
    deflateEnd(&z);
    return out;
}

// A file of many pages that is cut while it is mapped: zeros, an error, and no signal that ends the program.
TEST(TextSource, AFileThatIsCutIsAnError) {
    const std::string name = testing::TempDir() + fmt::format("cuticle_cut_{}.pbrt", ::getpid());
    for (const off_t size : {off_t{0}, off_t{5000}, off_t{1} << 20}) {
        std::ofstream(name) << std::string(4 << 20, '#');
        const auto source = TextSource::FromFile(name, {}), other = TextSource::FromFile(name, {});
        source->CheckUnchanged();
        ASSERT_EQ(::truncate(name.c_str(), size), 0);
        EXPECT_EQ(source->End() - source->Begin(), 4 << 20);
        EXPECT_EQ(source->End()[-1], 0); // with the signal, at first
        EXPECT_EQ(source->Begin()[size + 4096], 0);
        for (const TextSource *s : {source.get(), other.get()})
            try {
                s->CheckUnchanged();
                ADD_FAILURE() << size;
            } catch (const Error &e) {
                EXPECT_EQ(std::string(e.what()),
                          name + ": error: \"" + name +
                              "\" was changed, and is shorter now, while it was read; read "
                              "it again when it is whole");
            }
    }
    std::filesystem::remove(name);
}

// The same in the middle of parsing: the warning at the beginning of the text is when it happens.
TEST(Parser, AFileThatIsCutWhileItIsReadIsAnError) {
    const std::string name = testing::TempDir() + fmt::format("cuticle_cut_{}.pbrt", ::getpid());
    struct Cut : WarningSink {
        void Warn(const FileLoc &, const std::string &, const std::string &) override {
            ++warnings;
            if (change)
                change();
        }
        std::function<void()> change;
        int warnings = 0;
    } sink;
    const WarningScope scope(&sink);
    const std::string head =
        "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" MediumInterface \"\" \"m\"\nWorldBegin\n";
    std::string text = head;
    while (text.size() < (4 << 20))
        text += "Translate 1 2 3 # and so on\nShape \"sphere\"\n";
    const auto parse = [&](const std::function<void()> &change) {
        std::ofstream(name) << text;
        sink.change = change;
        sink.warnings = 0;
        std::string message;
        try {
            ParseScene(TestPlugins(), name);
        } catch (const Error &e) {
            message = e.what();
        }
        EXPECT_GT(sink.warnings, 0);
        return message;
    };
    EXPECT_EQ(parse({}), "");
    for (const off_t size : {off_t{0}, off_t{10000}, static_cast<off_t>(text.size()) - 1})
        EXPECT_NE(
            parse([&] { ASSERT_EQ(::truncate(name.c_str(), size), 0); }).find("was changed, and is shorter"),
            std::string::npos)
            << size;
    EXPECT_NE(parse([&] { std::ofstream(name, std::ios::app) << "# more"; }).find("was changed while"),
              std::string::npos);
    std::filesystem::remove(name);
}

TEST(Parser, IncludesAreRelativeToTheTopFile) {
    const auto s = ParseScene(TestPlugins(), kData + "/include_top.pbrt");
    ASSERT_EQ(s.shapes.size(), 3u);
    const float radii[] = {1, 2, 3};
    for (size_t i = 0; i < 3; ++i)
        EXPECT_EQ(s.shapes[i].params.FindFloat("radius", 0), radii[i]);
    ExpectNear(ImageOf(s.shapes[1].objectToWorld, {1, 0, 0}), {3, 0, 0}, 0); // the leaf's Scale goes on
    EXPECT_TRUE(s.shapes[2].objectToWorld.IsIdentity());
    EXPECT_EQ(*s.shapes[0].params.loc.file, kData + "/parts/leaf.pbrt");
    EXPECT_EQ(s.shapes[0].params.loc.line, 2u);
    EXPECT_EQ(s.shapes[2].params.loc.line, 5u);
    EXPECT_EQ(s.filename, kData + "/include_top.pbrt");
}

TEST(Parser, ErrorInAnIncludeNamesThatFile) {
    EXPECT_EQ(ErrorOf(World("Include \"parts/broken.pbrt\"")),
              kData +
                  "/parts/broken.pbrt:2:18: error: expected the value of \"float radius\", found \"oops\"\n"
                  "      \"float radius\" oops\n    " +
                  std::string(17, ' ') + "^");
}

TEST(Parser, MissingIncludeIsAWarningWithItsPlace) {
    const std::string text =
        World("AttributeBegin\n  Include \"nowhere.pbrt\"\nNamedMaterial \"from there\"\n"
              "Material \"matte\" \"texture Kd\" \"also\" ObjectInstance \"too\" AttributeEnd");
    EXPECT_TRUE(Has(WarningOf(text), "test.pbrt:3:11: error: cannot open \"" + kData +
                                         "/nowhere.pbrt\": No such file or directory; it is left out, as by "
                                         "pbrt-v3"))
        << WarningOf(text);
    // What follows from it is not said again.
    FlushWarnings();
    EXPECT_EQ(ErrorOf(text), "");
    EXPECT_EQ(FlushWarnings(), 1u);
}

// pbrt-v3 reads one row of tokens through the stack of files.
TEST(Parser, DirectivesGoOnBehindAnInclude) {
    const TemporaryFolder folder;
    folder.Write("material", "Material \"hair\" # and its parameters outside");
    folder.Write("value", "Material \"hair\" \"float eumelanin\"");
    folder.Write("array", "Shape \"curve\" \"point P\" [0 0 0 1 0 0");
    folder.Write("curve", "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]");
    folder.Write("word", "Shape");
    folder.Write("numbers", "Translate 1 2");
    folder.Write("empty", "# nothing");
    folder.Write("nested", "Include \"array\" 2 0 0");
    const auto parse = [&](const std::string &body) {
        return ParseSceneText(TestPlugins(), World(body), "t", folder.Path());
    };
    for (const char *body : {"Include \"material\" \"float eumelanin\" 3 Shape \"sphere\"",
                             "Include \"value\" 3 Include \"empty\" Shape \"sphere\""}) {
        const SceneDescription s = parse(body);
        ASSERT_EQ(s.materials.size(), 2u) << body;
        EXPECT_EQ(s.materials[1].params.FindFloat("eumelanin", 0), 3) << body;
        EXPECT_EQ(s.shapes[0].state.material, 1) << body;
    }
    for (const char *body :
         {"Include \"array\" 2 0 0 3 0 0] \"float width\" 2", "Include \"curve\" \"float width\" 2",
          "Include \"word\" \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" 2",
          "Include \"nested\" 3 0 0] \"float width\" 2"}) {
        const SceneDescription s = parse(body);
        ASSERT_EQ(s.curves.segments.size(), 1u) << body;
        EXPECT_EQ(s.curves.segments[0].cp[3].x, 3) << body;
        EXPECT_EQ(s.curves.segments[0].width[0], 2) << body;
    }
    ExpectNear(ImageOf(parse("Include \"numbers\" 3 Shape \"sphere\"").shapes[0].objectToWorld, {0, 0, 0}),
               {1, 2, 3}, 0);
    // A place is one of the file that it stands in.
    const auto error = [&](const std::string &body) -> std::string {
        const StrictWarnings strict;
        try {
            parse(body);
        } catch (const Error &e) {
            return e.what();
        }
        return "";
    };
    EXPECT_TRUE(error("Include \"array\" x").starts_with("t:2:17: error: expected a value of \"point P\""));
    EXPECT_TRUE(
        error("Include \"array\" WorldEnd").starts_with(folder.Path() + "/array:1:25: error: the values"));
    EXPECT_TRUE(
        error("Include \"curve\" \"float no\" 2").starts_with("t:2:17: error: Shape \"curve\" has no use"));
    EXPECT_TRUE(
        error("Include \"value\" \"x\"").starts_with("t:2:17: error: \"float eumelanin\" takes numbers"));
}

TEST(Parser, IncludingItselfIsSeen) {
    EXPECT_THROW(ParseScene(TestPlugins(), kData + "/loop_a.pbrt"), Error);
    try {
        ParseScene(TestPlugins(), kData + "/loop_a.pbrt");
    } catch (const Error &e) {
        EXPECT_TRUE(Has(e.what(), kData + "/loop_b.pbrt:2:11: error: ")) << e.what();
        EXPECT_TRUE(Has(e.what(), "includes itself by way of other files")) << e.what();
    }
}

TEST(Parser, IncludesHaveALimitInDepthAndInNumber) {
    const TemporaryFolder folder;
    for (int i = 0; i < 80; ++i)
        folder.Write("f" + std::to_string(i), "Include \"f" + std::to_string(i + 1) + "\"");
    // Each file includes the next one ten times: 10^20 in all, if nobody counts.
    for (int i = 0; i < 20; ++i) {
        std::string text;
        for (int k = 0; k < 10; ++k)
            text += "Include \"g" + std::to_string(i + 1) + "\"\n";
        folder.Write("g" + std::to_string(i), text);
    }
    folder.Write("g20", "");
    const auto error = [&](const std::string &first) -> std::string {
        try {
            ParseSceneText(TestPlugins(), World("Include \"" + first + "\""), "top.pbrt", folder.Path());
        } catch (const Error &e) {
            return e.what();
        }
        return "";
    };
    EXPECT_TRUE(Has(error("f0"), "too deep")) << error("f0");
    EXPECT_TRUE(Has(error("g0"), "too many"));
}

TEST(Parser, GzipIsKnownByItsContent) {
    const TemporaryFolder folder;
    std::string body;
    for (int i = 0; i < 20000; ++i)
        body += "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 " + std::to_string(i) + " 0 0]\n";
    const std::string text = World(body), half = text.substr(0, text.size() / 2),
                      rest = text.substr(text.size() / 2);
    const auto plain = Parse(text);
    ASSERT_EQ(plain.curves.segments.size(), 20000u);
    for (const std::string &path :
         {folder.Write("a.pbrt.gz", Gzip(text)), folder.Write("b.pbrt", Gzip(text)),
          folder.Write("c.pbrt.gz", text),
          folder.Write("d.gz", Gzip(half) + Gzip(rest))}) { // members may follow one another
        const auto s = ParseScene(TestPlugins(), path);
        EXPECT_EQ(s.curves.segments.size(), plain.curves.segments.size()) << path;
        EXPECT_EQ(s.bytesRead, text.size()) << path;
        EXPECT_EQ(s.curves.segments.back().cp[3].x, 19999) << path;
    }
    folder.Write("inner.gz", Gzip("Shape \"sphere\"\n"));
    EXPECT_EQ(ParseSceneText(TestPlugins(), World("Include \"inner.gz\""), "t", folder.Path()).shapes.size(),
              1u);

    const auto error = [&](const std::string &content) -> std::string {
        try {
            ParseScene(TestPlugins(), folder.Write("bad.gz", content));
        } catch (const Error &e) {
            return e.what();
        }
        return "";
    };
    const std::string packed = Gzip(text);
    EXPECT_TRUE(Has(error(packed.substr(0, packed.size() / 2)), "ends in the middle"));
    std::string damaged = packed;
    for (size_t i = packed.size() / 2; i < packed.size() / 2 + 50; ++i)
        damaged[i] = static_cast<char>(~damaged[i]);
    EXPECT_NE(error(damaged), "");
    EXPECT_TRUE(Has(error(Gzip(std::string(1 << 24, '\0'))), "binary data"));
    EXPECT_TRUE(Has(error(Gzip(std::string(size_t(300) << 20, ' '))), "times its size"));
}

// Text already read is given back to the system every few megabytes: places must stay right, and all curves
// arrive.
TEST(Parser, LargeFileIsReleasedBehindTheReader) {
    const TemporaryFolder folder;
    std::string text = "WorldBegin\nAttributeBegin\n";
    constexpr int kCurves = 250000;
    for (int i = 0; i < kCurves; ++i)
        text += "Shape \"curve\" \"point P\" [0 0 0 1 0 0 2 0 0 " + std::to_string(i) +
                " 0 0] \"float width0\" [0.010000] \"float width1\" [0.005000]\n";
    ASSERT_GT(text.size(), size_t(20) << 20);
    const auto s = ParseScene(TestPlugins(), folder.Write("large.pbrt", text + "AttributeEnd WorldEnd\n"));
    ASSERT_EQ(s.curves.segments.size(), static_cast<size_t>(kCurves));
    for (int i = 0; i < kCurves; ++i)
        ASSERT_EQ(s.curves.segments[static_cast<size_t>(i)].cp[3].x, static_cast<float>(i));
    const std::string path = folder.Write("wrong.pbrt", text + "  TransformEnd\n");
    try {
        ParseScene(TestPlugins(), path);
        FAIL() << "TransformEnd closed an AttributeBegin";
    } catch (const Error &e) {
        EXPECT_EQ(std::string(e.what()),
                  path + ":" + std::to_string(kCurves + 3) +
                      ":3: error: TransformEnd inside the block of AttributeBegin at " + path +
                      ":2:1: that must end first\n      TransformEnd\n      ^");
    }
}

TEST(Parser, FilesThatAreNone) {
    EXPECT_THROW(ParseScene(TestPlugins(), kData + "/no such file.pbrt"), Error);
    EXPECT_THROW(ParseScene(TestPlugins(), kData), Error);
    const TemporaryFolder folder;
    EXPECT_THROW(ParseScene(TestPlugins(), folder.Write("empty", "")), Error);
    // A file of exactly whole pages has no byte behind it to stop at.
    std::string page = World("Shape \"sphere\"");
    page.insert(0, 8192 - page.size(), '\n');
    page.back() = ' ';
    EXPECT_EQ(ParseScene(TestPlugins(), folder.Write("page", page)).shapes.size(), 1u);
    const std::string number = "WorldBegin Translate 0 0 " + std::string(8192 - 25, '1');
    ASSERT_EQ(number.size() % 4096, 0u);
    EXPECT_THROW(ParseScene(TestPlugins(), folder.Write("number", number)), Error);
}

} // namespace
} // namespace cuticle
