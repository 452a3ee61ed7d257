// Files: plain ones are read, whole or from front to back; what is written appears whole or not at all.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

class GzipReader;

// A file descriptor that closes itself; a negative one means that there is no file.
struct File {
    int fd;
    explicit File(int f) : fd(f) {}
    ~File();
    File(const File &) = delete;
    File &operator=(const File &) = delete;
};

// The path under which a file may be opened: its name or, in a SandboxScope, what that leads to without
// links. Throws Error (finally: nobody goes on) where this is outside of the sandbox. All that opens files
// asks it.
std::string AllowedPath(const std::string &filename);

// Opens a plain file for reading; the caller closes the descriptor. `what` stands in the message ("the
// image"). Throws Error naming the file and the system's reason; also for a folder, a device or a pipe, by
// which a scene could make the program wait or read without end.
int OpenPlainFile(const std::string &filename, const std::string &what);

// Reads a plain file whole; throws what OpenPlainFile throws.
std::string ReadFile(const std::string &filename, const std::string &what);

// Reads a plain file from front to back, unpacked where it is gzip; its first bytes decide, not its name.
class InputFile {
  public:
    // Throws what OpenPlainFile throws.
    InputFile(const std::string &filename, const std::string &what);
    ~InputFile();
    InputFile(const InputFile &) = delete;
    InputFile &operator=(const InputFile &) = delete;

    // Reads up to `size` > 0 bytes; returns how many, 0 only at the end. Throws Error with the reason but
    // without the file's name.
    size_t Read(char *to, size_t size);

  private:
    std::string_view NextPiece();
    File file_;
    std::vector<char> buffer_;
    std::string_view ahead_; // bytes of buffer_ that nobody has taken yet
    std::unique_ptr<GzipReader> gzip_;
};

// Writes a file in pieces so that it appears whole or not at all, compressed where its name ends in .gz. It
// is written under another name beside `filename`; Commit() renames it over the destination. Without Commit()
// (an exception on the way, say) nothing of it is left and what stood there before stays. A link is followed,
// also one to a file that is not there yet; a device or a pipe is written to and never replaced. All
// functions throw Error naming the path and the system's reason.
//
// The other name is the file's with ".cuticle-" and six characters behind it, and is locked (flock) while its
// writer lives: what a killed run left is known by that, and the next OutputFile in the folder removes it.
class OutputFile {
  public:
    // Error where no file of this name can be put in place: also for one that may not be written to, a pipe
    // that nobody reads, and a file that the InputLog of this thread has noted.
    explicit OutputFile(const std::string &filename);
    ~OutputFile();
    OutputFile(const OutputFile &) = delete;
    OutputFile &operator=(const OutputFile &) = delete;

    // Sets room on the disk aside, so that so many bytes can be written later; Error where there is not as
    // much. Filesystems that cannot do that, devices and pipes take it in silence.
    void Reserve(uint64_t bytes);
    void Write(std::string_view bytes);
    // Puts the file in place. onDisk: it is to be there even if the machine stops the moment after.
    void Commit(bool onDisk = false);
    uint64_t BytesWritten() const { return bytes_; } // before compression
    bool IsPlain() const { return isPlain_; }        // neither a device nor a pipe

  private:
    [[noreturn]] void Fail(const char *doing) const;
    void OpenTemporary(bool exists, unsigned mode);
    void OpenDevice();
    std::string filename_, target_, temporary_; // temporary_ "": none
    int fd_ = -1;
    void *gz_ = nullptr; // zlib's handle, which owns a descriptor of its own
    uint64_t bytes_ = 0;
    bool isPlain_ = true;
};

// Writes bytes that are there already, by an OutputFile.
void WriteFileAtomically(const std::string &filename, const std::string &bytes);

// Makes a folder and those above it, where they are not there yet. Throws Error with the system's reason.
void MakeFolder(const std::string &folder);

} // namespace cuticle
