// PNG by libpng: read in every kind, written as 8-bit sRGB.
#include "images/formats.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <new>

namespace cuticle {

namespace {

// libpng leaves by longjmp: everything that must survive it, or be freed after it, lives in this struct
// outside the function that calls setjmp.
struct PNGState {
    png_structp png = nullptr;
    png_infop info = nullptr;
    const std::string *in = nullptr;
    size_t at = 0;
    std::string out;
    std::string message;
    png_uint_32 width = 0, height = 0;
    size_t bitDepth = 0, channels = 0;
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

bool ReadPNGRow(PNGState *state) {
    if (setjmp(png_jmpbuf(state->png)))
        return false;
    png_read_row(state->png, state->pixels.data(), nullptr);
    return true;
}

// Reads all rows into state->pixels; an interlaced picture comes in no other way.
bool ReadPNGRows(PNGState *state) {
    if (setjmp(png_jmpbuf(state->png)))
        return false;
    png_read_image(state->png, state->rows.data());
    return true;
}

bool EndPNGRows(PNGState *state) {
    if (setjmp(png_jmpbuf(state->png)))
        return false;
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

} // namespace

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
        FailImage(filename, "not a readable PNG file: " + state.message);
    // The rows as they are stored, and what a palette or a grey of few bits expands to
    const size_t storedRow = png_get_rowbytes(state.png, state.info);
    CheckImageSize(filename, static_cast<int64_t>(storedRow), state.height, 1, bytes.size(), kMaxByDeflate);
    const bool isInterlaced = png_get_interlace_type(state.png, state.info) != PNG_INTERLACE_NONE;
    if (!StartPNGRows(&state))
        FailImage(filename, "not a readable PNG file: " + state.message);
    CheckImageSize(filename, state.width, state.height, static_cast<int64_t>(state.channels), bytes.size(),
                   kMaxByDeflate * 32);

    Image image = EmptyImage(filename, state.width, state.height, ChannelNames(state.channels));
    const size_t rowBytes = png_get_rowbytes(state.png, state.info);
    std::vector<uint16_t> wide(state.bitDepth == 16 ? rowBytes / 2 : 0);
    const auto append = [&](const png_byte *row) {
        if (state.bitDepth == 8)
            return AppendIntegers(row, rowBytes, decodeSRGB, &image);
        std::memcpy(wide.data(), row, rowBytes);
        AppendIntegers(wide.data(), wide.size(), decodeSRGB, &image);
    };
    state.pixels.resize(isInterlaced ? rowBytes * state.height : rowBytes);
    if (isInterlaced) {
        for (size_t y = 0; y < state.height; ++y)
            state.rows.push_back(state.pixels.data() + y * rowBytes);
        if (!ReadPNGRows(&state))
            FailImage(filename, "not a readable PNG file: " + state.message);
    }
    for (size_t y = 0; y < state.height; ++y) {
        if (!isInterlaced && !ReadPNGRow(&state))
            FailImage(filename, "not a readable PNG file: " + state.message);
        append(isInterlaced ? state.rows[y] : state.pixels.data());
    }
    if (!EndPNGRows(&state))
        FailImage(filename, "not a readable PNG file: " + state.message);
    return image;
}

std::string EncodeSRGB8(const Image &image) {
    std::string bytes;
    bytes.reserve(3 * image.Pixels());
    for (size_t y = 0; y < static_cast<size_t>(image.height); ++y)
        for (size_t x = 0; x < static_cast<size_t>(image.width); ++x) {
            Spectrum rgb = image.RGB(x, y);
            if (rgb.HasNaNs())
                rgb = {1, 0, 1};
            for (size_t c = 0; c < 3; ++c)
                bytes += static_cast<char>(std::lround(255 * LinearToSRGB(std::clamp(rgb[c], 0.f, 1.f))));
        }
    return bytes;
}

std::string EncodePNG(const std::string &filename, const Image &image) {
    PNGState state;
    state.width = static_cast<png_uint_32>(image.width),
    state.height = static_cast<png_uint_32>(image.height);

    const std::string bytes = EncodeSRGB8(image);
    const size_t rowBytes = size_t{3} * state.width;
    state.pixels.assign(bytes.begin(), bytes.end());
    for (size_t y = 0; y < state.height; ++y)
        state.rows.push_back(state.pixels.data() + y * rowBytes);

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
        FailImage(filename, "cannot encode as PNG: " + state.message);
    return std::move(state.out);
}

} // namespace cuticle
