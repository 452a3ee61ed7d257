// Files that are read whole, and written whole or not at all.
#pragma once

#include <string>

namespace cuticle {

// A file descriptor that closes itself; negative: none.
struct File {
    int fd;
    explicit File(int f) : fd(f) {}
    ~File();
    File(const File &) = delete;
    File &operator=(const File &) = delete;
};

// Opens a plain file for reading; the caller closes the descriptor. `what` stands in the message ("the image"). Throws
// Error naming the file and the system's reason; also for a folder, a device or a pipe, by which a scene could make
// the program wait or read without end.
int OpenPlainFile(const std::string &filename, const std::string &what);

// Reads a plain file whole; Errors as of OpenPlainFile.
std::string ReadFile(const std::string &filename, const std::string &what);

// Writes bytes to a temporary file beside `filename` and renames it over it; what stood there before survives any
// failure. Throws Error naming the path and the system's reason.
void WriteFileAtomically(const std::string &filename, const std::string &bytes);

} // namespace cuticle
