// Pictures in files: what is written is read back; what is damaged is an Error and never a crash.
#include "images/image.h"

#include "core/error.h"
#include "core/memory_budget.h"
#include "files/gzip.h"
#include "message_of.h"

#include <gtest/gtest.h>
#include <png.h>
#include <zlib.h>

#include <bit>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wunused-function"
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

using namespace cuticle;
namespace fs = std::filesystem;

namespace {

// A folder of the test's own, gone at its end.
class ImageFile : public testing::Test {
  protected:
    ImageFile() {
        const auto *info = testing::UnitTest::GetInstance()->current_test_info();
        folder =
            fs::path(testing::TempDir()) / ("cuticle_image_" + std::to_string(::getpid()) + info->name());
        fs::create_directories(folder);
    }
    ~ImageFile() override { fs::remove_all(folder); }
    std::string Path(const std::string &name) const { return (folder / name).string(); }
    std::string Write(const std::string &name, const std::string &bytes) const {
        std::ofstream(Path(name), std::ios::binary) << bytes;
        return Path(name);
    }
    static std::string Bytes(const std::string &path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    size_t FilesInFolder() const {
        return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }
    fs::path folder;
};

Image Gradient(int width, int height, std::vector<std::string> channels) {
    Image image(width, height, std::move(channels));
    for (size_t i = 0; i < image.data.size(); ++i)
        image.data[i] = static_cast<float>(i) / static_cast<float>(image.data.size());
    return image;
}

std::string PFM(const std::string &header, const std::vector<float> &values) {
    std::string bytes = header;
    bytes.append(reinterpret_cast<const char *>(values.data()), values.size() * sizeof(float));
    return bytes;
}

// An uncompressed 24-bit TGA of w x h, top row first, blue, green, red in the order of the bytes.
std::string TGA(int w, int h, const std::vector<unsigned char> &bgr) {
    std::string bytes(18, '\0');
    bytes[2] = 2;
    bytes[12] = static_cast<char>(w & 255), bytes[13] = static_cast<char>(w >> 8);
    bytes[14] = static_cast<char>(h & 255), bytes[15] = static_cast<char>(h >> 8);
    bytes[16] = 24, bytes[17] = 0x20;
    return bytes.append(bgr.begin(), bgr.end());
}

// PNG of any colour type, as libpng's simplified interface writes it.
std::string PNG(png_uint_32 format, int w, int h, const void *pixels, const void *colormap = nullptr,
                int entries = 0) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(w), image.height = static_cast<png_uint_32>(h);
    image.format = format;
    image.colormap_entries = static_cast<png_uint_32>(entries);
    std::string bytes(1 << 16, '\0');
    png_alloc_size_t size = bytes.size();
    EXPECT_TRUE(png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels, 0, colormap))
        << image.message;
    bytes.resize(size);
    return bytes;
}

// A whole Radiance picture of one row, w x 1, not compressed.
std::string HDR(const std::vector<std::array<unsigned char, 4>> &rgbe) {
    std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X " + std::to_string(rgbe.size()) + "\n";
    for (const auto &p : rgbe)
        bytes.append(p.begin(), p.end());
    return bytes;
}

// A JPEG of one colour, in blocks of 8 x 8.
std::string JPEG(int w, int h, const std::array<unsigned char, 3> &rgb) {
    std::vector<unsigned char> pixels;
    for (int i = 0; i < w * h; ++i)
        pixels.insert(pixels.end(), rgb.begin(), rgb.end());
    std::string bytes;
    const auto append = [](void *to, void *from, int size) {
        static_cast<std::string *>(to)->append(static_cast<const char *>(from), static_cast<size_t>(size));
    };
    EXPECT_TRUE(stbi_write_jpg_to_func(append, &bytes, w, h, 3, pixels.data(), 95));
    return bytes;
}

enum { UintType = 0, HalfType = 1, FloatType = 2 };

// An uncompressed EXR of any channels, written from the format's description and not by OpenEXR.
struct RawEXR {
    struct Channel {
        std::string name;
        int type, sampling;
    };
    std::array<int, 4> dataWindow, displayWindow;
    std::vector<Channel> channels; // in alphabetical order
    bool tiled = false;            // in tiles of 4 x 4 pixels
    std::function<double(int x, int y, size_t channel)>
        value; // >= 0; x, y count from the data window's corner

