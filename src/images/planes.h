//> Hold a picture as three planes
#pragma once

#include "images/image.h"

namespace cuticle {

// The linear R, G and B of a picture (or anything else with three channels), a plane of doubles for each:
// width times height values, row by row from the top.
struct Planes {
    size_t width = 0, height = 0;
    std::array<std::vector<double>, 3> channel;
    size_t Size() const { return channel[0].size(); }
};
// Takes the colours of a picture, as Image::RGB gives them.
Planes ToPlanes(const Image &image);

// Throws Error when the sizes of two pictures differ or a picture is empty.
void CheckSameSize(const Image &test, const Image &reference);

} // namespace cuticle
//<
