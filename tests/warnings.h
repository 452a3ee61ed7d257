// The warnings of a test program: counted between two calls of FlushWarnings, or made errors for a while.
#pragma once

#include "core/error.h"

namespace cuticle {

// Takes all warnings of the main thread, on which tests run, from the program's start.
struct TestWarnings {
    WarningLog log;
    WarningScope scope{&log};
};
inline TestWarnings &WarningsOfTests() {
    static TestWarnings warnings;
    return warnings;
}
inline const TestWarnings &startedWithTheProgram = WarningsOfTests();

// How many warnings there were since the last call.
inline size_t FlushWarnings() { return WarningsOfTests().log.Flush(); }

// While it lives, every warning throws Error.
struct StrictWarnings {
    WarningLog log{true};
    WarningScope scope{&log};
};

} // namespace cuticle
