// cuticle groom: strands of hair, made or read, written as scene geometry.
#include "cli/commands.h"
#include "core/error.h"
#include "files/file.h"
#include "grooms/groom_file.h"
#include "grooms/hair_file.h"
#include "grooms/pbrt_writer.h"
#include "grooms/procedural.h"

#include <algorithm>
#include <iostream>
#include <map>
#include <optional>

namespace cuticle {

namespace {

struct GroomArguments {
    std::string kind, style, input, output, mesh;
    std::map<std::string, std::string> values, colorValues; // groom parameters that were given
    PbrtCurveOptions curves;
    std::string spline, colors;
    float width = 0;
    size_t pointsPerStrand = 0;
    std::optional<double> time;
    bool skin = false, quiet = false;
};

enum class StrandOutput { Pbrt, Hair };

StrandOutput FormatOf(const std::string &filename) {
    if (filename.ends_with(".pbrt") || filename.ends_with(".pbrt.gz"))
        return StrandOutput::Pbrt;
    if (filename.ends_with(".hair"))
        return StrandOutput::Hair;
    throw Error("the output's name \"{}\" must end in .pbrt, .pbrt.gz or .hair", filename);
}

std::string OptionName(std::string_view parameter) {
    std::string name = "--" + std::string(parameter);
    std::replace(name.begin(), name.end(), '_', '-');
    return name;
}

void Report(const GroomArguments &a, const PbrtCurveCounts &counts, uint64_t bytes) {
    if (a.quiet)
        return;
    std::cout << a.output << ": " << counts.strands << " strands, " << counts.segments << " segments in "
              << counts.statements << " Shape statements";
    if (counts.materials > 0)
        std::cout << ", " << counts.materials << " materials";
    std::cout << ", " << bytes << " bytes of text\n";
}

// Says what a reader of the file wants to know; the numbers make the same groom again. params: null for a
// file's strands.
std::string HeaderComment(const GroomArguments &a, const GroomParams *params) {
    std::string text = "# Hair as pbrt-v3 curves, written by cuticle groom";
    if (params == nullptr)
        return text + " from a file of strands, in that file's units.\n";
    text += " " + a.kind + (a.kind == "head" ? " --style " + params->style : "");
    for (const GroomParamInfo &info : GroomParamTable())
        if (GroomReads(params->kind, info)) {
            const std::string value = CLI::detail::to_string(GetGroomParam(*params, info.name));
            text += " " + OptionName(info.name) + " " + value;
        }
    for (const auto &[name, value] : a.colorValues)
        text += " " + OptionName(name) + " " + value;
    text += a.kind == "head"
                ? "\n# Units: cm; y up, the face looks along +z, the origin lies between the ears.\n"
                : "\n";
    return text;
}

void RunProcedural(const GroomArguments &a) {
    const StrandOutput format = FormatOf(a.output);
    GroomParams params = MakeGroomParams(a.kind, a.style);
    for (const auto &[name, value] : a.values)
        SetGroomParam(&params, name, value);
    for (const auto &[name, value] : a.colorValues)
        SetGroomColor(&params, name, value);
    if (!a.mesh.empty() && !a.mesh.ends_with(".ply"))
        throw Error("the mesh's name \"{}\" must end in .ply", a.mesh);
    const std::unique_ptr<StrandSource> source = MakeStrandSource(params);
    if (!a.mesh.empty())
        WritePly(a.mesh, MakeHeadMesh());

    if (format == StrandOutput::Hair) {
        if (a.skin)
            throw Error("a .hair file holds no skin; leave out --skin or write .pbrt");
        const Groom groom = source->Range(0, source->StrandCount());
        WriteHairFile(a.output, groom);
        if (!a.quiet)
            std::cout << a.output << ": " << groom.StrandCount() << " strands, " << groom.points.size()
                      << " points\n";
        return;
    }
    OutputFile out(a.output);
    out.Write(HeaderComment(a, &params));
    if (a.skin) {
        out.Write("AttributeBegin\nMaterial \"matte\" \"rgb Kd\" [0.6 0.4 0.3]\n");
        if (a.kind == "head")
            WritePbrtMesh(MakeHeadMesh(), &out);
        else
            out.Write("Shape \"sphere\" \"float radius\" " + CLI::detail::to_string(params.radius) + "\n");
        out.Write("AttributeEnd\n");
    }
    PbrtCurveOptions curves = a.curves;
    curves.colors = source->HasColors();
    PbrtCurveCounts counts;
    constexpr size_t kBatch = 16384; // so that memory stays small whatever the number of strands
    for (size_t begin = 0; begin < source->StrandCount(); begin += kBatch)
        WritePbrtCurves(source->Range(begin, begin + kBatch), curves, &out, &counts);
    const uint64_t bytes = out.BytesWritten();
    out.Commit();
    Report(a, counts, bytes);
}

// Says what is done with the colours of a file that has them.
void ReportColors(const GroomArguments &a, bool dropped, const PbrtCurveCounts &counts) {
    if (a.quiet)
        return;
    if (dropped)
        std::cout << a.input << ": the strands' colours are left out; "
                  << (a.colors.empty()
                          ? "the scene's Material holds, and --colors keep writes one for each colour\n"
                          : "as --colors ignore asks\n");
    else if (counts.materials > 0)
        std::cout << a.input
                  << ": each colour is written as a Material \"hair\" of its own, which stands in place "
                     "of the scene's\n";
}

void RunFrom(GroomArguments a) {
    const StrandOutput format = FormatOf(a.output);
    Groom groom = ReadGroomFile(a.input, {a.width, a.pointsPerStrand, a.time});
    // Colours become materials only where they are asked for: those would stand in place of the user's own
    const bool writesMaterials = format == StrandOutput::Pbrt && a.colors == "keep";
    const bool dropsColors =
        groom.hasColor && !writesMaterials && (format == StrandOutput::Pbrt || a.colors == "ignore");
    if (dropsColors) {
        groom.pointColors.clear();
        groom.hasColor = false;
    }
    if (!a.spline.empty() && groom.spline == StrandSpline::Bezier)
        throw Error("{}: the file's curves are cubic; --spline is for files of points", a.input);
    a.curves.segments.spline = StrandSplineByName(a.spline);
    a.curves.colors = writesMaterials;
    if (format == StrandOutput::Hair) {
        groom = PointsOnCurves(WithoutPlacements(std::move(groom), a.input));
        groom.width *= a.curves.widthScale;
        for (float &w : groom.pointWidths)
            w *= a.curves.widthScale;
        for (auto &widths : groom.strandWidths)
            for (float &w : widths)
                w *= a.curves.widthScale;
        WriteHairFile(a.output, groom);
        if (!a.quiet)
            std::cout << a.output << ": " << groom.StrandCount() << " strands, " << groom.points.size()
                      << " points\n";
        ReportColors(a, dropsColors, {});
        return;
    }
    OutputFile out(a.output);
    out.Write(HeaderComment(a, nullptr));
    PbrtCurveCounts counts;
    WritePbrtCurves(groom, a.curves, &out, &counts);
    const uint64_t bytes = out.BytesWritten();
    out.Commit();
    Report(a, counts, bytes);
    ReportColors(a, dropsColors, counts);
}

void AddOutputOptions(CLI::App &command, const std::shared_ptr<GroomArguments> &a) {
    command
        .add_option("-o,--output", a->output,
                    "where to write: .pbrt, .pbrt.gz (Shape \"curve\" statements to Include) or .hair")
        ->required()
        ->type_name("FILE");
    command.add_option("--curve-type", a->curves.curveType, "the curves' type")
        ->check(CLI::IsMember({"cylinder", "flat"}))
        ->capture_default_str();
    command.add_flag("--per-segment", a->curves.perSegment,
                     "one Shape statement for each Bezier segment instead of one for each strand");
    command.add_flag("-q,--quiet", a->quiet, "print nothing but errors");
}

void AddProceduralCommand(CLI::App &groom, const std::string &kind, const std::string &about,
                          const std::string &example) {
    CLI::App *command = groom.add_subcommand(kind, about);
    auto a = std::make_shared<GroomArguments>();
    a->kind = kind;
    AddOutputOptions(*command, a);
    if (kind == "head") {
        std::vector<std::string> styles(HeadStyles().begin(), HeadStyles().end());
        a->style = styles[0];
        command->add_option("--style", a->style, "how the hair falls; sets the defaults of what follows")
            ->check(CLI::IsMember(styles))
            ->capture_default_str();
        command->add_option("--mesh", a->mesh, "also write the head and shoulders as a PLY mesh with normals")
            ->type_name("FILE.ply");
    }
    if (kind == "head" || kind == "fur-ball")
        command->add_flag("--skin", a->skin,
                          "put the skin under the hair into the .pbrt file, with a matte material");
    // The table of parameters is the one that scene files use.
    for (const GroomParamInfo &info : GroomParamTable()) {
        if (!GroomReads(kind, info))
            continue;
        const double usual = GetGroomParam(MakeGroomParams(kind), info.name);
        std::string defaults = CLI::detail::to_string(usual);
        if (kind == "head")
            for (const std::string_view style : HeadStyles())
                if (const double own = GetGroomParam(MakeGroomParams(kind, style), info.name); own != usual)
                    defaults += fmt::format(", {} {:g}", style, own);
        const bool whole = std::holds_alternative<int GroomParams::*>(info.member);
        command
            ->add_option_function<std::string>(
                OptionName(info.name),
                [a, name = std::string(info.name)](const std::string &v) { a->values[name] = v; },
                std::string(info.help) + " [" + defaults + "]")
            ->type_name(whole ? "INT" : "FLOAT");
    }
    for (const GroomColorInfo &info : GroomColorTable())
        command
            ->add_option_function<std::string>(
                OptionName(info.name),
                [a, name = std::string(info.name)](const std::string &v) { a->colorValues[name] = v; },
                std::string(info.help))
            ->type_name("R,G,B");
    command->footer("Example: " + example);
    command->callback([a] { RunProcedural(*a); });
}

void AddFromCommand(CLI::App &groom) {
    CLI::App *command = groom.add_subcommand("from", "Read strands from a .hair, .tfx, .usda or .ply file");
    auto a = std::make_shared<GroomArguments>();
    command
        ->add_option("input", a->input,
                     "the strands: .hair (Cem Yuksel), .tfx (TressFX 4), .usda (USD's BasisCurves as text) "
                     "or .ply (points "
                     "only), told apart by what they begin with")
        ->required()
        ->type_name("FILE");
    AddOutputOptions(*command, a);
    command
        ->add_option(
            "--spline", a->spline,
            "how points are joined: smoothly through them, more smoothly beside them, straight [catmull-rom, "
            "or what a .usda file says]")
        ->check(CLI::IsMember(std::vector<std::string>(kStrandSplines.begin(), kStrandSplines.end())));
    command
        ->add_option("--segments", a->curves.segments.segmentsPerStrand,
                     "resample each strand to so many segments of equal length; 0: one per pair of points")
        ->check(CLI::Range(0, 10000))
        ->capture_default_str();
    command
        ->add_option("--width", a->width,
                     "diameter of all hairs, instead of the file's widths (the file's units)")
        ->check(CLI::PositiveNumber);
    command
        ->add_option("--points-per-strand", a->pointsPerStrand,
                     "points of a .ply file that make a strand [100]")
        ->check(CLI::Range(2, 1000000));
    command->add_option("--time", a->time,
                        "time code of a .usda file's samples: the last that is no later [the first]");
    command->add_option("--width-scale", a->curves.widthScale, "factor on all widths")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command
        ->add_option(
            "--colors", a->colors,
            "keep: a hair material for each colour (each strand's mean), in place of the scene's; ignore: "
            "the scene's Material holds [ignore, and keep into a .hair file]")
        ->check(CLI::IsMember({"keep", "ignore"}));
    command
        ->add_option("--color-levels", a->curves.colorLevels,
                     "steps per channel when there are more than 256 colours")
        ->check(CLI::Range(2, 1024))
        ->capture_default_str();
    command->add_option("--beta-m", a->curves.betaM, "longitudinal roughness of these materials")
        ->check(CLI::Range(0., 1.))
        ->capture_default_str();
    command->add_option("--beta-n", a->curves.betaN, "azimuthal roughness of these materials")
        ->check(CLI::Range(0., 1.))
        ->capture_default_str();
    command->footer("Example: cuticle groom from straight.hair --width-scale 2 -o straight.pbrt.gz");
    command->callback([a] { RunFrom(*a); });
}

} // namespace

void AddGroomCommand(CLI::App &app) {
    CLI::App *groom = app.add_subcommand("groom", "Make hair, or read it, and write it as scene geometry");
    groom->require_subcommand(1);
    groom->add_flag_callback(
        "--list",
        [groom] {
            for (const HeadStyleInfo &style : HeadStyleTable())
                std::cout << fmt::format("head --style {:<12} {}\n", style.name, style.help);
            for (const CLI::App *kind : groom->get_subcommands([](const CLI::App *) { return true; }))
                if (kind->get_name() != "head" && kind->get_name() != "from")
                    std::cout << fmt::format("{:<25} {}\n", kind->get_name(), kind->get_description());
            throw CLI::Success();
        },
        "list the styles of a head and the kinds of groom, and stop");
    groom->footer(
        "The output is geometry without camera and lights: a scene takes it in by Include \"FILE.pbrt.gz\"\n"
        "after its Material \"hair\". Scenes that only Cuticle reads can name a groom directly instead:\n"
        "  Shape \"groom\" \"string style\" \"curly\" \"integer strands\" 30000\n"
        "  Shape \"hairfile\" \"string filename\" \"straight.hair\" # or .tfx, .usda, .ply\n"
        "Examples:\n"
        "  cuticle groom head --style curly --strands 50000 --seed 1 -o head.pbrt.gz\n"
        "  cuticle groom from straight.hair -o straight.pbrt.gz");
    AddProceduralCommand(
        *groom, "head", "A head of hair, in one of the styles of --list",
        "cuticle groom head --style wavy --strands 30000 --width-scale 2 --skin -o wavy.pbrt.gz");
    AddProceduralCommand(*groom, "fur-ball", "A ball of fur",
                         "cuticle groom fur-ball --strands 100000 --skin -o fur.pbrt.gz");
    AddProceduralCommand(*groom, "hair-cube", "Straight parallel hairs that fill a cube",
                         "cuticle groom hair-cube --strands 10000 -o cube.pbrt");
    AddProceduralCommand(*groom, "ball", "A ball of random curved strands, for measurements",
                         "cuticle groom ball --strands 50000 --segments 8 -o ball.pbrt.gz");
    AddFromCommand(*groom);
}

} // namespace cuticle
