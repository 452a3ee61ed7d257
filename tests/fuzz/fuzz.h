// The fuzz targets share this: an Error is the right answer to bad input, anything else that leaves a reader
// is not.
#pragma once

#include "core/error.h"
#include "warnings.h"

#include <cstdint>
#include <iostream>
#include <string>

namespace cuticle {

// Runs a reader; false where it refused its input. Whatever is not an Error ends the target.
template <class Reader>
bool Accepts(const Reader &read) {
    static const bool quiet = [] {
        std::cerr.setstate(std::ios::failbit); // warnings: millions of them
        return true;
    }();
    static_cast<void>(quiet);
    bool accepted = true;
    try {
        read();
    } catch (const Error &) {
        accepted = false;
    }
    FlushWarnings();
    return accepted;
}

// Ends the target where a law is broken.
inline void Require(bool holds) {
    if (!holds)
        __builtin_trap();
}

inline std::string Text(const uint8_t *data, size_t size) {
    return {reinterpret_cast<const char *>(data), size};
}

} // namespace cuticle