    template <class T>
    static void Put(std::string *to, T v) {
        to->append(reinterpret_cast<const char *>(&v), sizeof(v));
    }
    // Exact for the small multiples of 1/4 that the tests use.
    static uint16_t Half(double v) {
        const uint32_t bits = std::bit_cast<uint32_t>(static_cast<float>(v));
        return static_cast<uint16_t>(v == 0 ? 0 : (((bits >> 23) - 112) << 10) | ((bits >> 13) & 0x3ff));
    }
    static void Attribute(std::string *to, const std::string &name, const std::string &type,
                          const std::string &bytes) {
        to->append(name.c_str(), name.size() + 1).append(type.c_str(), type.size() + 1);
        Put(to, static_cast<int32_t>(bytes.size()));
        *to += bytes;
    }
    std::string Block(int x0, int y0, int x1, int y1) const {
        std::string bytes;
        for (int y = y0; y < y1; ++y)
            for (size_t c = 0; c < channels.size(); ++c)
                for (int x = x0; x < x1; ++x) {
                    if (channels[c].type == UintType)
                        Put(&bytes, static_cast<uint32_t>(value(x, y, c)));
                    else if (channels[c].type == HalfType)
                        Put(&bytes, Half(value(x, y, c)));
                    else
                        Put(&bytes, static_cast<float>(value(x, y, c)));
                }
        return bytes;
    }
    std::string Encode() const {
        std::string bytes, list, box, tiles;
        Put(&bytes, uint32_t{20000630});
        Put(&bytes, uint32_t{tiled ? 0x202u : 2u});
        for (const Channel &c : channels) {
            list.append(c.name.c_str(), c.name.size() + 1);
            for (const int32_t v : {c.type, 0, c.sampling, c.sampling})
                Put(&list, v);
        }
        Attribute(&bytes, "channels", "chlist", list + std::string(1, '\0'));
        Attribute(&bytes, "compression", "compression", std::string(1, '\0'));
        for (const int32_t v : dataWindow)
            Put(&box, v);
        Attribute(&bytes, "dataWindow", "box2i", box);
        box.clear();
        for (const int32_t v : displayWindow)
            Put(&box, v);
        Attribute(&bytes, "displayWindow", "box2i", box);
        Attribute(&bytes, "lineOrder", "lineOrder", std::string(1, '\0'));
        std::string one, zeros(8, '\0');
        Put(&one, 1.f);
        Attribute(&bytes, "pixelAspectRatio", "float", one);
        Attribute(&bytes, "screenWindowCenter", "v2f", zeros);
        Attribute(&bytes, "screenWindowWidth", "float", one);
        Put(&tiles, uint32_t{4}), Put(&tiles, uint32_t{4}), tiles += '\0';
        if (tiled)
            Attribute(&bytes, "tiles", "tiledesc", tiles);
        bytes += '\0';

        // The chunks: one a line, or one a tile; before them the table of where each begins
        const int w = dataWindow[2] - dataWindow[0] + 1, h = dataWindow[3] - dataWindow[1] + 1;
        std::vector<std::string> chunks;
        for (int y = 0; y < h; y += tiled ? 4 : 1)
            for (int x = 0; x < w; x += tiled ? 4 : w) {
                std::string chunk;
                if (tiled)
                    for (const int32_t v : {x / 4, y / 4, 0, 0})
                        Put(&chunk, v);
                else
                    Put(&chunk, static_cast<int32_t>(dataWindow[1] + y));
                const std::string block =
                    tiled ? Block(x, y, std::min(x + 4, w), std::min(y + 4, h)) : Block(0, y, w, y + 1);
                Put(&chunk, static_cast<int32_t>(block.size()));
                chunks.push_back(chunk + block);
            }
        uint64_t at = bytes.size() + 8 * chunks.size();
        for (const std::string &chunk : chunks) {
            Put(&bytes, at);
            at += chunk.size();
        }
        for (const std::string &chunk : chunks)
            bytes += chunk;
        return bytes;
    }
};

} // namespace

using EXR = ImageFile;
using PNGFile = ImageFile;
using PFMFile = ImageFile;
using OldFormats = ImageFile;
using Damaged = ImageFile;
using AtomicWrite = ImageFile;

