#include "images/image.h"

#include "core/error.h"
#include "core/file.h"

#include <ImathBox.h>
#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#define STBI_NO_STDIO
#include <png.h>
#include <stb/stb_image.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cerrno>
#include <climits>
#include <csetjmp>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <new>
#include <set>
#include <sys/stat.h>
#include <unistd.h>

namespace cuticle {

namespace {

constexpr int64_t maxPixels = int64_t{1} << 30;

[[noreturn]] void Fail(const std::string &filename, const std::string &why) {
    throw Error("\"" + filename + "\": " + why);
}

std::string Extension(const std::string &filename) {
    const size_t slash = filename.find_last_of('/'), dot = filename.find_last_of('.');
    if (dot == std::string::npos || (slash != std::string::npos && dot < slash))
        return "";
    std::string ext = filename.substr(dot);
    for (char &c : ext)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return ext;
}

void CheckReadable(const std::string &filename) {
    const std::string ext = Extension(filename);
    for (const char *known : {".exr", ".pfm", ".png", ".tga", ".hdr", ".jpg", ".jpeg"})
        if (ext == known)
            return;
    Fail(filename, "image files end in .exr, .pfm, .png, .tga, .hdr, .jpg or .jpeg");
}

// Refuses sizes that have no meaning, and sizes that so short a file cannot hold: a header of a few damaged bytes
// must not ask for gigabytes. No format here packs more than 2^14 values into a byte except for pictures of one
// colour, and those only from 2^22 values on are refused.
void CheckSize(const std::string &filename, int64_t width, int64_t height, int64_t channels,
               size_t fileBytes) {
    const std::string size = std::to_string(width) + " x " + std::to_string(height);
    if (width <= 0 || height <= 0)
        Fail(filename, "the header gives a size of " + size + " pixels");
    if (width > maxPixels || height > maxPixels || width * height > maxPixels)
        Fail(filename, "the header gives " + size + " pixels, more than 2^30");
    const int64_t values = width * height * std::max<int64_t>(channels, 1);
    if (values > (int64_t{1} << 22) && static_cast<uint64_t>(values) >> 14 > fileBytes)
        Fail(filename, "the header gives " + size + " pixels, which a file of " + std::to_string(fileBytes) +
                           " bytes cannot hold (truncated or damaged)");
}

std::vector<std::string> ChannelNames(int n) {
    switch (n) {
    case 1:
        return {"Y"};
    case 2:
        return {"Y", "A"};
    case 3:
        return {"R", "G", "B"};
    default:
        return {"R", "G", "B", "A"};
    }
}

// An image from integer samples of 1 to 4 channels, interleaved, top row first. Alpha is never sRGB-encoded.
template <class Sample>
Image FromIntegers(const Sample *samples, int width, int height, int channels, bool decodeSRGB) {
    Image image(width, height, ChannelNames(channels));
    constexpr float largest = std::numeric_limits<Sample>::max();
    for (size_t i = 0; i < image.data.size(); ++i) {
        const size_t c = i % image.Channels();
        const float v = static_cast<float>(samples[i]) / largest;
        image.data[i] = decodeSRGB && image.channels[c] != "A" ? SRGBToLinear(v) : v;
    }
    return image;
}

// --- EXR ---------------------------------------------------------------------------------------------------------

// OpenEXR reads from and writes to memory: what a file holds is checked once, and a file appears whole.
class MemoryIn : public Imf::IStream {
  public:
    MemoryIn(const std::string &name, const std::string &bytes) : IStream(name.c_str()), bytes_(bytes) {}
    bool read(char c[], int n) override {
        if (n < 0 || at_ > bytes_.size() || static_cast<size_t>(n) > bytes_.size() - at_)
            throw Iex::InputExc("the file ends too early");
        std::memcpy(c, bytes_.data() + at_, static_cast<size_t>(n));
        at_ += static_cast<size_t>(n);
        return at_ < bytes_.size();
    }
    uint64_t tellg() override { return at_; }
    void seekg(uint64_t position) override { at_ = position; }

