// The readers of binary strands share this: values by their place, and errors that name it.
#pragma once

#include "core/error.h"
#include "core/vecmath.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

namespace cuticle {

static_assert(std::endian::native == std::endian::little, "the files are little-endian, and read by memcpy");

// Holds the bytes of a file, and its name for messages; both must outlive it.
struct BinaryFile {
    std::string_view bytes;
    const std::string &name;

    // Throws Error at a byte of the file; what is wrong is a format string and its values, or plain text.
    [[noreturn]] void Fail(size_t byte, std::string_view what) const {
        throw Error(FileLoc{std::make_shared<const std::string>(name)}, "byte {}: {}", byte, what);
    }
    template <typename Arg, typename... Args>
    [[noreturn]] void Fail(size_t byte, fmt::format_string<Arg, Args...> format, Arg &&arg,
                           Args &&...args) const {
        Fail(byte, fmt::vformat(format, fmt::make_format_args(arg, args...)));
    }

    // Reads a value; the caller has checked that the value lies within the file.
    template <typename T>
    T Read(size_t offset) const {
        T v;
        std::memcpy(&v, bytes.data() + offset, sizeof v);
        return v;
    }

    // Throws where `count` values of `size` bytes from `at` on do not lie within the file; count must fit 32
    // bits.
    void NeedArray(size_t at, size_t count, size_t size, const std::string &what) const {
        if (at <= bytes.size() && count * size <= bytes.size() - at)
            return;
        Fail(bytes.size(), "the file ends within the {}: {} of them need {} bytes from byte {}", what, count,
             count * size, at);
    }

    // Throws at the first value that is not `valid`.
    template <typename Valid>
    void ReadFloats(size_t offset, size_t count, float *out, const std::string &what, Valid valid) const {
        if (count == 0)
            return;
        std::memcpy(out, bytes.data() + offset, count * sizeof(float));
        for (size_t i = 0; i < count; ++i)
            if (!valid(out[i]))
                Fail(offset + i * sizeof(float), "{} is {:f}", what, out[i]);
    }
};

// Whether a width or a part of a colour makes sense.
inline bool IsNotNegative(float v) { return v >= 0 && std::isfinite(v); }
// Whether a coordinate of a point makes sense: those further out cannot be squared in binary32.
inline bool IsCoordinate(float v) { return std::abs(v) <= kMaxCoordinate; }

} // namespace cuticle
