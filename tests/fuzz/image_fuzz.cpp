// Bytes as a picture; the first one chooses the format.
#include "fuzz/fuzz.h"
#include "images/image.h"

using namespace cuticle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static constexpr const char *kNames[] = {"a.pfm", "a.png", "a.exr", "a.hdr", "a.tga", "a.jpg"};
    if (size == 0)
        return 0;
    Image image;
    if (Accepts([&] { image = DecodeImage(kNames[data[0] % 6], Text(data + 1, size - 1)); }))
        Require(image.width > 0 && image.height > 0 && image.Channels() > 0 &&
                image.data.size() ==
                    static_cast<size_t>(image.width) * static_cast<size_t>(image.height) * image.Channels());
    return 0;
}
