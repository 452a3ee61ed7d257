// cuticle volume: strands of hair as one body, its density and its shell, for other programs and for the eye.
#include "cli/commands.h"
#include "core/clock.h"
#include "core/error.h"
#include "core/memory_budget.h"
#include "files/file.h"
#include "grooms/groom_file.h"
#include "images/image.h"
#include "volume/density.h"
#include "volume/shell.h"
#include "volume/slices.h"
#include "volume/vdb_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

namespace cuticle {

namespace {

struct VolumeArguments {
    std::string input, density = "lines";
    std::vector<std::string> outputs;
    GroomFileOptions file;
    int resolution = 96;
    size_t smoothing = 2, sliceScale = 4;
    std::optional<float> cell, iso;
    bool json = false, quiet = false;
};

// The volume and what is told of it. Times are seconds of the wall.
struct HairVolume {
    size_t strands = 0;
    StrandTotals totals;
    DenseGrid<float> density; // smoothed
    double mass = 0;          // of the strands' density on the grid
    HairShell shell;
    double readTime = 0, densityTime = 0, shellTime = 0, writeTime = 0;
    size_t Bytes() const { return density.Bytes() + shell.distance.Bytes(); }
};

void CheckOutputs(const std::vector<std::string> &outputs) {
    for (const std::string &name : outputs) {
        if (!name.ends_with(".vdb") && !name.ends_with(".ply") && !name.ends_with(".png"))
            throw Error(
                "the output's name \"{}\" must end in .vdb (density and distance), .ply (the shell) or "
                ".png (two cuts through the distance)",
                name);
        const OutputFile canBeWritten(name); // whatever cannot be written is found before the work
    }
}

// Runs f and returns the seconds that it took.
template <class F>
double Timed(const F &f) {
    const double start = WallSeconds();
    f();
    return WallSeconds() - start;
}

HairVolume MakeVolume(const VolumeArguments &a) {
    HairVolume v;
    Groom groom;
    v.readTime = Timed([&] { groom = WithoutPlacements(ReadGroomFile(a.input, a.file), a.input); });
    const bool lines = a.density == "lines";
    const StrandSet strands = lines ? CurvesOf(groom) : ControlPoints(groom);
    v.strands = groom.StrandCount();
    v.densityTime = Timed([&] {
        const Bounds3f bounds = BoundsOf(strands);
        const Vector3f d = bounds.Diagonal();
        const float cell = a.cell ? *a.cell : std::max({d.x, d.y, d.z}) / static_cast<float>(a.resolution);
        if (!(cell > 0))
            throw Error("{}: all points of the strands are one", a.input)
                .WithRemedy("give the side of a cell, --cell");
        v.totals = TotalsOf(strands);
        const GridBox box = BoxAround(bounds, cell, a.smoothing + 3);
        v.density = lines ? LineDensity(strands, box) : VertexDensity(strands, box);
        v.mass = Mass(v.density) * (lines ? 1 : std::pow(static_cast<double>(cell), -3));
        v.density = Smoothed(std::move(v.density), a.smoothing);
    });
    v.shellTime =
        Timed([&] { v.shell = MakeShell(v.density, a.iso ? *a.iso : MedianDensity(v.density) / 2); });
    return v;
}

// Cuts through the middle, from the side and from the front.
Image Slices(const HairVolume &v, size_t scale) {
    const GridBox &box = v.density.box;
    const Point3f middle =
        box.Position(box.size[0] - 1, box.size[1] - 1, box.size[2] - 1) * 0.5f + box.origin * 0.5f;
    const float step = 4 * box.cell;
    const SlicePicture both = SideBySide({CutDistance(v.shell.distance, middle, 2, scale, step),
                                          CutDistance(v.shell.distance, middle, 0, scale, step)},
                                         4 * scale);
    Image image(static_cast<int>(both.width), static_cast<int>(both.height), {"R", "G", "B"});
    for (size_t i = 0; i < both.colors.size(); ++i)
        for (int c = 0; c < 3; ++c)
            image.data[3 * i + static_cast<size_t>(c)] = both.colors[i][c];
    return image;
}

void WriteOutputs(const VolumeArguments &a, const HairVolume &v) {
    for (const std::string &name : a.outputs)
        if (name.ends_with(".vdb"))
            WriteVdb(name, {{"density", VdbField::Kind::Fog, &v.density},
                            {"distance", VdbField::Kind::Distance, &v.shell.distance}});
        else if (name.ends_with(".ply"))
            WritePly(name, v.shell.mesh);
        else
            WriteImage(name, Slices(v, a.sliceScale));
}

void PrintText(const VolumeArguments &a, const HairVolume &v) {
    const GridBox &box = v.density.box;
    fmt::print("{}: {} strands, {} points, {:.6g} long in all, fibers of a volume of {:.6g}\n", a.input,
               v.strands, v.totals.points, v.totals.length, v.totals.volume);
    fmt::print("grid: {} x {} x {} vertices, cells of {:.6g}, {}\n", box.size[0], box.size[1], box.size[2],
               box.cell, ByteSizeText(v.Bytes()));
    fmt::print("density of {}: mass {:.6g}, half of it denser than {:.6g}\n", a.density, v.mass,
               MedianDensity(v.density));
    fmt::print("shell: at a density of {:.6g}, {} triangles around a volume of {:.6g}\n", v.shell.iso,
               v.shell.mesh.indices.size() / 3, v.shell.Volume());
    fmt::print("time: {:.2f} s to read, {:.2f} s density, {:.2f} s shell, {:.2f} s to write\n", v.readTime,
               v.densityTime, v.shellTime, v.writeTime);
    for (const std::string &name : a.outputs)
        fmt::print("wrote {}\n", name);
}

void PrintJSON(const VolumeArguments &a, const HairVolume &v) {
    const GridBox &box = v.density.box;
    nlohmann::ordered_json json;
    json["input"] = a.input, json["strands"] = v.strands, json["points"] = v.totals.points;
    json["length"] = v.totals.length, json["fiber_volume"] = v.totals.volume;
    json["resolution"] = {box.size[0], box.size[1], box.size[2]}, json["cell"] = box.cell;
    json["origin"] = {box.origin.x, box.origin.y, box.origin.z}, json["bytes"] = v.Bytes();
    json["density"] = a.density, json["smoothing"] = a.smoothing, json["mass"] = v.mass;
    json["median_density"] = MedianDensity(v.density), json["iso"] = v.shell.iso;
    json["triangles"] = v.shell.mesh.indices.size() / 3, json["shell_volume"] = v.shell.Volume();
    json["seconds"] = {
        {"read", v.readTime}, {"density", v.densityTime}, {"shell", v.shellTime}, {"write", v.writeTime}};
    json["outputs"] = a.outputs;
    std::cout << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
}

void RunVolume(const VolumeArguments &a) {
    CheckOutputs(a.outputs);
    HairVolume v = MakeVolume(a);
    v.writeTime = Timed([&] { WriteOutputs(a, v); });
    if (a.json)
        PrintJSON(a, v);
    else if (!a.quiet)
        PrintText(a, v);
}

} // namespace

void AddVolumeCommand(CLI::App &app) {
    CLI::App *c = app.add_subcommand("volume", "Make one body of strands: its density, its shell, distances");
    auto a = std::make_shared<VolumeArguments>();
    c->add_option("groom", a->input, "the strands: a .hair, .tfx, .usda or .ply file")
        ->required()
        ->type_name("FILE");
    c->add_option(
         "-o,--output", a->outputs,
         "what to write, by the ending: .vdb (OpenVDB: density and distance), .ply (the shell), .png "
         "(two cuts through the distance); may be repeated")
        ->type_name("FILE");
    c->add_option(
         "--density", a->density,
         "lines: the share of space that fibers fill, whatever their points; vertices: the number of "
         "control points, as in Petrovic's paper")
        ->check(CLI::IsMember({"lines", "vertices"}))
        ->capture_default_str();
    CLI::Option *resolution =
        c->add_option("--resolution", a->resolution, "cells along the longest side of the hair")
            ->check(CLI::Range(1, 4096))
            ->capture_default_str();
    c->add_option("--cell", a->cell, "instead: the side of a cell, in the file's units")
        ->check(CLI::PositiveNumber)
        ->excludes(resolution);
    c->add_option("--smooth", a->smoothing,
                  "how often the density is smoothed over neighbouring cells; 0 as in the paper")
        ->check(CLI::Range(0, 100))
        ->capture_default_str();
    c->add_option("--iso", a->iso,
                  "density on the shell [half of the density that half of the hair is denser than]")
        ->check(CLI::PositiveNumber);
    c->add_option("--width", a->file.width, "diameter of all hairs, instead of the file's widths")
        ->check(CLI::PositiveNumber);
    c->add_option("--points-per-strand", a->file.pointsPerStrand,
                  "points of a .ply file that make a strand [100]")
        ->check(CLI::Range(2, 1000000));
    c->add_option("--slice-scale", a->sliceScale, "pixels of a .png for each cell")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    c->add_flag("--json", a->json, "print what was measured as JSON");
    c->add_flag("-q,--quiet", a->quiet, "print nothing but errors");
    c->footer("Lengths are in the file's units. The distance is negative inside of the hair.\n"
              "Example: cuticle volume straight.hair -o hair.vdb -o shell.ply -o slices.png");
    c->callback([a] { RunVolume(*a); });
}

} // namespace cuticle
