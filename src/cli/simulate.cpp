// cuticle simulate: hair that moves, written frame by frame.
#include "cli/commands.h"
#include "cli/stops.h"
#include "cli/terminal_progress.h"
#include "core/clock.h"
#include "core/error.h"
#include "core/parallel.h"
#include "dynamics/recipe.h"
#include "files/file.h"
#include "files/frame_names.h"
#include "grooms/hair_file.h"
#include "grooms/usd_writer.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

namespace cuticle {

namespace {

struct SimulateArguments {
    std::string recipe, output;
    size_t threads = 0; // 0: all
    bool manual = false, quiet = false;
};

// Takes frames to where they are written.
class FrameOutput {
  public:
    FrameOutput(const std::string &output, double framesPerSecond) {
        if (output.ends_with(".usda")) {
            usd_.emplace(output, framesPerSecond);
        } else if (output.ends_with(".hair")) {
            names_.emplace(output, "output",
                           "frames/%04d.hair: a .hair file holds one frame, one .usda file all");
            const std::string folder = std::filesystem::path(names_->Of(0)).parent_path().string();
            if (!folder.empty())
                MakeFolder(folder);
        } else {
            throw Error(
                "the output's name \"{}\" must end in .hair (a file for each frame: frames/%04d.hair) or "
                ".usda (one file with time samples)",
                output);
        }
    }
    void Add(size_t frame, const Groom &groom) {
        if (usd_)
            usd_->AddFrame(frame, groom);
        else
            WriteHairFile(names_->Of(frame), groom);
    }
    void Finish() {
        if (usd_)
            usd_->Finish();
    }

  private:
    std::optional<UsdWriter> usd_;
    std::optional<FrameNames> names_;
};

void Summarise(const SimulateArguments &a, const HairSimulation &simulation, size_t frames,
               const StepReport &worst, double cpuSeconds) {
    if (worst.recovered > 0)
        Warning(
            "strands that were stopped",
            fmt::format(
                "{} times a strand's step gave no number, and it was stopped where it was; more substeps, or "
                "less stiffness or load, help",
                worst.recovered));
    if (a.quiet)
        return;
    std::cout << fmt::format(
        "{}: {} frames, {} key hairs of {} points, {} steps a frame, {:.0f} ms of CPU a frame; "
        "lengths within {:.1e}, obstacles kept out to {:.1e} cm\n",
        a.output, frames, simulation.Keys().StrandCount(), simulation.Keys().PointCount(),
        simulation.Substeps(), frames > 1 ? 1000 * cpuSeconds / static_cast<double>(frames - 1) : 0,
        worst.stretch, worst.penetration);
}

void RunSimulate(const SimulateArguments &a) {
    if (a.manual) {
        std::cout << SimulationManual();
        return;
    }
    if (a.recipe.empty() || a.output.empty())
        throw Error("a simulation needs a recipe and -o OUTPUT")
            .WithRemedy("cuticle simulate --help shows how");
    SimulationRecipe recipe = ReadSimulationRecipe(a.recipe);
    const size_t frames = recipe.FrameCount();
    FrameOutput output(a.output, recipe.settings.framesPerSecond);
    CatchStops();
    OnThreads(a.threads, [&] {
        HairSimulation simulation(std::move(recipe.groom), std::move(recipe.obstacle), recipe.settings);
        StepReport worst;
        double cpu = 0;
        size_t done = 0;
        {
            TerminalProgress progress("Simulating");
            output.Add(done++, simulation.Frame());
            while (done < frames && !StopAsked()) {
                const double start = ProcessCpuSeconds();
                worst.Join(simulation.NextFrame());
                cpu += ProcessCpuSeconds() - start;
                output.Add(done++, simulation.Frame());
                progress.Report(done, frames);
            }
            output.Finish();
        }
        Summarise(a, simulation, done, worst, cpu);
        if (done < frames) {
            std::cerr << fmt::format("stopped after {} of {} frames, which are kept\n", done, frames);
            throw ExitStatus{StopStatus()};
        }
    });
}

} // namespace

void AddSimulateCommand(CLI::App &app) {
    auto a = std::make_shared<SimulateArguments>();
    CLI::App *c = app.add_subcommand("simulate", "Let hair move, and write its frames.");
    c->add_option("recipe", a->recipe, "the hair and what moves it, in the scene language's syntax")
        ->type_name("FILE");
    c->add_option(
         "-o,--output", a->output,
         "where to write: frames/%04d.hair (a file for each frame) or a .usda file with time samples")
        ->type_name("FILE");
    c->add_flag("--manual", a->manual, "print every statement of a recipe and its parameters, in Markdown");
    c->add_option("--threads", a->threads, "how many threads to use; 0: all [0]")->check(CLI::Range(0, 4096));
    c->add_flag("-q,--quiet", a->quiet, "print nothing but errors and warnings");
    c->footer("A recipe, as small as may be:\n"
              "  Hair \"groom\" \"string style\" \"wavy\" \"integer strands\" 5000\n"
              "  Obstacle \"head\"\n"
              "  Motion \"keys\" \"float time\" [0 0.4 0.8] \"vector3 turn\" [0 0 0  0 40 0  0 0 0]\n"
              "Frame 0 is the groom as it is. The frames are the same for any number of threads. Ctrl-C ends "
              "after the\n"
              "frame under way and keeps all frames that are done; so do SIGTERM, SIGHUP and SIGXCPU (exit "
              "status 128 and\n"
              "the signal's number).\n"
              "Example: cuticle simulate shake.recipe -o frames/%04d.hair");
    c->callback([a] { RunSimulate(*a); });
}

} // namespace cuticle
