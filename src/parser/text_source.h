// The text of a scene file in memory, followed by a NUL byte.
#pragma once

#include "core/error.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace cuticle {

// The text of one file in memory, or a view of a string that the caller keeps alive. A NUL byte always
// follows, so that a scanner may look at one byte past the end.
class TextSource {
  public:
    // Reads a file whole: mapped where it is a plain one, unpacked where it begins with gzip's magic bytes,
    // whatever its name. Throws an Error at `from` (the Include that asked, or a place without line) that
    // names the file: missing, a folder, damaged gzip data, text that unpacks to absurd sizes. fromLine: the
    // scene's line there, to be quoted.
    static std::unique_ptr<TextSource> FromFile(const std::string &filename, const FileLoc &from,
                                                std::string_view fromLine = {});
    static std::unique_ptr<TextSource> FromText(const std::string &text, const std::string &name);
    ~TextSource();
    TextSource(const TextSource &) = delete;
    TextSource &operator=(const TextSource &) = delete;

    const std::shared_ptr<const std::string> &Name() const { return name_; }
    const char *Begin() const { return begin_; }
    const char *End() const { return end_; }
    // Throws Error where the file is no longer what it was when it was opened: text that was read from it is
    // then worth nothing, and what was cut off reads as zeros.
    void CheckUnchanged() const;
    // Lets the system take back the memory of what stands before `upTo` (it is read again if asked for), so
    // that a file of many gigabytes does not count as memory of ours. Does nothing for text that was unpacked
    // or handed in.
    void Release(const char *upTo);

  private:
    using Refusal =
        std::function<void(const std::string &)>; // throws the Error, given what is wrong with the file
    TextSource();
    bool Map(int fd, size_t size); // false: it cannot be
    void Unmap();
    void ReadToEnd(int fd, const Refusal &fail);
    std::shared_ptr<const std::string> name_;
    const char *begin_ = nullptr, *end_ = nullptr;
    std::string unpacked_;
    struct Mapped;
    std::unique_ptr<Mapped> file_; // where text is mapped
    void *mapped_ = nullptr;
    size_t mappedSize_ = 0, released_ = 0;
};

// Reads line `loc.line` of the file loc.file again from disk, for an error message long after parsing, when
// the text is gone; "" where that is not possible.
std::string SourceLine(const FileLoc &loc);

} // namespace cuticle
