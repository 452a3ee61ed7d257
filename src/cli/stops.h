// Signals that ask a long command to stop and to keep what it has.
#pragma once

#include <atomic>

namespace cuticle {

// Makes Ctrl-C and the signals by which a system ends a program (SIGTERM, SIGHUP, SIGXCPU) set StopAsked()
// from the first call on. What the caller has set to be ignored (nohup, a shell's background) stays so. A
// second Ctrl-C, of an impatient user, ends the program.
void CatchStops();

// Becomes true when one of them has come.
const std::atomic<bool> &StopAsked();

// The exit status of a command that one of them has stopped: 128 and the signal's number.
int StopStatus();

} // namespace cuticle
