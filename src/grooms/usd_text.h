// The words of USD's text form: a cursor over a layer.
#pragma once

#include "core/error.h"

#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

// Reads from the text's beginning to its end; comments and space are passed over before every word. All
// functions throw Error with file, line and column where the text holds something else than they are asked
// for.
class UsdText {
  public:
    UsdText(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

    // The next character that counts, not taken; '\0' at the end.
    char Peek();
    size_t At() const { return at_; } // byte
    // Takes the character if it is the next one.
    bool Take(char c);
    void Expect(char c, const char *where);
    // A name, keyword, type or token without quotes; "" where none begins here.
    std::string_view Word();
    // A string in single, double or triple quotes, escapes left as they are.
    std::string_view String();
    // One value of any kind, unread: brackets with all they hold, strings, @assets@, <paths>, numbers, words.
    void SkipValue();
    // (..) after a declaration, if there is one, as entries "name = value"; use(name) is called before each
    // value is passed over and may read it itself (returns true).
    template <typename Use>
    void Metadata(Use use) {
        if (!Take('('))
            return;
        while (!Take(')')) {
            if (Peek() == '"' || Peek() == '\'') {
                String(); // a comment
                continue;
            }
            std::string_view word = Word();
            if (word == "prepend" || word == "append" || word == "add" || word == "delete" ||
                word == "reorder")
                word = Word();
            if (word.empty())
                Fail(at_, "a name was expected in this list in parentheses");
            if (Take('=') && !use(word))
                SkipValue();
            if (Peek() == '(') // a time offset of a reference
                SkipValue();
            Take(';');
        }
    }
    // A number, tuple of numbers, or (nested) array of either, as a flat list. Throws for anything that is
    // not finite or outside +-3e38.
    std::vector<double> Numbers();
    // The same in binary32, for long arrays.
    std::vector<float> Floats();
    // A string or word, or an array of them.
    std::vector<std::string> Strings();
    std::string OneString(); // of a list, its first

    [[noreturn]] void Fail(size_t byte, const std::string &what) const;
    template <typename Arg, typename... Args>
    [[noreturn]] void Fail(size_t byte, fmt::format_string<Arg, Args...> format, Arg &&arg,
                           Args &&...args) const {
        Fail(byte, fmt::vformat(format, fmt::make_format_args(arg, args...)));
    }
    FileLoc Loc(size_t byte) const;

  private:
    template <typename T>
    std::vector<T> Flat();
    double Number();
    std::string_view text_;
    std::string name_;
    size_t at_ = 0;
};

} // namespace cuticle
