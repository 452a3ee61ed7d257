// Pictures in memory and in files: .exr through OpenEXR, .png through libpng, .jpg through
// libjpeg, .tga and .hdr through stb_image, .pfm by ourselves.
#pragma once

#include "core/color.h"

#include <map>
#include <string>
#include <vector>

namespace cuticle {

// A value in an EXR header: text, a number, or a 4x4 matrix (row major, as OpenEXR keeps it).
struct ImageAttribute {
    enum class Kind { Text, Number, Matrix } kind = Kind::Text;
    std::string text;
    double number = 0;
    std::array<float, 16> matrix{};
};

// A picture holds float channels, row by row from the top, with the names that they have in the file ("R",
// "G", "B", "A", "variance.R", ...).
struct Image {
    int width = 0, height = 0;
    std::vector<std::string> channels;
    std::vector<float> data; // width * height * channels.size(), channels interleaved
    std::map<std::string, ImageAttribute> attributes;
    // The picture that the pixels are a window of (EXR display window); equal to width, height when not
    // cropped.
    int fullWidth = 0, fullHeight = 0, cropX = 0, cropY = 0;

    Image() = default;
    Image(int w, int h, std::vector<std::string> channelNames); // zero-filled
    int ChannelIndex(const std::string &name) const;            // -1 when absent
    size_t Channels() const { return channels.size(); }
    size_t Pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
    // x from the left, y from the top, c in the order of `channels`; all must be within the picture.
    float &At(size_t x, size_t y, size_t c) { return data[Index(x, y, c)]; }
    float At(size_t x, size_t y, size_t c) const { return data[Index(x, y, c)]; }
    // R, G, B (or Y three times, or the first channel) of one pixel.
    Spectrum RGB(size_t x, size_t y) const;

  private:
    size_t Index(size_t x, size_t y, size_t c) const {
        return (y * static_cast<size_t>(width) + x) * channels.size() + c;
    }
};

// Reads .exr, .pfm, .png, .tga, .hdr or .jpg, by the ending of the file's name. 8-bit formats and 16-bit PNG
// become v/255 or v/65535, converted from sRGB to linear when decodeSRGB is set. Throws Error naming the
// file: missing, damaged, of absurd size (more than 2^30 pixels).
Image ReadImage(const std::string &filename, bool decodeSRGB = true);
// Reads the same from a file's bytes in memory; the name's ending says the format.
Image DecodeImage(const std::string &filename, const std::string &bytes, bool decodeSRGB = true);

// Writes by the name's ending: .exr (32-bit float channels, ZIP, all channels and attributes), .pfm (the
// floats of R, G, B) or .png (8-bit sRGB of R, G, B, clamped). NaN is an Error for none: EXR and PFM keep
// it, PNG shows it magenta. The file appears whole or not at all. Throws Error naming the path and the
// system's reason.
void WriteImage(const std::string &filename, const Image &image);
// The bytes of the file that WriteImage would write.
std::string EncodeImage(const std::string &filename, const Image &image);

// R, G and B of every pixel, row by row from the top, clamped to [0, 1], as sRGB in 8 bits each. A pixel
// that is not a number is magenta, so that it is seen.
std::string EncodeSRGB8(const Image &image);

} // namespace cuticle