  private:
    const std::string &bytes_;
    uint64_t at_ = 0;
};

class MemoryOut : public Imf::OStream {
  public:
    explicit MemoryOut(const std::string &name) : OStream(name.c_str()) {}
    void write(const char c[], int n) override {
        const size_t count = static_cast<size_t>(n);
        bytes.resize(std::max(bytes.size(), at_ + count));
        std::memcpy(bytes.data() + at_, c, count);
        at_ += count;
    }
    uint64_t tellp() override { return at_; }
    void seekp(uint64_t position) override { at_ = position; }
    std::string bytes;

  private:
    uint64_t at_ = 0;
};

// Attributes that say how the file is stored; OpenEXR sets them itself.
const std::set<std::string> &StorageAttributes() {
    static const std::set<std::string> names = {
        "channels",         "compression",        "dataWindow",        "displayWindow", "lineOrder",
        "pixelAspectRatio", "screenWindowCenter", "screenWindowWidth", "tiles",         "type",
        "chunkCount",       "maxSamplesPerPixel"};
    return names;
}

void ReadAttributes(const Imf::Header &header, Image *image) {
    for (auto it = header.begin(); it != header.end(); ++it) {
        if (StorageAttributes().count(it.name()))
            continue;
        ImageAttribute value;
        if (const auto *text = dynamic_cast<const Imf::StringAttribute *>(&it.attribute())) {
            value.text = text->value();
        } else if (const auto *asFloat = dynamic_cast<const Imf::FloatAttribute *>(&it.attribute())) {
            value.kind = ImageAttribute::Kind::Number, value.number = asFloat->value();
        } else if (const auto *asDouble = dynamic_cast<const Imf::DoubleAttribute *>(&it.attribute())) {
            value.kind = ImageAttribute::Kind::Number, value.number = asDouble->value();
        } else if (const auto *asInt = dynamic_cast<const Imf::IntAttribute *>(&it.attribute())) {
            value.kind = ImageAttribute::Kind::Number, value.number = asInt->value();
        } else if (const auto *matrix = dynamic_cast<const Imf::M44fAttribute *>(&it.attribute())) {
            value.kind = ImageAttribute::Kind::Matrix;
            std::memcpy(value.matrix.data(), matrix->value().getValue(), sizeof(value.matrix));
        } else {
            continue; // a type that Image does not know
        }
        image->attributes[it.name()] = value;
    }
}

// OpenEXR allocates from the header's word alone, so sizes of attributes and the data window are judged before it sees
// the file. A header is a list of name, type, size, value; what else may be wrong is left for OpenEXR to complain about.
void CheckEXRHeader(const std::string &filename, const std::string &bytes) {
    size_t at = 8; // after magic number and version
    const auto text = [&] {
        const size_t end = std::min(bytes.find('\0', std::min(at, bytes.size())), bytes.size());
        std::string s = bytes.substr(std::min(at, end), end - std::min(at, end));
        at = end + 1;
        return s;
    };
    while (at < bytes.size() && bytes[at] != 0) {
        const std::string name = text();
        text(); // the type
        int32_t size = 0, window[4];
        if (at + sizeof(size) > bytes.size())
            return;
        std::memcpy(&size, bytes.data() + at, sizeof(size));
        at += sizeof(size);
        if (size < 0 || static_cast<size_t>(size) > bytes.size() - at)
            Fail(filename, "not a readable EXR file: an attribute of its header has " + std::to_string(size) +
                               " bytes, more than the file (truncated or damaged)");
        if (name == "dataWindow" && size == sizeof(window)) {
            std::memcpy(window, bytes.data() + at, sizeof(window));
            CheckSize(filename, int64_t{window[2]} - window[0] + 1, int64_t{window[3]} - window[1] + 1, 1,
                      bytes.size());
        }
        at += static_cast<size_t>(size);
    }
}

Image ReadEXR(const std::string &filename, const std::string &bytes) {
    CheckEXRHeader(filename, bytes);
    try {
        MemoryIn stream(filename, bytes);
        Imf::InputFile file(stream);
        const Imf::Header &header = file.header();
        const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();

        // List the channels: R, G, B, A first, the others in the file's (alphabetical) order
        std::vector<std::string> names;
        for (const char *name : {"R", "G", "B", "A"})
            if (header.channels().findChannel(name))
                names.push_back(name);
        for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
            if (it.channel().xSampling != 1 || it.channel().ySampling != 1)
                Fail(filename, std::string("channel \"") + it.name() + "\" is subsampled, which is not read");
            if (std::find(names.begin(), names.end(), it.name()) == names.end())
                names.push_back(it.name());
        }
        if (names.empty())
            Fail(filename, "the file has no channels");

        // Check the sizes in 64 bits before anything is allocated
        const auto extent = [](int low, int high) { return int64_t{high} - low + 1; };
        const int64_t width = extent(data.min.x, data.max.x), height = extent(data.min.y, data.max.y);
        CheckSize(filename, width, height, static_cast<int64_t>(names.size()), bytes.size());
        const int64_t fullWidth = extent(display.min.x, display.max.x);
        const int64_t fullHeight = extent(display.min.y, display.max.y);
        const int64_t cropX = int64_t{data.min.x} - display.min.x,
                      cropY = int64_t{data.min.y} - display.min.y;
        if (fullWidth <= 0 || fullHeight <= 0 || fullWidth > INT_MAX || fullHeight > INT_MAX ||
            std::abs(cropX) > INT_MAX || std::abs(cropY) > INT_MAX)
            Fail(filename, "the display window makes no sense");

        // Read all channels as floats, interleaved; the base address is where pixel (0, 0) would be
        Image image(static_cast<int>(width), static_cast<int>(height), names);
        image.fullWidth = static_cast<int>(fullWidth), image.fullHeight = static_cast<int>(fullHeight);
        image.cropX = static_cast<int>(cropX), image.cropY = static_cast<int>(cropY);
        const size_t xStride = names.size() * sizeof(float), yStride = xStride * static_cast<size_t>(width);
        Imf::FrameBuffer frame;
        for (size_t c = 0; c < names.size(); ++c)
            frame.insert(names[c],
                         Imf::Slice::Make(Imf::FLOAT, image.data.data() + c, data, xStride, yStride));
        file.setFrameBuffer(frame);
        file.readPixels(data.min.y, data.max.y);
        ReadAttributes(header, &image);
        return image;
    } catch (const Error &) {
        throw;
    } catch (const std::exception &e) {
        Fail(filename, std::string("not a readable EXR file: ") + e.what());
    }
}

std::string EncodeEXR(const std::string &filename, const Image &image) {
    try {
        // Describe the picture: its windows, attributes and channels
        const int fullWidth = image.fullWidth > 0 ? image.fullWidth : image.width;
        const int fullHeight = image.fullHeight > 0 ? image.fullHeight : image.height;
        const Imath::Box2i display({0, 0}, {fullWidth - 1, fullHeight - 1});
        const Imath::Box2i data({image.cropX, image.cropY},
                                {image.cropX + image.width - 1, image.cropY + image.height - 1});
        Imf::Header header(display, data);
        header.compression() = Imf::ZIP_COMPRESSION;
        for (const auto &[name, value] : image.attributes) {
            if (StorageAttributes().count(name))
                Fail(filename, "\"" + name + "\" is an attribute of the EXR format itself");
            if (value.kind == ImageAttribute::Kind::Text) {
                header.insert(name, Imf::StringAttribute(value.text));
            } else if (value.kind == ImageAttribute::Kind::Number) {
                header.insert(name, Imf::DoubleAttribute(value.number));
            } else {
                Imath::M44f matrix;
                std::memcpy(matrix.getValue(), value.matrix.data(), sizeof(value.matrix));
                header.insert(name, Imf::M44fAttribute(matrix));
            }
        }
        Imf::FrameBuffer frame;
        const size_t xStride = image.Channels() * sizeof(float);
        const size_t yStride = xStride * static_cast<size_t>(image.width);
        for (size_t c = 0; c < image.Channels(); ++c) {
            header.channels().insert(image.channels[c], Imf::Channel(Imf::FLOAT));
            frame.insert(image.channels[c],
                         Imf::Slice::Make(Imf::FLOAT, image.data.data() + c, data, xStride, yStride));
        }

        // Encode into memory; the destructor writes the table of offsets
        MemoryOut stream(filename);
        {
            Imf::OutputFile file(stream, header);
            file.setFrameBuffer(frame);
            file.writePixels(image.height);
        }
        return std::move(stream.bytes);
    } catch (const Error &) {
        throw;
    } catch (const std::exception &e) {
        Fail(filename, std::string("cannot encode as EXR: ") + e.what());
    }
}

// --- PNG ---------------------------------------------------------------------------------------------------------

// libpng leaves by longjmp: everything that must survive it, or be freed after it, lives in this struct outside the
// function that calls setjmp.
struct PNGState {
    png_structp png = nullptr;
    png_infop info = nullptr;
    const std::string *in = nullptr;
    size_t at = 0;
    std::string out;
    std::string message;
    png_uint_32 width = 0, height = 0;
    int bitDepth = 0, channels = 0;
    std::vector<png_byte> pixels;
    std::vector<png_bytep> rows;
};

void OnPNGError(png_structp png, png_const_charp message) {
    static_cast<PNGState *>(png_get_error_ptr(png))->message = message;
    png_longjmp(png, 1);
}

void OnPNGWarning(png_structp, png_const_charp) {}

void ReadPNGBytes(png_structp png, png_bytep to, size_t n) {
    PNGState &state = *static_cast<PNGState *>(png_get_io_ptr(png));
    if (n > state.in->size() - state.at)
        png_error(png, "the file ends too early");
    std::memcpy(to, state.in->data() + state.at, n);
    state.at += n;
}

void WritePNGBytes(png_structp png, png_bytep from, size_t n) {
    static_cast<PNGState *>(png_get_io_ptr(png))->out.append(reinterpret_cast<const char *>(from), n);
}

void FlushPNGBytes(png_structp) {}

// The steps that libpng may leave; false: state->message says why.
bool ReadPNGHeader(PNGState *state) {
    if (setjmp(png_jmpbuf(state->png)))
        return false;
    png_set_read_fn(state->png, state, ReadPNGBytes);
    png_set_user_limits(state->png, 0x7fffffff, 0x7fffffff); // CheckSize() judges
    png_read_info(state->png, state->info);
    state->width = png_get_image_width(state->png, state->info);
    state->height = png_get_image_height(state->png, state->info);
    return true;
}

// Asks for 8 or 16 bits of Y, YA, RGB or RGBA; libpng allocates its rows here.
bool StartPNGRows(PNGState *state) {
    if (setjmp(png_jmpbuf(state->png)))
        return false;
    png_set_expand(state->png); // palette to RGB, 1, 2, 4 bits to 8, a transparent colour to alpha
    if (std::endian::native == std::endian::little)
        png_set_swap(state->png);
    png_set_interlace_handling(state->png);
    png_read_update_info(state->png, state->info);
    state->bitDepth = png_get_bit_depth(state->png, state->info);
    state->channels = png_get_channels(state->png, state->info);
    return true;
}

bool ReadPNGRows(PNGState *state) {
    if (setjmp(png_jmpbuf(state->png)))
        return false;
    png_read_image(state->png, state->rows.data());
    png_read_end(state->png, nullptr);
    return true;
}

bool WritePNGRows(PNGState *state) {
    if (setjmp(png_jmpbuf(state->png)))
        return false;
    png_set_write_fn(state->png, state, WritePNGBytes, FlushPNGBytes);
    png_set_IHDR(state->png, state->info, state->width, state->height, 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(state->png, state->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(state->png, state->info);
    png_write_image(state->png, state->rows.data());
    png_write_end(state->png, nullptr);
    return true;
}

Image ReadPNG(const std::string &filename, const std::string &bytes, bool decodeSRGB) {
    PNGState state;
    state.in = &bytes;
    state.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &state, OnPNGError, OnPNGWarning);
    if (!state.png)
        throw std::bad_alloc();
    struct Destroyer {
        PNGState &state;
        ~Destroyer() { png_destroy_read_struct(&state.png, &state.info, nullptr); }
    } destroyer{state};
    state.info = png_create_info_struct(state.png);
    if (!state.info)
        throw std::bad_alloc();
    if (!ReadPNGHeader(&state))
        Fail(filename, "not a readable PNG file: " + state.message);
    CheckSize(filename, state.width, state.height, 1, bytes.size());
    if (!StartPNGRows(&state))
        Fail(filename, "not a readable PNG file: " + state.message);
    const size_t rowBytes = png_get_rowbytes(state.png, state.info);
    state.pixels.resize(rowBytes * state.height);
    for (size_t y = 0; y < state.height; ++y)
        state.rows.push_back(state.pixels.data() + y * rowBytes);
    if (!ReadPNGRows(&state))
        Fail(filename, "not a readable PNG file: " + state.message);

    const int width = static_cast<int>(state.width), height = static_cast<int>(state.height);
    if (state.bitDepth == 8)
        return FromIntegers(state.pixels.data(), width, height, state.channels, decodeSRGB);
    std::vector<uint16_t> samples(state.pixels.size() / 2);
    std::memcpy(samples.data(), state.pixels.data(), samples.size() * 2);
    return FromIntegers(samples.data(), width, height, state.channels, decodeSRGB);
}

std::string EncodePNG(const std::string &filename, const Image &image) {
    PNGState state;
    state.width = static_cast<png_uint_32>(image.width),
    state.height = static_cast<png_uint_32>(image.height);

    // Encode to 8-bit sRGB; a pixel that is not a number shows magenta, so that it is seen
    const size_t rowBytes = static_cast<size_t>(image.width) * 3;
    state.pixels.resize(rowBytes * static_cast<size_t>(image.height));
    for (int y = 0; y < image.height; ++y) {
        png_byte *row = state.pixels.data() + static_cast<size_t>(y) * rowBytes;
        state.rows.push_back(row);
        for (int x = 0; x < image.width; ++x) {
            Spectrum rgb = image.RGB(x, y);
            if (rgb.HasNaNs())
                rgb = {1, 0, 1};
            for (int c = 0; c < 3; ++c)
                *row++ = static_cast<png_byte>(std::lround(255 * LinearToSRGB(std::clamp(rgb[c], 0.f, 1.f))));
        }
    }

    state.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &state, OnPNGError, OnPNGWarning);
    if (!state.png)
        throw std::bad_alloc();
    struct Destroyer {
        PNGState &state;
        ~Destroyer() { png_destroy_write_struct(&state.png, &state.info); }
    } destroyer{state};
    state.info = png_create_info_struct(state.png);
    if (!state.info)
        throw std::bad_alloc();
    if (!WritePNGRows(&state))
        Fail(filename, "cannot encode as PNG: " + state.message);
    return std::move(state.out);
}

// --- .tga, .jpg, .hdr ----------------------------------------------------------------------------------------------

// stb_image takes the end of its input for zeros, and some of its decoders then return a picture of garbage. Fed
// through callbacks, it shows that it wanted more than there was: a read that starts at the end, or a read of pixels
// (never of its buffer's 128 bytes) that comes up short.
struct StbInput {
    const std::string &bytes;
    size_t at = 0;
    bool overrun = false;

