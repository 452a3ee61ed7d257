// The program gnuplot, run without a shell.
#pragma once

#include <string>

namespace cuticle {

// Runs gnuplot (Debian: gnuplot-nox) on a program text and returns the bytes that it draws. It reads no
// start-up files; text, drawing and complaints go through unnamed files, so that neither side ever waits for
// the other. Throws Error, with gnuplot's words if it had any, if it is not installed or cannot draw.
std::string RunGnuplot(const std::string &text);

} // namespace cuticle
