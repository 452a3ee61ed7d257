// Names of files that hold the frames of a motion: "frames/%04d.exr" stands for frames/0000.exr, 0001, ...
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

// The largest number of a frame.
inline constexpr size_t kMaxFrame = 999999;

// The frames of a command line's --frames: first, first + step, ... up to last.
struct FrameRange {
    size_t first = 0, last = 0, step = 1;
};
// Reads "FIRST:LAST" or "FIRST:LAST:STEP". Throws Error for whatever is none, or empty.
FrameRange ParseFrameRange(const std::string &text);

// The name of a file for each frame, with one place for its number: "%d", or "%04d" for four digits or more,
// as of printf ("%4d" fills up with blanks).
class FrameNames {
  public:
    // Throws Error where the pattern has no such place, or two. what: "output", which stands in the message;
    // example: a name that is right.
    FrameNames(const std::string &pattern, const std::string &what, const std::string &example);
    std::string Of(size_t frame) const;
    // The frames whose files are there, in order, up to kMaxFrame; none where the folder is not. The number
    // stands in the file's name, not in a folder's.
    std::vector<size_t> Existing() const;

  private:
    std::string pattern_;
};

// Puts the frame's number in all such places of a name.
std::string WithFrameNumber(std::string_view name, size_t frame);

} // namespace cuticle