TEST_F(EXR, ArbitraryChannelsAndAttributesSurvive) {
    Image image = Gradient(37, 19, {"R", "G", "B", "A", "variance.B", "variance.G", "variance.R"});
    image.data[5] = -3, image.data[6] = 1e30f, image.data[7] = 1e-42f;
    image.attributes["scene"].text = "a head of hair";
    image.attributes["spp"] = {ImageAttribute::Kind::Number, "", 16, {}};
    ImageAttribute matrix{ImageAttribute::Kind::Matrix, "", 0, {}};
    for (size_t i = 0; i < 16; ++i)
        matrix.matrix[i] = static_cast<float>(i * i);
    image.attributes["worldToCamera"] = matrix;
    WriteImage(Path("a.exr"), image);
    const Image back = ReadImage(Path("a.exr"));
    EXPECT_EQ(back.width, 37);
    EXPECT_EQ(back.height, 19);
    EXPECT_EQ(back.channels, image.channels);
    EXPECT_EQ(back.data, image.data); // bit for bit
    EXPECT_EQ(back.attributes.at("scene").text, "a head of hair");
    EXPECT_EQ(back.attributes.at("spp").number, 16);
    EXPECT_EQ(back.attributes.at("worldToCamera").matrix, matrix.matrix);
    EXPECT_EQ(back.attributes.size(), 3u);
}

TEST_F(EXR, NaNAndInfinitySurvive) {
    Image image(2, 1, {"R", "G", "B"});
    image.data = {std::nanf(""), 1, -Infinity, Infinity, 0, -0.f};
    WriteImage(Path("a.exr"), image);
    const Image back = ReadImage(Path("a.exr"));
    EXPECT_TRUE(std::isnan(back.data[0]));
    EXPECT_EQ(back.data[2], -Infinity);
    EXPECT_EQ(back.data[3], Infinity);
    EXPECT_TRUE(std::signbit(back.data[5]));
}

TEST_F(EXR, CroppedPicturesKeepTheirPlace) {
    Image image = Gradient(5, 4, {"R", "G", "B"});
    image.fullWidth = 20, image.fullHeight = 10, image.cropX = 7, image.cropY = 3;
    WriteImage(Path("a.exr"), image);
    const Image back = ReadImage(Path("a.exr"));
    EXPECT_EQ(back.fullWidth, 20);
    EXPECT_EQ(back.fullHeight, 10);
    EXPECT_EQ(back.cropX, 7);
    EXPECT_EQ(back.cropY, 3);
    EXPECT_EQ(back.data, image.data);
}

// Half and whole numbers become floats; a window that begins below 0 is read whole; scan lines or tiles.
TEST_F(EXR, ReadsHalfAndUintInLinesAndTiles) {
    for (const bool tiled : {false, true}) {
        const int w = 6, h = 5;
        RawEXR raw{
            {-2, -3, w - 3, h - 4}, {0, 0, 9, 9}, {{"Y", HalfType, 1}, {"id", UintType, 1}}, tiled, {}};
        raw.value = [](int x, int y, size_t c) { return c == 0 ? 0.25 * (x + 10 * y) : 1000. * x + y; };
        const Image image = ReadImage(Write("h.exr", raw.Encode()));
        ASSERT_EQ(image.channels, (std::vector<std::string>{"Y", "id"}));
        ASSERT_EQ(image.width, w);
        ASSERT_EQ(image.height, h);
        EXPECT_EQ(image.cropX, -2);
        EXPECT_EQ(image.cropY, -3);
        EXPECT_EQ(image.fullWidth, 10);
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x) {
                EXPECT_EQ(image.At(x, y, 0), 0.25f * static_cast<float>(x + 10 * y)) << x << ", " << y;
                EXPECT_EQ(image.At(x, y, 1), static_cast<float>(1000 * x + y)) << x << ", " << y;
            }
        EXPECT_EQ(image.RGB(1, 0), Spectrum(0.25f));
    }
}

TEST_F(EXR, ColoursComeFirstWhateverTheOrderInTheFile) {
    RawEXR raw{{0, 0, 1, 1},
               {0, 0, 1, 1},
               {{"A", FloatType, 1},
                {"B", FloatType, 1},
                {"G", FloatType, 1},
                {"R", FloatType, 1},
                {"depth.Z", FloatType, 1}},
               false,
               {}};
    raw.value = [](int, int, size_t c) { return static_cast<double>(c) + 0.5; };
    const Image image = ReadImage(Write("o.exr", raw.Encode()));
    EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A", "depth.Z"}));
    EXPECT_EQ(image.RGB(1, 1), Spectrum(3.5f, 2.5f, 1.5f));
}

TEST_F(EXR, SubsampledChannelsAreAnError) {
    RawEXR raw{{0, 0, 1, 1}, {0, 0, 1, 1}, {{"RY", FloatType, 2}}, false, {}};
    raw.value = [](int, int, size_t) { return 0.; };
    EXPECT_NE(MessageOf([&] { ReadImage(Write("s.exr", raw.Encode())); }).find("subsampled"),
              std::string::npos);
}

