//> Declare how a picture is denoised
#pragma once

#include "core/color.h"
#include "core/vecmath.h"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace cuticle {

// One part of the light of a picture, estimated twice, from two halves of the samples that share nothing. Row
// by row, of equal size.
struct PartHalves {
    std::vector<Spectrum> a, b;
};

// Two pictures that tell where strands are and how they shine, of little noise, and of none that the samples
// share. Row by row.
using Guides = std::array<std::vector<float>, 2>;

// How far a picture is off, as it tells by itself: root mean squares relative to how bright the picture is
// there, by pixel and in blocks of 8 x 8 pixels.
struct PictureError {
    double pixels = 0, blocks = 0;
};

struct DenoisedPicture {
    std::vector<Spectrum> picture;
    PictureError before, after; // estimates, of the mean of the samples and of the denoised picture
    // The errors in words, for statistics and the picture's file.
    std::string Words() const;
};

// Smooths each part of a picture, or fits it to the guides, by as much as its two halves show to be right
// there, and adds the parts up. Parts: direct light and what is scattered more often, as they differ in noise
// and in detail; all of size.x * size.y finite pixels. Guides: null, or as large. The same for any number of
// threads.
DenoisedPicture Denoise(Point2i size, std::span<const PartHalves> parts, const Guides *guides = nullptr);

//> Declare the steps, for tests
// A picture smoothed by a Gaussian of standard deviation sigma pixels, cut off at three; at the edges the
// weights that are left are scaled up. sigma 0: as it is.
std::vector<Spectrum> Smoothed(const std::vector<Spectrum> &picture, Point2i size, float sigma);
//<

} // namespace cuticle
//<
