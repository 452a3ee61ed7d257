// A line on the terminal that shows how far a render or a simulation is.
#pragma once

#include "core/clock.h"
#include "render/progress.h"

#include <string_view>

namespace cuticle {

// Rewrites one line of standard error at most five times a second, and erases it at the end. Says nothing
// where standard error is no terminal.
class TerminalProgress : public ProgressSink {
  public:
    // doing: "Rendering", "Simulating"; lives as long as the program.
    explicit TerminalProgress(std::string_view doing = "Rendering");
    ~TerminalProgress() override;
    void Report(uint64_t done, uint64_t total) override;

  private:
    std::string_view doing_;
    bool isTerminal_;
    uint64_t first_ = 0;                           // samples that were there before
    double start_ = WallSeconds(), lastShown_ = 0; // lastShown_: in seconds after the start
};

} // namespace cuticle
