#include "dynamics/pose_file.h"

#include "core/error.h"
#include "files/file.h"
#include "grooms/usd_layer.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <memory>
#include <set>
#include <string_view>
#include <tuple>

namespace cuticle {

namespace {

// A body stands so at a frame; loc is the line of the file that says it.
struct FramePose {
    double frame;
    Transform pose; // from the body's coordinates to the world's
    FileLoc loc;
};

FileLoc PlaceIn(const std::string &name, size_t line, size_t column) {
    return {std::make_shared<const std::string>(name), static_cast<uint32_t>(line),
            static_cast<uint32_t>(column)};
}

// Reads a table line by line.
class PoseTable {
  public:
    PoseTable(std::string_view text, const std::string &name) : text_(text), name_(name) {}
    std::vector<FramePose> Read() {
        for (size_t line = 1; !text_.empty(); ++line) {
            const std::string_view whole = text_.substr(0, text_.find('\n'));
            text_.remove_prefix(std::min(text_.size(), whole.size() + 1));
            ReadLine(whole.substr(0, whole.find('#')), line);
        }
        return std::move(poses_);
    }

  private:
    static bool IsGap(char c) { return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';'; }

    void ReadLine(std::string_view text, size_t line) {
        std::vector<double> v;
        for (size_t at = 0;;) {
            while (at < text.size() && IsGap(text[at]))
                ++at;
            if (at == text.size())
                break;
            size_t end = at;
            while (end < text.size() && !IsGap(text[end]))
                ++end;
            const std::string_view word = text.substr(at, end - at);
            double number = 0;
            const auto [stop, fault] = std::from_chars(word.data(), word.data() + word.size(), number);
            if (fault != std::errc() || stop != word.data() + word.size() || !(std::abs(number) <= 1e6)) {
                if (v.empty() && poses_.empty() && !namesSeen_ &&
                    std::isalpha(static_cast<unsigned char>(word[0]))) {
                    namesSeen_ = true; // of the columns
                    return;
                }
                throw Error(PlaceIn(name_, line, at + 1), "\"{}\" is no number within a million", word)
                    .WithRemedy("a line is a frame, a place x y z, and a turn of 3 or 4 numbers");
            }
            v.push_back(number);
            at = end;
        }
        if (!v.empty())
            Add(v, PlaceIn(name_, line, 1));
    }

    void Add(const std::vector<double> &v, const FileLoc &loc) {
        if (v.size() != 7 && v.size() != 8)
            throw Error(loc, "this line has {} numbers", v.size())
                .WithRemedy("7 are a frame, a place x y z, and a turn (axis times degrees); 8 have a "
                            "quaternion w x y z for the turn");
        if (columns_ != 0 && v.size() != columns_)
            throw Error(loc, "this line has {} numbers, the lines before it have {}", v.size(), columns_);
        columns_ = v.size();
        if (!poses_.empty() && !(v[0] > poses_.back().frame))
            throw Error(loc, "frame {} stands after frame {}", v[0], poses_.back().frame)
                .WithRemedy("frames must grow");
        const Vector3d axis = v.size() == 7 ? Vector3d{v[4], v[5], v[6]} : Vector3d{v[5], v[6], v[7]};
        double degrees = axis.Length();
        if (v.size() == 8) {
            if (!(v[4] != 0 || degrees > 0))
                throw Error(loc, "this turn, 0 0 0 0, is no quaternion").WithRemedy("no turn is 1 0 0 0");
            degrees = 2 * std::atan2(degrees, v[4]) * 180 / kPi<double>;
        }
        const Transform turn = axis == Vector3d{} ? Transform() : Transform::Rotate(degrees, Normalize(axis));
        poses_.push_back({v[0], Transform::Translate({v[1], v[2], v[3]}) * turn, loc});
    }

