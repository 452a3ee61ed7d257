// Poses of a head that others made, frame by frame: a table, or an Xform of a .usda file.
#pragma once

#include "dynamics/simulation.h"

#include <optional>
#include <string>
#include <vector>

namespace cuticle {

struct PoseFileOptions {
    std::string prim;                      // of a .usda file: its name or path; "": the first that moves
    std::optional<double> framesPerSecond; // > 0; none: the .usda file's timeCodesPerSecond, else 24
    std::optional<double> start;           // the frame (time code) at time 0; none: the file's first
    std::optional<double> unit;            // cm; none: the .usda file's metersPerUnit, else 1
    bool isZUp = false;                    // of a table: (x, y, z) is turned to (x, z, -y)
};

// Reads poses as a head takes them from where it stands at `start` on, so that the first is none. A table has
// a line for each frame: its number, a place, and a turn, which is either a vector (degrees; its direction is
// the axis, its length the angle) or a quaternion (w x y z); blanks, commas or semicolons between; "#" begins
// a comment, and a first line of names is passed over. Throws Error with file:line:col for what is no number,
// for lines unlike the first, for frames that do not grow, for neighbours more than 150 degrees apart; for an
// Xform that is not there, does not move, or is scaled or sheared on the way.
std::vector<HeadMotion::TimedPose> ReadPoseFile(const std::string &filename, const PoseFileOptions &options);
// The same from text; `name` stands in messages.
std::vector<HeadMotion::TimedPose> ParsePoses(const std::string &text, const std::string &name,
                                              const PoseFileOptions &options);

} // namespace cuticle
