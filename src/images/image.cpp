#include "images/image.h"

#include "core/error.h"
#include "core/memory_budget.h"
#include "files/file.h"
#include "files/gzip.h"
#include "images/formats.h"

#include <algorithm>
#include <new>

namespace cuticle {

namespace {

// A format of pictures, known by the ending of its files. encode: none where it is only read.
struct ImageFormat {
    const char *ending;
    Image (*read)(const std::string &filename, const std::string &bytes, bool decodeSRGB);
    std::string (*encode)(const std::string &filename, const Image &image);
};
// To add one: a row here, functions in formats.h and a file of its own; DecodeImage's message lists all
// endings.
constexpr ImageFormat kFormats[] = {
    {".exr", ReadEXR, EncodeEXR}, {".pfm", ReadPFM, EncodePFM}, {".png", ReadPNG, EncodePNG},
    {".tga", ReadByStb, nullptr}, {".hdr", ReadByStb, nullptr}, {".jpg", ReadJPEG, nullptr},
    {".jpeg", ReadJPEG, nullptr},
};

const ImageFormat *FindFormat(const std::string &filename) {
    const std::string ending = Extension(filename);
    for (const ImageFormat &format : kFormats)
        if (ending == format.ending)
            return &format;
    return nullptr;
}

// The format of a file that is to be read; Error where it has none.
const ImageFormat &FormatOf(const std::string &filename) {
    const ImageFormat *format = FindFormat(filename);
    if (!format)
        FailImage(filename, "image files end in .exr, .pfm, .png, .tga, .hdr, .jpg or .jpeg");
    return *format;
}

} // namespace

void FailImage(const std::string &filename, const std::string &why) {
    throw Error("\"{}\": {}", filename, why);
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

void CheckImageSize(const std::string &filename, int64_t width, int64_t height, int64_t channels,
                    size_t fileBytes, int64_t samplesPerByte) {
    if (width <= 0 || height <= 0)
        throw Error("\"{}\": the header gives a size of {} x {} pixels", filename, width, height);
    if (width > kMaxPixels || height > kMaxPixels || width * height > kMaxPixels)
        throw Error("\"{}\": the header gives {} x {} pixels, more than 2^30", filename, width, height);
    const auto samples = static_cast<uint64_t>(width * height * std::max<int64_t>(channels, 1));
    constexpr uint64_t kNoMatter = uint64_t{1} << 16; // so few are never refused for the file's length
    if (samples > kNoMatter && samples / static_cast<uint64_t>(samplesPerByte) > fileBytes)
        throw Error(
            "\"{}\": the header gives {} x {} pixels, which a file of {} bytes cannot hold (truncated or "
            "damaged)",
            filename, width, height, fileBytes);
    if (ExpandsTooFar(samples, fileBytes))
        throw Error(
            "\"{}\": {} x {} pixels of {} channels are more than {} times the file's {} bytes, as no honest "
            "picture is",
            filename, width, height, channels, kMaxExpansion, fileBytes);
}

Image EmptyImage(const std::string &filename, int64_t width, int64_t height,
                 std::vector<std::string> channels) {
    Image image(0, 0, std::move(channels));
    image.width = image.fullWidth = static_cast<int>(width);
    image.height = image.fullHeight = static_cast<int>(height);
    const size_t samples = image.Pixels() * image.Channels();
    ClaimMemory(fmt::format("the picture \"{}\" of {} x {} pixels", filename, width, height),
                samples * sizeof(float));
    image.data.reserve(samples);
    return image;
}

std::vector<std::string> ChannelNames(size_t n) {
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

Image::Image(int w, int h, std::vector<std::string> channelNames)
    : width(w), height(h), channels(std::move(channelNames)), fullWidth(w), fullHeight(h) {
    if (w < 0 || h < 0 || int64_t{w} * h > kMaxPixels)
        throw Error("an image of {} x {} pixels cannot be", w, h);
    data.resize(Pixels() * Channels());
}

int Image::ChannelIndex(const std::string &name) const {
    const auto found = std::find(channels.begin(), channels.end(), name);
    return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
}

Spectrum Image::RGB(size_t x, size_t y) const {
    // Almost every image has its colours first
    if (channels.size() >= 3 && channels[0] == "R" && channels[1] == "G" && channels[2] == "B")
        return {At(x, y, 0), At(x, y, 1), At(x, y, 2)};
    const int r = ChannelIndex("R"), g = ChannelIndex("G"), b = ChannelIndex("B");
    if (r >= 0 && g >= 0 && b >= 0)
        return {At(x, y, r), At(x, y, g), At(x, y, b)};
    return Spectrum(At(x, y, std::max(0, ChannelIndex("Y"))));
}

Image DecodeImage(const std::string &filename, const std::string &bytes, bool decodeSRGB) {
    const ImageFormat &format = FormatOf(filename);
    try {
        return format.read(filename, bytes, decodeSRGB);
    } catch (const std::bad_alloc &) {
        FailImage(filename, "the image does not fit into memory");
    }
}

Image ReadImage(const std::string &filename, bool decodeSRGB) {
    FormatOf(filename); // refuse before reading
    return DecodeImage(filename, ReadFile(filename, "the image"), decodeSRGB);
}

std::string EncodeImage(const std::string &filename, const Image &image) {
    const ImageFormat *format = FindFormat(filename);
    if (!format || !format->encode)
        FailImage(filename, "images are written as .exr, .pfm or .png");
    if (image.width <= 0 || image.height <= 0 || image.channels.empty())
        FailImage(filename, "there is no pixel to write");
    if (image.data.size() != image.Pixels() * image.Channels())
        FailImage(filename, "the image's data do not fit its size");
    return format->encode(filename, image);
}

void WriteImage(const std::string &filename, const Image &image) {
    WriteFileAtomically(filename, EncodeImage(filename, image));
}

} // namespace cuticle
