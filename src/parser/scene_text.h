// The text that the parser reads: the scene file and the files under way that it includes, with messages at a
// place of them. Of no use outside of the parser.
#pragma once

#include "parser/lexer.h"
#include "parser/param_set.h"

#include <algorithm>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cuticle {

// The stack of files being read; the last one included is on top, and what is asked for a lexer, a place or a
// failure means that one.
class SceneText {
  public:
    // folder: of the top-level scene file, where the names of files are looked up.
    explicit SceneText(const std::string &folder) : folder_(std::make_shared<const std::string>(folder)) {}

    Lexer &lexer() { return *files_.back().lexer; }
    const std::shared_ptr<const std::string> &Folder() const { return folder_; }
    FileLoc Loc(const Token &t) { return lexer().Loc(t.begin); }
    [[noreturn]] void Fail(const char *at, const std::string &message) { lexer().Fail(at, message); }
    [[noreturn]] void Fail(const Token &at, const std::string &message) { Fail(at.begin, message); }
    template <class At, typename Arg, typename... Args>
    [[noreturn]] void Fail(const At &at, fmt::format_string<Arg, Args...> format, Arg &&arg, Args &&...args) {
        Fail(at, fmt::vformat(format, fmt::make_format_args(arg, args...)));
    }
    // The text of a parameter of the directive just read: where a message about it points.
    const char *PlaceOf(const Token &directive, const Param &p);

    // The scene file itself. Throws an Error when its first bytes are no text.
    void Open(std::unique_ptr<TextSource> source);
    // A file that the token at `at` includes. Error there: no such file, one that includes itself, too many
    // or too deep.
    void Include(const std::string &name, const Token &at);
    // Goes on in the file that included the top one; false when there is none.
    bool Leave();
    // Throws Error where a file under way has changed since it was opened.
    void CheckUnchanged() const;
    size_t BytesRead() const { return bytesRead_; } // of text, unpacked, of all files opened

    // Curves read of the top file, counted for the forecast of how many will come.
    size_t &Curves() { return files_.back().curves; }

    // A file that the scene names was not there, and names may be unknown because of it: that is not said
    // again.
    bool missingFile = false;

  private:
    struct File {
        std::unique_ptr<Lexer> lexer;
        std::string canonical; // the path without links, by which one that includes itself is known
        size_t curves = 0;
    };
    void Push(std::unique_ptr<TextSource> source, const std::string &canonical);

    std::shared_ptr<const std::string> folder_;
    std::vector<File> files_;
    size_t includes_ = 0, bytesRead_ = 0;
};

// A name of the scene in quotes, cut where it is absurdly long.
std::string Quoted(std::string_view s);
// A token as messages name it: "the string "abc"", "the end of the file".
std::string Describe(const Token &t);
// " (not-a-number and infinity have no place in a scene)" for such words, else "".
std::string_view NotANumberHint(std::string_view word);

// ". Did you mean ...?" from the keys of maps by name, which the scene has defined; "" where there are none.
template <typename Map>
std::string SuggestFrom(std::string_view name, std::initializer_list<const Map *> maps) {
    std::vector<std::string_view> known;
    for (const Map *map : maps)
        for (const auto &entry : *map)
            known.push_back(entry.first);
    if (known.empty())
        return "";
    std::sort(known.begin(), known.end());
    // A name far from all others is answered with a list, which should stay readable.
    std::string s = Suggestion(name, known.data(), known.size());
    if (s.starts_with("Known") && known.size() > 20)
        s = Suggestion(name, known.data(), 20);
    return ". " + s;
}

} // namespace cuticle
