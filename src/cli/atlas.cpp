// cuticle atlas: maps of where the methods break.
#include "figures/atlas/atlas.h"
#include "cli/commands.h"
#include "files/file.h"

#include <iostream>
#include <memory>

namespace cuticle {

namespace {

struct AtlasArguments {
    std::string folder = "atlas";
    std::vector<std::string> chapters;
    AtlasOptions options;
    bool quiet = false;
};

// Bars would end a cell of the table.
std::string CellText(const std::string &text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '|')
            escaped += '\\';
        escaped += c;
    }
    return escaped;
}

// The index as a page: a table of the faults, then all pictures.
std::string IndexPage(const Table &index, const std::vector<AtlasMap> &maps) {
    std::string page =
        "# The stability atlas\n\nMeasured by `cuticle atlas`. Numbers: the worst of a map, as published, "
        "ours as it renders (in float), and ours in double where that was measured; inf: no number at all in "
        "some cell; empty: there is no such form. Stated: the model itself has the fault, ours too.\n\n"
        "| fault | what | map | quantity | published | ours | double | state | tests |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
    for (size_t i = 0; i < index.Rows(); ++i) {
        page += "|";
        for (const char *column :
             {"fault", "what", "map", "quantity", "published", "ours", "double", "state", "tests"}) {
            const std::string &text = index.Text(i, column);
            const bool isMap = column == std::string_view("map");
            page.append(isMap ? " [" : " ").append(CellText(text));
            if (isMap)
                page.append("](").append(text).append(")");
            page += " |";
        }
        page += "\n";
    }
    for (const AtlasMap &map : maps)
        page += "\n![" + map.title + "](" + map.name + ".svg)\n";
    return page;
}

void RunAtlas(const AtlasArguments &a) {
    CheckFolderName(a.folder,
                    "the option takes a folder, which gets index.md and each map as .csv, .svg and .png");
    std::vector<AtlasMap> maps;
    for (const AtlasChapter &chapter : AtlasChapters()) {
        if (!a.chapters.empty() &&
            std::find(a.chapters.begin(), a.chapters.end(), chapter.name) == a.chapters.end())
            continue;
        for (AtlasMap &map : chapter.make(a.options)) {
            WriteAtlasMap(a.folder, map);
            if (!a.quiet)
                std::cout << "wrote " << a.folder << "/" << map.name << ".csv, .svg, .png" << std::endl;
            maps.push_back(std::move(map));
        }
    }
    const Table index = AtlasIndex(maps);
    WriteFileAtomically(a.folder + "/index.csv", index.Csv());
    WriteFileAtomically(a.folder + "/index.md", IndexPage(index, maps));
    if (!a.quiet)
        std::cout << "wrote " << a.folder << "/index.md and index.csv\n";
}

} // namespace

void AddAtlasCommand(CLI::App &app) {
    auto a = std::make_shared<AtlasArguments>();
    CLI::App *c = app.add_subcommand("atlas", "Map where the methods break, as published and ours.");
    c->add_option("-o,--output", a->folder, "folder for the maps, index.md and index.csv (default: atlas)")
        ->type_name("DIR");
    c->add_flag("--quick", a->options.quick, "coarse maps");
    c->add_flag("-q,--quiet", a->quiet, "print nothing but errors");
    std::vector<std::string> names;
    for (const AtlasChapter &chapter : AtlasChapters())
        names.emplace_back(chapter.name);
    c->add_option("--chapter", a->chapters, "only these (default: all)")
        ->check(CLI::IsMember(names))
        ->type_name("NAME")
        ->take_all();
    c->footer("A heat map for every known fault of the published methods, and for every model over its "
              "parameters, as published\nbeside ours in float and in double: NaN and "
              "negative values, energy, samples against density, weights,\nreciprocity. gnuplot draws.\n"
              "Example: cuticle atlas -o atlas --quick");
    c->callback([a] { RunAtlas(*a); });
}

} // namespace cuticle
