// cuticle figure and cuticle chart: make the papers' figures, and chart our own measurements.
#include "cli/commands.h"
#include "cli/terminal_progress.h"
#include "core/error.h"
#include "figures/charts/chart_table.h"
#include "figures/papers/figure_table.h"

#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

namespace cuticle {

namespace {

constexpr const char *kFolderHolds = "the option takes a folder, which gets NAME.csv, NAME.svg and NAME.png";

struct FigureArguments {
    std::vector<std::string> names;
    std::string folder = ".";
    std::string quality = "paper";
    bool list = false, all = false, quiet = false;
    FigureOptions options;
    std::vector<std::string> peers;
};

void ListFigures() {
    for (const Figure &f : Figures()) {
        std::printf("%-18s %-10s %-9s %s\n", f.id, ToString(f.kind).c_str(), f.Made() ? "made" : "not made",
                    f.caption);
        if (*f.scenes != '\0')
            std::printf("%-39s scenes: %s\n", "", f.scenes);
    }
}
void ListCharts() {
    for (const Chart &c : Charts())
        std::printf("%-12s %s\n", c.name, c.caption);
}

// Writes the files of a figure or chart, says which, and what was checked; returns whether all laws hold.
bool Deliver(const std::string &stem, const std::string &caption, const FigureData &data,
             const FigureArguments &a) {
    WriteFigure(a.folder, stem, caption, data);
    if (!a.quiet) {
        std::cout << "wrote " << a.folder << "/" << stem << ".csv, .svg, .png";
        for (const FigurePicture &picture : data.pictures)
            std::cout << ", " << picture.name << ".exr" << (picture.name == stem ? "" : ", .png");
        std::cout << "\n";
    }
    bool all = true;
    for (const FigureCheck &c : data.checks) {
        if (!a.quiet || !c.Holds())
            std::printf("  %s %s %.6g, asked for %.6g to %.6g\n",
                        c.Holds() ? "holds: " : "BROKEN:", c.law.c_str(), c.value, c.low, c.high);
        all = all && c.Holds();
    }
    std::fflush(stdout);
    return all;
}

Peer ParsePeer(const std::string &text) {
    const size_t equals = text.find('=');
    Peer peer{text.substr(0, equals), equals == std::string::npos ? "" : text.substr(equals + 1)};
    for (const char *word : {"{scene}", "{out}"})
        if (peer.name.empty() || peer.command.find(word) == std::string::npos)
            throw Error("--peer \"{}\" must be NAME=COMMAND with {{scene}} and {{out}} in the command", text);
    return peer;
}

void RunFigures(FigureArguments &a) {
    if (a.list)
        return ListFigures();
    CheckFolderName(a.folder, kFolderHolds);
    a.options.quick = a.quality == "draft";
    std::vector<const Figure *> figures;
    for (const std::string &id : a.names)
        figures.push_back(&FindFigure(id));
    for (const Figure &figure : Figures())
        if (a.all && figure.Made())
            figures.push_back(&figure);
    bool all = true;
    for (const Figure *figure : figures) {
        std::optional<TerminalProgress> progress;
        if (!a.quiet)
            a.options.progress = &progress.emplace();
        const FigureData data = MakeFigure(*figure, a.options);
        progress.reset();
        all = Deliver(figure->id, figure->caption, data, a) && all;
    }
    if (!all)
        throw ExitStatus{1};
}

void RunCharts(FigureArguments &a) {
    if (a.list)
        return ListCharts();
    CheckFolderName(a.folder, kFolderHolds);
    for (const std::string &peer : a.peers)
        a.options.peers.push_back(ParsePeer(peer));
    bool all = true;
    for (const std::string &name : a.names) {
        const Chart &chart = FindChart(name);
        all = Deliver(chart.name, chart.caption, chart.make(a.options), a) && all;
    }
    if (!all)
        throw ExitStatus{1};
}

// Adds what the two commands share. Names or --list must be given, one of them.
CLI::App *AddCommand(CLI::App &app, const char *name, const char *what, const char *names,
                     FigureArguments *a) {
    CLI::App *c = app.add_subcommand(name, what);
    CLI::Option *which = c->add_option(names, a->names, "which to make; --list shows all");
    c->add_option("-o,--output", a->folder, "folder for NAME.csv, NAME.svg and NAME.png (default: this one)")
        ->type_name("DIR");
    CLI::Option *list = c->add_flag("--list", a->list, "list all of them");
    list->excludes(which);
    c->add_option("--scenes", a->options.scenes, "folder of the shipped scenes (default: scenes)")
        ->type_name("DIR");
    c->add_flag("-q,--quiet", a->quiet, "print nothing but errors and broken laws");
    c->parse_complete_callback([c, a] {
        if (a->names.empty() && !a->list && !a->all)
            throw CLI::RequiredError(c->get_name() + ": the name of one, or --list,");
    });
    return c;
}

} // namespace

void AddFigureCommand(CLI::App &app) {
    auto a = std::make_shared<FigureArguments>();
    CLI::App *c = AddCommand(app, "figure", "Make figures of the papers, and check them.", "ID", a.get());
    c->add_flag("--all", a->all, "make every figure that can be made")->excludes("ID")->excludes("--list");
    c->add_option("--quality", a->quality,
                  "draft: coarser grids, pictures of a quarter of the size; paper: all (default)")
        ->check(CLI::IsMember({"draft", "paper"}))
        ->type_name("Q");
    c->add_option("--pictures", a->options.pictures,
                  "folder of NAME.exr that were rendered before; they are measured, and nothing is rendered")
        ->type_name("DIR");
    c->footer("Every figure carries laws that its own numbers must satisfy; they are printed, and a broken "
              "one makes the\n"
              "exit status 1. gnuplot draws. A figure that is rendered also leaves each of its pictures, as "
              "EXR and PNG.\n"
              "Example: cuticle figure deon-03 pharr-1.17 -o figures");
    c->callback([a] { RunFigures(*a); });
}

void AddChartCommand(CLI::App &app) {
    auto a = std::make_shared<FigureArguments>();
    CLI::App *c = AddCommand(app, "chart", "Measure error against cost, and chart it.", "NAME", a.get());
    c->add_flag("--quick", a->options.quick, "fewer samples and coarser grids, for a first look");
    c->add_option("--peer", a->peers,
                  "another renderer on the chart \"render\": NAME='COMMAND {scene} {out}', run by sh")
        ->type_name("NAME=COMMAND")
        ->take_all();
    c->footer("All numbers are measured in the run that draws them, repetitions of all methods in turn.\n"
              "Example: cuticle chart bessel -o charts");
    c->callback([a] { RunCharts(*a); });
}

} // namespace cuticle
