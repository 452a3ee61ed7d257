// cuticle goniometer: measures what one simulated fiber scatters.
#include "cli/commands.h"
#include "core/angles.h"
#include "core/clock.h"
#include "core/error.h"
#include "core/parallel.h"
#include "figures/papers/fiber_plot.h"
#include "files/file.h"

#include <fmt/format.h>
#include <iostream>
#include <map>

namespace cuticle {

namespace {

struct GoniometerArguments {
    FiberDescription fiber;
    FiberLight light;
    FiberMeasurement measurement;
    GoniometerView view;
    // In degrees, as they are given
    double alpha = 0, rotation = 0, thetaI = 0, phiI = 0, width = 2, offset = 0;
    std::optional<double> h;
    std::vector<double> roughness;
    std::vector<size_t> cells;
    std::string output, title;
    int threads = 0;
    bool quiet = false;
};

std::string Number(double v) { return fmt::format("{:.6g}", v); }

// Writes the parameters as the command that makes the same numbers again, for the CSV's first line.
std::string CommandOf(const GoniometerArguments &a) {
    const FiberDescription &f = a.fiber;
    std::string text = fmt::format("cuticle goniometer --eta {:.6g} --axis-ratio {:.6g} --rotation {:.6g} "
                                   "--alpha {:.6g} --roughness {:.6g} "
                                   "{:.6g} --distribution {} --sigma-a {:.6g}",
                                   f.eta, f.axisRatio, a.rotation, a.alpha, f.roughnessU, f.roughnessV,
                                   f.distribution == MicrofacetDistribution::GGX ? "ggx" : "beckmann",
                                   fmt::join(f.sigmaA, " "));
    if (f.medullaRatio > 0) {
        text += fmt::format(" --medulla {:.6g} --medulla-sigma-s {:.6g} --medulla-g {:.6g}", f.medullaRatio,
                            f.medullaSigmaS, f.medullaG);
        if (!f.medullaSigmaA.empty())
            text += fmt::format(" --medulla-sigma-a {:.6g}", fmt::join(f.medullaSigmaA, " "));
    }
    if (f.polarised)
        text += " --polarised";
    text += fmt::format(" --theta-i {:.6g} --phi-i {:.6g}", a.thetaI, a.phiI);
    if (a.h)
        text += fmt::format(" --h {:.6g}", *a.h);
    return text + fmt::format(" --samples {} --seed {}", a.measurement.samples, a.measurement.seed);
}

// Writes one line for each angle of the cut: every class and channel with its standard error.
std::string SliceCsv(const FiberHistogram &histogram, const GoniometerArguments &a) {
    const bool incidence = a.view.plane == GoniometerPlane::Incidence;
    std::string text = incidence ? "theta_o_deg" : "phi_o_minus_phi_i_deg";
    std::vector<LobeSlice> slices;
    for (size_t c = 0; c < histogram.Classes(); ++c)
        for (size_t k = 0; k < histogram.Channels(); ++k) {
            slices.push_back(GoniometerSlice(histogram, a.light, a.view, c, k));
            const std::string name = histogram.ClassName(c) + "_" + std::to_string(k);
            text.append(",").append(name).append("_per_sr,").append(name).append("_error");
        }
    text += '\n';
    for (size_t i = 0; i < slices[0].angle.size(); ++i) {
        text += Number(slices[0].angle[i] / kDegree);
        for (const LobeSlice &s : slices)
            text += "," + Number(s.value[i]) + "," + Number(s.error[i]);
        text += '\n';
    }
    return text;
}

void Report(const FiberHistogram &histogram, double seconds) {
    fmt::print("share of the light that meets the fiber, with one standard error\n");
    for (size_t c = 0; c < histogram.Classes(); ++c) {
        fmt::print("  {:<9}", histogram.ClassName(c));
        for (size_t k = 0; k < histogram.Channels(); ++k)
            fmt::print("  {:.6f} ± {:.6f}", histogram.Albedo(c, k), histogram.AlbedoError(c, k));
        fmt::print("\n");
    }
    if (histogram.Lost() > 0)
        fmt::print("  given up   {:.6g}\n", histogram.Lost());
    fmt::print("{} samples in {:.2f} s\n", histogram.Samples(), seconds);
}

// Names the files to write: one, by its ending, or in a folder all three kinds.
std::vector<std::string> OutputNames(const GoniometerArguments &a) {
    for (const char *ending : {".csv", ".svg", ".png", ".pdf"})
        if (a.output.ends_with(ending))
            return {a.output};
    CheckFolderName(a.output, "a file's name ends in .csv, .svg, .png or .pdf");
    MakeFolder(a.output);
    constexpr std::array<const char *, 4> planes = {"incidence", "normal", "cone", "hemisphere"};
    const std::string stem = a.output + "/" + planes[static_cast<size_t>(a.view.plane)];
    return {stem + ".csv", stem + ".svg", stem + ".png"};
}

std::string Title(const GoniometerArguments &a) {
    if (!a.title.empty())
        return PlainText(a.title);
    const FiberDescription &f = a.fiber;
    std::string text = "{/Symbol h} " + Number(f.eta) + ", {/Symbol q}_i " + Number(a.thetaI) + "°";
    if (a.phiI != 0)
        text += ", {/Symbol f}_i " + Number(a.phiI) + "°";
    if (a.h)
        text += ", {/:Italic h} " + Number(*a.h);
    if (f.axisRatio != 1)
        text += ", axis ratio " + Number(f.axisRatio);
    if (a.alpha != 0)
        text += ", scales " + Number(a.alpha) + "°";
    if (f.roughnessU > 0 || f.roughnessV > 0)
        text += std::string(", ") + (f.distribution == MicrofacetDistribution::GGX ? "GGX " : "Beckmann ") +
                Number(f.roughnessU) + (f.roughnessV != f.roughnessU ? " × " + Number(f.roughnessV) : "");
    if (f.sigmaA[a.view.channel] != 0)
        text += ", {/Symbol s}_a " + Number(f.sigmaA[a.view.channel]);
    if (f.medullaRatio > 0)
        text += ", medulla " + Number(f.medullaRatio);
    return text;
}

void RunGoniometer(GoniometerArguments a) {
    a.fiber.alpha = a.alpha * kDegree, a.fiber.rotation = a.rotation * kDegree;
    a.light = {a.thetaI * kDegree, a.phiI * kDegree, a.h};
    a.view.halfWidth = a.width / 2 * kDegree, a.view.thetaOffset = a.offset * kDegree;
    if (!a.roughness.empty())
        a.fiber.roughnessU = a.roughness.front(), a.fiber.roughnessV = a.roughness.back();
    if (!a.cells.empty())
        a.measurement.cells.rows = a.cells[0], a.measurement.cells.columns = a.cells[1];
    if (a.view.channel >= a.fiber.sigmaA.size())
        throw Error("--channel must be below the number of channels, which is that of --sigma-a: {}",
                    a.fiber.sigmaA.size());
    std::optional<ThreadLimit> limit;
    if (a.threads > 0)
        limit.emplace(static_cast<size_t>(a.threads));

    const std::vector<std::string> names = a.output.empty() ? std::vector<std::string>() : OutputNames(a);
    const double start = WallSeconds();
    const FiberHistogram histogram = SimulateFiber(a.fiber, a.light, a.measurement);
    if (!a.quiet)
        Report(histogram, WallSeconds() - start);
    for (const std::string &name : names) {
        if (name.ends_with(".csv"))
            WriteFileAtomically(name,
                                "# " + CommandOf(a) + "\n" +
                                    (a.view.plane == GoniometerPlane::Hemisphere ? histogram.ToCsv()
                                                                                 : SliceCsv(histogram, a)));
        else
            WritePlot(name, GoniometerPlot(histogram, a.light, a.view, Title(a)));
        if (!a.quiet)
            std::cout << "wrote " << name << "\n";
    }
}

void AddFiberOptions(CLI::App *c, const std::shared_ptr<GoniometerArguments> &a) {
    FiberDescription &f = a->fiber;
    c->add_option("--eta", f.eta, "index of refraction of the fiber")->capture_default_str()->group("Fiber");
    c->add_option("--axis-ratio", f.axisRatio, "second semi-axis of the section over the first; 1: a circle")
        ->capture_default_str()
        ->group("Fiber");
    c->add_option("--rotation", a->rotation, "azimuth of the first semi-axis, degrees")
        ->capture_default_str()
        ->group("Fiber");
    c->add_option("--alpha", a->alpha, "tilt of the scales toward the root, degrees")
        ->capture_default_str()
        ->group("Fiber");
    c->add_option("--roughness", a->roughness,
                  "of the surface along the fiber and across it (one number: both) [0]")
        ->expected(1, 2)
        ->group("Fiber");
    c->add_option("--distribution", f.distribution, "of the microfacets' slopes: beckmann or ggx [beckmann]")
        ->transform(CLI::CheckedTransformer(std::map<std::string, MicrofacetDistribution>{
            {"beckmann", MicrofacetDistribution::Beckmann}, {"ggx", MicrofacetDistribution::GGX}}))
        ->group("Fiber");
    c->add_option("--sigma-a", f.sigmaA, "absorption per radius, a number for each channel [0]")
        ->expected(1, 1000)
        ->group("Fiber");
    c->add_flag("--polarised", f.polarised,
                "follow how light is polarised, instead of averaging at every bounce as all models do")
        ->group("Fiber");
    c->add_option("--medulla", f.medullaRatio, "radius of a medulla over the fiber's; 0: none")
        ->capture_default_str()
        ->group("Fiber");
    c->add_option("--medulla-sigma-a", f.medullaSigmaA,
                  "its absorption per radius of the fiber [as --sigma-a]")
        ->expected(1, 1000)
        ->group("Fiber");
    c->add_option("--medulla-sigma-s", f.medullaSigmaS, "its scattering per radius of the fiber")
        ->capture_default_str()
        ->group("Fiber");
    c->add_option("--medulla-g", f.medullaG, "mean cosine of its scattering (Henyey and Greenstein)")
        ->capture_default_str()
        ->group("Fiber");
}

void AddMeasurementOptions(CLI::App *c, const std::shared_ptr<GoniometerArguments> &a) {
    c->add_option("--theta-i", a->thetaI,
                  "where the light comes from: angle from the normal plane, positive toward the tip, degrees")
        ->capture_default_str()
        ->group("Light");
    c->add_option("--phi-i", a->phiI, "and around the fiber, degrees")->capture_default_str()->group("Light");
    c->add_option("--h", a->h, "one ray at this offset in [-1, 1] instead of light across the whole width")
        ->group("Light");
    c->add_option("--samples", a->measurement.samples, "rays to trace")
        ->capture_default_str()
        ->group("Measurement");
    c->add_option("--seed", a->measurement.seed, "of the random numbers")
        ->check(CLI::Range(uint64_t{0}, kMaxSeed))
        ->capture_default_str()
        ->group("Measurement");
    c->add_option("--orders", a->measurement.orders, "kinds of paths to tell apart: R, TT, TRT, ...")
        ->capture_default_str()
        ->group("Measurement");
    c->add_option("--cells", a->cells, "rows in theta and columns in phi of the sphere [180 360]")
        ->expected(2)
        ->group("Measurement");
    c->add_flag("--equal-solid-angle", a->measurement.cells.equalSolidAngle,
                "rows of equal height in sin theta")
        ->group("Measurement");
    c->add_option("--threads", a->threads, "at most so many; 0: all")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str()
        ->group("Measurement");
}

void AddViewOptions(CLI::App *c, const std::shared_ptr<GoniometerArguments> &a) {
    c->add_option("--plane", a->view.plane,
                  "the cut: incidence, normal, cone (theta = -theta_i) or hemisphere [incidence]")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, GoniometerPlane>{{"incidence", GoniometerPlane::Incidence},
                                                   {"normal", GoniometerPlane::Normal},
                                                   {"cone", GoniometerPlane::Cone},
                                                   {"hemisphere", GoniometerPlane::Hemisphere}}))
        ->group("View");
    c->add_option("--width", a->width, "of the cut, degrees")
        ->check(CLI::Range(0., 180.))
        ->capture_default_str()
        ->group("View");
    c->add_option("--offset", a->offset, "the normal plane and the cone so far toward the tip, degrees")
        ->check(CLI::Range(-90., 90.))
        ->capture_default_str()
        ->group("View");
    c->add_option("--quantity", a->view.quantity,
                  "density: share per steradian; s: Marschner's S, that over cos theta_o [density]")
        ->transform(CLI::CheckedTransformer(std::map<std::string, GoniometerQuantity>{
            {"density", GoniometerQuantity::Density}, {"s", GoniometerQuantity::S}}))
        ->group("View");
    c->add_option("--channel", a->view.channel, "the channel to draw")->capture_default_str()->group("View");
    c->add_option("--title", a->title, "of the picture [the parameters]")->group("View");
    c->add_option("-o,--output", a->output,
                  "a .csv, .svg, .png or .pdf file, or a folder for the first three")
        ->type_name("FILE|FOLDER");
    c->add_flag("-q,--quiet", a->quiet, "print nothing but errors");
}

} // namespace

void AddGoniometerCommand(CLI::App &app) {
    auto a = std::make_shared<GoniometerArguments>();
    CLI::App *c =
        app.add_subcommand("goniometer", "Measure what one fiber scatters, by tracing rays through it.");
    AddFiberOptions(c, a);
    AddMeasurementOptions(c, a);
    AddViewOptions(c, a);
    c->footer(
        "Directions point away from the fiber, which runs from root to tip. Numbers depend on the seed, not "
        "on the\n"
        "threads. Plots are drawn by gnuplot.\n"
        "Example: cuticle goniometer --alpha 3 --roughness 0.1 --sigma-a 0.2 --theta-i 45 -o lobes.png");
    c->callback([a] { RunGoniometer(*a); });
}

} // namespace cuticle
