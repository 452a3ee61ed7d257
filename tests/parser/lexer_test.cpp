#include "parser/lexer.h"
#include "parser/test_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>

namespace cuticle {
namespace {

TEST(ScanNumber, RoundsLikeStrtod) {
    std::mt19937_64 random(1);
    char text[64];
    for (int i = 0; i < 200000; ++i) {
        const double mantissa = static_cast<double>(static_cast<int64_t>(random())) / 9.3e18;
        const int exponent = static_cast<int>(random() % 80) - 40, digits = static_cast<int>(random() % 20);
        static constexpr const char *kFormats[] = {"%.*f", "%.*e", "%.*g", "%+.*f"};
        const bool fixed = i % 4 == 0 || i % 4 == 3;
        const int n = std::snprintf(text, sizeof text, kFormats[i % 4], digits,
                                    fixed ? mantissa * 1000 : mantissa * std::pow(10, exponent));
        double v = 0;
        const char *after = ScanNumber(text, text + n, &v);
        ASSERT_EQ(after, text + n) << text;
        const double expected = std::strtod(text, nullptr);
        ASSERT_EQ(std::memcmp(&v, &expected, sizeof v), 0) << text;
    }
}

TEST(ScanNumber, FormsOfRealFiles) {
    const std::pair<const char *, double> forms[] = {
        {".5", 0.5},           {"5.", 5},  {"-.25", -0.25}, {"1e+006", 1e6}, {"+3", 3},
        {"1E-3", 1e-3},        {"007", 7}, {"-1.e2", -100}, {"1e-999", 0},   {"0.1e1", 1},
        {"16777217", 16777217}};
    for (const auto &[text, value] : forms) {
        double v = -1;
        EXPECT_EQ(ScanNumber(text, text + std::strlen(text), &v), text + std::strlen(text)) << text;
        EXPECT_EQ(v, value) << text;
    }
    double zero = 1;
    ScanNumber("-0", nullptr, &zero);
    EXPECT_EQ(zero, 0);
    EXPECT_TRUE(std::signbit(zero));
    for (const char *text : {"", ".", "-", "+", "e5", "-.e5", "nan", "inf", "-inf", "[", "x"})
        EXPECT_EQ(ScanNumber(text, text + std::strlen(text), &zero), nullptr) << text;
}

TEST(Lexer, KnowsLineAndColumnInAnyOrder) {
    const std::string text = "a bb\r\n  \"c\"\n\n# x\n\t12]";
    Lexer lexer(TextSource::FromText(text, "t"));
    std::vector<Token> tokens;
    while (tokens.empty() || tokens.back().kind != Token::Kind::End)
        tokens.push_back(lexer.Next());
    ASSERT_EQ(tokens.size(), 6u);
    const uint32_t lines[] = {1, 1, 2, 5, 5, 5}, columns[] = {1, 3, 3, 2, 4, 5};
    for (int i : {0, 5, 2, 1, 4, 3, 0}) {
        const FileLoc loc = lexer.Loc(tokens[static_cast<size_t>(i)].begin);
        EXPECT_EQ(loc.line, lines[i]) << i;
        EXPECT_EQ(loc.column, columns[i]) << i;
    }
    EXPECT_EQ(tokens[2].text, "c");
    EXPECT_EQ(tokens[3].number, 12);
}

} // namespace
} // namespace cuticle
