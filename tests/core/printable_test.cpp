#include "core/error.h"
#include "core/printable.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <vector>

namespace cuticle {
namespace {

TEST(Printable, LeavesTextAndShowsWhatWouldAct) {
    const std::pair<std::string, std::string> cases[] = {
        {"plain text, \"quotes\" and \\", "plain text, \"quotes\" and \\"},
        {"h\xc3\xa4r \xe2\x82\xac \xf0\x9f\x98\x80", "h\xc3\xa4r \xe2\x82\xac \xf0\x9f\x98\x80"},
        {"a\x1b[2Jb\x07\x7f", "a\\x1b[2Jb\\x07\\x7f"},
        {"a\tb\nc\r", "a b\\nc\\r"},
        {std::string("a\0b", 3), "a\\x00b"},
        {"\xc2\x9b[31m", "\\u009b[31m"}, // control sequence introducer of one character
        {"\xe2\x80\xae"
         "txt.exe",
         "\\u202etxt.exe"}, // right to left from here
        {"\xe2\x81\xa6\xe2\x80\x8b\xef\xbb\xbf", "\\u2066\\u200b\\ufeff"},
        {"\xf3\xa0\x80\x81", "\\U000e0001"}, // a tag
        {"\xff\xfe", "\\xff\\xfe"},
        {"\xc0\x8a\xe0\x80\x8a", "\\xc0\\x8a\\xe0\\x80\\x8a"}, // \n, overlong
        {"\xed\xa0\x80", "\\xed\\xa0\\x80"},                   // half of a surrogate pair
        {"\xf4\x90\x80\x80", "\\xf4\\x90\\x80\\x80"},          // U+110000
        {"cut \xe2\x82", "cut \\xe2\\x82"},
        {"\xe2(\xa1", "\\xe2(\\xa1"},
    };
    for (const auto &[raw, shown] : cases)
        EXPECT_EQ(Printable(raw), shown);
}

// Whatever the bytes, no byte comes through that a terminal acts on, and printing twice changes nothing.
TEST(Printable, NoPairOfBytesIsRaw) {
    for (int a = 0; a < 256; ++a)
        for (int b = 0; b < 256; ++b) {
            const std::string shown = Printable(std::string{static_cast<char>(a), static_cast<char>(b)});
            for (size_t i = 0; i < shown.size(); ++i) {
                const auto c = static_cast<unsigned char>(shown[i]);
                EXPECT_TRUE(c >= 32 && c != 127) << a << " " << b;
                if (c == 0xc2) { // what follows must not make it a control character U+0080 to U+009F
                    EXPECT_GE(static_cast<unsigned char>(shown[i + 1]), 0xa0) << a << " " << b;
                }
            }
            EXPECT_EQ(Printable(shown), shown);
        }
}

TEST(Printable, OutputIsFilteredByteForByte) {
    std::ostringstream stream;
    {
        const PrintableOutput filter(&stream);
        // lines and tabs stay; a character may come in pieces
        stream << "a\tb\n\x1b[1m"
               << "\xe2"
               << "\x82"
               << "\xac\n"
               << '\x07' << 42;
    }
    EXPECT_EQ(stream.str(), "a\tb\n\\x1b[1m\xe2\x82\xac\n\\x07"
                            "42");
    stream << '\x07'; // the filter is gone
    EXPECT_EQ(stream.str().back(), '\x07');
}

TEST(Errors, NothingIsEchoedRaw) {
    const std::string evil = "\x1b]0;owned\x07\xe2\x80\xae\xff\nfake.pbrt:1:1: error: no";
    const FileLoc loc{std::make_shared<const std::string>(evil), 3, 7};
    const std::string line = "abc \x1b[ \xc3\xa4 \"x";
    const Error e = Error(loc, "no \"{}\"", evil).WithRemedy("not {}", evil).WithSourceLine(line);
    for (const char bad : {'\x1b', '\x07', '\xff'})
        EXPECT_EQ(std::string(e.what()).find(bad), std::string::npos);
    const std::string shown = e.what();
    EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 2); // the quoted line and the caret
    EXPECT_NE(loc.ToString().find("\\u202e"), std::string::npos);
    // The caret stands under the seventh byte of the line, whatever was escaped before it.
    EXPECT_NE(shown.find("\n    abc \\x1b[ \xc3\xa4 \"x\n    " + std::string(9, ' ') + "^"),
              std::string::npos)
        << shown;
}

// A suggestion costs the same for names of any length, and quotes no more than a line of them.
TEST(Errors, SuggestionsAreBounded) {
    const std::string longName(60000, 'a');
    std::vector<std::string> names;
    for (int i = 0; i < 300; ++i)
        names.push_back(longName + std::to_string(i));
    const std::vector<std::string_view> known(names.begin(), names.end());
    EXPECT_LT(Suggestion(longName, known.data(), known.size()).size(), 2000u);
    const std::string_view two[] = {"matte", longName};
    EXPECT_EQ(Suggestion("mate", two, 2), "Did you mean \"matte\"?");
}

} // namespace
} // namespace cuticle
