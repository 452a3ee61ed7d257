// What the readers of binary strands share: values by their place, and errors that name it.
#pragma once

#include "core/error.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

namespace cuticle {

static_assert(std::endian::native == std::endian::little, "the files are little-endian, and read by memcpy");

// Bytes of a file, and its name for messages.
struct BinaryFile {
    std::string_view bytes;
    const std::string &name;

    [[noreturn]] void Fail(size_t byte, const std::string &what) const {
        throw Error(FileLoc{std::make_shared<const std::string>(name)},
                    "byte " + std::to_string(byte) + ": " + what);
    }

    // The caller has checked that the value lies within the file.
    template <typename T>
    T Read(size_t offset) const {
        T v;
        std::memcpy(&v, bytes.data() + offset, sizeof v);
        return v;
    }

    // Throws where `count` values of `size` bytes from `at` on do not lie within the file; count must fit 32 bits.
    void NeedArray(size_t at, size_t count, size_t size, const std::string &what) const {
        if (at <= bytes.size() && count * size <= bytes.size() - at)
            return;
        Fail(bytes.size(), "the file ends within the " + what + ": " + std::to_string(count) +
                               " of them need " + std::to_string(count * size) + " bytes from byte " +
                               std::to_string(at));
    }

    // Throws at the first value that is not `valid`.
    template <typename Valid>
    void ReadFloats(size_t offset, size_t count, float *out, const std::string &what, Valid valid) const {
        if (count == 0)
            return;
        std::memcpy(out, bytes.data() + offset, count * sizeof(float));
        for (size_t i = 0; i < count; ++i)
            if (!valid(out[i]))
                Fail(offset + i * sizeof(float), what + " is " + std::to_string(out[i]));
    }
};

// Widths and colours.
inline bool IsNotNegative(float v) { return v >= 0 && std::isfinite(v); }
// Points further out than this cannot be squared in binary32; no unit of length makes hair that long.
inline bool IsCoordinate(float v) { return std::abs(v) <= 1e18f; }

} // namespace cuticle
