// Scene text cut into tokens: words, quoted strings, numbers and brackets, each with its place.
#pragma once

#include "core/error.h"
#include "parser/text_source.h"

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace cuticle {

// Reads one decimal number ("-1", ".5", "5.", "1e+006") at `p`, rounded to the nearest double, and gives the
// place after it; nullptr where no number begins at p. What follows the number is not looked at. *end must be
// readable and no part of a number.
const char *ScanNumber(const char *p, const char *end, double *value);

// pbrt's white space.
inline bool IsBlank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

struct Token {
    enum class Kind { End, Word, String, Number, Open, Close };
    Kind kind = Kind::End;
    const char *begin = nullptr; // first byte, the quote of a string included
    std::string_view text;       // as written; of a string what stands between the quotes
    double number = 0;
};

// Cuts text into tokens. Throws Errors with place and line for whatever is no token: an unterminated or
// absurdly long string, a malformed number or one beyond the range of a float, bytes that are no text. After
// an Error the next call goes on behind the fault.
class Lexer {
  public:
    explicit Lexer(std::unique_ptr<TextSource> source);

    Token Next();
    const Token &Peek();

    // Reading goes on at the cursor; only meaningful while nothing is peeked at.
    const char *Cursor() const { return cursor_; }
    void SetCursor(const char *p) { cursor_ = p, peeked_ = false; }
    const TextSource &Source() const { return *source_; }
    // Gives back the memory of the text already read; to be called now and then.
    void ReleaseBehind() {
        if (cursor_ - releasedAt_ >= kReleaseStep)
            ReleaseNow();
    }

    // Line and column of a byte of the text; takes time as the bytes between it and the last place asked
    // for, and going back to an earlier line as that line, but never as the line that both stand on.
    FileLoc Loc(const char *at) const;
    // The line that holds a byte, without its end, cut 200 bytes behind `at`.
    std::string_view Line(const char *at) const;
    [[noreturn]] void Fail(const char *at, const std::string &message) const;
    // Whether this byte, or the end, is of this text.
    bool Holds(const char *at) const;
    // The text of a string token with its escapes (\n \t \" \\ ...) replaced.
    std::string Unescape(const Token &string) const;

  private:
    static constexpr std::ptrdiff_t kReleaseStep = 8 << 20;
    void ReleaseNow();
    Token Scan();
    Token ScanString(const char *p);
    Token ScanWord(const char *p);
    std::unique_ptr<TextSource> source_;
    const char *cursor_, *end_, *releasedAt_;
    Token peekedToken_;
    bool peeked_ = false;
    // The last place that Loc() was asked for.
    mutable const char *knownAt_, *knownLineStart_;
    mutable uint32_t knownLine_ = 1;
};

} // namespace cuticle
