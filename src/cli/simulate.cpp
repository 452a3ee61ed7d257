// cuticle simulate: hair that moves, written frame by frame.
#include "cli/commands.h"
#include "cli/stops.h"
#include "cli/terminal_progress.h"
#include "core/clock.h"
#include "core/error.h"
#include "core/isa.h"
#include "core/parallel.h"
#include "dynamics/recipe.h"
#include "dynamics/velocity_grid.h"
#include "files/file.h"
#include "files/frame_names.h"
#include "files/inputs.h"
#include "grooms/hair_file.h"
#include "grooms/usd_writer.h"
#include "volume/density.h"
#include "volume/vdb_file.h"

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
    std::string recipe, output, head, vdb;
    float cell = 1;     // cm, of volumes
    size_t threads = 0; // 0: all
    bool manual = false, quiet = false, keys = false, resume = false;
};

// Keeps the state of a simulation that was stopped beside its frames, and reads it again. A state belongs to
// what it was made from: recipe and files, program, kernels.
class StateFile {
  public:
    // frames: the name of any frame; `inputs` has all files that were read.
    StateFile(const std::string &frames, const InputLog &inputs, const SimulateArguments &a)
        : name_((std::filesystem::path(frames).parent_path() / "simulation.part").string()),
          made_(fmt::format("cuticle simulate {} {} {}\n", CUTICLE_VERSION, IsaName(ChooseIsa()),
                            inputs.Digest(std::filesystem::path(a.recipe).parent_path().string()))) {}
    void Write(const HairSimulation &simulation) const {
        WriteFileAtomically(name_, made_ + simulation.State());
    }
    // Whether there is one, which is then the simulation's. Throws Error for that of another.
    bool Read(HairSimulation *simulation) const {
        if (!std::filesystem::exists(name_))
            return false;
        const InputScope unnoted(nullptr);
        const std::string bytes = ReadFile(name_, "the state of the simulation");
        if (!bytes.starts_with(made_) || !simulation->SetState(std::string_view(bytes).substr(made_.size())))
            throw Error("\"{}\" was left by another recipe, by other hair, or on another processor", name_)
                .WithRemedy("remove it to begin anew");
        return true;
    }
    void Remove() const {
        std::error_code ignored;
        std::filesystem::remove(name_, ignored);
    }
    const std::string &Name() const { return name_; }

  private:
    std::string name_, made_;
};

// The place of a head as a statement of scenes.
std::string TransformText(const Pose &pose) {
    std::string text =
        "# where the head stands in this frame: for Include before Shape \"groomhead\"\nConcatTransform [";
    for (const Vector3d &column : {pose.x, pose.y, pose.z})
        text += fmt::format("{} {} {} 0  ", column.x, column.y, column.z);
    return text + fmt::format("{} {} {} 1]\n", pose.origin.x, pose.origin.y, pose.origin.z);
}

// Writes hair as a volume: its density, and the velocity of the key hairs where there is some.
void WriteFrameVolume(const std::string &name, const HairSimulation &simulation, const Groom &hair,
                      float cell) {
    constexpr size_t kPasses = 2; // of smoothing
    const StrandSet strands = CurvesOf(hair);
    const GridBox box = BoxAround(BoundsOf(strands), cell, kPasses + 3);
    const DenseGrid<float> density = Smoothed(LineDensity(strands, box), kPasses);
    const KeyStrands &keys = simulation.Keys();
    std::vector<Vector3d> points, velocities;
    std::vector<double> masses;
    for (size_t s = 0; s < keys.StrandCount(); ++s)
        for (size_t i = 0; i < keys.PointCount(); ++i) {
            points.push_back(keys.Position(s, i)), velocities.push_back(keys.Velocity(s, i));
            masses.push_back(keys.Mass(s, i));
        }
    VelocityGrid around(points, masses, velocities, std::max(1.5, static_cast<double>(cell)));
    around.Smooth(1);
    DenseGrid<Vector3f> velocity(box);
    for (size_t k = 0, n = 0; k < box.size[2]; ++k)
        for (size_t j = 0; j < box.size[1]; ++j)
            for (size_t i = 0; i < box.size[0]; ++i, ++n)
                if (density.values[n] > 0)
                    velocity.values[n] = Vector3f(around.At(Vector3d(box.Position(i, j, k)), {}));
    WriteVdb(name,
             {{"density", VdbField::Kind::Fog, &density}, {"velocity", VdbField::Kind::Plain, &velocity}});
}

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
    // The names of the frames; null for one file.
    const FrameNames *Names() const { return names_ ? &*names_ : nullptr; }
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
               const StepReport &worst, double cpuOfAFrame) {
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
        simulation.Substeps(), 1000 * cpuOfAFrame, worst.stretch, worst.penetration);
}

