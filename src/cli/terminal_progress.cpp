#include "cli/terminal_progress.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <string>
#include <unistd.h>

namespace cuticle {

TerminalProgress::TerminalProgress() : isTerminal_(isatty(STDERR_FILENO)) {}

TerminalProgress::~TerminalProgress() {
    if (isTerminal_)
        std::fputs("\r\033[K", stderr);
}

void TerminalProgress::Report(uint64_t done, uint64_t total) {
    if (!isTerminal_)
        return;
    const double elapsed = WallSeconds() - start_;
    if (elapsed < lastShown_ + 0.2)
        return;
    lastShown_ = elapsed;
    const double fraction = static_cast<double>(done) / static_cast<double>(total);
    constexpr size_t kWidth = 30;
    const std::string bar(static_cast<size_t>(fraction * kWidth), '#');
    fmt::print(stderr, "\rRendering [{:<{}}] {:5.1f}%  {} elapsed, {} left \033[K", bar, kWidth,
               100 * fraction, DurationText(elapsed),
               DurationText(elapsed * (1 - fraction) / std::max(fraction, 1e-9)));
}

} // namespace cuticle