TEST_F(PNGFile, EightBitRoundTripIsExact) {
    // Every 8-bit value, written from its linear value, comes back as itself.
    Image image(256, 1, {"R", "G", "B"});
    for (int x = 0; x < 256; ++x)
        for (size_t c = 0; c < 3; ++c)
            image.At(x, 0, c) = SRGBToLinear(static_cast<float>(x) / 255);
    WriteImage(Path("a.png"), image);
    const Image encoded = ReadImage(Path("a.png"), false), linear = ReadImage(Path("a.png"));
    ASSERT_EQ(encoded.channels, (std::vector<std::string>{"R", "G", "B"}));
    for (int x = 0; x < 256; ++x) {
        EXPECT_EQ(encoded.At(x, 0, 1), static_cast<float>(x) / 255);
        EXPECT_EQ(linear.At(x, 0, 1), image.At(x, 0, 1));
    }
}

TEST_F(PNGFile, ClampsAndShowsNaNMagenta) {
    Image image(4, 1, {"R", "G", "B"});
    image.data = {-1, 2, 0.5f, std::nanf(""), 0, 0, Infinity, -Infinity, 1, 0, 0, std::nanf("")};
    WriteImage(Path("a.png"), image);
    const Image back = ReadImage(Path("a.png"), false);
    EXPECT_EQ(back.RGB(0, 0), Spectrum(0, 1, 188.f / 255)); // sRGB of 0.5
    EXPECT_EQ(back.RGB(1, 0), Spectrum(1, 0, 1));
    EXPECT_EQ(back.RGB(2, 0), Spectrum(1, 0, 1));
    EXPECT_EQ(back.RGB(3, 0), Spectrum(1, 0, 1));
    EXPECT_EQ(back.RGB(0, 0)[2], 188.f / 255);
}

TEST_F(PNGFile, ReadsGreyAlphaPaletteAnd16Bit) {
    const unsigned char grey[] = {0, 51, 255, 102};
    Image image = ReadImage(Write("g.png", PNG(PNG_FORMAT_GRAY, 2, 2, grey)), false);
    EXPECT_EQ(image.channels, (std::vector<std::string>{"Y"}));
    EXPECT_EQ(image.data, (std::vector<float>{0, 0.2f, 1, 0.4f}));
    EXPECT_EQ(image.RGB(1, 0), Spectrum(0.2f));

    // Alpha is linear already: decoding leaves it
    const unsigned char greyAlpha[] = {255, 51, 0, 255};
    image = ReadImage(Write("ga.png", PNG(PNG_FORMAT_GA, 2, 1, greyAlpha)));
    EXPECT_EQ(image.channels, (std::vector<std::string>{"Y", "A"}));
    EXPECT_EQ(image.data, (std::vector<float>{1, 0.2f, 0, 1}));

    const unsigned char colormap[] = {255, 0, 0, 0, 51, 255}, indices[] = {1, 0, 1};
    image = ReadImage(Write("p.png", PNG(PNG_FORMAT_RGB_COLORMAP, 3, 1, indices, colormap, 2)), false);
    EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_EQ(image.RGB(0, 0), Spectrum(0, 0.2f, 1));
    EXPECT_EQ(image.RGB(1, 0), Spectrum(1, 0, 0));

    // 16-bit linear in memory; libpng stores it sRGB-encoded at 16 bits, and we decode it again
    const png_uint_16 deep[] = {0, 6554, 65535, 32768, 1000, 3};
    image = ReadImage(Write("d.png", PNG(PNG_FORMAT_LINEAR_RGB, 2, 1, deep)));
    ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
    const Image raw = ReadImage(Path("d.png"), false);
    for (size_t i = 0; i < 6; ++i)
        EXPECT_NEAR(image.data[i], SRGBToLinear(raw.data[i]), 1e-7);
    bool finer = false; // than 8 bits
    for (const float v : raw.data)
        finer |= std::abs(v * 255 - std::round(v * 255)) > 0.01f;
    EXPECT_TRUE(finer);
}

