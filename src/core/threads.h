// Threads carry a list of inputs along, and are counted before loops (core/parallel.h) rely on them.
#pragma once

#include <cstddef>

namespace cuticle {

// The list where this thread notes the files that it reads (files/inputs.h), null for none. Set by InputScope
// alone; threads that help in a loop take it over.
class InputLog;
InputLog *&CurrentInputLog();

// How many threads the system lets this process have at once now, the calling one included: it starts as
// many as `wanted`, ends them again, and counts. A limit on processes or on addresses allows fewer, and a
// loop that cannot start its threads may end the program: who gets fewer than wanted (half of what the
// limits allow, at least 1) sets a ThreadLimit.
size_t StartableThreads(size_t wanted);

} // namespace cuticle
