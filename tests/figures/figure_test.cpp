// Every figure of the papers that is made keeps its own laws; the table knows what is in the house.
#include "figures/papers/figure_table.h"

#include "core/error.h"
#include "figures/rendered.h"

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

std::vector<Figure> MadeFigures() {
    std::vector<Figure> made;
    for (const Figure &figure : Figures())
        if (figure.Made())
            made.push_back(figure);
    return made;
}
std::string TestName(const std::string &id) {
    return std::regex_replace(id, std::regex("[^A-Za-z0-9]"), "_");
}

class MadeFigure : public ::testing::TestWithParam<Figure> {};

TEST_P(MadeFigure, KeepsItsLaws) {
    FigureOptions options;
    options.quick = true;
    options.scenes = CUTICLE_SOURCE_DIR "/scenes";
    // What the reference images show is measured; the tests of images ask whether scenes still give them. One
    // figure is rendered here.
    const std::string references = CUTICLE_SOURCE_DIR "/reference_images";
    if (GetParam().measure != nullptr && GetParam().id != std::string("pharr-1.20")) {
        options.pictures = references;
        for (const std::string &stem : GetParam().Scenes())
            ASSERT_TRUE(fs::exists(references + "/" + stem + ".exr")) << "no reference image of " << stem;
    }
    const FigureData data = MakeFigure(GetParam(), options);
    EXPECT_GE(data.pictures.size(), GetParam().Scenes().size());
    EXPECT_GT(data.table.Rows(), 0u);
    EXPECT_EQ(data.table.Csv().find_first_of("\\{}"), std::string::npos)
        << "gnuplot's marks belong to the plot";
    EXPECT_FALSE(data.checks.empty()) << "a figure carries at least one law";
    for (const FigureCheck &check : data.checks)
        EXPECT_TRUE(check.Holds()) << check.law << " " << check.value << ", asked for " << check.low << " to "
                                   << check.high;
}
INSTANTIATE_TEST_SUITE_P(All, MadeFigure, ::testing::ValuesIn(MadeFigures()),
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
        EXPECT_EQ(figure.Scenes().empty(), figure.measure == nullptr) << figure.id;
        for (const std::string &stem : figure.Scenes()) {
            EXPECT_TRUE(fs::exists(scenes / (stem + ".pbrt"))) << figure.id << " names " << stem;
            // Its own, or that of an earlier figure, to be compared with
            EXPECT_TRUE(stem == figure.id || (stem.starts_with(figure.id) && stem[stem.size() - 2] == '-') ||
                        named.count(stem) == 1)
                << stem << " is not named after " << figure.id;
            named.insert(stem);
        }
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

// A rendered figure leaves its pictures beside the plot; a picture of the figure's own name has no second
// PNG, which is the plot's.
TEST(FigureData, PicturesBecomeFilesOfTheirOwn) {
    std::string folder = ::testing::TempDir() + "figureXXXXXX";
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    Image grey(4, 2, {"R", "G", "B"});
    std::fill(grey.data.begin(), grey.data.end(), 0.5f);
    FigureData data{Table({"mean"})};
    data.table.Add({MeanLuminance(grey)});
    data.plot.panels = {PicturePanel("a picture", grey)};
    data.pictures = {{"x", grey}, {"x-a", grey}};
    const std::vector<std::string> files = WriteFigure(folder, "x", "", data);
    const std::set<std::string> names = {"x.csv", "x.svg", "x.png", "x.exr", "x-a.exr", "x-a.png"};
    std::set<std::string> found;
    for (const std::string &file : files) {
        EXPECT_TRUE(fs::exists(file)) << file;
        found.insert(fs::path(file).filename());
    }
    EXPECT_EQ(found, names);
    EXPECT_EQ(ReadImage(folder + "/x-a.exr").width, 4);
    EXPECT_GT(ReadImage(folder + "/x.png").width, 100) << "the plot's";
    fs::remove_all(folder);
}

// Windows are shares of a picture, from its upper left corner; the smallest is a pixel.
TEST(FigureData, MeansAreOfTheirWindow) {
    Image image(10, 4, {"R", "G", "B"});
    for (size_t y = 0; y < 4; ++y)
        for (size_t x = 0; x < 10; ++x)
            image.At(x, y, 1) = float(x) + 10 * float(y);
    EXPECT_FLOAT_EQ(MeanColor(image)[1], 4.5f + 15);
    EXPECT_FLOAT_EQ(MeanColor(image, {0, 0.5, 0, 0.5})[1], 2 + 5);
    EXPECT_FLOAT_EQ(MeanColor(image, {0.9, 1, 0.75, 1})[1], 39);
    EXPECT_FLOAT_EQ(MeanColor(image, {1, 1, 1, 1})[1], 39);
    EXPECT_FLOAT_EQ(MeanColor(image, {0, 0, 0, 0})[1], 0);
}

} // namespace
} // namespace cuticle
