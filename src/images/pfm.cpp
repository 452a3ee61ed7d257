// PFM: three lines of header and raw floats.
#include "images/formats.h"

#include <fmt/core.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace cuticle {

// "PF" (RGB) or "Pf" (one channel), width, height, a scale whose sign says the byte order (negative: little
// endian), one white space, then rows of floats from the bottom up. As in pbrt-v3 the scale's magnitude
// multiplies the values.
Image ReadPFM(const std::string &filename, const std::string &bytes, bool) {
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
            FailImage(filename,
                      fmt::format("not a readable PFM file: the {} \"{}\" is no number", what, text));
        return v;
    };
    const std::string magic = word();
    if (magic != "PF" && magic != "Pf")
        FailImage(filename, "not a PFM file: it does not begin with PF or Pf");
    const size_t channels = magic == "PF" ? 3 : 1;
    const double w = number("width"), h = number("height"), scale = number("scale");
    if (w != std::floor(w) || h != std::floor(h) || w > 2e9 || h > 2e9 || w < 1 || h < 1)
        FailImage(filename, "the PFM header gives an absurd size");
    if (scale == 0)
        FailImage(filename, "the PFM header gives a scale of 0, which leaves the byte order open");
    ++at; // the white space before the pixels
    const int width = static_cast<int>(w), height = static_cast<int>(h);
    CheckImageSize(filename, width, height, static_cast<int64_t>(channels), bytes.size(), 1);
    const size_t rows = static_cast<size_t>(height), rowValues = static_cast<size_t>(width) * channels;
    if (at > bytes.size() || (bytes.size() - at) / sizeof(float) < rows * rowValues)
        FailImage(filename, "the PFM file ends too early");

    Image image = EmptyImage(filename, width, height, ChannelNames(channels));
    image.data.resize(rows * rowValues);
    const bool swap = (scale < 0) != (std::endian::native == std::endian::little);
    for (size_t y = 0; y < rows; ++y) {
        const char *row = bytes.data() + at + (rows - 1 - y) * rowValues * sizeof(float);
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

std::string EncodePFM(const std::string &, const Image &image) {
    static_assert(std::endian::native == std::endian::little, "a scale of -1 says so");
    std::string out = fmt::format("PF\n{} {}\n-1.0\n", image.width, image.height);
    for (size_t y = static_cast<size_t>(image.height); y-- > 0;)
        for (size_t x = 0; x < static_cast<size_t>(image.width); ++x) {
            const Spectrum rgb = image.RGB(x, y);
            for (size_t c = 0; c < 3; ++c) {
                const float v = rgb[c];
                out.append(reinterpret_cast<const char *>(&v), sizeof(v));
            }
        }
    return out;
}

} // namespace cuticle
