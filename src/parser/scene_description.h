// A parsed scene: what the file says, with transforms, attributes and names resolved, before any object is
// made.
#pragma once

#include "core/vecmath.h"
#include "parser/param_set.h"
#include "shapes/curve_list.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace cuticle {

// A directive that makes one object: Camera, Sampler, Film, PixelFilter, Integrator, Accelerator.
struct Entity {
    std::string type; // the plug-in's name as written, e.g. "perspective"
    ParamSet params;
    Transform ctm; // the current transformation when it was read
};

struct TextureEntity {
    std::string name; // given by the scene
    std::string type; // "imagemap", ...
    ParamSet params;
    Transform ctm;
};

struct MaterialEntity {
    std::string name; // of a named material, else ""
    std::string type; // "matte", "hair", ...; "" is pbrt's null material
    ParamSet params;
    // For type "mix": namedmaterial1 and namedmaterial2 as indices into SceneDescription::materials, resolved
    // where the mix was made; -1 for any other type.
    int mixed[2] = {-1, -1};
};

struct LightEntity {
    std::string type;
    ParamSet params;
    Transform ctm;
};

// State shared by all shapes that follow one another without an attribute change.
struct ShapeState {
    int material = 0;   // index into SceneDescription::materials
    int areaLight = -1; // index into SceneDescription::areaLights
    bool reverseOrientation = false;
    bool operator==(const ShapeState &) const = default;
};

struct ShapeEntity {
    std::string type;
    ParamSet params;
    Transform objectToWorld;
    ShapeState state;
};

// Curves of one type and state; CurveSegment::group indexes these.
struct CurveGroup {
    CurveType type = CurveType::Flat;
    ShapeState state;
    FileLoc loc;          // of the statement that opened the group
    bool flipped = false; // ReverseOrientation or a mirroring transformation, not both
};

// Curves, already Bezier segments, in world (or object-definition) space or in one of their own.
struct CurvePool {
    CurveList segments;
    // Ribbon normals, by segment index (ribbons are rare).
    std::unordered_map<uint32_t, RibbonNormals> ribbonNormals;
    size_t claimed = 0; // bytes of segments, claimed while they were read
};

// Curves under a transformation that scales unevenly. They stay in their own coordinates, where their widths
// are what the scene says, and rays are brought there, as pbrt-v3 does.
struct UnevenCurves {
    Transform toParent; // to the world, or to the object that they belong to
    CurvePool curves;
};

// An object's shapes and curves, in the coordinates of the current transformation at the place of use.
struct ObjectDefinition {
    std::string name;
    FileLoc loc;
    std::vector<ShapeEntity> shapes;
    CurvePool curves;
    std::vector<UnevenCurves> unevenCurves;
};

struct ObjectUse {
    int object = 0; // index into SceneDescription::objects
    Transform instanceToWorld;
    FileLoc loc;
};

struct SceneDescription {
    std::string filename;
    Entity camera, sampler, film, filter, integrator,
        accelerator; // type and defaults as pbrt-v3's when not given
    std::vector<TextureEntity> floatTextures, spectrumTextures;
    std::vector<MaterialEntity> materials; // [0] is the default, matte
    std::vector<LightEntity> lights;
    std::vector<Entity> areaLights;
    std::vector<ShapeEntity> shapes;
    std::vector<CurveGroup> curveGroups;
    CurvePool curves;
    std::vector<UnevenCurves> unevenCurves;
    std::vector<ObjectDefinition> objects;
    std::vector<ObjectUse> instances;
    size_t bytesRead = 0;        // of scene text, decompressed
    std::optional<size_t> frame; // of an animation, as of ParseOptions
};

class PluginTables;

struct ParseOptions {
    // Not null: an error is added here instead of thrown, and parsing goes on at the next directive (at most
    // 1000 errors). To see every problem of a file at once.
    std::vector<std::string> *collectErrors = nullptr;
    // Off: Shape "curve" statements go through the general parameter parser like any other, for tests and for
    // measurement; the result is the same bit for bit.
    bool fastCurves = true;
    // The frame of an animation: its number stands in all strings of the scene, for "%d" or "%04d", and is
    // the time code of files with time samples.
    std::optional<size_t> frame = {};
};

// Reads a pbrt-v3 scene file (.pbrt or .pbrt.gz, decided by content) with everything it includes. Throws
// Error with file:line:col and the offending line.
//
// plugins: the names that it may use, and which parameters of a Shape are its material's; AllPlugins()
// (render/plugins.h) has all that is rendered.
SceneDescription ParseScene(const PluginTables &plugins, const std::string &filename,
                            const ParseOptions &options = {});
// The same from text in memory; `name` stands in messages, relative names are taken from `folder`.
SceneDescription ParseSceneText(const PluginTables &plugins, const std::string &text, const std::string &name,
                                const std::string &folder = ".", const ParseOptions &options = {});

} // namespace cuticle
