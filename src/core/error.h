// Errors and warnings that name file, line and column (the habit is pbrt-v4's).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace cuticle {

// A place in a text file; line and column count from 1, 0 = not known. Cheap to copy: the name is shared.
struct FileLoc {
    std::shared_ptr<const std::string> file;
    uint32_t line = 0, column = 0;
    std::string ToString() const; // "file:line:col", as much of it as is known
};

// Carries a complete message, "file:line:col: error: what, and what would be right". The program prints it and
// exits with status 1; a library user catches it.
class Error : public std::runtime_error {
  public:
    // Without a place of its own it takes that of the PlaceScope, if there is one.
    explicit Error(const std::string &message);
    // A quoted source line, if given, is added below the message with a caret under the column.
    Error(const FileLoc &loc, const std::string &message, std::string_view sourceLine = {});
};

// The message of an error that knows no place, without "error: " in front: for a caller who knows it and throws again.
std::string Reason(const Error &e);

// While it lives, errors and warnings of this thread that know no place of their own are at this one: the directive
// whose object is being made. Those at a place in another file (a mesh, a groom) say that it was used here. The
// innermost scope counts.
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

// Reports a warning on standard error, once per kind: repeats of one kind are counted and summed up by
// FlushWarnings(). kind is a short fixed text ("unknown texture class"), message the whole sentence. With strict
// warnings on, throws Error instead. Safe from any thread.
void Warning(const FileLoc &loc, const std::string &kind, const std::string &message);
void Warning(const std::string &kind, const std::string &message);

// Makes every warning an Error (cuticle render --strict).
void SetStrictWarnings(bool strict);
// Prints "... and N more of this kind" for the kinds that repeated, and forgets all. Returns how many warnings
// (repeats included) there were since the last call.
size_t FlushWarnings();

// " Did you mean "x"?" for the name nearest to `name` by edit distance, or " Known are: a, b, c." when none is
// near. names: the valid ones.
std::string Suggestion(std::string_view name, const std::string_view *names, size_t count);

} // namespace cuticle
