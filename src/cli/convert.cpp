// cuticle convert: one picture format into another.
#include "cli/commands.h"
#include "images/image.h"

#include <cmath>
#include <iostream>
#include <memory>

namespace cuticle {

namespace {

struct ConvertArguments {
    std::string from, to;
    double exposure = 0;
};

// Multiplies light by 2^exposure: the colours by that factor, their variances by its square, all else not at
// all.
void Expose(Image *image, double exposure) {
    const double factor = std::exp2(exposure);
    for (size_t c = 0; c < image->Channels(); ++c) {
        const std::string &name = image->channels[c];
        const size_t dot = name.find_last_of('.');
        const std::string last = dot == std::string::npos ? name : name.substr(dot + 1);
        if (last != "R" && last != "G" && last != "B" && last != "Y")
            continue;
        const double f = name.starts_with("variance.") ? factor * factor : factor;
        for (size_t i = c; i < image->data.size(); i += image->Channels())
            image->data[i] = static_cast<float>(image->data[i] * f);
    }
}

void RunConvert(const ConvertArguments &a) {
    Image image = ReadImage(a.from);
    if (a.exposure != 0)
        Expose(&image, a.exposure);
    WriteImage(a.to, image);
    std::cout << "wrote " << a.to << " (" << image.width << " x " << image.height << ")\n";
}

} // namespace

void AddConvertCommand(CLI::App &app) {
    auto a = std::make_shared<ConvertArguments>();
    CLI::App *c = app.add_subcommand("convert", "Convert a picture to .exr or .png.");
    c->add_option("A", a->from, "picture to read (.exr, .pfm, .png, .tga, .hdr, .jpg)")->required();
    c->add_option("B", a->to, "picture to write (.exr or .png)")->required();
    c->add_option("--exposure", a->exposure, "make it 2^EV times as bright (default: 0)")
        ->check(CLI::Range(-100., 100.))
        ->type_name("EV");
    c->footer(
        "An .exr keeps linear values, every channel and the attributes. A .png holds R, G and B, clamped to\n"
        "[0, 1] and encoded as sRGB in 8 bits; a pixel that is NaN becomes magenta. 8-bit pictures that are\n"
        "read are decoded from sRGB. Exposure changes the channels R, G, B, Y (layer.R too) and their "
        "variances.\n"
        "Example: cuticle convert head.exr head.png --exposure 1.5");
    c->callback([a] { RunConvert(*a); });
}

} // namespace cuticle
