// OpenEXR: float channels of any name, attributes, windows.
#include "images/formats.h"

#include "core/error.h"
#include "files/gzip.h"

#include <ImathBox.h>
#include <OpenEXR/Iex.h>
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

#include <algorithm>
#include <array>
#include <climits>
#include <cstring>
#include <set>

namespace cuticle {

namespace {

// OpenEXR reads from and writes to memory: what a file holds is checked once, and a file appears whole.
class EXRMemoryIn : public Imf::IStream {
  public:
    EXRMemoryIn(const std::string &name, const std::string &bytes) : IStream(name.c_str()), bytes_(bytes) {}
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

class EXRMemoryOut : public Imf::OStream {
  public:
    explicit EXRMemoryOut(const std::string &name) : OStream(name.c_str()) {}
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

// The lines of a chunk, by the header's number of its compression; 1 for a number that OpenEXR will refuse.
int64_t LinesOfChunk(unsigned char compression) {
    constexpr std::array<int64_t, 10> lines{1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
    return compression < lines.size() ? lines[compression] : 1;
}

// The channels in the value of the attribute "channels": names that end in NUL, 16 bytes after each.
int64_t CountChannels(std::string_view list) {
    int64_t count = 0;
    for (size_t at = 0; at < list.size() && list[at] != 0; ++count) {
        const size_t end = list.find('\0', at);
        if (end == std::string_view::npos)
            break;
        at = end + 17;
    }
    return count;
}

// OpenEXR allocates from the header's word alone, so sizes of attributes, the data window, and the chunks
// that it takes are judged before it sees the file. A header is a list of name, type, size, value; what else
// may be wrong is left for OpenEXR to complain about.
void CheckEXRHeader(const std::string &filename, const std::string &bytes) {
    size_t at = 8; // after magic number and version
    const auto text = [&] {
        const size_t end = std::min(bytes.find('\0', std::min(at, bytes.size())), bytes.size());
        std::string s = bytes.substr(std::min(at, end), end - std::min(at, end));
        at = end + 1;
        return s;
    };
    int64_t width = 0, height = 0, channels = 1, lines = 1;
    uint32_t tile[2] = {0, 0};
    while (at < bytes.size() && bytes[at] != 0) {
        const std::string name = text();
        text(); // the type
        int32_t size = 0, window[4];
        if (at + sizeof(size) > bytes.size())
            return;
        std::memcpy(&size, bytes.data() + at, sizeof(size));
        at += sizeof(size);
        if (size < 0 || static_cast<size_t>(size) > bytes.size() - at)
            FailImage(filename,
                      fmt::format("not a readable EXR file: an attribute of its header has {} bytes, "
                                  "more than the file (truncated or damaged)",
                                  size));
        const char *value = bytes.data() + at;
        if (name == "dataWindow" && size == sizeof(window)) {
            std::memcpy(window, value, sizeof(window));
            width = int64_t{window[2]} - window[0] + 1, height = int64_t{window[3]} - window[1] + 1;
        } else if (name == "channels") {
            channels = CountChannels({value, static_cast<size_t>(size)});
        } else if (name == "compression" && size == 1) {
            lines = LinesOfChunk(static_cast<unsigned char>(*value));
        } else if (name == "tiles" && size == 9) {
            std::memcpy(tile, value, sizeof(tile));
        }
        at += static_cast<size_t>(size);
    }
    if (width == 0 && height == 0)
        return; // no data window: OpenEXR says so
    // Each chunk has its place in a table and a head of its own; OpenEXR holds at least one chunk, or one row
    // of tiles, unpacked
    const bool isTiled = tile[0] > 0 && tile[1] > 0;
    const int64_t chunkLines = isTiled ? int64_t{tile[1]} : lines;
    const auto chunks = [](int64_t size, int64_t of) { return (size + of - 1) / of; };
    const int64_t most = std::max<int64_t>(height, 0) + chunkLines;
    if (width > 0 && height > 0 && width <= kMaxPixels && most <= kMaxPixels) {
        const int64_t count = chunks(height, chunkLines) * (isTiled ? chunks(width, int64_t{tile[0]}) : 1);
        if (static_cast<uint64_t>(count) * 16 > bytes.size())
            FailImage(
                filename,
                fmt::format("not a readable EXR file: its {} pieces do not fit into {} bytes (truncated "
                            "or damaged)",
                            count, bytes.size()));
        if (ExpandsTooFar(static_cast<uint64_t>(width * std::min(chunkLines, kMaxPixels / width)) *
                              static_cast<uint64_t>(channels),
                          bytes.size()))
            FailImage(filename,
                      fmt::format("not a readable EXR file: a piece of {} x {} pixels, which {} bytes "
                                  "cannot hold (truncated or damaged)",
                                  width, chunkLines, bytes.size()));
    }
    // What its codecs make of a byte is not bounded by anything that can be known here
    CheckImageSize(filename, width, height, channels, bytes.size(), int64_t{1} << 14);
}

} // namespace

Image ReadEXR(const std::string &filename, const std::string &bytes, bool) {
    CheckEXRHeader(filename, bytes);
    try {
        EXRMemoryIn stream(filename, bytes);
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
                FailImage(filename,
                          fmt::format("channel \"{}\" is subsampled, which is not read", it.name()));
            if (std::find(names.begin(), names.end(), it.name()) == names.end())
                names.push_back(it.name());
        }
        if (names.empty())
            FailImage(filename, "the file has no channels");

        // CheckEXRHeader has judged the size
        const auto extent = [](int low, int high) { return int64_t{high} - low + 1; };
        const int64_t width = extent(data.min.x, data.max.x), height = extent(data.min.y, data.max.y);
        const int64_t fullWidth = extent(display.min.x, display.max.x);
        const int64_t fullHeight = extent(display.min.y, display.max.y);
        const int64_t cropX = int64_t{data.min.x} - display.min.x,
                      cropY = int64_t{data.min.y} - display.min.y;
        if (fullWidth <= 0 || fullHeight <= 0 || fullWidth > INT_MAX || fullHeight > INT_MAX ||
            std::abs(cropX) > INT_MAX || std::abs(cropY) > INT_MAX)
            FailImage(filename, "the display window makes no sense");

        // Read all channels as floats, interleaved; the base address is where pixel (0, 0) would be
        Image image = EmptyImage(filename, width, height, names);
        image.fullWidth = static_cast<int>(fullWidth), image.fullHeight = static_cast<int>(fullHeight);
        image.cropX = static_cast<int>(cropX), image.cropY = static_cast<int>(cropY);
        const size_t xStride = names.size() * sizeof(float), yStride = xStride * static_cast<size_t>(width);
        Imf::FrameBuffer frame;
        for (size_t c = 0; c < names.size(); ++c)
            frame.insert(names[c],
                         Imf::Slice::Make(Imf::FLOAT, image.data.data() + c, data, xStride, yStride));
        file.setFrameBuffer(frame);
        // Some rows at a time: memory is written to as far as the file has rows for it
        constexpr int64_t kRows = 256;
        for (int64_t y = 0; y < height; y += kRows) {
            const int64_t end = std::min(height, y + kRows);
            image.data.resize(static_cast<size_t>(end * width) * names.size());
            file.readPixels(static_cast<int>(data.min.y + y), static_cast<int>(data.min.y + end - 1));
        }
        ReadAttributes(header, &image);
        return image;
    } catch (const Error &) {
        throw;
    } catch (const std::exception &e) {
        FailImage(filename, fmt::format("not a readable EXR file: {}", e.what()));
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
                FailImage(filename, fmt::format("\"{}\" is an attribute of the EXR format itself", name));
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
        EXRMemoryOut stream(filename);
        {
            Imf::OutputFile file(stream, header);
            file.setFrameBuffer(frame);
            file.writePixels(image.height);
        }
        return std::move(stream.bytes);
    } catch (const Error &) {
        throw;
    } catch (const std::exception &e) {
        FailImage(filename, fmt::format("cannot encode as EXR: {}", e.what()));
    }
}

} // namespace cuticle