TEST_F(PFMFile, ReadsBothByteOrdersBottomUp) {
    const std::vector<float> values = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    const Image image = ReadImage(Write("a.pfm", PFM("PF\n2 2\n-1\n", values)));
    EXPECT_EQ(image.RGB(0, 0), Spectrum(7, 8, 9)); // the file's second row is the top one
    EXPECT_EQ(image.RGB(1, 1), Spectrum(4, 5, 6));

    std::vector<float> swapped;
    for (const float v : values) {
        unsigned char b[4];
        std::memcpy(b, &v, 4);
        std::swap(b[0], b[3]), std::swap(b[1], b[2]);
        float s;
        std::memcpy(&s, b, 4);
        swapped.push_back(s);
    }
    EXPECT_EQ(ReadImage(Write("b.pfm", PFM("PF 2 2 1.0 ", swapped))).data, image.data);
    EXPECT_EQ(EncodeImage("c.pfm", image), PFM("PF\n2 2\n-1.0\n", values)); // what was read is written again
    // The scale multiplies, as in pbrt-v3
    const Image grey = ReadImage(Write("c.pfm", PFM("Pf\n3 1\n-2\n", {1, 2, 4})));
    EXPECT_EQ(grey.channels, (std::vector<std::string>{"Y"}));
    EXPECT_EQ(grey.data, (std::vector<float>{2, 4, 8}));
}

TEST_F(OldFormats, TGA) {
    const std::string bytes = TGA(2, 1, {0, 51, 255, 255, 0, 102});
    const Image image = ReadImage(Write("a.TGA", bytes), false);
    ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_EQ(image.RGB(0, 0), Spectrum(1, 0.2f, 0));
    EXPECT_EQ(image.RGB(1, 0), Spectrum(0.4f, 0, 1));
    EXPECT_FLOAT_EQ(ReadImage(Path("a.TGA")).RGB(0, 0)[1], SRGBToLinear(0.2f));
}

TEST_F(OldFormats, HDR) {
    const Image image =
        ReadImage(Write("a.hdr", HDR({{128, 64, 0, 129}, {255, 255, 255, 140}, {0, 0, 0, 0}})));
    ASSERT_EQ(image.width, 3);
    EXPECT_FLOAT_EQ(image.RGB(0, 0)[0], 1);
    EXPECT_FLOAT_EQ(image.RGB(0, 0)[1], 0.5f);
    EXPECT_FLOAT_EQ(image.RGB(1, 0)[2], 4080);
    EXPECT_EQ(image.RGB(2, 0), Spectrum(0));
}

TEST_F(OldFormats, JPEG) {
    for (const char *name : {"a.jpg", "b.jpeg"}) {
        const Image image = ReadImage(Write(name, JPEG(17, 9, {200, 100, 50})), false);
        ASSERT_EQ(image.width, 17);
        ASSERT_EQ(image.height, 9);
        ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
        for (int y = 0; y < 9; ++y)
            for (int x = 0; x < 17; ++x) {
                EXPECT_NEAR(image.RGB(x, y)[0], 200 / 255.f, 0.02f);
                EXPECT_NEAR(image.RGB(x, y)[1], 100 / 255.f, 0.02f);
                EXPECT_NEAR(image.RGB(x, y)[2], 50 / 255.f, 0.02f);
            }
    }
}

TEST_F(Damaged, ErrorsNameTheFile) {
    const auto names = [&](const std::string &name, const std::string &bytes) {
        const std::string path = Write(name, bytes);
        const std::string message = MessageOf([&] { ReadImage(path); });
        EXPECT_NE(message.find(path), std::string::npos) << name << ": \"" << message << "\"";
    };
    for (const char *ext : {"exr", "png", "pfm", "tga", "hdr", "jpg", "jpeg"}) {
        names(std::string("empty.") + ext, "");
        names(std::string("text.") + ext,
              "this is a letter to my aunt and not a picture at all, whatever it is called");
    }
    EXPECT_NE(MessageOf([&] { ReadImage(Path("missing.exr")); }).find("No such file"), std::string::npos);
    EXPECT_NE(MessageOf([&] { ReadImage(Path("a.bmp")); }).find(".exr"), std::string::npos);
    fs::create_directory(folder / "d.png");
    EXPECT_NE(MessageOf([&] { ReadImage(Path("d.png")); }).find("directory"), std::string::npos);
}

