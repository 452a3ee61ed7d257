// Tests of messages ask here for the message of what a call throws.
#pragma once

#include "core/error.h"

#include <functional>
#include <string>

namespace cuticle {

// The text of the Error that f throws, "" if it throws none.
inline std::string MessageOf(const std::function<void()> &f) {
    try {
        f();
    } catch (const Error &e) {
        return e.what();
    }
    return "";
}

} // namespace cuticle
