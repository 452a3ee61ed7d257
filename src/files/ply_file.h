// PLY files piece by piece: what their headers say, and their values one after another. Meshes
// (shapes/ply.h) and strands of points (grooms/ply_strands.h) are both read by it.
#pragma once

#include "core/error.h"
#include "files/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

// Hands out bytes one after another, from a file (gzip or not) or from memory, through one buffer.
class PlySource {
  public:
    PlySource(std::string_view bytes, std::string name)
        : name_(std::move(name)), at_(bytes.data()), end_(at_ + bytes.size()) {}
    explicit PlySource(const std::string &filename)
        : name_(filename), file_(std::make_unique<InputFile>(filename, "the PLY file")), buffer_(1 << 18) {}

    // Returns the next byte, or -1 at the end.
    int Peek() { return at_ != end_ || Refill() ? static_cast<unsigned char>(*at_) : -1; }
    int Get() {
        const int c = Peek();
        if (c >= 0)
            ++at_;
        return c;
    }
    // Reads n bytes; false if fewer are left.
    bool Read(void *to, size_t n) {
        auto *out = static_cast<char *>(to);
        while (n > 0) {
            if (at_ == end_ && !Refill())
                return false;
            const size_t part = std::min(n, static_cast<size_t>(end_ - at_));
            std::memcpy(out, at_, part);
            at_ += part, out += part, n -= part;
        }
        return true;
    }
    // Throws Error("<name>: <what>").
    template <typename... Args>
    [[noreturn]] void Fail(fmt::format_string<Args...> what, Args &&...args) const {
        throw Error("{}: {}", name_, fmt::vformat(what, fmt::make_format_args(args...)));
    }
    const std::string &Name() const { return name_; }

  private:
    bool Refill() {
        if (!file_)
            return false;
        try {
            at_ = buffer_.data();
            end_ = at_ + file_->Read(buffer_.data(), buffer_.size());
        } catch (const Error &e) {
            Fail("{}", e.Message());
        }
        return at_ != end_;
    }

    std::string name_;
    std::unique_ptr<InputFile> file_; // none: all bytes are in memory
    std::vector<char> buffer_;
    const char *at_ = nullptr, *end_ = nullptr;
};

enum class PlyType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };
enum class PlyFormat { Ascii, LittleEndian, BigEndian };

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::Float32;
    std::optional<PlyType> countType; // of a list
    int target = -1;                  // for the reader: where it keeps the values; -1: nowhere
};
struct PlyElement {
    std::string name;
    uint64_t count = 0;
    std::vector<PlyProperty> properties;
};
struct PlyHeader {
    PlyFormat format = PlyFormat::Ascii;
    std::vector<PlyElement> elements;
};

// Reads the header; throws Error where it makes no sense.
PlyHeader ReadPlyHeader(PlySource &source);

// Reads values one after another, in any of the three formats.
class PlyValues {
  public:
    PlyValues(PlySource &source, PlyFormat format) : source_(source), format_(format) {}

    double Read(PlyType type) {
        if (format_ == PlyFormat::Ascii)
            return ReadText();
        switch (type) {
        case PlyType::Int8:
            return ReadBinary<int8_t, uint8_t>();
        case PlyType::UInt8:
            return ReadBinary<uint8_t, uint8_t>();
        case PlyType::Int16:
            return ReadBinary<int16_t, uint16_t>();
        case PlyType::UInt16:
            return ReadBinary<uint16_t, uint16_t>();
        case PlyType::Int32:
            return ReadBinary<int32_t, uint32_t>();
        case PlyType::UInt32:
            return ReadBinary<uint32_t, uint32_t>();
        case PlyType::Float32:
            return ReadBinary<float, uint32_t>();
        case PlyType::Float64:
            break;
        }
        return ReadBinary<double, uint64_t>();
    }
    // Reads the length of a list.
    uint64_t ReadCount(const PlyProperty &property) {
        const double v = Read(*property.countType);
        if (!(v >= 0 && v <= 4294967295.0 && v == std::floor(v)))
            source_.Fail("property {}: a list of length {:f}", property.name, v);
        return static_cast<uint64_t>(v);
    }
    void SetPlace(const PlyElement *element, uint64_t index) { element_ = element, index_ = index; }

  private:
    [[noreturn]] void FailTruncated() const {
        source_.Fail("ends at {} {} of {}", element_->name, index_, element_->count);
    }
    template <typename T, typename Bits>
    T ReadBinary() {
        unsigned char bytes[sizeof(Bits)];
        if (!source_.Read(bytes, sizeof bytes))
            FailTruncated();
        Bits bits = 0;
        for (size_t i = 0; i < sizeof bytes; ++i) {
            const size_t place = format_ == PlyFormat::LittleEndian ? i : sizeof bytes - 1 - i;
            bits = static_cast<Bits>(bits | static_cast<Bits>(static_cast<Bits>(bytes[i]) << (8 * place)));
        }
        return std::bit_cast<T>(bits);
    }
    double ReadText() {
        int c;
        while ((c = source_.Get()) == ' ' || (c >= '\t' && c <= '\r')) {
        }
        if (c < 0)
            FailTruncated();
        char word[64];
        size_t n = 0;
        for (; c > ' '; c = source_.Get()) {
            if (n == sizeof word)
                source_.Fail("a number of more than 64 characters at {} {}", element_->name, index_);
            word[n++] = static_cast<char>(c);
        }
        double v = 0;
        const std::string_view text(word, n);
        const bool plus = text.starts_with('+'), minus = text.starts_with('-');
        const auto r = std::from_chars(word + plus, word + n, v);
        if (r.ec == std::errc::result_out_of_range) // v is left alone: too near to 0, or too far
            return text.find("e-") != text.npos || text.find("E-") != text.npos ? 0
                   : minus                                                      ? -HUGE_VAL
                                                                                : HUGE_VAL;
        if (r.ec != std::errc() || r.ptr != word + n)
            source_.Fail("\"{}\" where a number belongs, at {} {}", text, element_->name, index_);
        return v;
    }

    PlySource &source_;
    PlyFormat format_;
    const PlyElement *element_ = nullptr;
    uint64_t index_ = 0;
};

// Limits what is reserved on a header's word alone.
inline size_t CautiousReserve(uint64_t count) {
    return static_cast<size_t>(std::min<uint64_t>(count, 1 << 20));
}

// Reads an element of no use to its end.
void SkipPlyElement(PlyValues &values, const PlyElement &element);

} // namespace cuticle
