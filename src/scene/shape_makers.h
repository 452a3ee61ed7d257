// The makers of shapes: from a Shape directive to triangles, a quadric or strands.
#pragma once

#include "grooms/groom.h"
#include "parser/plugins.h"
#include "parser/scene_description.h"
#include "shapes/solid_set.h"

#include <optional>
#include <string_view>
#include <variant>

namespace cuticle {

// The strands of a shape, in its own coordinates, and how they become curve segments.
struct StrandShape {
    Groom groom;
    SegmentOptions segments;
    float widthScale = 1; // factor on all widths
};

// All makers throw Error at the directive, or at the parameter, that makes no shape.
// The triangles of a mesh, in the shape's own coordinates.
using MeshMaker = TriangleMesh (*)(const ShapeEntity &shape);
// Adds a quadric to *solids and returns its geometry id. solids null: only reads the parameters (the shape is
// invisible) and returns 0.
using QuadricMaker = uint32_t (*)(const ShapeEntity &shape, SolidSet *solids, uint32_t shapeId);
// frame: of an animation, whose number is the time code of files with time samples.
using StrandMaker = StrandShape (*)(const ParamSet &params, std::optional<size_t> frame);
// std::monostate: no maker. "curve" is made by the parser, "nurbs" is not rendered.
using ShapeMaker = std::variant<std::monostate, MeshMaker, QuadricMaker, StrandMaker>;

// The row of a shape's name, or null. ShapePlugins() (scene/plugins.h) has them all.
const PluginRow<ShapeMaker> *FindShape(std::string_view name);

} // namespace cuticle
