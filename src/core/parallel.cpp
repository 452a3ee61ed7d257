#include "core/parallel.h"

#include "core/error.h"

#include <algorithm>

#ifdef CUTICLE_WITH_TBB
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace cuticle {

#ifdef CUTICLE_WITH_TBB

void ParallelForRange(size_t count, size_t grain, const std::function<void(size_t, size_t)> &body) {
    const ThreadContext caller;
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                      [&](const tbb::blocked_range<size_t> &piece) {
                          // A thread that waits inside a loop of its own may run this piece meanwhile: it
                          // gets its context back.
                          const ThreadContext own;
                          struct Restore {
                              const ThreadContext &context;
                              ~Restore() { context.Apply(); }
                          } restore{own};
                          caller.Apply();
                          body(piece.begin(), piece.end());
                      });
}

void Isolated(const std::function<void()> &f) { tbb::this_task_arena::isolate(f); }

void OnThreads(size_t threads, const std::function<void()> &f) {
    tbb::task_arena arena(threads > 0 ? static_cast<int>(threads) : tbb::task_arena::automatic);
    arena.execute(f);
}

size_t MaxThreads() {
    return std::min(static_cast<size_t>(tbb::this_task_arena::max_concurrency()),
                    tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

struct ThreadLimit::Impl {
    tbb::global_control control;
};
ThreadLimit::ThreadLimit(size_t threads)
    : impl_(new Impl{{tbb::global_control::max_allowed_parallelism, std::max<size_t>(1, threads)}}) {}

#else

void ParallelForRange(size_t count, size_t, const std::function<void(size_t, size_t)> &body) {
    if (count > 0)
        body(0, count);
}
void Isolated(const std::function<void()> &f) { f(); }
void OnThreads(size_t, const std::function<void()> &f) { f(); }
size_t MaxThreads() { return 1; }
struct ThreadLimit::Impl {};
ThreadLimit::ThreadLimit(size_t) {}

#endif

ThreadLimit::~ThreadLimit() = default;

} // namespace cuticle
