// The older formats, by stb_image: .tga and .hdr.
#include "images/formats.h"

#include "core/error.h"

#define STBI_NO_STDIO
#include <stb/stb_image.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace cuticle {

namespace {

// stb_image takes the end of its input for zeros, and some of its decoders then return a picture of garbage.
// Fed through callbacks, it shows that it wanted more than there was: a read that starts at the end, or a
// read of pixels (never of its buffer's 128 bytes) that comes up short.
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

} // namespace

Image ReadByStb(const std::string &filename, const std::string &bytes, bool decodeSRGB) {
    const auto fail = [&](const StbInput &in) {
        const char *reason = stbi_failure_reason();
        FailImage(filename, fmt::format("not a readable {} file: {}", Extension(filename).substr(1),
                                        in.overrun ? "the file ends too early"
                                        : reason   ? reason
                                                   : "unknown format"));
    };
    const stbi_io_callbacks callbacks = {StbInput::Read, StbInput::Skip, StbInput::Eof};
    int width = 0, height = 0, channels = 0;
    StbInput head{bytes};
    if (bytes.empty() || !stbi_info_from_callbacks(&callbacks, &head, &width, &height, &channels))
        fail(head);
    // A run in a TGA takes two bytes for 128 pixels, in an HDR for 127 of one channel
    CheckImageSize(filename, width, height, channels, bytes.size(), bytes.starts_with("#?") ? 64 : 256);

    StbInput in{bytes};
    StbInput probe{bytes};
    if (stbi_is_hdr_from_callbacks(&callbacks, &probe)) {
        const std::unique_ptr<float, decltype(&stbi_image_free)> pixels(
            stbi_loadf_from_callbacks(&callbacks, &in, &width, &height, &channels, 0), stbi_image_free);
        if (!pixels || in.overrun)
            fail(in);
        Image image = EmptyImage(filename, width, height, ChannelNames(static_cast<size_t>(channels)));
        image.data.assign(pixels.get(), pixels.get() + image.Pixels() * image.Channels());
        return image;
    }
    const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> pixels(
        stbi_load_from_callbacks(&callbacks, &in, &width, &height, &channels, 0), stbi_image_free);
    if (!pixels || in.overrun)
        fail(in);
    Image image = EmptyImage(filename, width, height, ChannelNames(static_cast<size_t>(channels)));
    AppendIntegers(pixels.get(), image.Pixels() * image.Channels(), decodeSRGB, &image);
    return image;
}

} // namespace cuticle
