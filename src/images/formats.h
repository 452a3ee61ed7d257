// The formats of pictures, and what their readers share. For src/images alone; everyone else includes
// image.h.
//
// To add one: declare its functions here, define them in a file of its own, and give its ending a row in
// kFormats of image.cpp.
#pragma once

#include "images/image.h"

#include <limits>

namespace cuticle {

// Each reads a picture from the bytes of a file, or makes such bytes. `filename` stands in messages. They
// throw Error for whatever is damaged, absurd or not to be kept in the format.
Image ReadEXR(const std::string &filename, const std::string &bytes, bool decodeSRGB);
std::string EncodeEXR(const std::string &filename, const Image &image);
Image ReadPNG(const std::string &filename, const std::string &bytes, bool decodeSRGB);
std::string EncodePNG(const std::string &filename, const Image &image);
Image ReadPFM(const std::string &filename, const std::string &bytes, bool decodeSRGB);
std::string EncodePFM(const std::string &filename, const Image &image);
Image ReadJPEG(const std::string &filename, const std::string &bytes, bool decodeSRGB);
// Reads .tga and .hdr, whichever the bytes are, by stb_image.
Image ReadByStb(const std::string &filename, const std::string &bytes, bool decodeSRGB);

// The most pixels that a picture may have.
inline constexpr int64_t kMaxPixels = int64_t{1} << 30;

// Throws Error that begins with the file's name.
[[noreturn]] void FailImage(const std::string &filename, const std::string &why);

// The ending of a file's name from its last dot, in small letters; "" without one.
std::string Extension(const std::string &filename);

// Refuses sizes that have no meaning, and sizes that so short a file cannot hold: a header of a few damaged
// bytes must not ask for gigabytes. samplesPerByte: the most samples that a byte of the file's format can
// stand for. Whatever the format, a picture that expands too far (files/gzip.h) is refused, a byte for a
// sample.
void CheckImageSize(const std::string &filename, int64_t width, int64_t height, int64_t channels,
                    size_t fileBytes, int64_t samplesPerByte);

// deflate's most, for PNG and for what else packs by it: 258 bytes for two bits.
inline constexpr int64_t kMaxByDeflate = 1032;

// The channels of a picture that has 1 to 4 and no names for them: Y, YA, RGB or RGBA.
std::vector<std::string> ChannelNames(size_t n);

// Appends the value of each sample, 1 to 4 channels interleaved, beginning with the first. Alpha is never
// sRGB-encoded.
template <class Sample>
void AppendIntegers(const Sample *samples, size_t count, bool decodeSRGB, Image *image) {
    constexpr float largest = std::numeric_limits<Sample>::max();
    const size_t channels = image->Channels();
    const bool hasAlpha = image->channels.back() == "A";
    for (size_t i = 0; i < count; ++i) {
        const float v = static_cast<float>(samples[i]) / largest;
        const bool isAlpha = hasAlpha && i % channels == channels - 1;
        image->data.push_back(decodeSRGB && !isAlpha ? SRGBToLinear(v) : v);
    }
}

// Claims the memory of an image (core/memory_budget.h) and makes it, of this size, with room for its samples
// and none of them yet: memory that is never written to costs nothing, so that a file that ends early takes
// what it has.
Image EmptyImage(const std::string &filename, int64_t width, int64_t height,
                 std::vector<std::string> channels);

} // namespace cuticle
