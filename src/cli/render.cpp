// cuticle render: scene in, picture out.
#include "cli/commands.h"
#include "cli/stops.h"
#include "cli/terminal_progress.h"
#include "core/check.h"
#include "core/clock.h"
#include "core/error.h"
#include "core/isa.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "core/printable.h"
#include "core/threads.h"
#include "fibers/hair_lanes.h"
#include "files/file.h"
#include "files/frame_names.h"
#include "files/inputs.h"
#include "materials/hair_models.h"
#include "render/plugins.h"
#include "render/renderer.h"
#include "render/sampler.h"
#include "scene/scene.h"

#include <nlohmann/json.hpp>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <limits>
#include <optional>
#include <sys/resource.h>
#include <unistd.h>

namespace cuticle {

namespace {

// Prints on standard error, or does not: a terminal that is gone costs no picture.
void Tell(const std::string &text) { std::fputs((Printable(text) + "\n").c_str(), stderr); }

double PeakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

struct RenderArguments {
    std::string scene, output, integrator, stats, compat, curves = "wide", hair = "lanes", hairModel,
                                                          maxMemory, frames;
    int spp = 0, shrink = 1;
    size_t threads = 0; // 0: all
    uint64_t seed = 0;
    std::vector<float> crop;
    bool quiet = false, strict = false, variance = false, quick = false, resume = false;
    std::optional<bool> denoise;      // the scene's wish, where it is not given
    std::optional<double> checkpoint; // seconds; 0: never
    std::optional<size_t> frame;      // of an animation, under way
};

// The part of a picture: its film while the render is under way.
std::string PartName(const std::string &picture) { return picture + ".part"; }

// Throws Error where a file of this name cannot be written, before hours are spent on it: it is begun and
// dropped. what: "picture".
void CheckWritable(const std::string &filename, const std::string &what) {
    const std::filesystem::path path(filename);
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    std::error_code error;
    if (!std::filesystem::is_directory(folder, error))
        throw Error("the {}'s folder \"{}\" does not exist", what, folder.string());
    if (std::filesystem::is_directory(path, error))
        throw Error("the {}'s name \"{}\" is that of a folder", what, filename);
    if (!std::filesystem::is_fifo(path, error)) // whose reader would see its end
        OutputFile{filename};
}

// Throws Error where the picture or the statistics ("" for none) cannot be written.
void CheckOutputs(const std::string &picture, const std::string &stats) {
    const std::string ending = std::filesystem::path(picture).extension().string();
    if (ending != ".exr" && ending != ".png")
        throw Error("the picture's name \"{}\" must end in .exr or .png (option -o)", picture);
    CheckWritable(picture, "picture");
    if (stats.empty())
        return;
    CheckWritable(stats, "statistics");
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
    options.film.denoise = a.denoise;
    options.film.shrink = a.shrink;
    options.interrupted = &StopAsked();
    if (!a.crop.empty())
        options.film.crop = {a.crop[0], a.crop[1], a.crop[2], a.crop[3]};
    return options;
}

// Everything besides the scene file and the options of a job that determines the picture, and in which
// kernels: another instruction set gives other last digits. To add an option that changes pictures: name it
// here.
std::vector<std::pair<std::string, std::string>> FactsOf(const RenderArguments &a, const InputLog &inputs,
                                                         const Scene &scene) {
    const std::string folder = std::filesystem::path(a.scene).parent_path().string();
    return {{"hash of the scene's files", inputs.Digest(folder)},
            {"option --hair-model", a.hairModel},
            {"option --compat", a.compat},
            {"option --curves", a.curves},
            {"option --hair", a.hair},
            {"frame of --frames", a.frame ? std::to_string(*a.frame) : ""},
            {"instruction set", scene.Isa()},
            {"processor's instruction set", IsaName(SupportedIsas().front())}};
}

// How the film is kept on disk; nothing where neither wished for nor possible.
std::optional<Checkpoints> CheckpointsOf(const RenderArguments &a, const std::string &output, bool isPlain) {
    const double seconds = a.checkpoint.value_or(60);
    if (!isPlain && (a.resume || a.checkpoint.value_or(0) > 0))
        throw Error("\"{}\" is no plain file, and no part can be kept beside it", output)
            .WithRemedy("leave --resume and --checkpoint out, or write to a file");
    if (!isPlain || (seconds == 0 && !a.resume))
        return std::nullopt;
    Checkpoints checkpoints;
    checkpoints.filename = PartName(output);
    checkpoints.seconds = seconds > 0 ? seconds : std::numeric_limits<double>::infinity();
    checkpoints.resume = a.resume;
    checkpoints.afterStop = a.resume || a.checkpoint.has_value() || a.frame.has_value();
    return checkpoints;
}

// Writes a picture to where nothing is lost by it: the current folder, else that of temporary files. Returns
// its name, "" if that cannot be either.
std::string SaveElsewhere(const std::string &name, const std::string &bytes) {
    std::error_code error;
    for (const std::filesystem::path &folder :
         {std::filesystem::current_path(error), std::filesystem::temp_directory_path(error)})
        for (int copy = 0; copy < 100 && !folder.empty(); ++copy) {
            const std::filesystem::path wished(name);
            const std::string number = copy > 0 ? fmt::format("-{}", copy) : "";
            const std::string place =
                (folder / (wished.stem().string() + number + wished.extension().string())).string();
            if (std::filesystem::exists(std::filesystem::symlink_status(place, error)))
                continue;
            try {
                WriteFileAtomically(place, bytes);
                return place;
            } catch (const Error &) {
                break; // the next folder
            }
        }
    return "";
}

// Writes the picture to its file or, where that can no longer be, elsewhere; the Error then says where.
void SavePicture(OutputFile *file, const std::string &name, const Image &image) {
    const std::string bytes = EncodeImage(name, image);
    try {
        file->Write(bytes);
        file->Commit(true);
        VLOG(1) << Printable(name) << ": written";
    } catch (const Error &e) {
        const std::string place = SaveElsewhere(name, bytes);
        if (place.empty())
            throw;
        throw Error(e.What()).WithRemedy("the picture was saved as \"{}\" instead", place);
    }
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
    json["learned"] = stats.learned;
    json["denoised"] = stats.denoised;
    json["nan_samples"] = stats.nanSamples;
    json["threads"] = stats.threads;
    json["isa"] = scene.Isa();
    json["seed"] = a.seed;
    json["version"] = CUTICLE_VERSION;
    return json;
}

// Writes JSON, which must be UTF-8, of names that need not be.
void WriteJson(const nlohmann::ordered_json &json, OutputFile *file) {
    file->Write(json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
    file->Commit();
}

// A limit on threads where fewer were asked for than there are, or fewer can be started than were asked for.
std::optional<size_t> ThreadsToUse(size_t wished) {
    if (wished == 0)
        return std::nullopt;
    const size_t startable = StartableThreads(wished);
    if (startable < wished)
        Warning("threads", fmt::format("{} of {} threads can be started (limits of processes or of memory); "
                                       "the render uses these",
                                       startable, wished));
    return startable;
}

// Says what a render that did not come to its end has left, and ends the command accordingly.
[[noreturn]] void TellWhatIsThere(const RenderArguments &a, const std::string &output,
                                  const RenderStats &stats, bool hasPart, const std::exception_ptr &failure) {
    const std::string next = hasPart ? "; --resume goes on from " + PartName(output) : "";
    if (a.frame)
        Tell(fmt::format("stopped in frame {}, which was not written{}", *a.frame, next));
    else
        Tell(fmt::format("stopped after {} of {} samples per pixel; wrote {}{}", stats.sppReached, stats.spp,
                         output, next));
    if (failure)
        std::rethrow_exception(failure);
    throw ExitStatus{StopStatus()};
}

// Prints the closing lines.
void TellTheEnd(const std::string &output, const Image &image, const Scene &scene, const Preparation &seconds,
                const RenderStats &stats) {
    std::cout << fmt::format("{}: {} x {}, {} samples per pixel, {} curves; read {:.1f} s, built {:.1f} s, "
                             "rendered {:.1f} s\n",
                             Printable(output), image.width, image.height, stats.sppReached, scene.Curves(),
                             seconds.parse, seconds.build, stats.renderSeconds);
    if (!stats.denoised.empty())
        std::cout << "denoised: " << stats.denoised << "\n";
}

// The most bytes that the picture's file takes.
uint64_t RoomFor(const SceneDescription &description, const RenderOptions &options) {
    const Point2i size = Film::WindowSizeOf(
        description.film, {options.film.crop, options.quick, false, {}, options.film.shrink});
    const uint64_t pixel = 6 * sizeof(float); // with variance, or with what is denoised
    return static_cast<uint64_t>(size.x) * static_cast<uint64_t>(size.y) * pixel + 65536; // and a header
}

// Renders the scene, or its frame a.frame, to `output`, or to what the scene says ("").
void RenderPicture(const RenderArguments &a, std::optional<size_t> threads, WarningLog *warnings) {
    InputLog inputs;
    const InputScope noted(&inputs);
    std::optional<MemoryBudget> budget;
    if (!a.maxMemory.empty())
        budget.emplace(ParseByteSize(a.maxMemory));
    const MemoryBudgetScope memory(budget ? &*budget : nullptr);

    VLOG(1) << Printable(a.scene) << ": reading";
    Preparation seconds;
    double start = WallSeconds();
    ParseOptions parse;
    parse.frame = a.frame;
    SceneDescription description = ParseScene(AllPlugins(), a.scene, parse);
    seconds.parse = WallSeconds() - start;
    const std::string output = OutputName(a, description);
    CheckOutputs(output, a.stats);
    ClaimFilm(description.film, {RenderOptionsOf(a).film.crop, a.quick, a.variance, a.denoise, a.shrink});

    VLOG(1) << Printable(a.scene) << ": building";
    start = WallSeconds();
    if (a.hair == "scalar")
        SetHairKernels("scalar");
    const Scene scene(&description, SceneOptionsOf(a));
    seconds.build = WallSeconds() - start;
    if (!a.frame)
        warnings->Flush();

    // The outputs are opened before the render, which holds them: now all inputs are known, too
    CatchStops();
    OutputFile picture(output);
    std::optional<OutputFile> statistics;
    if (!a.stats.empty())
        statistics.emplace(a.stats);
    RenderOptions options = RenderOptionsOf(a);
    options.threads = threads.value_or(0);
    options.checkpoints = CheckpointsOf(a, output, picture.IsPlain());
    size_t partsWritten = 0;
    if (options.checkpoints) {
        options.checkpoints->written = &partsWritten;
        options.facts = FactsOf(a, inputs, scene);
    }
    picture.Reserve(RoomFor(description, options));

    VLOG(1) << Printable(a.scene) << ": rendering";
    RenderStats stats;
    std::optional<TerminalProgress> progress;
    if (!a.quiet)
        options.progress = &progress.emplace();
    std::exception_ptr failure;
    options.failure = &failure;
    const Image image = Render(description, scene, options, &stats);
    progress.reset();
    if (!a.frame)
        warnings->Flush();
    const bool isStopped = stats.sppReached < stats.spp;
    if (!a.frame || (!isStopped && !failure)) // a frame's name stands for a whole picture
        SavePicture(&picture, output, image);
    std::error_code ignored;
    if (!isStopped && !failure && partsWritten > 0)
        std::filesystem::remove(PartName(output), ignored);

    if (stats.nanSamples > 0)
        Tell(fmt::format("warning: {} samples were not finite and were left out", stats.nanSamples));
    if (statistics)
        WriteJson(StatsJson(a, output, description, scene, image, seconds, stats), &*statistics);
    if (failure || isStopped)
        TellWhatIsThere(a, output, stats, partsWritten > 0, failure);
    if (!a.quiet)
        TellTheEnd(output, image, scene, seconds, stats);
    if (stats.nanSamples > 0)
        throw ExitStatus{1};
}

// Renders the frames of an animation one by one. With --resume those whose pictures are there are done.
void RenderFrames(const RenderArguments &a, std::optional<size_t> threads, WarningLog *warnings) {
    constexpr const char *kExample = "frames/%04d.exr";
    const FrameRange range = ParseFrameRange(a.frames);
    if (a.output.empty())
        throw Error("--frames needs -o, a name with a place for the number of a frame")
            .WithRemedy("write it as in {}", kExample);
    const FrameNames outputs(a.output, "picture", kExample);
    std::optional<FrameNames> stats;
    if (!a.stats.empty())
        stats.emplace(a.stats, "statistics", "frames/%04d.json");
    if (const std::string folder = std::filesystem::path(outputs.Of(0)).parent_path().string();
        !folder.empty())
        MakeFolder(folder);
    size_t there = 0;
    for (size_t frame = range.first; frame <= range.last; frame += range.step) {
        RenderArguments one = a;
        one.frame = frame, one.output = outputs.Of(frame);
        one.stats = stats ? stats->Of(frame) : "";
        if (a.resume && std::filesystem::exists(one.output)) {
            ++there;
            continue;
        }
        if (StopAsked()) {
            Tell(fmt::format("stopped before frame {}; --resume goes on from it", frame));
            throw ExitStatus{StopStatus()};
        }
        RenderPicture(one, threads, warnings);
    }
    if (!a.quiet && there > 0)
        std::cout << fmt::format("{} frames were there already\n", there);
}

void RunRender(const RenderArguments &a) {
    WarningLog warnings(a.strict);
    const WarningScope scope(&warnings);
    // --threads bounds parsing and building as well as rendering
    std::optional<ThreadLimit> limit;
    const std::optional<size_t> threads = ThreadsToUse(a.threads);
    if (threads)
        limit.emplace(*threads);
    if (a.frames.empty())
        return RenderPicture(a, threads, &warnings);
    RenderFrames(a, threads, &warnings);
}

} // namespace

// Long because: an option is a statement of some lines.
void AddRenderCommand(CLI::App &app) {
    auto a = std::make_shared<RenderArguments>();
    CLI::App *c = app.add_subcommand("render", "Render a pbrt-v3 scene to a picture.");
    c->add_option("SCENE", a->scene, "scene file, .pbrt or .pbrt.gz")->required();
    c->add_option("-o,--output,--outfile", a->output,
                  "picture to write, .exr or .png (default: the scene's Film filename, else SCENE.exr)")
        ->type_name("FILE");
    c->add_option(
         "--frames", a->frames,
         "an animation: these frames, each to a name that -o has a place for (frames/%04d.exr); %04d in the "
         "scene's strings is the frame's number too, and .usda files follow by their time samples")
        ->type_name("FIRST:LAST[:STEP]");
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
        ->check(CLI::Range(uint64_t{0}, kMaxSeed))
        ->type_name("N");
    c->add_option("--integrator", a->integrator, "path, directlighting or whitted (default: the scene's)")
        ->type_name("NAME");
    c->add_flag("--variance", a->variance,
                "add the variance of every pixel's mean as channels variance.R .G .B (.exr)");
    c->add_flag_function(
        "--denoise,!--no-denoise", [a](int64_t times) { a->denoise = times > 0; },
        "smooth the picture where its samples show that it gets better by it, and say how far it is "
        "off; what is smoothed stays as channels unfiltered.R .G .B (default: the scene's Film says)");
    c->add_option(
         "--checkpoint", a->checkpoint,
         "keep what is rendered in PICTURE.part, so that no kill costs more than these seconds; 0: never "
         "(default: 60)")
        ->check(CLI::Range(0., 1e9))
        ->type_name("SECONDS");
    c->add_flag(
        "--resume", a->resume,
        "go on from PICTURE.part, if it is there, to the same picture bit for bit; of an animation, leave "
        "the frames as they are whose pictures are there");
    c->add_option("--stats", a->stats, "write times, counts and memory as JSON")->type_name("FILE.json");
    c->add_option("--shrink", a->shrink, "1/N of the resolution each way (default: 1)")
        ->check(CLI::Range(1, 1000))
        ->type_name("N");
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
    c->footer(
        "Ctrl-C writes what there is and says how many samples it holds (exit status 130); so do "
        "SIGTERM, SIGHUP\nand SIGXCPU (128 and the signal's number). A part is removed when its picture "
        "is finished.\n"
        "CUTICLE_ISA=sse2|avx2|avx512 chooses the instruction set of the kernels of curves and hair; "
        "default: the best there is.\n"
        "Example: cuticle render scenes/quickstart.pbrt --spp 64 -o head.exr --stats head.json");
    c->callback([a] { RunRender(*a); });
}

} // namespace cuticle
