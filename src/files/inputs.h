// The files that a scene is made from: which they were, and whether they are still the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <utility>

namespace cuticle {

// A hash of 128 bits of bytes that come piece by piece, however they are cut. It tells what is equal by
// accident from what is not; it is no protection against those who want two contents to be taken for one.
class ContentHash {
  public:
    void Add(std::string_view bytes);
    // The hash of all bytes so far, as 32 hexadecimal digits.
    std::string Hex() const;

  private:
    void Mix(const char *block);
    static constexpr size_t kBlock = 32;
    uint64_t lanes_[4] = {0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89};
    uint64_t size_ = 0;
    char rest_[kBlock] = {}; // the last size_ % kBlock bytes
};

// Takes note of files that are read: a picture is never written over one of them, and who goes on with a
// render asks whether they are the same. Safe from any thread.
class InputLog {
  public:
    // Notes the file that is open as fd. text: its bytes where they cannot be read a second time (a pipe).
    void Add(const std::string &filename, int fd, std::string_view text = {});
    // The name under which the file that stands at `path` now was read, whatever links lead there; "": it was
    // not read.
    std::string NameOf(const std::string &path) const;
    // A hash of the contents of all, and of their names as seen from `folder` (those in other folders: as
    // they are). Throws Error for a file that is gone or was changed since it was noted.
    std::string Digest(const std::string &folder) const;

  private:
    struct Seen {
        dev_t device = 0;
        ino_t inode = 0;
        off_t size = 0;
        int64_t changed = 0; // when it was written to last, in ns
        std::string hash;    // of a pipe; "": to be read
    };
    mutable std::mutex mutex_;
    std::map<std::string, Seen> files_; // by the name that they were opened by
};

// While it lives, the files that this thread opens (and those that help it in ParallelFor) are noted in this
// log; null: nowhere. The innermost scope counts.
class InputScope {
  public:
    explicit InputScope(InputLog *log);
    ~InputScope();
    InputScope(const InputScope &) = delete;
    InputScope &operator=(const InputScope &) = delete;

  private:
    InputLog *outer_;
};

// Notes a file that is open as fd in the log of this thread, if there is one. All that opens files for
// reading calls it.
void NoteInput(const std::string &filename, int fd, std::string_view text = {});

} // namespace cuticle
