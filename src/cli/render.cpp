// cuticle render: scene in, picture out.
#include "cli/commands.h"
#include "cli/terminal_progress.h"
#include "core/check.h"
#include "core/clock.h"
#include "core/error.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "fibers/hair_lanes.h"
#include "files/file.h"
#include "materials/hair_models.h"
#include "render/plugins.h"
#include "render/renderer.h"
#include "render/sampler.h"
#include "scene/scene.h"

#include <nlohmann/json.hpp>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <sys/resource.h>
#include <unistd.h>

namespace cuticle {

namespace {

std::atomic<bool> interrupted = false;

// The first Ctrl-C asks for what there is; a second one, of an impatient user, ends the program.
extern "C" void OnInterrupt(int) {
    if (interrupted.exchange(true))
        _exit(130);
}

double PeakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

struct RenderArguments {
    std::string scene, output, integrator, stats, compat, curves = "wide", hair = "lanes", hairModel,
                                                          maxMemory;
    int spp = 0;
    size_t threads = 0; // 0: all
    uint64_t seed = 0;
    std::vector<float> crop;
    bool quiet = false, strict = false, variance = false, quick = false;
};

// Throws Error where a file of this name cannot be written, before hours are spent on it. what: "picture".
void CheckWritable(const std::string &filename, const std::string &what, const std::string &scene) {
    const std::filesystem::path path(filename);
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    std::error_code error;
    if (!std::filesystem::is_directory(folder, error))
        throw Error("the {}'s folder \"{}\" does not exist", what, folder.string());
    if (access(folder.c_str(), W_OK) != 0)
        throw Error("the {}'s folder \"{}\" cannot be written to", what, folder.string());
    if (std::filesystem::is_directory(path, error))
        throw Error("the {}'s name \"{}\" is that of a folder", what, filename);
    if (std::filesystem::equivalent(path, scene, error))
        throw Error("the {}'s name \"{}\" is that of the scene, which it would overwrite", what, filename);
}

// Throws Error where the picture or the statistics ("" for none) cannot be written.
void CheckOutputs(const std::string &picture, const std::string &stats, const std::string &scene) {
    const std::string ending = std::filesystem::path(picture).extension().string();
    if (ending != ".exr" && ending != ".png")
        throw Error("the picture's name \"{}\" must end in .exr or .png (option -o)", picture);
    CheckWritable(picture, "picture", scene);
    if (stats.empty())
        return;
    CheckWritable(stats, "statistics", scene);
    const auto whole = [](const std::string &name) {
        return std::filesystem::absolute(name).lexically_normal();
    };
    if (whole(stats) == whole(picture))
        throw Error("the picture and the statistics cannot both be written to \"{}\"", stats);
}

// The picture's name: the one asked for, else the scene's, with an ending that can be written.
std::string OutputName(const RenderArguments &a, const SceneDescription &description) {
    if (!a.output.empty())
        return a.output;
    const std::string name = DefaultOutput(description);
    std::filesystem::path path(name);
    if (path.extension() == ".png" || path.extension() == ".exr")
        return name;
    Warning("output format", fmt::format("the scene's film asks for \"{}\"; .exr is written instead", name));
    return path.replace_extension(".exr").string();
}

SceneOptions SceneOptionsOf(const RenderArguments &a) {
    SceneOptions options;
    options.materials.compatPbrtV3 = a.compat == "pbrt-v3";
    options.materials.hairModel = a.hairModel;
    options.binaryCurves = a.curves == "binary";
    return options;
}

RenderOptions RenderOptionsOf(const RenderArguments &a) {
    RenderOptions options;
    if (a.spp > 0)
        options.spp = a.spp;
    if (!a.integrator.empty())
        options.integrator = a.integrator;
    options.threads = a.threads;
    options.seed = a.seed;
    options.quick = a.quick;
    options.variance = a.variance;
    options.interrupted = &interrupted;
    if (!a.crop.empty())
        options.film.crop = {a.crop[0], a.crop[1], a.crop[2], a.crop[3]};
    return options;
}

// Seconds that reading and building the scene took.
struct Preparation {
    double parse = 0, build = 0;
};

nlohmann::ordered_json StatsJson(const RenderArguments &a, const std::string &output,
                                 const SceneDescription &description, const Scene &scene, const Image &image,
                                 const Preparation &seconds, const RenderStats &stats) {
    nlohmann::ordered_json json;
    json["scene"] = a.scene;
    json["output"] = output;
    json["parse_s"] = seconds.parse;
    json["parse_bytes"] = description.bytesRead;
    json["build_s"] = seconds.build;
    json["render_s"] = stats.renderSeconds;
    json["spp"] = stats.sppReached;
    json["width"] = image.width;
    json["height"] = image.height;
    json["rays"] = stats.rays;
    json["shadow_rays"] = stats.shadowRays;
    json["curves"] = scene.Curves();
    json["scene_mb"] = static_cast<double>(scene.MemoryBytes()) / (1024 * 1024);
    json["peak_rss_mb"] = PeakMegabytes();
    json["nan_samples"] = stats.nanSamples;
    json["threads"] = stats.threads;
    json["isa"] = scene.Isa();
    json["seed"] = a.seed;
    json["version"] = CUTICLE_VERSION;
    return json;
}

void RunRender(const RenderArguments &a) {
    WarningLog warnings(a.strict);
    const WarningScope scope(&warnings);
    // --threads bounds parsing and building as well as rendering
    std::optional<ThreadLimit> limit;
    if (a.threads > 0)
        limit.emplace(a.threads);

    std::optional<MemoryBudget> budget;
    if (!a.maxMemory.empty())
        budget.emplace(ParseByteSize(a.maxMemory));
    const MemoryBudgetScope memory(budget ? &*budget : nullptr);

    VLOG(1) << a.scene << ": reading";
    Preparation seconds;
    double start = WallSeconds();
    SceneDescription description = ParseScene(AllPlugins(), a.scene);
    seconds.parse = WallSeconds() - start;
    const std::string output = OutputName(a, description);
    CheckOutputs(output, a.stats, a.scene);
    ClaimFilm(description.film, {RenderOptionsOf(a).film.crop, a.quick, a.variance});

    VLOG(1) << a.scene << ": building";
    start = WallSeconds();
    if (a.hair == "scalar")
        SetHairKernels("scalar");
    const Scene scene(&description, SceneOptionsOf(a));
    seconds.build = WallSeconds() - start;
    warnings.Flush();

    VLOG(1) << a.scene << ": rendering";
    RenderOptions options = RenderOptionsOf(a);
    std::signal(SIGINT, OnInterrupt);
    RenderStats stats;
    std::optional<TerminalProgress> progress;
    if (!a.quiet)
        options.progress = &progress.emplace();
    const Image image = Render(description, scene, options, &stats);
    progress.reset();
    warnings.Flush();
    WriteImage(output, image);
    VLOG(1) << output << ": written";

    if (stats.nanSamples > 0)
        std::cerr << "warning: " << stats.nanSamples << " samples were not finite and were left out\n";
    if (!a.stats.empty())
        WriteFileAtomically(a.stats,
                            StatsJson(a, output, description, scene, image, seconds, stats).dump(2) + "\n");
    if (stats.sppReached < stats.spp) {
        fmt::print(stderr, "stopped after {} of {} samples per pixel; wrote {}\n", stats.sppReached,
                   stats.spp, output);
        throw ExitStatus{130};
    }
    if (!a.quiet)
        fmt::print("{}: {} x {}, {} samples per pixel, {} curves; read {:.1f} s, built {:.1f} s, rendered "
                   "{:.1f} s\n",
                   output, image.width, image.height, stats.sppReached, scene.Curves(), seconds.parse,
                   seconds.build, stats.renderSeconds);
}

} // namespace

void AddRenderCommand(CLI::App &app) {
    auto a = std::make_shared<RenderArguments>();
    CLI::App *c = app.add_subcommand("render", "Render a pbrt-v3 scene to a picture.");
    c->add_option("SCENE", a->scene, "scene file, .pbrt or .pbrt.gz")->required();
    c->add_option("-o,--output,--outfile", a->output,
                  "picture to write, .exr or .png (default: the scene's Film filename, else SCENE.exr)")
        ->type_name("FILE");
    c->add_option("--spp", a->spp, "samples per pixel (default: the scene's Sampler)")
        ->check(CLI::Range(1, kMaxSamples))
        ->type_name("N");
    c->add_option("--threads,--nthreads", a->threads,
                  "threads; the picture does not depend on them (default: all cores)")
        ->check(CLI::Range(1, 1024))
        ->type_name("N");
    c->add_option("--max-memory", a->maxMemory,
                  "refuse, before it is allocated, what would not fit: film, maps, curves, meshes (4G, 512M)")
        ->type_name("SIZE");
    c->add_option("--crop,--cropwindow", a->crop, "render only this window, in fractions of the picture")
        ->expected(4)
        ->type_name("x0 x1 y0 y1");
    c->add_option("--seed", a->seed, "seed of the random numbers; another seed, another noise (default: 0)")
        ->type_name("N");
    c->add_option("--integrator", a->integrator, "path, directlighting or whitted (default: the scene's)")
        ->type_name("NAME");
    c->add_flag("--variance", a->variance,
                "add the variance of every pixel's mean as channels variance.R .G .B (.exr)");
    c->add_option("--stats", a->stats, "write times, counts and memory as JSON")->type_name("FILE.json");
    c->add_flag("--quick", a->quick, "a quarter of the resolution each way and of the samples");
    c->add_flag("-q,--quiet", a->quiet, "no progress and no closing line; warnings and errors stay");
    c->add_flag("--strict", a->strict, "warnings become errors");
    c->add_option("--compat", a->compat,
                  "pbrt-v3: tilt the scales, mirror the fibers and let rays leave them as pbrt-v3 does")
        ->check(CLI::IsMember({"pbrt-v3"}))
        ->type_name("RENDERER");
    c->add_option("--curves", a->curves,
                  "wide: our curve set; binary: pbrt-v3's way, a binary tree and recursion, for comparison "
                  "(default: wide)")
        ->check(CLI::IsMember({"wide", "binary"}))
        ->type_name("NAME");
    c->add_option(
         "--hair", a->hair,
         "lanes: our hair model; scalar: the same, one lobe at a time, for comparison (default: lanes)")
        ->check(CLI::IsMember({"lanes", "scalar"}))
        ->type_name("NAME");
    std::vector<std::string> models;
    for (const std::string_view name : HairModelNames())
        models.emplace_back(name);
    c->add_option(
         "--hair-model", a->hairModel,
         "render all hair with this model of a fiber, its parameters taken from eta, beta_m, beta_n, alpha "
         "and the hair's colour where the scene does not give them (default: the scene's \"string model\")")
        ->check(CLI::IsMember(models))
        ->type_name("NAME");
    c->footer("Ctrl-C writes what there is and says how many samples it holds (exit status 130).\n"
              "CUTICLE_ISA=sse2|avx2|avx512 chooses the instruction set of the kernels of curves and hair; "
              "default: the best there is.\n"
              "Example: cuticle render scenes/quickstart.pbrt --spp 64 -o head.exr --stats head.json");
    c->callback([a] { RunRender(*a); });
}

} // namespace cuticle
