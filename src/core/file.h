// Files that are read whole, and written whole or not at all.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

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

// A file written in pieces that appears whole or not at all, compressed where its name ends in .gz. It is written under
// another name beside `filename`; Commit() renames it over the destination. Without Commit() (an exception on the way,
// say) nothing of it is left and what stood there before stays. A link is followed; a device or a pipe is written to
// and never replaced. All functions throw Error naming the path and the system's reason.
class OutputFile {
  public:
    explicit OutputFile(const std::string &filename);
    ~OutputFile();
    OutputFile(const OutputFile &) = delete;
    OutputFile &operator=(const OutputFile &) = delete;

    void Write(std::string_view bytes);
    void Commit();
    uint64_t BytesWritten() const { return bytes_; } // before compression

  private:
    [[noreturn]] void Fail(const char *doing) const;
    std::string filename_, target_, temporary_; // temporary_ "": none
    int fd_ = -1;
    void *gz_ = nullptr; // zlib's handle, owns fd_ when set
    uint64_t bytes_ = 0;
};

// The same for bytes that are there already.
void WriteFileAtomically(const std::string &filename, const std::string &bytes);

// Makes a folder and those above it, where they are not there yet. Throws Error with the system's reason.
void MakeFolder(const std::string &folder);

} // namespace cuticle
