// Asks every model of the table for values and samples at random and extreme inputs, for as long as it is
// told: no answer may be NaN, infinite or negative, and none may take for ever. The suite has a few seconds
// of it (test fibers.endurance); before a release an hour of one core:
//
//   cmake --build --preset release --target endure_fibers
//   build/release/endure_fibers --minutes 60
//
// A fault prints its inputs to the last bit, as C++ for a test of their own, and the exit status is 1.
#include "core/error.h"
#include "fibers/model_edges.h"

#include <CLI/CLI.hpp>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <optional>
#include <thread>

namespace cuticle {
namespace {

using Clock = std::chrono::steady_clock;

struct Settings {
    double minutes = 1, most = 1e9, mostOfOthers = 1e7;
    unsigned threads = 1;
    uint64_t seed = 1;
    std::string only;
};

// This is what a thread is at, for the watch and for a crash to tell.
struct Work {
    std::mutex mutex; // of all but `answers`
    const FiberModel *model = nullptr;
    FiberInputs at;
    std::vector<OwnValue> own;
    std::optional<edges::Query> query; // none while the fiber is prepared
    std::atomic<uint64_t> answers = 0; // counts up with all that the thread finishes
};
std::deque<Work> &AllWork() {
    static std::deque<Work> work;
    return work;
}
void Tell(const Work &work, const std::string &what) {
    std::printf("FAULT %s: %s\n  %s\n  own = %s;\n  query = %s;\n", std::string(work.model->name).c_str(),
                what.c_str(), edges::Text(work.at).c_str(), edges::Text(work.own).c_str(),
                work.query ? edges::Text(*work.query).c_str() : "none yet, the fiber is being prepared");
    std::fflush(stdout);
}
void TellAndDie(int signal) {
    std::signal(signal, SIG_DFL);
    for (const Work &work : AllWork())
        if (work.model)
            Tell(work, fmt::format("signal {} in this thread or another", signal));
    std::raise(signal);
}

// A model's share of the run, by all threads.
struct Tally {
    std::atomic<uint64_t> round = 0, answers = 0, refused = 0, faults = 0;
    uint64_t wanted = 0;
    Clock::time_point end;
    // Some answers of each model there are however busy the machine is.
    bool Done() const {
        return answers >= wanted || faults >= 5 || (Clock::now() > end && (answers > 0 || refused > 100));
    }
};

// Answers of one set of parameters. Refused parameters (a table where it cannot be one) are an answer, too.
void RunRound(const FiberModel &model, uint64_t seed, Work &work, Tally &tally) {
    edges::Chooser c(seed);
    {
        const std::lock_guard lock(work.mutex);
        work.model = &model;
        work.at = edges::EdgeInputs(c, model), work.own = edges::EdgeOwn(c, model);
        work.query.reset();
    }
    std::unique_ptr<PreparedFiber> fiber;
    try {
        fiber = std::make_unique<PreparedFiber>(model, work.at, work.own);
    } catch (const Error &) {
        ++tally.refused, ++work.answers;
        return;
    }
    const int queries = model.inCells ? 20000 : model.farField ? 2000 : 200;
    for (int i = 0; i < queries && !(i > 0 && i % 100 == 0 && Clock::now() > tally.end); ++i) {
        const edges::Query query = edges::EdgeQuery(c);
        {
            const std::lock_guard lock(work.mutex);
            work.query = query;
        }
        FiberStorage storage;
        fiber->Make(query.h, &storage);
        const std::string fault = edges::FaultAt(*storage.Get(), query);
        ++work.answers, ++tally.answers;
        if (!fault.empty()) {
            ++tally.faults;
            Tell(work, fault);
            return;
        }
    }
}

// This is what all threads of the process have worked.
double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Ends the program where a thread does not answer within a minute of work for each thread. Work is counted
// in the process's CPU time, as a hang burns it in whichever thread a parallel loop put it, while a busy
// machine, on which an answer may wait for long, is no fault of a model. A deadlock burns none: an hour of
// the clock.
class Watch {
  public:
    Watch() : thread_([this] { Run(); }) {}
    ~Watch() {
        done_ = true;
        thread_.join();
    }

