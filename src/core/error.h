// Errors and warnings that name file, line and column (the habit is pbrt-v4's).
#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

namespace cuticle {

// A place in a text file; line and column count from 1, 0 = not known. Cheap to copy: the name is shared.
struct FileLoc {
    std::shared_ptr<const std::string> file;
    uint32_t line = 0, column = 0;
    std::string ToString() const; // "file:line:col" to be read, as much of it as is known
};

// Wrong input: where, what is wrong, and what would be right. The program prints what() and exits with status
// 1; a library user catches it and may read the fields.
//
//     throw Error(loc, "\"lobes\" is {}", lobes).WithRemedy("it must be 1 to {}", kMaxSceneLobes);
//
// prints "scene.pbrt:2:9: error: "lobes" is 0; it must be 1 to 16". An error without a place of its own takes
// that of the PlaceScope, if there is one.
class Error : public std::exception {
  public:
    explicit Error(std::string what) : Error(FileLoc{}, std::move(what)) {}
    Error(const FileLoc &place, std::string what);
    // Formats a string of libfmt, which is checked when it is compiled.
    template <typename Arg, typename... Args>
    Error(fmt::format_string<Arg, Args...> format, Arg &&arg, Args &&...args)
        : Error(FileLoc{}, fmt::vformat(format, fmt::make_format_args(arg, args...))) {}
    template <typename Arg, typename... Args>
    Error(const FileLoc &place, fmt::format_string<Arg, Args...> format, Arg &&arg, Args &&...args)
        : Error(place, fmt::vformat(format, fmt::make_format_args(arg, args...))) {}

    // Adds what would be right: after "; ", or after ". " where it begins with a capital letter.
    Error &&WithRemedy(std::string remedy) &&;
    template <typename Arg, typename... Args>
    Error &&WithRemedy(fmt::format_string<Arg, Args...> format, Arg &&arg, Args &&...args) && {
        return std::move(*this).WithRemedy(fmt::vformat(format, fmt::make_format_args(arg, args...)));
    }
    // Quotes the line of the source below the message, with a caret under the place's column.
    Error &&WithSourceLine(std::string_view line) &&;

    // Notes that pbrt-v3 prints a message here and goes on, and what it does instead ("the shape is left
    // out").
    Error &&WithPbrtInstead(std::string instead) &&;
    template <typename Arg, typename... Args>
    Error &&WithPbrtInstead(fmt::format_string<Arg, Args...> format, Arg &&arg, Args &&...args) && {
        return std::move(*this).WithPbrtInstead(fmt::vformat(format, fmt::make_format_args(arg, args...)));
    }
    // Is thrown whatever pbrt-v3 does: nobody goes on after this one.
    Error &&Finally() &&;
    // Goes on as pbrt-v3 does, with a Warning of this kind; where pbrt-v3 does not, throws this again.
    void GoOnAsPbrt(const std::string &kind) const;

    const FileLoc &Place() const { return place_; }
    const std::string &What() const { return what_; }
    const std::string &Remedy() const { return remedy_; }
    // Returns what and remedy without the place: for a caller who knows the place and throws again.
    std::string Message() const;
    // All of it, "file:line:col: error: what; remedy".
    const char *what() const noexcept override { return printed_.c_str(); }

  private:
    void Print();
    bool isFinal_ = false;
    FileLoc place_;
    std::string what_, remedy_, instead_;
    std::string quotedLine_; // and a caret under the column
    std::string usedAt_;     // the directive under way that made another file be read
    std::string printed_;
};

// While it lives, errors and warnings of this thread that know no place of their own are at this one: the
// directive whose object is being made. Those at a place in another file (a mesh, a groom) say that it was
// used here. The innermost scope counts. ParallelFor carries it to the threads that help.
class PlaceScope {
  public:
    explicit PlaceScope(const FileLoc &loc);
    ~PlaceScope();
    PlaceScope(const PlaceScope &) = delete;
    PlaceScope &operator=(const PlaceScope &) = delete;

  private:
    FileLoc loc_;
    const FileLoc *outer_;
};

// Takes the warnings of a render. kind is a short fixed text ("unknown texture class") that repeats share;
// message is complete, with its place. Safe from any thread. May throw Error to refuse.
class WarningSink {
  public:
    virtual ~WarningSink() = default;
    virtual void Warn(const FileLoc &place, const std::string &kind, const std::string &message) = 0;
};

// While it lives, warnings of this thread (and of those that help it in ParallelFor) go to this sink. The
// innermost scope counts; without any, each warning is printed on standard error.
class WarningScope {
  public:
    explicit WarningScope(WarningSink *sink);
    ~WarningScope();
    WarningScope(const WarningScope &) = delete;
    WarningScope &operator=(const WarningScope &) = delete;

  private:
    WarningSink *outer_;
};

// The usual sink: prints a warning on standard error once per kind and counts the repeats.
class WarningLog : public WarningSink {
  public:
    // strict: every warning becomes an Error (cuticle render --strict).
    explicit WarningLog(bool strict = false) : strict_(strict) {}
    void Warn(const FileLoc &place, const std::string &kind, const std::string &message) override;
    // Prints "kind: N more of this kind" for the kinds that repeated, and forgets all. Returns how many
    // warnings (repeats included) there were since the last call.
    size_t Flush();

  private:
    bool strict_;
    std::mutex mutex_;
    std::map<std::string, size_t> counts_;
};

// Hands a warning to the sink of this thread. message is the whole sentence, without place.
void Warning(const FileLoc &loc, const std::string &kind, const std::string &message);
void Warning(const std::string &kind, const std::string &message);

// While it lives, this thread (and those that help it in ParallelFor) opens no file outside of a folder:
// scenes of strangers are read so. files/file.h keeps to it. Throws Error where the folder is none.
class SandboxScope {
  public:
    explicit SandboxScope(const std::string &folder);
    ~SandboxScope();
    SandboxScope(const SandboxScope &) = delete;
    SandboxScope &operator=(const SandboxScope &) = delete;
    // The folder of the innermost scope, without links and with a slash at its end; null: there is none.
    static const std::string *Folder();

  private:
    std::string folder_;
    const std::string *outer_;
};

// A thread that helps another takes this over from it: sink, place, sandbox. Copies share nothing that
// changes.
class ThreadContext {
  public:
    ThreadContext();    // of this thread
    void Apply() const; // on the thread that helps
    bool operator==(const ThreadContext &) const = default;

  private:
    WarningSink *sink_;
    const FileLoc *place_;
    const std::string *sandbox_;
};

// "Did you mean "x"?" for the name nearest to `name` by edit distance, or "Known are: a, b, c." when none is
// near. names: the valid ones. Long names are not compared and are cut.
std::string Suggestion(std::string_view name, const std::string_view *names, size_t count);

} // namespace cuticle