TEST_F(Damaged, AbsurdHeaders) {
    for (const char *header :
         {"PF\n0 5\n-1\n", "PF\n-3 5\n-1\n", "PF\n1e9 1e9\n-1\n", "PF\n32768 32769\n-1\n", "PF\n2 2\n0\n",
          "PF\nnan 2\n-1\n", "PF\n2.5 2\n-1\n", "PF\n2 2\n", "PF\n2 2\n-1"})
        EXPECT_NE(MessageOf([&] { ReadImage(Write("a.pfm", header)); }), "") << header;
    // A PNG header of 2^31 - 1 squared, with a good checksum
    std::string png = PNG(PNG_FORMAT_GRAY, 1, 1, "\x05");
    std::memcpy(png.data() + 16, "\x7f\xff\xff\xff\x7f\xff\xff\xff", 8);
    uLong crc = crc32(0, reinterpret_cast<const Bytef *>(png.data()) + 12, 17);
    for (size_t i = 0; i < 4; ++i)
        png[29 + i] = static_cast<char>(crc >> (24 - 8 * i));
    EXPECT_NE(MessageOf([&] { ReadImage(Write("big.png", png)); }).find("2^30"), std::string::npos);
    // ... and of 16384 squared: few enough pixels, but not in so short a file
    std::memcpy(png.data() + 16, "\0\0\x40\0\0\0\x40\0", 8);
    crc = crc32(0, reinterpret_cast<const Bytef *>(png.data()) + 12, 17);
    for (size_t i = 0; i < 4; ++i)
        png[29 + i] = static_cast<char>(crc >> (24 - 8 * i));
    EXPECT_NE(MessageOf([&] { ReadImage(Write("thin.png", png)); }).find("cannot hold"), std::string::npos);
    // An EXR whose windows are absurd: the four numbers after the words "dataWindow", "box2i" and a size
    WriteImage(Path("a.exr"), Gradient(8, 8, {"R", "G", "B"}));
    std::string exr = Bytes(Path("a.exr"));
    const size_t at = exr.find("dataWindow") + sizeof("dataWindow") + sizeof("box2i") + 4;
    const int32_t windows[][4] = {
        {0, 0, 1 << 30, 1 << 30}, {INT32_MIN, 0, INT32_MAX, 0}, {5, 5, 1, 1}, {0, 0, 20000, 20000}};
    for (const auto &window : windows) {
        std::memcpy(exr.data() + at, window, sizeof(window));
        EXPECT_NE(MessageOf([&] { ReadImage(Write("b.exr", exr)); }), "");
    }
    // Found by fuzzing: OpenEXR allocates 2 GB for a text of that length before it misses the bytes
    const std::string text("\x76\x2f\x31\x01\x02\0\0\0owner\0string\0\xff\xff\xff\x7f", 25);
    EXPECT_NE(MessageOf([&] { ReadImage(Write("text.exr", text)); }).find("more than the file"),
              std::string::npos);
}

// The most memory that this process has held, in MB.
double PeakMB() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

std::string PNGChunk(const std::string &type, const std::string &data) {
    const auto number = [](uLong v) {
        std::string s;
        for (int i = 3; i >= 0; --i)
            s += static_cast<char>(v >> (8 * i));
        return s;
    };
    const std::string body = type + data;
    return number(data.size()) + body +
           number(crc32(0, reinterpret_cast<const Bytef *>(body.data()), static_cast<uInt>(body.size())));
}

// Headers of 8192 x 8192 pixels, 805 MB as floats, above the first rows of such a picture: memory follows the
// rows.
TEST_F(Damaged, MemoryFollowsWhatAFileHolds) {
    const double before = PeakMB();
    std::string rows; // 64 of noise, each with its filter's number
    for (uint32_t i = 0, x = 1; i < 64 * (3 * 8192 + 1); ++i, x = x * 1664525 + 1013904223)
        rows += i % (3 * 8192 + 1) == 0 ? '\0' : static_cast<char>(x >> 24);
    uLongf size = compressBound(rows.size());
    std::string packed(size, '\0');
    compress(reinterpret_cast<Bytef *>(packed.data()), &size, reinterpret_cast<const Bytef *>(rows.data()),
             rows.size());
    packed.resize(size);
    const std::string png = std::string("\x89PNG\r\n\x1a\n", 8) +
                            PNGChunk("IHDR", std::string("\0\0\x20\0\0\0\x20\0\x08\x02\0\0\0", 13)) +
                            PNGChunk("IDAT", packed);
    EXPECT_NE(MessageOf([&] { ReadImage(Write("some.png", png)); }).find("not a readable PNG"),
              std::string::npos);

    WriteImage(Path("a.exr"), Gradient(64, 64, {"R", "G", "B"}));
    std::string exr = Bytes(Path("a.exr"));
    const size_t at = exr.find("dataWindow") + sizeof("dataWindow") + sizeof("box2i") + 4;
    const int32_t window[4] = {0, 0, 8191, 8191};
    std::memcpy(exr.data() + at, window, sizeof(window));
    exr += std::string(1 << 20, '\x55');
    EXPECT_NE(MessageOf([&] { ReadImage(Write("some.exr", exr)); }).find("not a readable EXR"),
              std::string::npos);
    EXPECT_LT(PeakMB() - before, 200);
}

