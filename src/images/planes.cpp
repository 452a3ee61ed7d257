//> Turn pictures into planes
#include "images/planes.h"

#include "core/error.h"

namespace cuticle {

//> Collect the colours of a picture
Planes ToPlanes(const Image &image) {
    Planes planes{static_cast<size_t>(image.width), static_cast<size_t>(image.height), {}};
    for (auto &c : planes.channel)
        c.reserve(image.Pixels());
    for (size_t y = 0; y < planes.height; ++y)
        for (size_t x = 0; x < planes.width; ++x) {
            const Spectrum rgb = image.RGB(x, y);
            for (size_t c = 0; c < 3; ++c)
                planes.channel[c].push_back(rgb[c]);
        }
    return planes;
}
//<

//> Refuse pictures that do not match
void CheckSameSize(const Image &test, const Image &reference) {
    if (test.width != reference.width || test.height != reference.height)
        throw Error("pictures of {} x {} and {} x {} pixels cannot be compared", test.width, test.height,
                    reference.width, reference.height);
    if (test.width <= 0 || test.height <= 0 || test.channels.empty() || reference.channels.empty())
        throw Error("a picture without pixels cannot be compared");
}
//<

} // namespace cuticle
//<