void RunSimulate(const SimulateArguments &a) {
    if (a.manual) {
        std::cout << SimulationManual();
        return;
    }
    if (a.recipe.empty() || a.output.empty())
        throw Error("a simulation needs a recipe and -o OUTPUT")
            .WithRemedy("cuticle simulate --help shows how");
    InputLog inputs;
    const InputScope noted(&inputs);
    SimulationRecipe recipe = ReadSimulationRecipe(a.recipe);
    const size_t frames = recipe.FrameCount();
    FrameOutput output(a.output, recipe.settings.framesPerSecond);
    std::optional<FrameNames> heads, volumes;
    if (!a.head.empty())
        heads.emplace(a.head, "head's", "frames/head-%04d.pbrt");
    if (!a.vdb.empty() && !a.vdb.ends_with(".vdb"))
        throw Error("the volume's name \"{}\" must end in .vdb", a.vdb)
            .WithRemedy("write to frames/%04d.vdb");
    if (!a.vdb.empty())
        volumes.emplace(a.vdb, "volume's", "frames/%04d.vdb");
    for (const std::string &name : {a.head, a.vdb})
        if (const auto folder = std::filesystem::path(name).parent_path(); !folder.empty())
            MakeFolder(folder.string());
    std::optional<StateFile> state;
    if (output.Names() != nullptr)
        state.emplace(output.Names()->Of(0), inputs, a);
    else if (a.resume)
        throw Error("--resume goes on with files of frames, and \"{}\" is one file for all", a.output)
            .WithRemedy("write to frames/%04d.hair");
    CatchStops();
    OnThreads(a.threads, [&] {
        HairSimulation simulation(std::move(recipe.groom), std::move(recipe.obstacle), recipe.settings);
        const auto write = [&] {
            const Groom hair = a.keys ? simulation.KeyFrame() : simulation.Frame();
            output.Add(simulation.FrameNumber(), hair);
            if (volumes)
                WriteFrameVolume(volumes->Of(simulation.FrameNumber()), simulation, hair, a.cell);
            if (heads)
                WriteFileAtomically(heads->Of(simulation.FrameNumber()),
                                    TransformText(simulation.HeadPose()));
        };
        StepReport worst;
        double cpu = 0;
        size_t made = 0;
        {
            TerminalProgress progress("Simulating");
            if (!(a.resume && state->Read(&simulation)))
                write();
            while (simulation.FrameNumber() + 1 < frames && !StopAsked()) {
                const double start = ProcessCpuSeconds();
                worst.Join(simulation.NextFrame());
                cpu += ProcessCpuSeconds() - start;
                ++made;
                write();
                progress.Report(simulation.FrameNumber() + 1, frames);
            }
            output.Finish();
        }
        const size_t done = simulation.FrameNumber() + 1;
        Summarise(a, simulation, done, worst, cpu / static_cast<double>(std::max<size_t>(made, 1)));
        if (done < frames) {
            if (state)
                state->Write(simulation);
            std::cerr << fmt::format("stopped after {} of {} frames, which are kept{}\n", done, frames,
                                     state ? "; --resume goes on from " + state->Name() : "");
            throw ExitStatus{StopStatus()};
        }
        if (state)
            state->Remove();
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
    c->add_option("--head", a->head,
                  "also write where the head stands, for a scene's Include: frames/head-%04d.pbrt")
        ->type_name("FILE");
    c->add_option("--vdb", a->vdb,
                  "also write volumes with density and velocity (cm/s), for other programs: frames/%04d.vdb")
        ->type_name("FILE");
    c->add_option("--cell", a->cell, "side of a volume's cell, cm [1]")->check(CLI::Range(0.01f, 100.f));
    c->add_flag("--keys", a->keys, "write the key hairs alone, which are simulated, not those that follow");
    c->add_flag("--resume", a->resume, "go on where a stopped simulation left its state, beside its frames");
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
