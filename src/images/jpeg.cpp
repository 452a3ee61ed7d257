// JPEG by libjpeg, read only.
#include "images/formats.h"

#include <cstdio> // jpeglib.h needs it

#include <jerror.h>
#include <jpeglib.h>

#include <algorithm>
#include <csetjmp>

namespace cuticle {

namespace {

// libjpeg leaves by longjmp: everything that must survive it, or be freed after it, lives in this struct
// outside the functions that call setjmp.
struct JPEGState {
    jpeg_decompress_struct reader{};
    jpeg_error_mgr errors{};
    jpeg_progress_mgr progress{};
    std::jmp_buf leave;
    std::string message;
    std::vector<JSAMPLE> row;

    JPEGState() = default;
    ~JPEGState() { jpeg_destroy_decompress(&reader); }
    JPEGState(const JPEGState &) = delete;
    JPEGState &operator=(const JPEGState &) = delete;
};

JPEGState &StateOf(j_common_ptr reader) { return *static_cast<JPEGState *>(reader->client_data); }

void OnJPEGError(j_common_ptr reader) {
    char text[JMSG_LENGTH_MAX];
    reader->err->format_message(reader, text);
    StateOf(reader).message = text;
    std::longjmp(StateOf(reader).leave, 1);
}

// libjpeg goes on with grey where data are damaged or end: those warnings are errors here.
void OnJPEGMessage(j_common_ptr reader, int level) {
    const int code = reader->err->msg_code;
    if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE))
        OnJPEGError(reader);
}

// A picture may come in any number of scans, each over all of it: a few bytes would keep us for hours.
void OnJPEGProgress(j_common_ptr reader) {
    constexpr int kMaxScans = 128;
    if (reinterpret_cast<j_decompress_ptr>(reader)->input_scan_number > kMaxScans) {
        StateOf(reader).message = "it has more than 128 scans";
        std::longjmp(StateOf(reader).leave, 1);
    }
}

// The steps that libjpeg may leave; false: state->message says why.
bool ReadJPEGHeader(const std::string &bytes, JPEGState *state) {
    jpeg_decompress_struct &reader = state->reader;
    reader.err = jpeg_std_error(&state->errors);
    reader.client_data = state;
    state->errors.error_exit = OnJPEGError;
    state->errors.emit_message = OnJPEGMessage;
    state->progress.progress_monitor = OnJPEGProgress;
    if (setjmp(state->leave))
        return false;
    jpeg_create_decompress(&reader);
    reader.progress = &state->progress;
    jpeg_mem_src(&reader, reinterpret_cast<const unsigned char *>(bytes.data()), bytes.size());
    jpeg_read_header(&reader, TRUE);
    return true;
}

bool StartJPEGRows(JPEGState *state) {
    if (setjmp(state->leave))
        return false;
    jpeg_decompress_struct &reader = state->reader;
    const bool isInk = reader.jpeg_color_space == JCS_CMYK || reader.jpeg_color_space == JCS_YCCK;
    reader.out_color_space = isInk ? JCS_CMYK : reader.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_start_decompress(&reader);
    return true;
}

bool ReadJPEGRow(JPEGState *state) {
    if (setjmp(state->leave))
        return false;
    JSAMPROW rows[] = {state->row.data()};
    jpeg_read_scanlines(&state->reader, rows, 1);
    return true;
}

bool FinishJPEG(JPEGState *state) {
    if (setjmp(state->leave))
        return false;
    jpeg_finish_decompress(&state->reader);
    return true;
}

// Four inks to R, G, B in place, three bytes a pixel. Programs write inks upside down, 255 for none.
void InksToRGB(std::vector<JSAMPLE> *row) {
    for (size_t from = 0, to = 0; from < row->size(); from += 4)
        for (size_t c = 0; c < 3; ++c)
            (*row)[to++] = static_cast<JSAMPLE>((*row)[from + c] * (*row)[from + 3] / 255);
}

} // namespace

Image ReadJPEG(const std::string &filename, const std::string &bytes, bool decodeSRGB) {
    JPEGState state;
    const auto require = [&](bool done) {
        if (!done)
            FailImage(filename, "not a readable JPEG file: " + state.message);
    };
    if (bytes.empty())
        FailImage(filename, "not a readable JPEG file: it is empty");
    require(ReadJPEGHeader(bytes, &state));
    // A flat block of 8 x 8 takes a bit or two
    constexpr int64_t kSamplesPerByte = 1024;
    const int64_t width = state.reader.image_width, height = state.reader.image_height;
    CheckImageSize(filename, width, height, state.reader.num_components, bytes.size(), kSamplesPerByte);
    require(StartJPEGRows(&state));
    const auto components = static_cast<size_t>(state.reader.output_components);
    const size_t channels = std::min<size_t>(components, 3), columns = state.reader.output_width;
    Image image = EmptyImage(filename, width, height, ChannelNames(channels));
    for (int64_t y = 0; y < height; ++y) {
        state.row.resize(columns * components);
        require(ReadJPEGRow(&state));
        if (components == 4)
            InksToRGB(&state.row);
        AppendIntegers(state.row.data(), columns * channels, decodeSRGB, &image);
    }
    require(FinishJPEG(&state));
    return image;
}

} // namespace cuticle
