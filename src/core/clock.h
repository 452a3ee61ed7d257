// Clocks: how long something took, by the wall and by the processor. A duration is the difference of two
// readings:
//
//     const double start = WallSeconds();
//     ...
//     const double seconds = WallSeconds() - start;
#pragma once

#include <string>

namespace cuticle {

// Time of the wall, in seconds since some fixed moment of this run. It never goes back.
double WallSeconds();
// CPU time that the calling thread has used, in seconds: a measurement on one thread, whatever else the
// machine does.
double ThreadCpuSeconds();
// CPU time, in seconds, of all threads of this process and of its children that have ended and were waited
// for: a measurement of parallel loops and of other programs.
double ProcessCpuSeconds();

// Writes a duration (seconds >= 0) as people read it: "12.3s", "4m05s", "2h30m".
std::string DurationText(double seconds);

} // namespace cuticle
