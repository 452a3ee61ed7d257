// The text that the parser reads: the scene file and the files under way that it includes, with messages at a
// place of them. Of no use outside of the parser.
#pragma once

#include "files/frame_names.h"
#include "parser/lexer.h"
#include "parser/param_set.h"

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cuticle {

// The stack of files being read, as one row of tokens: where an included file ends, the one that included
// it goes on, in the middle of a directive too, as in pbrt-v3. A place is a byte of the text of any file
// that is open or that ended in the directive under way.
class SceneText {
  public:
    // folder: of the top-level scene file, where the names of files are looked up. frame: whose number all
    // strings get in their places "%d" or "%04d"; none: strings stay as they are.
    explicit SceneText(const std::string &folder, std::optional<size_t> frame = {})
        : folder_(std::make_shared<const std::string>(folder)), frame_(frame) {}

    Token Next();
    const Token &Peek();
    // Before a directive: forgets the files that ended in the one before, and gives back memory of text.
    void BeginDirective();
    // The file on top, to be read byte by byte.
    Lexer &lexer() { return *files_.back().lexer; }
    bool IsIncluded() const { return files_.size() > 1; } // the file on top

    const std::shared_ptr<const std::string> &Folder() const { return folder_; }
    FileLoc Loc(const char *at) { return LexerOf(at).Loc(at); }
    FileLoc Loc(const Token &t) { return Loc(t.begin); }
    // Returns what a string says.
    std::string Unescape(const Token &string) {
        const std::string text = LexerOf(string.begin).Unescape(string);
        return frame_ ? WithFrameNumber(text, *frame_) : text;
    }
    [[noreturn]] void Fail(const char *at, const std::string &message) { LexerOf(at).Fail(at, message); }
    [[noreturn]] void Fail(const Token &at, const std::string &message) { Fail(at.begin, message); }
    template <class At, typename Arg, typename... Args>
    [[noreturn]] void Fail(const At &at, fmt::format_string<Arg, Args...> format, Arg &&arg, Args &&...args) {
        Fail(at, fmt::vformat(format, fmt::make_format_args(arg, args...)));
    }
    // Warns of what pbrt-v3 prints an error about and goes on. kind: as of a Warning.
    template <class At, typename... Args>
    void Complain(const At &at, const std::string &kind, fmt::format_string<Args...> format, Args &&...args) {
        Warning(Loc(at), kind, fmt::vformat(format, fmt::make_format_args(args...)));
    }
    // ". Did you mean ...?" for a Complain() of that kind, from the keys of maps by name, which the scene has
    // defined; "" where there are none, and the second time: of a kind only the first is printed, and this
    // takes time as there are names.
    template <typename Map>
    std::string SuggestOnce(const std::string &kind, std::string_view name,
                            std::initializer_list<const Map *> maps) {
        if (!suggested_.insert(kind).second)
            return "";
        std::vector<std::string_view> known;
        for (const Map *map : maps)
            for (const auto &entry : *map)
                known.push_back(entry.first);
        if (known.empty())
            return "";
        std::sort(known.begin(), known.end());
        // A name far from all others is answered with a list, which should stay readable.
        std::string s = Suggestion(name, known.data(), known.size());
        if (s.starts_with("Known") && known.size() > kMaxListed)
            s = Suggestion(name, known.data(), kMaxListed);
        return ". " + s;
    }
    // The text of a parameter of the directive just read: where a message about it points.
    const char *PlaceOf(const Token &directive, const Param &p);
    // The parameters of a directive say where they are declared, as they are read.
    void BeginParams() { paramPlaces_.clear(); }
    void NoteParam(const std::string &name, const char *at) { paramPlaces_.emplace_back(name, at); }

    // The scene file itself. Throws an Error when its first bytes are no text.
    void Open(std::unique_ptr<TextSource> source);
    // A file that the token at `at` includes; a Warning there that there is none, which is left out, as by
    // pbrt-v3. Error there: no scene text, a file that includes itself, too many or too deep.
    void Include(const std::string &name, const Token &at);
    // Throws Error where a file under way has changed since it was opened.
    void CheckUnchanged() const;
    size_t BytesRead() const { return bytesRead_; } // of text, unpacked, of all files opened

    // A file that the scene names was not there, and names may be unknown because of it: that is not said
    // again.
    bool missingFile = false;

  private:
    struct File {
        std::unique_ptr<Lexer> lexer;
        std::string canonical; // the path without links, by which one that includes itself is known
    };
    void Push(std::unique_ptr<TextSource> source, const std::string &canonical);
    Lexer &LexerOf(const char *at);

    std::shared_ptr<const std::string> folder_;
    std::optional<size_t> frame_;
    std::vector<File> files_, ended_; // ended_: in the directive under way
    std::vector<std::pair<std::string, const char *>> paramPlaces_;
    static constexpr size_t kMaxListed = 20; // names in a suggestion
    std::set<std::string, std::less<>> suggested_;
    size_t includes_ = 0, bytesRead_ = 0;
};

// A name of the scene in quotes, cut where it is absurdly long.
std::string Quoted(std::string_view s);
// A token as messages name it: "the string "abc"", "the end of the file".
std::string Describe(const Token &t);
// " (not-a-number and infinity have no place in a scene)" for such words, else "".
std::string_view NotANumberHint(std::string_view word);

} // namespace cuticle
