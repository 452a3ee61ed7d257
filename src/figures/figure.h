// What a figure or a chart is made of: a table of numbers, the plot of it, and the laws that the numbers must satisfy.
#pragma once

#include "figures/plot.h"

#include <span>
#include <string>
#include <variant>
#include <vector>

namespace cuticle {

// Columns with names (and units in them: "theta_deg"), rows of numbers and texts.
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
    // As RFC 4180 has it, lines ending in \n: a line of names, then the rows; numbers with 9 digits, NaN as "nan".
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

// Another renderer on the axes of the chart of renderings; command: run by sh, {scene} and {out} replaced.
struct Peer {
    std::string name, command;
};

struct FigureOptions {
    bool quick = false;            // fewer samples, a coarser grid: for tests and a first look
    std::string scenes = "scenes"; // where the shipped scenes are
    std::vector<Peer> peers;
};

// plot.caption is set by the command: the row's caption, then note.
struct FigureData {
    Table table;
    Plot plot;
    std::string
        note; // what this run found, where it differs from the paper and why; ends with a full stop, or empty
    std::vector<FigureCheck> checks;
};
using FigureFunction = FigureData (*)(const FigureOptions &);

enum class FigureKind { Plot, Render, Diagram, Photo, Animation };
std::string ToString(FigureKind kind);

// A figure of one of the four papers. make is null, and scenes empty, for one that is not made (yet); scenes names the
// files under scenes/ (without .pbrt) that render it, with blanks between.
struct Figure {
    const char *id;
    FigureKind kind;
    const char *caption;
    FigureFunction make;
    const char *scenes;
    bool Made() const { return make != nullptr || *scenes != '\0'; }
};
std::span<const Figure> Figures();
// Throws Error with the nearest ids, or, for a figure that `cuticle figure` does not draw, with what there is instead.
const Figure &FindFigure(const std::string &id);

// A measurement of error against cost.
struct Chart {
    const char *name;
    const char *caption;
    FigureFunction make;
};
std::span<const Chart> Charts();
const Chart &FindChart(const std::string &name);

// Writes folder/stem.csv, .svg and .png; the folder is made if need be. Throws Error.
void WriteFigure(const std::string &folder, const std::string &stem, const std::string &caption,
                 const FigureData &data);

// printf of one number.
std::string Printed(const char *format, double value);

// n numbers from a to b, both included; n >= 2.
std::vector<double> Linspace(double a, double b, size_t n);
// The same in equal ratios; a, b > 0.
std::vector<double> Logspace(double a, double b, size_t n);

} // namespace cuticle
