// How far a render is: what a job tells whoever started it.
#pragma once

#include <cstdint>

namespace cuticle {

// Takes a job's progress. Calls come from any thread, but one at a time.
class ProgressSink {
  public:
    virtual ~ProgressSink() = default;
    // Says that `done` of `total` samples, of all pixels together, are taken; done grows from call to call.
    virtual void Report(uint64_t done, uint64_t total) = 0;
};

} // namespace cuticle
