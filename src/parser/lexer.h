// Scene text cut into tokens: words, quoted strings, numbers and brackets, each with its place.
#pragma once

#include "core/error.h"

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace cuticle {

// The text of one file in memory, or a view of a string that the caller keeps alive. Always followed by a NUL byte,
// so that a scanner may look at one byte past the end.
class TextSource {
  public:
    // Reads a file whole: mapped where it is a plain one, unpacked where it begins with gzip's magic bytes, whatever
    // its name. Throws an Error at `from` (the Include that asked, or a place without line) that names the file:
    // missing, a folder, damaged gzip data, text that unpacks to absurd sizes.
    static std::unique_ptr<TextSource> FromFile(const std::string &filename, const FileLoc &from,
                                                std::string_view fromLine = {});
    // text.data()[text.size()] must be a NUL byte.
    static std::unique_ptr<TextSource> FromText(const std::string &text, const std::string &name);
    ~TextSource();
    TextSource(const TextSource &) = delete;
    TextSource &operator=(const TextSource &) = delete;

    const std::shared_ptr<const std::string> &Name() const { return name_; }
    const char *Begin() const { return begin_; }
    const char *End() const { return end_; }
    // Lets the system take back the memory of what stands before `upTo` (it is read again if asked for), so that a
    // file of many gigabytes does not count as memory of ours. Does nothing for text that was unpacked or handed in.
    void Release(const char *upTo);

  private:
    TextSource() = default;
    std::shared_ptr<const std::string> name_;
    const char *begin_ = nullptr, *end_ = nullptr;
    std::string unpacked_;
    void *mapped_ = nullptr;
    size_t mappedSize_ = 0, released_ = 0;
};

// Reads one decimal number ("-1", ".5", "5.", "1e+006") at `p`, rounded to the nearest double, and gives the place after it;
// nullptr where no number begins at p. What follows the number is not looked at. *end must be readable and no part
// of a number.
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

// Throws Errors with place and line for whatever is no token: an unterminated or absurdly long string, a malformed number or one
// beyond the range of a float, bytes that are no text. After an Error the next call goes on behind the fault.
class Lexer {
  public:
    explicit Lexer(std::unique_ptr<TextSource> source);

    Token Next();
    const Token &Peek();

    // Where reading goes on; only meaningful while nothing is peeked at.
    const char *Cursor() const { return cursor_; }
    void SetCursor(const char *p) { cursor_ = p, peeked_ = false; }
    const TextSource &Source() const { return *source_; }
    // To be called now and then: gives back the memory of the text already read.
    void ReleaseBehind() {
        if (cursor_ - releasedAt_ >= kReleaseStep)
            ReleaseNow();
    }

    // Line and column of a byte of the text; takes time as the bytes between this and the last place asked for.
    FileLoc Loc(const char *at) const;
    // The line that holds a byte, without its end, cut some hundred bytes behind `at`.
    std::string_view Line(const char *at) const;
    [[noreturn]] void Fail(const char *at, const std::string &message) const;
    // The text of a string token with its escapes (\n \t \" \\ ...) replaced.
    std::string Unescape(const Token &string) const;

  private:
    static constexpr std::ptrdiff_t kReleaseStep = 8 << 20;
    void ReleaseNow();
    Token Scan();
    std::unique_ptr<TextSource> source_;
    const char *cursor_, *end_, *releasedAt_;
    Token peekedToken_;
    bool peeked_ = false;
    // The last place that Loc() was asked for.
    mutable const char *knownAt_, *knownLineStart_;
    mutable uint32_t knownLine_ = 1;
};

// Line `loc.line` of the file loc.file, read again from disk for an error message (long after parsing, when the text
// is gone); "" where that is not possible.
std::string SourceLine(const FileLoc &loc);

} // namespace cuticle
