// The stability atlas: where the formulas of the papers and our own break, as heat maps over their
// parameters.
//
// Every fault that is known of the published methods is a row of AtlasFaults(), with the map that shows it,
// the tests that watch it, and two numbers that the run measures: the method as published, and ours. Maps
// over the parameters of whole models hold every model that scenes may name, without further ado.
#pragma once

#include "figures/figure.h"

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace cuticle {

struct AtlasOptions {
    bool quick = false; // coarse maps, in about half of the time
};

// An axis of cells of equal size. With exponent, numbers along it are powers of ten: low and high are the
// exponents.
struct AtlasAxis {
    std::string label, column; // for the plot; for the table
    double low, high;
    size_t cells;
    bool exponent = false;
    // The value in the middle of cell i < cells.
    double At(size_t i) const;
};

// One heat map. Values in rows of y. NaN is a cell without a number: white. No values: a place without a map;
// why, says the note, line by line.
struct AtlasPanel {
    std::string title;
    std::vector<double> values;
    std::vector<std::string> note = {};
};

// A finding is what a map says of one fault: the same quantity for the method as published, for ours as it
// renders, and for ours in double precision. NaN: there is none, or it was not measured.
struct AtlasFinding {
    int row; // of AtlasFaults(), 0: none of them
    std::string quantity;
    double published, ours;
    bool stated = false; // the model's own fault, ours too, though the row as a whole is mended
    double inDouble = std::numeric_limits<double>::quiet_NaN();
};

struct AtlasMap {
    std::string name; // of the files
    std::string title, quantity;
    AtlasAxis x, y;
    std::vector<AtlasPanel> panels;
    bool log = true;
    double min, max; // of the colours; values beyond are drawn as these
    std::vector<AtlasFinding> findings;
    std::string note = ""; // what a reader must know to read it
    int columns = 0;       // of panels; 0: by their number
};

// Computes f(x, y) in every cell with all threads.
std::vector<double> FillMap(const AtlasAxis &x, const AtlasAxis &y,
                            const std::function<double(double, double)> &f);
// Four panels by f(T(), published, x, y), T double and float: both methods in both precisions.
template <typename F>
std::vector<AtlasPanel> FourPanels(const AtlasMap &map, F f) {
    const auto fill = [&](auto type, bool published) {
        return FillMap(map.x, map.y, [&](double x, double y) { return f(type, published, x, y); });
    };
    return {{"published, double", fill(double(), true)},
            {"published, float", fill(float(), true)},
            {"ours, double", fill(double(), false)},
            {"ours, float", fill(float(), false)}};
}
// The largest value; infinity if a cell holds no finite number.
double WorstOf(const std::vector<double> &values);

// A fault of a published method. tests names those that watch it, with blanks between; state is "mended"
// where ours is right, "stated" where the model itself is at fault and ours has the fault too.
struct AtlasFault {
    int row;
    const char *fault, *state, *tests;
};
std::span<const AtlasFault> AtlasFaults();

// A group of maps that are made together.
struct AtlasChapter {
    const char *name, *what;
    std::vector<AtlasMap> (*make)(const AtlasOptions &);
};
std::span<const AtlasChapter> AtlasChapters();

// The chapters' functions, one file each.
std::vector<AtlasMap> LongitudinalMaps(const AtlasOptions &options);
std::vector<AtlasMap> AzimuthalMaps(const AtlasOptions &options);
std::vector<AtlasMap> PathMaps(const AtlasOptions &options);
std::vector<AtlasMap> SamplingMaps(const AtlasOptions &options);
std::vector<AtlasMap> DynamicsMaps(const AtlasOptions &options);
std::vector<AtlasMap> RoughnessMaps(const AtlasOptions &options);
std::vector<AtlasMap> ModelMaps(const AtlasOptions &options);

// Writes folder/NAME.csv, .svg and .png of a map.
void WriteAtlasMap(const std::string &folder, const AtlasMap &map);
// The index: a row for every finding, the faults first.
Table AtlasIndex(std::span<const AtlasMap> maps);

} // namespace cuticle
