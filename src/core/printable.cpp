#include "core/printable.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ostream>
#include <utility>

namespace cuticle {

namespace {

// A character at the start of a text.
struct Decoded {
    enum class Kind { Whole, Cut, Invalid };
    Kind kind = Kind::Invalid;
    size_t bytes = 1; // that it takes; 1 where they are no UTF-8
    uint32_t code = 0;
};

// Reads one character of UTF-8. Cut: the text ends before the character does. Invalid: overlong forms, halves
// of surrogate pairs and codes beyond U+10FFFF too.
Decoded DecodeUTF8(std::string_view text) {
    const auto first = static_cast<unsigned char>(text[0]);
    if (first < 0x80)
        return {Decoded::Kind::Whole, 1, first};
    const size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    if (first < 0xc2 || first > 0xf4)
        return {};
    uint32_t code = first & (0xffu >> (size + 1));
    for (size_t i = 1; i < size; ++i) {
        if (i == text.size())
            return {Decoded::Kind::Cut, text.size(), 0};
        const auto next = static_cast<unsigned char>(text[i]);
        if ((next & 0xc0) != 0x80)
            return {};
        code = code << 6 | (next & 0x3f);
    }
    constexpr std::array<uint32_t, 5> kSmallest{0, 0, 0x80, 0x800, 0x10000};
    if (code < kSmallest[size] || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff))
        return {};
    return {Decoded::Kind::Whole, size, code};
}

// Characters that act instead of being seen, from Unicode's general categories Cc, Cf, Zl and Zp.
bool IsHidden(uint32_t code) {
    // To add a range: here, in order.
    static constexpr std::array<std::pair<uint32_t, uint32_t>, 17> kHidden{{
        {0x00, 0x1f},       // control characters
        {0x7f, 0x9f},       // delete, and the second set of control characters
        {0xad, 0xad},       // soft hyphen
        {0x600, 0x605},     // Arabic marks around numbers
        {0x61c, 0x61c},     // Arabic letter mark
        {0x6dd, 0x6dd},     // Arabic end of ayah
        {0x70f, 0x70f},     // Syriac abbreviation mark
        {0x890, 0x891},     // Arabic marks above money
        {0x8e2, 0x8e2},     // Arabic disputed end of ayah
        {0x180e, 0x180e},   // Mongolian vowel separator
        {0x200b, 0x200f},   // zero widths, and marks of direction
        {0x2028, 0x202e},   // ends of lines and paragraphs, embeddings and overrides of direction
        {0x2060, 0x206f},   // joiners, isolates of direction
        {0xfeff, 0xfeff},   // byte order mark
        {0xfff9, 0xfffb},   // annotations
        {0x1bca0, 0x1bca3}, // shorthand format controls
        {0xe0000, 0xe0fff}, // tags
    }};
    return std::any_of(kHidden.begin(), kHidden.end(),
                       [&](const auto &range) { return code >= range.first && code <= range.second; });
}

std::string Escaped(uint32_t code) {
    return code == '\n'     ? "\\n"
           : code == '\r'   ? "\\r"
           : code < 0x80    ? fmt::format("\\x{:02x}", code)
           : code < 0x10000 ? fmt::format("\\u{:04x}", code)
                            : fmt::format("\\U{:08x}", code);
}

// Appends the text to `out`, less a character at its end that is cut, which is returned. lines: ends of lines
// and tabs stay.
std::string_view AppendPrintable(std::string_view text, bool lines, std::string *out) {
    while (!text.empty()) {
        const Decoded c = DecodeUTF8(text);
        if (c.kind == Decoded::Kind::Cut)
            break;
        if (c.kind == Decoded::Kind::Invalid)
            *out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
        else if (c.code == '\t' || (lines && c.code == '\n'))
            *out += lines || c.code != '\t' ? text[0] : ' ';
        else if (IsHidden(c.code))
            *out += Escaped(c.code);
        else
            out->append(text.substr(0, c.bytes));
        text.remove_prefix(c.bytes);
    }
    return text;
}

class PrintableBuffer : public std::streambuf {
  public:
    explicit PrintableBuffer(std::streambuf *to) : to_(to) {}

  protected:
    int_type overflow(int_type c) override {
        if (traits_type::eq_int_type(c, traits_type::eof()))
            return traits_type::not_eof(c);
        const char byte = traits_type::to_char_type(c);
        return xsputn(&byte, 1) == 1 ? c : traits_type::eof();
    }
    std::streamsize xsputn(const char *bytes, std::streamsize count) override {
        cut_.append(bytes, static_cast<size_t>(count));
        std::string out;
        cut_ = std::string(AppendPrintable(cut_, true, &out));
        const auto size = static_cast<std::streamsize>(out.size());
        return to_->sputn(out.data(), size) == size ? count : 0;
    }
    int sync() override { return to_->pubsync(); }

  private:
    std::streambuf *to_;
    std::string cut_; // the beginning of a character whose other bytes have not come yet
};

} // namespace

std::string Printable(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (const char byte : AppendPrintable(text, false, &out))
        out += fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
    return out;
}

size_t Columns(std::string_view printable) {
    return static_cast<size_t>(std::count_if(printable.begin(), printable.end(), [](char c) {
        return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
    }));
}

PrintableOutput::PrintableOutput(std::ostream *stream)
    : stream_(*stream), filter_(std::make_unique<PrintableBuffer>(stream->rdbuf())),
      original_(stream->rdbuf(filter_.get())) {}

PrintableOutput::~PrintableOutput() {
    stream_.flush();
    stream_.rdbuf(original_);
}

} // namespace cuticle
