// Videos, through the program ffmpeg.
#pragma once

#include "images/image.h"

#include <memory>
#include <string>

namespace cuticle {

// Takes the frames of a video one by one. ffmpeg runs beside this program (found by PATH, called by words,
// without a shell) and encodes them as H.264, which every player knows. A stop (cli/stops.h) ends both: then
// Add and Finish throw the command's ExitStatus.
class VideoEncoder {
  public:
    // quality: H.264's constant rate factor, 0 (no loss) to 51. Throws Error where there is no ffmpeg.
    VideoEncoder(int width, int height, double framesPerSecond, int quality);
    ~VideoEncoder(); // ends ffmpeg
    VideoEncoder(const VideoEncoder &) = delete;
    VideoEncoder &operator=(const VideoEncoder &) = delete;

    // Adds a frame of the video's size. Throws Error with what ffmpeg says where it has ended.
    void Add(const Image &image);
    // Ends the video and returns its file, MP4. Throws Error with what ffmpeg says where it failed.
    std::string Finish();

  private:
    struct Child;
    std::unique_ptr<Child> child_;
};

} // namespace cuticle
