// cuticle convert: one picture format into another, and pictures into a video.
#include "cli/commands.h"
#include "cli/stops.h"
#include "cli/video.h"
#include "core/error.h"
#include "files/file.h"
#include "files/frame_names.h"
#include "images/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <vector>

namespace cuticle {

namespace {

struct ConvertArguments {
    std::string from, to;
    std::string frames; // of a video; "": all that are there
    double exposure = 0, framesPerSecond = 24;
    int quality = 23;
    int bits = 24;
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

// Rounds light to so many significant bits, and variances to half as many: a file that is packed is smaller.
void KeepBits(Image *image, int bits) {
    for (size_t c = 0; c < image->Channels(); ++c) {
        const int kept = image->channels[c].starts_with("variance.") ? std::max(1, bits / 2) : bits;
        for (size_t i = c; i < image->data.size(); i += image->Channels()) {
            int exponent = 0;
            const float mantissa = std::frexp(image->data[i], &exponent), scale = std::ldexp(1.f, kept);
            if (std::isfinite(mantissa))
                image->data[i] = std::ldexp(std::round(mantissa * scale) / scale, exponent);
        }
    }
}

// The numbers of the frames that a video is made of. Throws Error where one of them is not there.
std::vector<size_t> FramesOf(const ConvertArguments &a, const FrameNames &names) {
    const std::vector<size_t> there = names.Existing();
    std::vector<size_t> frames = there;
    if (!a.frames.empty()) {
        const FrameRange range = ParseFrameRange(a.frames);
        frames.clear();
        for (size_t f = range.first; f <= range.last; f += range.step)
            frames.push_back(f);
    } else if (there.empty()) {
        throw Error("there is no picture with a name like \"{}\"", a.from);
    } else { // one number after the other, by the step of the first two
        const size_t step = there.size() > 1 ? there[1] - there[0] : 1;
        frames.clear();
        for (size_t f = there.front(); f <= there.back(); f += step)
            frames.push_back(f);
    }
    for (const size_t f : frames)
        if (!std::binary_search(there.begin(), there.end(), f))
            throw Error("frame {} is missing: there is no \"{}\"", f, names.Of(f))
                .WithRemedy("render it, or choose others by --frames FIRST:LAST");
    return frames;
}

void RunVideo(const ConvertArguments &a) {
    const FrameNames names(a.from, "pictures", "frames/%04d.exr");
    const std::vector<size_t> frames = FramesOf(a, names);
    OutputFile output(a.to);
    CatchStops();
    std::optional<VideoEncoder> video;
    int width = 0, height = 0;
    for (const size_t f : frames) {
        Image image = ReadImage(names.Of(f));
        if (a.exposure != 0)
            Expose(&image, a.exposure);
        if (!video) {
            width = image.width, height = image.height;
            video.emplace(width, height, a.framesPerSecond, a.quality);
        }
        if (image.width != width || image.height != height)
            throw Error("\"{}\" is of {} x {} pixels, the frames before of {} x {}", names.Of(f), image.width,
                        image.height, width, height);
        video->Add(image);
    }
    const std::string bytes = video->Finish();
    output.Write(bytes);
    output.Commit();
    std::cout << fmt::format("wrote {} ({} x {}, {} frames, {:.1f} s, {:.0f} KB)\n", a.to, width, height,
                             frames.size(), static_cast<double>(frames.size()) / a.framesPerSecond,
                             static_cast<double>(bytes.size()) / 1024);
}

void RunConvert(const ConvertArguments &a) {
    if (a.to.ends_with(".mp4"))
        return RunVideo(a);
    if (!a.frames.empty())
        throw Error("--frames is for a video, and \"{}\" is none", a.to).WithRemedy("its name ends in .mp4");
    Image image = ReadImage(a.from);
    if (a.exposure != 0)
        Expose(&image, a.exposure);
    if (a.bits < 24)
        KeepBits(&image, a.bits);
    WriteImage(a.to, image);
    std::cout << "wrote " << a.to << " (" << image.width << " x " << image.height << ")\n";
}

} // namespace

void AddConvertCommand(CLI::App &app) {
    auto a = std::make_shared<ConvertArguments>();
    CLI::App *c =
        app.add_subcommand("convert", "Convert a picture to .exr, .pfm or .png, or pictures to a video.");
    c->add_option("A", a->from,
                  "picture to read (.exr, .pfm, .png, .tga, .hdr, .jpg); for a video, those of all frames: "
                  "frames/%04d.exr")
        ->required();
    c->add_option("B,-o,--output", a->to, "picture (.exr, .pfm or .png) or video (.mp4) to write")
        ->required();
    c->add_option("--frames", a->frames, "frames of the video (default: all that are there)")
        ->type_name("FIRST:LAST[:STEP]");
    c->add_option("--fps", a->framesPerSecond, "frames a second of the video (default: 24)")
        ->check(CLI::Range(0.1, 1000.))
        ->type_name("N");
    c->add_option("--crf", a->quality,
                  "H.264's constant rate factor of the video: 0, no loss, to 51, very small (default: 23)")
        ->check(CLI::Range(0, 51))
        ->type_name("N");
    c->add_option("--exposure", a->exposure, "make it 2^EV times as bright (default: 0)")
        ->check(CLI::Range(-100., 100.))
        ->type_name("EV");
    c->add_option(
         "--bits", a->bits,
         "round light to N significant bits, variances to half of that: a smaller .exr (default: 24, all)")
        ->check(CLI::Range(1, 24))
        ->type_name("N");
    c->footer(
        "An .exr keeps linear values, every channel and the attributes, a .pfm those of R, G and B. A .png "
        "holds R, G and B, clamped to\n"
        "[0, 1] and encoded as sRGB in 8 bits; a pixel that is NaN becomes magenta. 8-bit pictures that are\n"
        "read are decoded from sRGB. Exposure changes the channels R, G, B, Y (layer.R too) and their "
        "variances. Videos are made by the program ffmpeg, which must be installed.\n"
        "Examples: cuticle convert head.exr head.png --exposure 1.5\n"
        "          cuticle convert frames/%04d.exr -o hair.mp4 --fps 24");
    c->callback([a] { RunConvert(*a); });
}

} // namespace cuticle
