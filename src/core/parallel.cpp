#include "core/parallel.h"

#include "core/error.h"
#include "core/threads.h"

#include <algorithm>

#ifdef CUTICLE_WITH_TBB
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <vector>
#endif

namespace cuticle {

#ifdef CUTICLE_WITH_TBB

void ParallelForRange(size_t count, size_t grain, const std::function<void(size_t, size_t)> &body) {
    const ThreadContext caller;
    InputLog *const callersInputs = CurrentInputLog();
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                      [&](const tbb::blocked_range<size_t> &piece) {
                          // A thread that waits inside a loop of its own may run this piece meanwhile: it
                          // gets its context back.
                          const ThreadContext own;
                          struct Restore {
                              const ThreadContext &context;
                              InputLog *inputs;
                              ~Restore() {
                                  context.Apply();
                                  CurrentInputLog() = inputs;
                              }
                          } restore{own, CurrentInputLog()};
                          caller.Apply();
                          CurrentInputLog() = callersInputs;
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

size_t StartableThreads(size_t wanted) {
    std::mutex heldUntilAllRun;
    std::atomic<size_t> ready = 0;
    std::vector<std::thread> threads;
    {
        const std::lock_guard lock(heldUntilAllRun);
        try {
            threads.reserve(wanted);
            while (threads.size() + 1 < wanted) {
                // The first allocation of a thread may take more addresses than its stack
                threads.emplace_back([&] {
                    void *volatile own = std::malloc(1000);
                    std::free(own);
                    ready.fetch_add(1);
                    ready.notify_all();
                    const std::lock_guard wait(heldUntilAllRun);
                });
                for (size_t seen = ready; seen < threads.size(); seen = ready)
                    ready.wait(seen);
            }
        } catch (const std::exception &) { // no thread, or no memory for one
        }
    }
    for (std::thread &thread : threads)
        thread.join();
    if (threads.size() + 1 >= wanted)
        return wanted;
    // The other half of the room is left for whatever else the program needs; and those of this half start
    // now, while there is room: each waits for all others, on a busy machine for a second at most. The loop
    // has an arena of its own, as one that is not asked for takes no more threads than there are cores.
    const size_t count = (threads.size() + 1) / 2 + (threads.empty() ? 1 : 0);
    const ThreadLimit limit(count);
    std::atomic<size_t> started = 0;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(1);
    OnThreads(count, [&] {
        ParallelFor(count, [&](size_t) {
            ++started;
            while (started < count && std::chrono::steady_clock::now() < deadline)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
        });
    });
    return count;
}

#else

void ParallelForRange(size_t count, size_t, const std::function<void(size_t, size_t)> &body) {
    if (count > 0)
        body(0, count);
}
void Isolated(const std::function<void()> &f) { f(); }
void OnThreads(size_t, const std::function<void()> &f) { f(); }
size_t MaxThreads() { return 1; }
size_t StartableThreads(size_t) { return 1; }
struct ThreadLimit::Impl {};
ThreadLimit::ThreadLimit(size_t) {}

#endif

InputLog *&CurrentInputLog() {
    thread_local InputLog *current = nullptr;
    return current;
}

ThreadLimit::~ThreadLimit() = default;

} // namespace cuticle