    static int Read(void *user, char *data, int size) {
        StbInput &in = *static_cast<StbInput *>(user);
        const size_t left = in.bytes.size() - in.at;
        const size_t n = std::min(left, static_cast<size_t>(std::max(size, 0)));
        in.overrun |= size > 0 && (left == 0 || (n < static_cast<size_t>(size) && size != 128));
        std::memcpy(data, in.bytes.data() + in.at, n);
        in.at += n;
        return static_cast<int>(n);
    }
    static void Skip(void *user, int n) {
        StbInput &in = *static_cast<StbInput *>(user);
        const int64_t to = static_cast<int64_t>(in.at) + n;
        in.overrun |= to > static_cast<int64_t>(in.bytes.size());
        in.at = static_cast<size_t>(std::clamp<int64_t>(to, 0, static_cast<int64_t>(in.bytes.size())));
    }
    static int Eof(void *user) {
        const StbInput &in = *static_cast<StbInput *>(user);
        return in.at == in.bytes.size();
    }
};

// stb_image (2.27, Debian 12's) counts the codes of a JPEG's Huffman table without asking whether they fit the 256 that
// the format allows, and writes beyond its own tables. So the tables are judged first.
void CheckJPEGTables(const std::string &filename, const std::string &bytes) {
    const auto byte = [&](size_t i) { return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0u; };
    for (size_t at = 2; at + 4 <= bytes.size();) {
        // Find the next marker: within coded pixels 0xff is followed by 0 or by a restart
        if (byte(at) != 0xff || byte(at + 1) == 0 || byte(at + 1) == 0xff || (byte(at + 1) & 0xf8) == 0xd0) {
            ++at;
            continue;
        }
        if (byte(at + 1) == 0xd8 || byte(at + 1) == 0xd9 || byte(at + 1) == 0x01) {
            at += 2; // markers that stand alone
            continue;
        }
        const bool isHuffman = byte(at + 1) == 0xc4;
        const size_t end = at + 2 + (byte(at + 2) << 8 | byte(at + 3));
        for (size_t table = at + 4; isHuffman && table < end;) {
            size_t codes = 0, space = 1; // space: how many codes of the present length are free
            for (size_t length = 1; length <= 16; ++length) {
                const size_t n = byte(table + length);
                space = 2 * space;
                if (n > space)
                    Fail(filename,
                         "not a readable JPEG file: a Huffman table has too many codes of one length");
                space -= n, codes += n;
            }
            if (codes > 256)
                Fail(filename,
                     "not a readable JPEG file: a Huffman table has " + std::to_string(codes) + " codes");
            table += 17 + codes;
        }
        at = end;
    }
}

Image ReadByStb(const std::string &filename, const std::string &bytes, bool decodeSRGB) {
    const std::string what = "not a readable " + Extension(filename).substr(1) + " file: ";
    const stbi_io_callbacks callbacks = {StbInput::Read, StbInput::Skip, StbInput::Eof};
    const auto because = [](const StbInput &in) {
        const char *reason = stbi_failure_reason();
        return std::string(in.overrun ? "the file ends too early" : reason ? reason : "unknown format");
    };
    if (bytes.starts_with("\xff\xd8"))
        CheckJPEGTables(filename, bytes);
    int width = 0, height = 0, channels = 0;
    StbInput head{bytes};
    if (bytes.empty() || !stbi_info_from_callbacks(&callbacks, &head, &width, &height, &channels))
        Fail(filename, what + because(head));
    CheckSize(filename, width, height, channels, bytes.size());

    StbInput in{bytes};
    StbInput probe{bytes};
    if (stbi_is_hdr_from_callbacks(&callbacks, &probe)) {
        const std::unique_ptr<float, decltype(&stbi_image_free)> pixels(
            stbi_loadf_from_callbacks(&callbacks, &in, &width, &height, &channels, 0), stbi_image_free);
        if (!pixels || in.overrun)
            Fail(filename, what + because(in));
        Image image(width, height, ChannelNames(channels));
        std::copy_n(pixels.get(), image.data.size(), image.data.begin());
        return image;
    }
    const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> pixels(
        stbi_load_from_callbacks(&callbacks, &in, &width, &height, &channels, 0), stbi_image_free);
    if (!pixels || in.overrun)
        Fail(filename, what + because(in));
    return FromIntegers(pixels.get(), width, height, channels, decodeSRGB);
}

// --- PFM ---------------------------------------------------------------------------------------------------------

// "PF" (RGB) or "Pf" (one channel), width, height, a scale whose sign says the byte order (negative: little endian), one
// white space, then rows of floats from the bottom up. As in pbrt-v3 the scale's magnitude multiplies the values.
Image ReadPFM(const std::string &filename, const std::string &bytes) {
    size_t at = 0;
    const auto word = [&] {
        while (at < bytes.size() && std::isspace(static_cast<unsigned char>(bytes[at])))
            ++at;
        const size_t begin = at;
        while (at < bytes.size() && !std::isspace(static_cast<unsigned char>(bytes[at])) && at - begin < 32)
            ++at;
        return bytes.substr(begin, at - begin);
    };
    const auto number = [&](const char *what) {
        const std::string text = word();
        char *end = nullptr;
        const double v = std::strtod(text.c_str(), &end);
        if (text.empty() || *end != 0 || !std::isfinite(v) || std::abs(v) > 1e30)
            Fail(filename,
                 std::string("not a readable PFM file: the ") + what + " \"" + text + "\" is no number");
        return v;
    };
    const std::string magic = word();
    if (magic != "PF" && magic != "Pf")
        Fail(filename, "not a PFM file: it does not begin with PF or Pf");
    const int channels = magic == "PF" ? 3 : 1;
    const double w = number("width"), h = number("height"), scale = number("scale");
    if (w != std::floor(w) || h != std::floor(h) || w > 2e9 || h > 2e9 || w < 1 || h < 1)
        Fail(filename, "the PFM header gives an absurd size");
    if (scale == 0)
        Fail(filename, "the PFM header gives a scale of 0, which leaves the byte order open");
    ++at; // the white space before the pixels
    const int width = static_cast<int>(w), height = static_cast<int>(h);
    CheckSize(filename, width, height, channels, bytes.size());
    const size_t values =
        static_cast<size_t>(width) * static_cast<size_t>(height) * static_cast<size_t>(channels);
    if (at > bytes.size() || (bytes.size() - at) / sizeof(float) < values)
        Fail(filename, "the PFM file ends too early");

    Image image(width, height, ChannelNames(channels));
    const size_t rowValues = static_cast<size_t>(width) * static_cast<size_t>(channels);
    const bool swap = (scale < 0) != (std::endian::native == std::endian::little);
    for (size_t y = 0; y < static_cast<size_t>(height); ++y) {
        const char *row =
            bytes.data() + at + (static_cast<size_t>(height) - 1 - y) * rowValues * sizeof(float);
        for (size_t i = 0; i < rowValues; ++i) {
            uint32_t bits;
            std::memcpy(&bits, row + i * sizeof(float), sizeof(bits));
            if (swap)
                bits = __builtin_bswap32(bits);
            image.data[y * rowValues + i] = std::bit_cast<float>(bits) * static_cast<float>(std::abs(scale));
        }
    }
    return image;
}

} // namespace

