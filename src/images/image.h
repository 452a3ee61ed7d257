// Pictures in memory and in files. EXR through OpenEXR, PNG through libpng, the older 8-bit formats and .hdr
// through stb_image; .pfm is read here, three lines of header and raw floats.
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

// Float channels, row by row from the top; names as in the file ("R", "G", "B", "A", "variance.R", ...).
struct Image {
    int width = 0, height = 0;
    std::vector<std::string> channels;
    std::vector<float> data; // width * height * channels.size(), channels interleaved
    std::map<std::string, ImageAttribute> attributes;
    // The picture that the pixels are a window of (EXR display window); equal to width, height when not cropped.
    int fullWidth = 0, fullHeight = 0, cropX = 0, cropY = 0;

    Image() = default;
    Image(int w, int h, std::vector<std::string> channelNames); // zero-filled
    int ChannelIndex(const std::string &name) const;            // -1 when absent
    size_t Channels() const { return channels.size(); }
    float &At(int x, int y, size_t c) {
        return data[(static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) *
                        channels.size() +
                    c];
    }
    float At(int x, int y, size_t c) const {
        return data[(static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) *
                        channels.size() +
                    c];
    }
    // R, G, B (or Y three times, or the first channel) of one pixel.
    Spectrum RGB(int x, int y) const;
};

// Reads .exr, .pfm, .png, .tga, .hdr, .jpg by file name ending. 8-bit formats: values v/255, converted from sRGB to linear
// when decodeSRGB is set (16-bit PNG likewise). Throws Error naming the file: missing, damaged, absurd sizes (more
// than 2^30 pixels).
Image ReadImage(const std::string &filename, bool decodeSRGB = true);
// The same of a file's bytes in memory; the name's ending says the format.
Image DecodeImage(const std::string &filename, const std::string &bytes, bool decodeSRGB = true);

// Writes by ending: .exr (32-bit float channels, ZIP, all channels and attributes) or .png (8-bit sRGB of R, G, B, clamped; NaN is
// an Error for neither: EXR keeps it, PNG shows it magenta). The file appears whole or not at all: it is
// written beside its destination and renamed. Throws Error naming the path and the system's reason.
void WriteImage(const std::string &filename, const Image &image);

} // namespace cuticle
