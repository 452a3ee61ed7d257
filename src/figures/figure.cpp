#include "figures/figure.h"

#include "core/error.h"
#include "files/file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cuticle {

void Table::Add(std::vector<Cell> row) {
    if (row.size() != columns_.size())
        throw Error("a row of " + std::to_string(row.size()) + " cells in a table of " +
                    std::to_string(columns_.size()) + " columns");
    rows_.push_back(std::move(row));
}

const Table::Cell &Table::At(size_t row, const std::string &column) const {
    const auto found = std::find(columns_.begin(), columns_.end(), column);
    if (found == columns_.end() || row >= rows_.size())
        throw Error("the table has no row " + std::to_string(row) + " with a column \"" + column + "\"");
    return rows_[row][static_cast<size_t>(found - columns_.begin())];
}
double Table::Number(size_t row, const std::string &column) const {
    if (const double *number = std::get_if<double>(&At(row, column)))
        return *number;
    throw Error("the table's column \"" + column + "\" holds texts, not numbers");
}
const std::string &Table::Text(size_t row, const std::string &column) const {
    if (const std::string *text = std::get_if<std::string>(&At(row, column)))
        return *text;
    throw Error("the table's column \"" + column + "\" holds numbers, not texts");
}

namespace {

std::string CsvCell(const Table::Cell &cell) {
    if (const double *number = std::get_if<double>(&cell)) {
        return std::isnan(*number) ? "nan" : Printed("%.9g", *number);
    }
    const std::string &text = std::get<std::string>(cell);
    if (text.find_first_of(",\"\n\r") == std::string::npos)
        return text;
    std::string quoted = "\"";
    for (const char c : text)
        quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

// The row of that name in a table of figures or charts.
template <typename Row, typename Name>
const Row &Find(std::span<const Row> rows, const std::string &name, const char *what, Name nameOf) {
    std::vector<std::string_view> names;
    for (const Row &row : rows) {
        if (name == nameOf(row))
            return row;
        names.emplace_back(nameOf(row));
    }
    throw Error(std::string("no ") + what + " is called \"" + name + "\". " +
                Suggestion(name, names.data(), names.size()));
}

} // namespace

std::string Table::Csv() const {
    std::string csv;
    const auto line = [&csv](const auto &cells, auto text) {
        for (size_t i = 0; i < cells.size(); ++i)
            csv += (i == 0 ? "" : ",") + text(cells[i]);
        csv += "\n";
    };
    line(columns_, [](const std::string &name) { return CsvCell(name); });
    for (const auto &row : rows_)
        line(row, CsvCell);
    return csv;
}

std::string ToString(FigureKind kind) {
    switch (kind) {
    case FigureKind::Plot:
        return "plot";
    case FigureKind::Render:
        return "render";
    case FigureKind::Diagram:
        return "diagram";
    case FigureKind::Photo:
        return "photo";
    case FigureKind::Animation:
        return "animation";
    }
    return "";
}

const Figure &FindFigure(const std::string &id) {
    const Figure &figure = Find(Figures(), id, "figure", [](const Figure &f) { return f.id; });
    if (figure.make != nullptr)
        return figure;
    if (*figure.scenes != '\0')
        throw Error("figure " + id +
                    " is rendered from scenes: cuticle render scenes/NAME.pbrt, NAME one of " +
                    figure.scenes);
    if (figure.kind == FigureKind::Photo)
        throw Error("figure " + id + " is a photograph, which cannot be computed");
    throw Error("figure " + id + " (" + ToString(figure.kind) +
                ") is not made; cuticle figure --list shows which are");
}

const Chart &FindChart(const std::string &name) {
    return Find(Charts(), name, "chart", [](const Chart &c) { return c.name; });
}

void WriteFigure(const std::string &folder, const std::string &stem, const std::string &caption,
                 const FigureData &data) {
    MakeFolder(folder);
    const std::string base = folder + "/" + stem;
    Plot plot = data.plot;
    plot.caption = caption + (data.note.empty() ? "" : " " + data.note);
    WriteFileAtomically(base + ".csv", data.table.Csv());
    WritePlot(base + ".svg", plot);
    WritePlot(base + ".png", plot);
}

std::string Printed(const char *format, double value) {
    char text[160];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::vector<double> Linspace(double a, double b, size_t n) {
    std::vector<double> x(n);
    for (size_t i = 0; i < n; ++i)
        x[i] = i + 1 == n ? b : a + (b - a) * static_cast<double>(i) / static_cast<double>(n - 1);
    return x;
}
std::vector<double> Logspace(double a, double b, size_t n) {
    std::vector<double> x = Linspace(std::log(a), std::log(b), n);
    for (double &v : x)
        v = std::exp(v);
    return x;
}

} // namespace cuticle