// One limit holds for all that is packed.
TEST_F(Damaged, WhatExpandsTooFarIsRefused) {
    EXPECT_FALSE(ExpandsTooFar(kFreeExpansion, 1));
    EXPECT_TRUE(ExpandsTooFar(kFreeExpansion + 201, 1000));
    EXPECT_FALSE(ExpandsTooFar(uint64_t{200} << 30, uint64_t{1} << 30));
    // A JPEG header of 65,500 squared above the pixels of 8 x 8, an EXR of one column and of one row
    std::string jpeg = JPEG(8, 8, {1, 2, 3});
    size_t frame = jpeg.find("\xff\xc0");
    ASSERT_NE(frame, std::string::npos);
    jpeg[frame + 5] = jpeg[frame + 6] = jpeg[frame + 7] = jpeg[frame + 8] = '\xff';
    EXPECT_NE(MessageOf([&] { ReadImage(Write("a.jpg", jpeg)); }), "");
    WriteImage(Path("a.exr"), Gradient(64, 64, {"R", "G", "B"}));
    std::string exr = Bytes(Path("a.exr"));
    const size_t at = exr.find("dataWindow") + sizeof("dataWindow") + sizeof("box2i") + 4;
    const int32_t column[4] = {0, 0, 0, (1 << 23) - 1}, row[4] = {0, 0, (1 << 23) - 1, 0};
    exr += std::string(4096, '\0');
    std::memcpy(exr.data() + at, column, sizeof(column));
    EXPECT_NE(MessageOf([&] { ReadImage(Write("c.exr", exr)); }).find("pieces do not fit"),
              std::string::npos);
    std::memcpy(exr.data() + at, row, sizeof(row));
    EXPECT_NE(MessageOf([&] { ReadImage(Write("r.exr", exr)); }).find("a piece of 8388608 x 16"),
              std::string::npos);
}

TEST_F(Damaged, APictureIsClaimedBeforeItIsHeld) {
    WriteImage(Path("a.exr"), Gradient(64, 64, {"R", "G", "B"}));
    MemoryBudget budget(40000);
    const MemoryBudgetScope scope(&budget);
    const std::string message = MessageOf([&] { ReadImage(Path("a.exr")); });
    EXPECT_NE(message.find("48.0 KB, is for the picture"), std::string::npos) << message; // 64 * 64 * 3 * 4
    EXPECT_NE(message.find("--max-memory allows 39.1 KB"), std::string::npos) << message;
}

// A decoder before this one wrote beyond its tables for these; every code must fit, and at most 256 of them.
// The table may also stand where only the decoder looks: behind bytes of pixels that hold a marker.
TEST_F(Damaged, JPEGHuffmanTablesWithTooManyCodes) {
    const std::string good = JPEG(8, 8, {1, 2, 3});
    const size_t at = good.find("\xff\xc4") + 5; // the 16 counts of the first table
    std::string manyOfOneLength = good, manyInAll = good;
    manyOfOneLength[at] = '\x03'; // three codes of one bit
    for (size_t i = 0; i < 16; ++i)
        manyInAll[at + i] = static_cast<char>(i < 8 ? 0 : 60);
    std::string hidden = good;
    hidden.insert(good.size() - 2, manyInAll.substr(at - 5, 2 + 2 + 17 + 480));
    EXPECT_EQ(MessageOf([&] { DecodeImage("a.jpg", good); }), "");
    for (const std::string &bytes : {manyOfOneLength, manyInAll, hidden})
        EXPECT_NE(MessageOf([&] { DecodeImage("a.jpg", bytes); }).find("not a readable JPEG file"),
                  std::string::npos);
}

