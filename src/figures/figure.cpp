#include "figures/figure.h"

#include "core/error.h"
#include "files/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cuticle {

void Table::Add(std::vector<Cell> row) {
    if (row.size() != columns_.size())
        throw Error("a row of {} cells in a table of {} columns", row.size(), columns_.size());
    rows_.push_back(std::move(row));
}

const Table::Cell &Table::At(size_t row, const std::string &column) const {
    const auto found = std::find(columns_.begin(), columns_.end(), column);
    if (found == columns_.end() || row >= rows_.size())
        throw Error("the table has no row {} with a column \"{}\"", row, column);
    return rows_[row][static_cast<size_t>(found - columns_.begin())];
}
double Table::Number(size_t row, const std::string &column) const {
    if (const double *number = std::get_if<double>(&At(row, column)))
        return *number;
    throw Error("the table's column \"{}\" holds texts, not numbers", column);
}
const std::string &Table::Text(size_t row, const std::string &column) const {
    if (const std::string *text = std::get_if<std::string>(&At(row, column)))
        return *text;
    throw Error("the table's column \"{}\" holds numbers, not texts", column);
}

namespace {

std::string CsvCell(const Table::Cell &cell) {
    if (const double *number = std::get_if<double>(&cell)) {
        return std::isnan(*number) ? "nan" : fmt::format("{:.9g}", *number);
    }
    const std::string &text = std::get<std::string>(cell);
    if (text.find_first_of(",\"\n\r") == std::string::npos)
        return text;
    std::string quoted = "\"";
    for (const char c : text)
        quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
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

std::vector<std::string> WriteFigure(const std::string &folder, const std::string &stem,
                                     const std::string &caption, const FigureData &data) {
    MakeFolder(folder);
    const std::string base = folder + "/" + stem;
    Plot plot = data.plot;
    plot.caption = caption + (data.note.empty() ? "" : " " + data.note);
    WriteFileAtomically(base + ".csv", data.table.Csv());
    WritePlot(base + ".svg", plot);
    WritePlot(base + ".png", plot);
    std::vector<std::string> files = {base + ".csv", base + ".svg", base + ".png"};
    for (const FigurePicture &picture : data.pictures)
        for (const char *ending : {".exr", ".png"}) {
            const std::string file = folder + "/" + picture.name + ending;
            if (file != base + ".png")
                WriteImage(files.emplace_back(file), picture.image);
        }
    return files;
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
