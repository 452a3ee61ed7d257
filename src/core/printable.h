// Text of strangers (scenes, names of files) is shown on a terminal in a form that does nothing there.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <memory>
#include <streambuf>
#include <string>
#include <string_view>

namespace cuticle {

// Replaces all that would move a terminal's cursor, change its state or hide what is written by an escape
// that can be seen: control characters (\n, \x1b, \u0085; a tab becomes a blank), marks that turn the
// direction of writing or take no room (\u202e), and bytes that are no UTF-8 (\xff). All else stays as it
// is.
std::string Printable(std::string_view text);

// How many columns a printable text takes, where each character takes one.
size_t Columns(std::string_view printable);

// While it lives, what is written to the stream passes through Printable(); ends of lines and tabs stay. The
// program sets one on each of its outputs, so that nothing reaches a terminal raw, whoever prints it.
class PrintableOutput {
  public:
    explicit PrintableOutput(std::ostream *stream);
    ~PrintableOutput();
    PrintableOutput(const PrintableOutput &) = delete;
    PrintableOutput &operator=(const PrintableOutput &) = delete;

  private:
    std::ostream &stream_;
    std::unique_ptr<std::streambuf> filter_;
    std::streambuf *original_;
};

} // namespace cuticle