  private:
    void Run() {
        struct Answer {
            uint64_t count;
            double cpu;
            Clock::time_point time;
        };
        const double most = 60. * static_cast<double>(AllWork().size());
        std::vector<Answer> last(AllWork().size(), {0, CpuSeconds(), Clock::now()});
        while (!done_) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            for (size_t i = 0; i < last.size(); ++i) {
                Work &work = AllWork()[i];
                if (last[i].count != work.answers || !work.model)
                    last[i] = {work.answers, CpuSeconds(), Clock::now()};
                else if (CpuSeconds() - last[i].cpu > most ||
                         Clock::now() - last[i].time > std::chrono::hours(1)) {
                    const std::lock_guard lock(work.mutex);
                    Tell(work, fmt::format("no answer in {:.0f} s of CPU time", CpuSeconds() - last[i].cpu));
                    std::_Exit(1);
                }
            }
        }
    }
    std::atomic<bool> done_ = false;
    std::thread thread_;
};

int Run(const Settings &settings) {
    std::vector<const FiberModel *> models;
    for (const FiberModel &model : FiberModels())
        if (settings.only.empty() || model.name == settings.only)
            models.push_back(&model);
    for (unsigned i = 0; i < settings.threads; ++i)
        AllWork().emplace_back();
    for (const int signal : {SIGABRT, SIGSEGV, SIGFPE})
        std::signal(signal, TellAndDie);
    const Watch watch;
    const auto begin = Clock::now();
    uint64_t faults = 0;
    for (size_t m = 0; m < models.size(); ++m) {
        const auto start = Clock::now();
        const double left = settings.minutes * 60 - std::chrono::duration<double>(start - begin).count();
        Tally tally;
        const bool isDefault = models[m] == &FiberModels().front();
        tally.wanted = static_cast<uint64_t>(isDefault ? settings.most : settings.mostOfOthers);
        tally.end = start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
                                std::max(0., left) / static_cast<double>(models.size() - m)));
        std::vector<std::thread> threads;
        for (unsigned i = 0; i < settings.threads; ++i)
            threads.emplace_back([&, i] {
                while (!tally.Done())
                    RunRound(*models[m], MixBits(settings.seed ^ MixBits(m + 1)) + tally.round++,
                             AllWork()[i], tally);
                const std::lock_guard lock(AllWork()[i].mutex);
                AllWork()[i].model = nullptr;
            });
        for (std::thread &thread : threads)
            thread.join();
        std::printf("%-12s %12llu answers, %8llu sets of parameters (%llu refused), %llu faults, %.0f s\n",
                    std::string(models[m]->name).c_str(), static_cast<unsigned long long>(tally.answers),
                    static_cast<unsigned long long>(tally.round),
                    static_cast<unsigned long long>(tally.refused),
                    static_cast<unsigned long long>(tally.faults),
                    std::chrono::duration<double>(Clock::now() - start).count());
        std::fflush(stdout);
        faults += tally.faults;
        if (tally.answers == 0)
            ++faults;
    }
    return faults > 0 ? 1 : 0;
}

} // namespace
} // namespace cuticle

int main(int argc, char **argv) {
    cuticle::Settings settings;
    CLI::App app(
        "Asks every fiber model at random and extreme inputs, and reports answers that are no number.");
    app.add_option("--minutes", settings.minutes, "the time for all models, shared out evenly (default: 1)");
    app.add_option("--default", settings.most, "answers of the default model are enough (default: 1e9)");
    app.add_option("--others", settings.mostOfOthers,
                   "answers of each other model are enough (default: 1e7)");
    app.add_option("--threads", settings.threads, "threads (default: 1)")->check(CLI::Range(1, 1024));
    app.add_option("--seed", settings.seed, "another seed, other inputs (default: 1)");
    app.add_option("--model", settings.only, "this model alone, by the name of its row");
    CLI11_PARSE(app, argc, argv);
    return cuticle::Run(settings);
}
