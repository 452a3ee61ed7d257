// The memory that a render may take: large things are claimed before they are allocated, and refused where
// all together would not fit.
#pragma once

#include "core/error.h"

#include <cstdint>
#include <mutex>
#include <string>

namespace cuticle {

// Adds up the claims of a render. Safe from any thread.
class MemoryBudget {
  public:
    explicit MemoryBudget(uint64_t limit) : limit_(limit) {} // bytes

    // what: "the film of 1280 x 720 pixels". Throws Error at loc where all claims so far and this one are
    // more than the limit; it names the largest of them, its size and its place. Claims are not given back.
    void Claim(const std::string &what, uint64_t bytes, const FileLoc &loc);

  private:
    const uint64_t limit_;
    std::mutex mutex_;
    uint64_t claimed_ = 0, largest_ = 0;
    std::string largestWhat_;
    FileLoc largestLoc_;
};

// While it lives, ClaimMemory on this thread claims from this budget; null: nothing is counted.
class MemoryBudgetScope {
  public:
    explicit MemoryBudgetScope(MemoryBudget *budget);
    ~MemoryBudgetScope();
    MemoryBudgetScope(const MemoryBudgetScope &) = delete;
    MemoryBudgetScope &operator=(const MemoryBudgetScope &) = delete;

  private:
    MemoryBudget *outer_;
};

// Claims from this thread's budget, if there is one. Without a place, that of the PlaceScope counts.
void ClaimMemory(const std::string &what, uint64_t bytes, const FileLoc &loc = {});
// Whether a claim counts: for callers to whom the text of one is dear.
bool MemoryIsLimited();

// Reads "4G", "512M", "64k", "1.5G" or a number of bytes, in powers of 1024. Throws Error for anything else.
uint64_t ParseByteSize(const std::string &text);
// "1.5 GB", in powers of 1024, for messages.
std::string ByteSizeText(uint64_t bytes);

} // namespace cuticle
