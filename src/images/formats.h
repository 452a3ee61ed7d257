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
// Reads .tga, .jpg and .hdr, whichever the bytes are, by stb_image.
Image ReadByStb(const std::string &filename, const std::string &bytes, bool decodeSRGB);

// The most pixels that a picture may have.
inline constexpr int64_t kMaxPixels = int64_t{1} << 30;

// Throws Error that begins with the file's name.
[[noreturn]] void FailImage(const std::string &filename, const std::string &why);

// The ending of a file's name from its last dot, in small letters; "" without one.
std::string Extension(const std::string &filename);

// Refuses sizes that have no meaning, and sizes that so short a file cannot hold: a header of a few damaged
// bytes must not ask for gigabytes. No format here packs more than 2^14 values into a byte except for
// pictures of one colour, and those only from 2^22 values on are refused.
void CheckImageSize(const std::string &filename, int64_t width, int64_t height, int64_t channels,
                    size_t fileBytes);

// The channels of a picture that has 1 to 4 and no names for them: Y, YA, RGB or RGBA.
std::vector<std::string> ChannelNames(size_t n);

// Makes an image from integer samples of 1 to 4 channels, interleaved, top row first. Alpha is never
// sRGB-encoded.
template <class Sample>
Image FromIntegers(const Sample *samples, int width, int height, size_t channels, bool decodeSRGB) {
    Image image(width, height, ChannelNames(channels));
    constexpr float largest = std::numeric_limits<Sample>::max();
    for (size_t i = 0; i < image.data.size(); ++i) {
        const size_t c = i % image.Channels();
        const float v = static_cast<float>(samples[i]) / largest;
        image.data[i] = decodeSRGB && image.channels[c] != "A" ? SRGBToLinear(v) : v;
    }
    return image;
}

} // namespace cuticle
