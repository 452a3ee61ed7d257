// Spectra in files: pairs, comments, and errors that name their place.
#include "parser/spd_file.h"

#include "core/error.h"

#include <gtest/gtest.h>

#include <fstream>

namespace cuticle {
namespace {

std::string WriteTemporary(const std::string &name, const std::string &text) {
    const std::string path = testing::TempDir() + name;
    std::ofstream(path) << text;
    return path;
}

TEST(SPD, ReadsPairsAndComments) {
    const auto path = WriteTemporary("good.spd", "# a lamp\n400 1\r\n\n500,2 # middle\n  600\t3\n");
    const Spectrum a = ReadSPD(path), b = SpectrumFromSamples({400, 500, 600}, {1, 2, 3});
    EXPECT_EQ(a, b);
}

TEST(SPD, ErrorsNameFileAndLine) {
    const auto message = [](const std::string &text) -> std::string {
        try {
            ReadSPD(WriteTemporary("bad.spd", text));
        } catch (const Error &e) {
            return e.what();
        }
        return "no error";
    };
    EXPECT_NE(message("400 1\n500 two\n").find("bad.spd:2:5"), std::string::npos)
        << message("400 1\n500 two\n");
    EXPECT_NE(message("400 1\n500\n").find("3 numbers"), std::string::npos);
    EXPECT_NE(message("").find("0 numbers"), std::string::npos);
    EXPECT_NE(message("400 nan\n").find("not a finite number"), std::string::npos);
    // Found by fuzzing: each number is finite, their colour is beyond binary32
    EXPECT_NE(message("#05\n 602\t1e41 # red\n2\t1e-1 # re").find("out of range"), std::string::npos);
    try {
        ReadSPD("no such.spd");
        FAIL() << "a missing file must be an error";
    } catch (const Error &e) {
        EXPECT_NE(std::string(e.what()).find("no such.spd"), std::string::npos);
    }
}

} // namespace
} // namespace cuticle