// A picture in more scans than any camera writes would be decoded for hours.
TEST_F(Damaged, JPEGOfManyScans) {
    // A picture of 8 x 8 in one component whose first, progressive scan is repeated
    const auto segment = [](char marker, const std::string &payload) {
        const size_t n = payload.size() + 2;
        return std::string{'\xff', marker, static_cast<char>(n >> 8), static_cast<char>(n & 0xff)} + payload;
    };
    std::string bytes = "\xff\xd8" + segment('\xdb', '\0' + std::string(64, '\1'));
    bytes += segment('\xc2', std::string("\x08\0\x08\0\x08\x01\x01\x11\0", 9)); // progressive
    std::string counts(16, '\0');
    counts[0] = '\1';
    bytes += segment('\xc4', '\0' + counts + '\0'); // one code, for no difference
    const std::string scan = segment('\xda', std::string("\x01\x01\0\0\0\0", 6)) + '\x7f';
    std::string few = bytes + scan + "\xff\xd9", many = bytes;
    for (int i = 0; i < 1000; ++i)
        many += scan;
    EXPECT_EQ(MessageOf([&] { EXPECT_EQ(DecodeImage("a.jpg", few).width, 8); }), "");
    EXPECT_NE(MessageOf([&] { DecodeImage("a.jpg", many + "\xff\xd9"); }).find("scans"), std::string::npos);
}

// Every way to cut a file short is an Error; the formats' tails that hold no pixels may be missing.
TEST_F(Damaged, EveryTruncationIsAnErrorOrHarmless) {
    const Image image = Gradient(9, 7, {"R", "G", "B"});
    WriteImage(Path("a.exr"), image);
    WriteImage(Path("a.png"), image);
    Write("a.pfm", PFM("PF\n3 2\n-1\n", std::vector<float>(18, 0.5f)));
    Write("a.tga", TGA(3, 2, std::vector<unsigned char>(18, 7)));
    Write("a.hdr", HDR(std::vector<std::array<unsigned char, 4>>(5, {9, 8, 7, 128})));
    Write("a.jpg", JPEG(9, 7, {200, 100, 50}));
    for (const char *name : {"a.exr", "a.png", "a.pfm", "a.tga", "a.hdr", "a.jpg"}) {
        const std::string bytes = Bytes(Path(name));
        ASSERT_EQ(MessageOf([&] { ReadImage(Path(name)); }), "") << name;
        for (size_t n = 0; n < bytes.size(); ++n) {
            EXPECT_NE(MessageOf([&] { DecodeImage(name, bytes.substr(0, n)); }), "")
                << name << " cut to " << n << " of " << bytes.size();
        }
    }
}

// Bytes changed at fixed places and to fixed values: a picture or an Error, nothing else.
TEST_F(Damaged, ChangedBytesNeverCrash) {
    const Image image = Gradient(9, 7, {"R", "G", "B"});
    WriteImage(Path("a.exr"), image);
    WriteImage(Path("a.png"), image);
    Write("a.pfm", PFM("PF\n3 2\n-1\n", std::vector<float>(18, 0.5f)));
    Write("a.tga", TGA(3, 2, std::vector<unsigned char>(18, 7)));
    Write("a.hdr", HDR(std::vector<std::array<unsigned char, 4>>(9, {9, 8, 7, 128})));
    size_t read = 0, refused = 0;
    Write("a.jpg", JPEG(9, 7, {200, 100, 50}));
    for (const char *name : {"a.exr", "a.png", "a.pfm", "a.tga", "a.hdr", "a.jpg"}) {
        const std::string bytes = Bytes(Path(name));
        for (size_t at = 0; at < bytes.size(); ++at)
            for (const int change : {0x00, 0x01, 0x7f, 0x80, 0xff}) {
                std::string damaged = bytes;
                damaged[at] =
                    static_cast<char>(change == 0 || change == 0xff ? change : damaged[at] ^ change);
                try {
                    const Image back = DecodeImage(name, damaged);
                    EXPECT_EQ(back.data.size(), static_cast<size_t>(back.width) *
                                                    static_cast<size_t>(back.height) * back.Channels());
                    ++read;
                } catch (const Error &) {
                    ++refused;
                }
            }
    }
    EXPECT_GT(read, 100u);
    EXPECT_GT(refused, 100u);
}

TEST_F(AtomicWrite, WriteImageRefusesWhatItCannotWrite) {
    const Image image = Gradient(2, 2, {"R", "G", "B"});
    EXPECT_NE(MessageOf([&] { WriteImage(Path("a.jpg"), image); }).find(".exr, .pfm or .png"),
              std::string::npos);
    EXPECT_NE(MessageOf([&] { WriteImage(Path("a.exr"), Image()); }).find("no pixel"), std::string::npos);
    Image wrong = image;
    wrong.data.pop_back();
    EXPECT_NE(MessageOf([&] { WriteImage(Path("a.exr"), wrong); }), "");
    EXPECT_THROW(Image(1 << 20, 1 << 20, {"R"}), Error);
    EXPECT_THROW(Image(-1, 5, {"R"}), Error);
    EXPECT_EQ(FilesInFolder(), 0u);
}
