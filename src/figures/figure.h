// A figure, a chart or a map: a table of numbers, the plot of it, and the laws that the numbers must satisfy.
#pragma once

#include "core/angles.h"
#include "core/error.h"
#include "core/vecmath.h"
#include "figures/plot.h"
#include "images/image.h"

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace cuticle {

class ProgressSink;

// A table has columns with names (and units in them: "theta_deg") and rows of numbers and texts.
class Table {
  public:
    using Cell = std::variant<double, std::string>;
    explicit Table(std::vector<std::string> columns) : columns_(std::move(columns)) {}

    // Throws Error if the row has not one cell for each column.
    void Add(std::vector<Cell> row);
    size_t Rows() const { return rows_.size(); }
    // Throw Error for a column that does not exist or holds the other kind of cell; row < Rows().
    double Number(size_t row, const std::string &column) const;
    const std::string &Text(size_t row, const std::string &column) const;
    // The table as RFC 4180 has it, lines ending in \n: a line of names, then the rows; numbers have 9
    // digits, NaN is "nan".
    std::string Csv() const;

  private:
    const Cell &At(size_t row, const std::string &column) const;
    std::vector<std::string> columns_;
    std::vector<std::vector<Cell>> rows_;
};

// A law that the figure's own data must satisfy: low <= value <= high. NaN breaks it.
struct FigureCheck {
    std::string law;
    double value, low, high;
    bool Holds() const { return value >= low && value <= high; }
};

// Another renderer on the chart of renderings. sh runs the command, with {scene} and {out} replaced by names
// of files.
struct Peer {
    std::string name, command;
};

struct FigureOptions {
    bool quick = false; // fewer samples, a coarser grid, a smaller picture: for tests and a first look
    std::string scenes = "scenes"; // where the shipped scenes are
    std::vector<Peer> peers;
    std::string pictures; // if not empty: the folder that the pictures of rendered figures are read from
    ProgressSink *progress = nullptr; // told how far a picture of a rendered figure is
};

// A picture that a figure is made of; it also becomes a file of its own.
struct FigurePicture {
    std::string name; // of its file, the scene's: "pharr-1.8-a"
    Image image;      // linear light
    int samples = 0;  // per pixel
    double cpuSeconds = 0;
};

// All that a figure's function computes. WriteFigure sets plot.caption: the caption of the row in the table,
// then note.
struct FigureData {
    Table table;
    Plot plot = {};
    // Says what this run found, where it differs from the paper and why; ends with a full stop, or is empty.
    std::string note = {};
    std::vector<FigureCheck> checks = {};
    std::vector<FigurePicture> pictures = {};
};
using FigureFunction = FigureData (*)(const FigureOptions &);

// The row whose `nameOf` is name, of a table of figures or charts. Throws Error with the nearest names: "no
// WHAT is called ...".
template <typename Row>
const Row &FindRow(std::span<const Row> rows, const char *Row::*nameOf, const std::string &name,
                   const char *what) {
    std::vector<std::string_view> names;
    for (const Row &row : rows) {
        if (name == row.*nameOf)
            return row;
        names.emplace_back(row.*nameOf);
    }
    throw Error("no {} is called \"{}\"", what, name)
        .WithRemedy(Suggestion(name, names.data(), names.size()));
}

// Writes folder/stem.csv, .svg and .png, and every picture as NAME.exr and, where its name is not the stem,
// NAME.png; the folder is made if need be. Returns the names of the files. Throws Error.
std::vector<std::string> WriteFigure(const std::string &folder, const std::string &stem,
                                     const std::string &caption, const FigureData &data);

// printf of one number.
std::string Printed(const char *format, double value);

// The larger of two errors; NaN stays.
inline double Worst(double a, double b) { return a >= b ? a : std::isnan(a) ? a : b; }

// n numbers in equal steps from a to b, both included; n >= 2.
std::vector<double> Linspace(double a, double b, size_t n);
// n numbers in equal ratios from a to b, both included; a, b > 0, n >= 2.
std::vector<double> Logspace(double a, double b, size_t n);

} // namespace cuticle
