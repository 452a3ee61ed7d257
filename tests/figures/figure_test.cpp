// Every figure of the papers that is made keeps its own laws; the table knows what is in the house.
#include "figures/papers/figure_table.h"

#include "core/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

namespace cuticle {
namespace {

namespace fs = std::filesystem;

std::vector<Figure> DrawnFigures() {
    std::vector<Figure> drawn;
    for (const Figure &figure : Figures())
        if (figure.make != nullptr)
            drawn.push_back(figure);
    return drawn;
}
std::string TestName(const std::string &id) {
    return std::regex_replace(id, std::regex("[^A-Za-z0-9]"), "_");
}

class DrawnFigure : public ::testing::TestWithParam<Figure> {};

TEST_P(DrawnFigure, KeepsItsLaws) {
    FigureOptions options;
    options.quick = true;
    const FigureData data = GetParam().make(options);
    EXPECT_GT(data.table.Rows(), 0u);
    EXPECT_EQ(data.table.Csv().find_first_of("\\{}"), std::string::npos)
        << "gnuplot's marks belong to the plot";
    EXPECT_FALSE(data.checks.empty()) << "a figure carries at least one law";
    for (const FigureCheck &check : data.checks)
        EXPECT_TRUE(check.Holds()) << check.law << " " << check.value << ", asked for " << check.low << " to "
                                   << check.high;
}
INSTANTIATE_TEST_SUITE_P(All, DrawnFigure, ::testing::ValuesIn(DrawnFigures()),
                         [](const auto &tested) { return TestName(tested.param.id); });

TEST(FigureTable, HoldsEachFigureOnceWithACaption) {
    std::set<std::string> ids;
    for (const Figure &figure : Figures()) {
        EXPECT_TRUE(ids.insert(figure.id).second) << figure.id;
        EXPECT_TRUE(std::string(figure.caption).ends_with(".")) << figure.id;
        EXPECT_FALSE(figure.kind == FigureKind::Photo && figure.Made()) << figure.id;
    }
    const auto own =
        std::count_if(ids.begin(), ids.end(), [](const auto &id) { return id.starts_with("book-"); });
    // 16 + 13 + 20 + 7 of the papers, Petrovic's videos among them
    EXPECT_EQ(ids.size() - static_cast<size_t>(own), 16u + 13 + 20 + 7);
}

// The scenes of a row exist; a scene named after a figure stands in that figure's row.
TEST(FigureTable, KnowsTheScenes) {
    const fs::path scenes = fs::path(CUTICLE_SOURCE_DIR) / "scenes";
    std::set<std::string> named;
    for (const Figure &figure : Figures()) {
        std::istringstream words(figure.scenes);
        for (std::string stem; words >> stem; named.insert(stem))
            EXPECT_TRUE(fs::exists(scenes / (stem + ".pbrt"))) << figure.id << " names " << stem;
    }
    for (const auto &entry : fs::directory_iterator(scenes)) {
        const std::string stem = entry.path().stem().string();
        if (std::regex_match(stem, std::regex("(marschner|deon|pharr|petrovic)-[0-9].*")) &&
            entry.path().extension() == ".pbrt") {
            EXPECT_EQ(named.count(stem), 1u)
                << stem << " belongs in the row of its figure in figure_table.cpp";
        }
    }
}

TEST(FigureTable, AnswersWrongNames) {
    const auto message = [](const std::string &id) {
        try {
            FindFigure(id);
        } catch (const Error &e) {
            return std::string(e.what());
        }
        return std::string();
    };
    EXPECT_NE(message("deon-3").find("deon-03"), std::string::npos);
    EXPECT_NE(message("marschner-02").find("photograph"), std::string::npos);
    EXPECT_EQ(message("deon-03"), "");
}

TEST(FigureData, MistakesInATableAreErrors) {
    Table table({"name", "value"});
    table.Add({"a, \"b\"", 0.1});
    table.Add({"c", NAN});
    EXPECT_EQ(table.Csv(), "name,value\n\"a, \"\"b\"\"\",0.1\nc,nan\n");
    EXPECT_THROW(table.Add({1.}), Error);
    EXPECT_THROW(table.Number(0, "name"), Error);
    EXPECT_THROW(table.Text(0, "no such column"), Error);
    EXPECT_FALSE((FigureCheck{"NaN breaks every law", NAN, -INFINITY, INFINITY}.Holds()));
}

TEST(FigureData, BecomesThreeFiles) {
    std::string folder = ::testing::TempDir() + "figureXXXXXX";
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    const FigureData data = FindFigure("pharr-1.16").make({});
    WriteFigure(folder + "/new", "pharr-1.16", "A caption.", data);
    for (const char *ending : {".csv", ".svg", ".png"})
        EXPECT_GT(fs::file_size(folder + "/new/pharr-1.16" + ending), 1000u);
    std::ifstream svg(folder + "/new/pharr-1.16.svg");
    std::ostringstream text;
    text << svg.rdbuf();
    EXPECT_NE(text.str().find("A caption."), std::string::npos);
    EXPECT_THROW(WriteFigure(folder + "/new/pharr-1.16.csv", "x", "", data), Error) << "a file is no folder";
    fs::remove_all(folder);
}

} // namespace
} // namespace cuticle