Image::Image(int w, int h, std::vector<std::string> channelNames)
    : width(w), height(h), channels(std::move(channelNames)), fullWidth(w), fullHeight(h) {
    if (w < 0 || h < 0 || int64_t{w} * h > maxPixels)
        throw Error("an image of " + std::to_string(w) + " x " + std::to_string(h) + " pixels cannot be");
    data.resize(static_cast<size_t>(w) * static_cast<size_t>(h) * channels.size());
}

int Image::ChannelIndex(const std::string &name) const {
    const auto found = std::find(channels.begin(), channels.end(), name);
    return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
}

Spectrum Image::RGB(int x, int y) const {
    // Almost every image has its colours first
    if (channels.size() >= 3 && channels[0] == "R" && channels[1] == "G" && channels[2] == "B")
        return {At(x, y, 0), At(x, y, 1), At(x, y, 2)};
    const int r = ChannelIndex("R"), g = ChannelIndex("G"), b = ChannelIndex("B");
    if (r >= 0 && g >= 0 && b >= 0)
        return {At(x, y, static_cast<size_t>(r)), At(x, y, static_cast<size_t>(g)),
                At(x, y, static_cast<size_t>(b))};
    return Spectrum(At(x, y, static_cast<size_t>(std::max(0, ChannelIndex("Y")))));
}

