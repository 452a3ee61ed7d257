// Rendered figures are made of these: scenes become pictures, pictures become panels and numbers.
#pragma once

#include "figures/figure.h"
#include "images/image.h"

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace cuticle {

// Renders options.scenes/NAME.pbrt as the scene says, denoised where it wishes; a draft (options.quick) at a
// quarter of the resolution each way and of the samples. Throws Error where the file is not there or is no
// scene.
FigurePicture RenderScene(const std::string &name, const FigureOptions &options);
// Reads folder/NAME.exr, which was rendered before. Throws Error.
FigurePicture ReadPicture(const std::string &name, const std::string &folder);
// Renders the text of a scene, as it says.
Image RenderText(const std::string &scene, int spp);

// A panel that shows a picture, the first of its rows on top; light beyond 1 is white.
PlotPanel PicturePanel(const std::string &title, size_t width, size_t height,
                       const std::function<Spectrum(size_t x, size_t y)> &color);
PlotPanel PicturePanel(const std::string &title, const Image &image);

// A window of a picture in shares of its size, from the upper left corner: 0 <= x0 < x1 <= 1, and so for y.
struct PictureWindow {
    double x0 = 0, x1 = 1, y0 = 0, y1 = 1;
};
// The mean of the light in a window, at least one pixel of it.
Spectrum MeanColor(const Image &image, const PictureWindow &window = {});
inline double MeanLuminance(const Image &image, const PictureWindow &window = {}) {
    return static_cast<double>(MeanColor(image, window).y());
}

} // namespace cuticle
