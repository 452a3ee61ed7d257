// The parameters of one directive, typed as written, each with its place in the file.
#pragma once

#include "core/color.h"
#include "core/error.h"

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

// g++ takes members of a scoped enumeration for shadows of the types of the same name, which they are not.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
enum class ParamType {
    Bool,
    Integer,
    Float,
    Point2,
    Vector2,
    Point3,
    Vector3,
    Normal,
    Spectrum,
    String,
    Texture
};
#pragma GCC diagnostic pop

// One parameter. Numbers of all numeric types are in `numbers` (integers exactly, up to 2^53); a Spectrum has
// been turned into linear RGB triples in `numbers`, whatever its spelling (rgb, xyz, blackbody, samples, .spd
// file).
struct Param {
    ParamType type;
    std::string name;
    FileLoc loc;
    std::vector<double> numbers;
    std::vector<std::string> strings; // String, Texture
    std::vector<bool> bools;
    // For Texture: indices into SceneDescription::floatTextures / spectrumTextures bound when the directive
    // was read (a later Texture of the same name does not change it); -1: no texture of that name and kind.
    int floatTexture = -1, spectrumTexture = -1;
    mutable bool used = false;
};

// Gives the path of a file that a scene names: an absolute name as it is, any other joined to the folder of
// the top-level scene file, as pbrt-v3 does wherever the directive stands. folder "": the working directory.
std::string ResolveFilename(const std::string &folder, const std::string &name);

// The parameters of one directive. Getters give the value or the default, mark the parameter as read, and
// take a wrong type or count for no parameter, with a Warning at its place, as pbrt-v3 does. Names are
// unique within a set (the last one wins, with a warning).
class ParamSet {
  public:
    FileLoc loc; // of the directive
    std::vector<Param> params;
    // The folder of the top-level scene file, where FindFilename looks; null or "": the working directory.
    std::shared_ptr<const std::string> folder;

    bool empty() const { return params.empty(); }
    const Param *Find(std::string_view name) const; // any type; does not mark it as used
    // The same, but only of that type, and marked as used.
    const Param *Find(std::string_view name, ParamType type) const;

    // One value each. FindInt: a fraction is cut off, with a Warning; an Error where the number does not
    // fit. A type mismatch (say a string where a float belongs) is a Warning at the parameter that names
    // what would be right, and the default counts; an integer is accepted for a float.
    bool FindBool(std::string_view name, bool defaultValue) const;
    int FindInt(std::string_view name, int defaultValue) const;
    float FindFloat(std::string_view name, float defaultValue) const;
    std::string FindString(std::string_view name, const std::string &defaultValue) const;
    Spectrum FindSpectrum(std::string_view name, const Spectrum &defaultValue) const;
    Point3f FindPoint3f(std::string_view name, const Point3f &defaultValue) const;
    Vector3f FindVector3f(std::string_view name, const Vector3f &defaultValue) const;
    // Arrays; empty when absent. Point3 arrays hold 3 numbers a point; numbers behind the last whole
    // element are left out, with a Warning.
    std::vector<float> FindFloats(std::string_view name) const;
    std::vector<int> FindInts(std::string_view name) const;
    std::vector<Point2f> FindPoint2fs(std::string_view name) const; // point2, vector2, or a plain float array
    std::vector<Point3f> FindPoint3fs(std::string_view name) const;
    std::vector<Normal3f> FindNormals(std::string_view name) const;
    // The file named by a string parameter, resolved against `folder`; "" when absent. For files that are
    // read (Film's output name is a FindString).
    std::string FindFilename(std::string_view name) const;

    // A Warning for each parameter that nobody read; "what" is the directive ("Shape \"sphere\"").
    void ReportUnused(const std::string &what) const;
};

// While it lives, notes which names this thread asks parameter sets for, that is what the makers read: tests
// hold the rows of plug-ins to it. The innermost one counts.
class ParamRecorder {
  public:
    ParamRecorder();
    ~ParamRecorder();
    ParamRecorder(const ParamRecorder &) = delete;
    ParamRecorder &operator=(const ParamRecorder &) = delete;
    // The names asked of sets whose directive stands on this line of its file.
    const std::set<std::string, std::less<>> &AskedOn(uint32_t line) const;

  private:
    friend class ParamSet;
    std::map<uint32_t, std::set<std::string, std::less<>>> asked_;
    ParamRecorder *outer_;
};

} // namespace cuticle
