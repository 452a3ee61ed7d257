// cuticle compare: how far is one picture from another, and is that too far?
#include "images/compare.h"

#include "cli/commands.h"
#include "core/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

namespace cuticle {

namespace {

// The options of the command; a limit that is not given is none.
struct CompareArguments {
    std::string test, reference, errorImage;
    bool json = false;
    double pixelsPerDegree = 67;
    int block = 1;
    std::optional<double> maxMSE, maxRelativeMSE, maxMean, maxP99, maxFLIP, maxRejected, maxBias;
};

// One measure of the comparison, with the limit that was set for it.
struct MeasureRow {
    const char *name;   // in the table
    const char *key;    // in JSON
    const char *option; // that limits it
    std::optional<double> value, limit;
    // True beyond the limit; NaN is beyond every limit.
    bool Fails() const { return limit && !(value && *value <= *limit); }
};

std::string Number(const std::optional<double> &v) { return v ? fmt::format("{:.6g}", *v) : "-"; }

void PrintTable(const std::vector<MeasureRow> &rows, const Comparison &c) {
    fmt::print("{:<28} {:>14} {:>14}\n", "measure", "value", "limit");
    for (const MeasureRow &row : rows)
        fmt::print("{:<28} {:>14} {:>14}{}\n", row.name, Number(row.value), Number(row.limit),
                   row.Fails() ? "  beyond the limit" : "");
    fmt::print("{:<28} {:>14} {:>14}{}\n", "pixels that are no numbers", c.badPixels, 0,
               c.badPixels > 0 ? "  beyond the limit" : "");
    if (c.zTest)
        fmt::print("{:<28} {:>14}   ({} of {} tested pixels or blocks rejected at level {:.3g} each)\n",
                   "z-test", c.zTest->passed ? "passed" : "failed", c.zTest->rejectedPixels,
                   c.zTest->values / 3, c.zTest->level);
}

void PrintJSON(const std::vector<MeasureRow> &rows, const Comparison &c, bool failed) {
    nlohmann::ordered_json json;
    json["width"] = c.width, json["height"] = c.height;
    for (const MeasureRow &row : rows)
        json[row.key] = row.value ? nlohmann::ordered_json(*row.value) : nlohmann::ordered_json();
    json["bad_pixels"] = c.badPixels;
    if (c.zTest) {
        json["rejected_pixels"] = c.zTest->rejectedPixels;
        json["z_test_level"] = c.zTest->level;
        json["z_test_passed"] = c.zTest->passed;
    }
    nlohmann::ordered_json limits = nlohmann::ordered_json::object(),
                           beyond = nlohmann::ordered_json::array();
    for (const MeasureRow &row : rows) {
        if (row.limit)
            limits[row.key] = *row.limit;
        if (row.Fails())
            beyond.push_back(row.key);
    }
    if (c.badPixels > 0)
        beyond.push_back("bad_pixels");
    json["limits"] = limits, json["beyond"] = beyond, json["passed"] = !failed;
    // Names need not be UTF-8; JSON must
    std::cout << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
}

// The part of the reference that a crop window of the same picture shows; the reference itself where
// `test` is no window of it.
Image PartSeenIn(const Image &test, const Image &reference) {
    const int x0 = test.cropX - reference.cropX, y0 = test.cropY - reference.cropY;
    if (test.fullWidth != reference.fullWidth || test.fullHeight != reference.fullHeight || x0 < 0 ||
        y0 < 0 || x0 + test.width > reference.width || y0 + test.height > reference.height)
        return reference;
    Image part(test.width, test.height, reference.channels);
    for (size_t y = 0; y < static_cast<size_t>(test.height); ++y)
        for (size_t x = 0; x < static_cast<size_t>(test.width); ++x)
            for (size_t c = 0; c < part.Channels(); ++c)
                part.At(x, y, c) = reference.At(x + static_cast<size_t>(x0), y + static_cast<size_t>(y0), c);
    return part;
}

void RunCompare(const CompareArguments &a) {
    const Image test = ReadImage(a.test), reference = PartSeenIn(test, ReadImage(a.reference));
    CompareOptions options;
    options.pixelsPerDegree = a.pixelsPerDegree;
    options.block = a.block;
    const Comparison c = Compare(test, reference, options);
    if ((a.maxRejected || a.maxBias) && !c.zTest)
        throw Error(
            "--max-rejected and --max-bias need the channels variance.R, .G and .B in both pictures (cuticle "
            "render --variance)");
    const std::optional<double> rejected =
        c.zTest ? std::optional(c.zTest->rejectedFraction) : std::optional<double>();
    const std::optional<double> bias = c.zTest ? std::optional(c.zTest->bias) : std::optional<double>();
    const std::vector<MeasureRow> rows = {
        {"MSE", "mse", "--max-mse", c.mse, a.maxMSE},
        {"relative MSE", "relative_mse", "--max-relmse", c.relativeMSE, a.maxRelativeMSE},
        {"mean difference", "mean_difference", "--max-mean", c.meanDifference, a.maxMean},
        {"99th percentile", "p99_difference", "--max-p99", c.p99Difference, a.maxP99},
        {"FLIP", "flip", "--max-flip", c.flip, a.maxFLIP},
        {"fraction rejected", "rejected_fraction", "--max-rejected", rejected, a.maxRejected},
        {"bias, standard deviations", "bias", "--max-bias", bias, a.maxBias}};
    bool failed = c.badPixels > 0;
    for (const MeasureRow &row : rows)
        failed |= row.Fails();
    if (!a.errorImage.empty())
        WriteImage(a.errorImage, ErrorImage(test, reference, c));
    if (a.json)
        PrintJSON(rows, c, failed);
    else
        PrintTable(rows, c);

    // Say which limit it was, apart from the numbers, so that a log shows it
    std::cout.flush();
    std::fflush(stdout);
    for (const MeasureRow &row : rows)
        if (row.Fails())
            fmt::print(stderr, "beyond the limit: {} is {}, {} allows {}\n", row.name, Number(row.value),
                       row.option, Number(row.limit));
    if (c.badPixels > 0)
        fmt::print(stderr, "beyond the limit: {} pixels are no finite numbers\n", c.badPixels);
    if (failed)
        throw ExitStatus{1};
}

} // namespace

void AddCompareCommand(CLI::App &app) {
    auto a = std::make_shared<CompareArguments>();
    CLI::App *c = app.add_subcommand("compare", "Compare a picture with a reference.");
    c->add_option("A", a->test, "picture to judge (.exr, .pfm, .png, .tga, .hdr, .jpg)")->required();
    c->add_option("B", a->reference, "reference of the same size, or of which A is a crop window")
        ->required();
    c->add_flag("--json", a->json, "print the measures as JSON instead of a table");
    c->add_option("--error-image", a->errorImage,
                  "write where they differ: FLIP as black, red, yellow, white; an .exr also holds channel "
                  "flip and the differences")
        ->type_name("FILE");
    c->add_option(
         "--pixels-per-degree", a->pixelsPerDegree,
         "pixels in one degree of the viewer's eye, for FLIP (default: 67, a 4K screen 0.7 m wide at "
         "0.7 m)")
        ->check(CLI::Range(1., 1000.))
        ->type_name("X");
    c->add_option(
         "--block", a->block,
         "the z-test takes the means of blocks of N by N pixels, which are nearer to normal (default: 1)")
        ->check(CLI::Range(1, 1000))
        ->type_name("N");
    const auto limit = [&](const char *name, std::optional<double> *value, const char *what) {
        c->add_option(name, *value, what)->check(CLI::NonNegativeNumber)->type_name("X");
    };
    limit("--max-mse", &a->maxMSE, "largest mean squared error");
    limit("--max-relmse", &a->maxRelativeMSE, "largest relative MSE, the mean of (A-B)^2 / (B^2 + 0.01)");
    limit("--max-mean", &a->maxMean, "largest mean of |A-B|");
    limit("--max-p99", &a->maxP99, "largest 99th percentile of |A-B|");
    limit("--max-flip", &a->maxFLIP, "largest mean FLIP, 0 (same) to 1");
    limit("--max-rejected", &a->maxRejected,
          "largest fraction of pixels that the z-test rejects; needs variances in both pictures");
    limit("--max-bias", &a->maxBias,
          "largest difference of the whole pictures' means, in its standard deviations; needs variances");
    c->footer(
        "Values are linear radiance, R, G and B; 8-bit pictures are decoded from sRGB to [0, 1]. The z-test\n"
        "rejects a pixel where its difference is too large for the variances of both pictures, at a level\n"
        "at which chance rejects any pixel at all in 1 of 100 pictures. A pixel that is NaN or infinite\n"
        "always fails. Exit status: 0 within all limits, 1 beyond one or on an error.\n"
        "Example: cuticle compare head.exr reference.exr --max-flip 0.05 --error-image error.png");
    c->callback([a] { RunCompare(*a); });
}

} // namespace cuticle
