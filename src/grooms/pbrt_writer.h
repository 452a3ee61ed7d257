// Grooms as pbrt-v3 text: Shape "curve" statements that any reader of the language takes.
#pragma once

#include "grooms/groom.h"
#include "grooms/head_mesh.h"

#include <string>

namespace cuticle {

struct PbrtCurveOptions {
    SegmentOptions segments;
    std::string curveType = "cylinder"; // flat or cylinder
    // One statement per Bezier segment instead of one per strand (older readers know only those).
    bool perSegment = false;
    float widthScale = 1;
    // Writes a hair material for every colour of the groom (its strands' mean colours, rounded to
    // colorLevels steps per channel where there are more than 256 of them).
    bool colors = false;
    int colorLevels = 32;
    float betaM = 0.3f, betaN = 0.3f;
};

// Counts what was written.
struct PbrtCurveCounts {
    size_t strands = 0, segments = 0, statements = 0, materials = 0;
};

// Appends the strands [begin, end) to *out as text, without materials. Coordinates are rounded to 1/200 of
// the groom's smallest width or finer.
void AppendPbrtCurves(const Groom &groom, size_t begin, size_t end, const PbrtCurveOptions &options,
                      std::string *out, PbrtCurveCounts *counts);

class OutputFile;

// Writes a whole groom, formatted in parallel, with materials if asked for. The text is the same for any
// number of threads.
void WritePbrtCurves(const Groom &groom, const PbrtCurveOptions &options, OutputFile *out,
                     PbrtCurveCounts *counts);

// Writes a Shape "trianglemesh" statement.
void WritePbrtMesh(const SurfaceMesh &mesh, OutputFile *out);

} // namespace cuticle
