#include "cli/terminal_progress.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <string>
#include <unistd.h>

namespace cuticle {

TerminalProgress::TerminalProgress(std::string_view doing)
    : doing_(doing), isTerminal_(isatty(STDERR_FILENO)) {}

TerminalProgress::~TerminalProgress() {
    if (isTerminal_)
        std::fputs("\r\033[K", stderr);
}

void TerminalProgress::Report(uint64_t done, uint64_t total) {
    if (!isTerminal_)
        return;
    const double elapsed = WallSeconds() - start_;
    if (lastShown_ == 0)
        first_ = done; // what an earlier run has done says nothing of how fast this one is
    if (elapsed < lastShown_ + 0.2)
        return;
    lastShown_ = elapsed;
    const double fraction = static_cast<double>(done) / static_cast<double>(total);
    constexpr size_t kWidth = 30;
    const std::string bar(static_cast<size_t>(fraction * kWidth), '#');
    const double left = elapsed * static_cast<double>(total - done) /
                        static_cast<double>(std::max<uint64_t>(done - std::min(done, first_), 1));
    // A terminal that is gone is no reason to fail
    std::fputs(fmt::format("\r{} [{:<{}}] {:5.1f}%  {} elapsed, {} left \033[K", doing_, bar, kWidth,
                           100 * fraction, DurationText(elapsed), DurationText(left))
                   .c_str(),
               stderr);
}

} // namespace cuticle