    std::string_view text_;
    const std::string &name_;
    std::vector<FramePose> poses_;
    size_t columns_ = 0;
    bool namesSeen_ = false;
};

// The prim that the options name, or the first that is seen and has samples of its own.
size_t FindMovingPrim(const UsdLayer &layer, const std::string &wanted, const FileLoc &loc) {
    std::string moving;
    for (size_t i = 0; i < layer.prims.size(); ++i) {
        if (layer.prims[i].samples.empty())
            continue;
        const std::string path = UsdPrimPath(layer.prims, i);
        if (wanted.empty() ? !IsHiddenUsdPrim(layer.prims, i)
                           : wanted == path || wanted == layer.prims[i].name)
            return i;
        moving += (moving.empty() ? "" : ", ") + path;
    }
    // A prim may be carried by one that moves
    for (size_t i = 0; i < layer.prims.size() && !wanted.empty(); ++i)
        if (wanted == UsdPrimPath(layer.prims, i) || wanted == layer.prims[i].name)
            return i;
    if (moving.empty())
        throw Error(loc, "no prim of this layer has xformOps with time samples")
            .WithRemedy("a head's Xform has, say, xformOp:transform.timeSamples");
    throw Error(loc, "no prim is named \"{}\"", wanted).WithRemedy("these move: {}", moving);
}

std::vector<FramePose> ReadUsdPoses(std::string_view text, const std::string &name,
                                    PoseFileOptions *options) {
    UsdText words(text, name);
    UsdLayer layer = ReadUsdLayer(words, name, {}, UsdSamples::Keep);
    const size_t prim = FindMovingPrim(layer, options->prim, PlaceIn(name, 1, 1));
    std::set<double> times;
    for (auto i = static_cast<ptrdiff_t>(prim); i >= 0; i = layer.prims[static_cast<size_t>(i)].parent)
        for (const auto &[operation, samples] : layer.prims[static_cast<size_t>(i)].samples)
            for (const auto &[time, numbers] : samples)
                times.insert(time);
    if (times.empty())
        throw Error(PlaceIn(name, 1, 1),
                    "the prim {} does not move: neither it nor what carries it has time samples",
                    UsdPrimPath(layer.prims, prim));
    options->isZUp = layer.upAxis == "Z";
    if (!options->framesPerSecond)
        options->framesPerSecond = layer.timeCodesPerSecond;
    if (!options->unit && layer.metersPerUnit > 0)
        options->unit = 100 * layer.metersPerUnit;
    std::vector<FramePose> poses;
    for (const double time : times) {
        SetUsdTime(&layer.prims, time);
        poses.push_back({time, UsdPrimToLayer(layer.prims, prim, name), PlaceIn(name, 1, 1)});
    }
    return poses;
}

// The rigid motion that a matrix is, lengths in units of `unit` cm. Throws Error where it is none.
Pose RigidPose(const Transform &t, double unit, const FramePose &at) {
    const Transform::Matrix &m = t.M();
    const auto column = [&](size_t c) { return Vector3d{m[0][c], m[1][c], m[2][c]}; };
    Pose pose{column(0), column(1), column(2), column(3) * unit};
    double off = 0;
    for (const auto &[a, b, wanted] : {std::tuple{pose.x, pose.x, 1.},
                                       {pose.y, pose.y, 1.},
                                       {pose.z, pose.z, 1.},
                                       {pose.x, pose.y, 0.},
                                       {pose.y, pose.z, 0.},
                                       {pose.z, pose.x, 0.}})
        off = std::max(off, std::abs(Dot(a, b) - wanted));
    if (!(off < 1e-3 && Dot(Cross(pose.x, pose.y), pose.z) > 0 && pose.origin.Length() < 1e9))
        throw Error(
            at.loc,
            "at frame {} the head is scaled, sheared or mirrored against where it begins, or is too far away",
            at.frame)
            .WithRemedy("a head may turn and move");
    pose.x = Normalize(pose.x);
    pose.y = Normalize(pose.y - pose.x * Dot(pose.x, pose.y));
    pose.z = Cross(pose.x, pose.y);
    return pose;
}

} // namespace

std::vector<HeadMotion::TimedPose> ParsePoses(const std::string &text, const std::string &name,
                                              const PoseFileOptions &given) {
    PoseFileOptions options = given;
    const std::vector<FramePose> frames =
        text.starts_with("#usda") ? ReadUsdPoses(text, name, &options) : PoseTable(text, name).Read();
    if (frames.empty())
        throw Error(PlaceIn(name, 1, 1), "there is no pose in this table");
    const double start = options.start.value_or(frames.front().frame);
    const auto first =
        std::find_if(frames.begin(), frames.end(), [&](const FramePose &p) { return p.frame == start; });
    if (first == frames.end())
        throw Error(PlaceIn(name, 1, 1), "there is no frame {} to start from", start)
            .WithRemedy("the file has frames {} to {}", frames.front().frame, frames.back().frame);
    if (first->pose.IsSingular())
        throw Error(first->loc, "at frame {} the head is scaled to nothing", start);
    const Transform yUp =
        options.isZUp
            ? Transform(Transform::Matrix{{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1}}})
            : Transform();
    const Transform back = yUp.Inverse(), fromStart = first->pose.Inverse();
    std::vector<HeadMotion::TimedPose> poses;
    for (auto at = first; at != frames.end(); ++at) {
        const Pose pose = RigidPose(yUp * at->pose * fromStart * back, options.unit.value_or(1), *at);
        if (!poses.empty()) {
            const Pose &last = poses.back().pose;
            const double cosine =
                (Dot(last.x, pose.x) + Dot(last.y, pose.y) + Dot(last.z, pose.z) - 1) / 2; // of the turn
            if (cosine < std::cos(150 * kPi<double> / 180))
                throw Error(at->loc, "between frames {} and {} the head turns by {:.0f} degrees",
                            (at - 1)->frame, at->frame, std::acos(std::max(cosine, -1.)) * 180 / kPi<double>)
                    .WithRemedy("which way it goes is not known above 150; give poses in between");
        }
        poses.push_back({(at->frame - start) / options.framesPerSecond.value_or(24), pose});
    }
    return poses;
}

std::vector<HeadMotion::TimedPose> ReadPoseFile(const std::string &filename, const PoseFileOptions &options) {
    return ParsePoses(ReadFile(filename, "the file of poses"), filename, options);
}

} // namespace cuticle
