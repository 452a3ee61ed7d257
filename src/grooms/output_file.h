// A file written in pieces that appears whole or not at all, compressed where its name ends in .gz.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace cuticle {

// Writes to a temporary file beside `filename`; Commit() renames it over the destination. Without Commit() (an
// exception on the way, say) the temporary file is removed and what stood there before stays. All functions
// throw Error naming the path and the system's reason.
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
    std::string filename_, temporary_;
    int fd_ = -1;
    void *gz_ = nullptr; // zlib's handle, owns fd_ when set
    uint64_t bytes_ = 0;
};

} // namespace cuticle
