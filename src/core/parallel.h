// Parallel loops, all that the house needs of threads. Behind it stands oneTBB, whose loops balance
// themselves and may nest; without it (a browser has no threads) the loops run one after the other.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace cuticle {

// Calls body(first, last) for pieces that together cover [0, count), on this thread and those that are free;
// a piece has at least `grain` steps where it is divided (> 0). Pieces run in any order: what they write must
// not overlap. The warning sink and the place of errors (core/error.h) are those of the calling thread. The
// first exception that a piece throws stops the loop and is thrown here.
void ParallelForRange(size_t count, size_t grain, const std::function<void(size_t first, size_t last)> &body);

// Calls body(i) for every i in [0, count).
template <typename Body>
void ParallelFor(size_t count, const Body &body) {
    ParallelForRange(count, 1, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i)
            body(i);
    });
}

// Joins map(first, last) over pieces of `grain` steps that cover [0, count), from the left: join(&total,
// piece). The pieces do not depend on the number of threads, so neither does the result. T needs a copy
// constructor.
template <typename T, typename Map, typename Join>
T ParallelReduce(size_t count, size_t grain, const T &identity, const Map &map, const Join &join) {
    std::vector<T> pieces((count + grain - 1) / grain, identity);
    ParallelFor(pieces.size(),
                [&](size_t i) { pieces[i] = map(i * grain, std::min(count, (i + 1) * grain)); });
    T total = identity;
    for (const T &piece : pieces)
        join(&total, piece);
    return total;
}

// Runs f so that this thread, while it waits for loops inside f, takes up no other work: for f that holds a
// lock.
void Isolated(const std::function<void()> &f);

// Runs f so that all loops inside f, also those of libraries on oneTBB, use at most this many threads, the
// calling one included; 0: as many as there are. Other loops of the process are not bounded by it.
void OnThreads(size_t threads, const std::function<void()> &f);
inline void OnOneThread(const std::function<void()> &f) { OnThreads(1, f); }

// How many threads a loop that starts here may use, this one included.
size_t MaxThreads();

// While it lives, loops of the whole process use at most this many threads (at least 1); the smallest limit
// counts.
class ThreadLimit {
  public:
    explicit ThreadLimit(size_t threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit &) = delete;
    ThreadLimit &operator=(const ThreadLimit &) = delete;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace cuticle