Image DecodeImage(const std::string &filename, const std::string &bytes, bool decodeSRGB) {
    CheckReadable(filename);
    const std::string ext = Extension(filename);
    try {
        if (ext == ".exr")
            return ReadEXR(filename, bytes);
        if (ext == ".png")
            return ReadPNG(filename, bytes, decodeSRGB);
        if (ext == ".pfm")
            return ReadPFM(filename, bytes);
        return ReadByStb(filename, bytes, decodeSRGB);
    } catch (const std::bad_alloc &) {
        Fail(filename, "the image does not fit into memory");
    }
}

Image ReadImage(const std::string &filename, bool decodeSRGB) {
    CheckReadable(filename);
    return DecodeImage(filename, ReadFile(filename, "the image"), decodeSRGB);
}

void WriteImage(const std::string &filename, const Image &image) {
    const std::string ext = Extension(filename);
    if (ext != ".exr" && ext != ".png")
        Fail(filename, "images are written as .exr or .png");
    if (image.width <= 0 || image.height <= 0 || image.channels.empty())
        Fail(filename, "there is no pixel to write");
    if (image.data.size() !=
        static_cast<size_t>(image.width) * static_cast<size_t>(image.height) * image.channels.size())
        Fail(filename, "the image's data do not fit its size");
    WriteFileAtomically(filename, ext == ".exr" ? EncodeEXR(filename, image) : EncodePNG(filename, image));
}

} // namespace cuticle
