#include "grooms/usd_writer.h"

#include "core/check.h"
#include "core/error.h"

#include <fmt/format.h>

#include <iterator>
#include <string_view>

namespace cuticle {

namespace {

void AppendPoints(const std::vector<Point3f> &points, std::string *text) {
    text->push_back('[');
    for (size_t i = 0; i < points.size(); ++i)
        fmt::format_to(std::back_inserter(*text), "{}({}, {}, {})", i == 0 ? "" : ", ", points[i].x,
                       points[i].y, points[i].z);
    text->push_back(']');
}

std::string_view BasisLines(StrandSpline spline) {
    switch (spline) {
    case StrandSpline::Linear:
        return "    uniform token type = \"linear\"\n";
    case StrandSpline::BSpline:
        return "    uniform token type = \"cubic\"\n    uniform token basis = \"bspline\"\n"
               "    uniform token wrap = \"pinned\"\n";
    case StrandSpline::Bezier:
        return "    uniform token type = \"cubic\"\n    uniform token basis = \"bezier\"\n";
    case StrandSpline::CatmullRom:
        break;
    }
    return "    uniform token type = \"cubic\"\n    uniform token basis = \"catmullRom\"\n"
           "    uniform token wrap = \"pinned\"\n";
}

} // namespace

UsdWriter::UsdWriter(const std::string &filename, double framesPerSecond)
    : file_(filename), framesPerSecond_(framesPerSecond) {}

void UsdWriter::Begin(size_t frame, const Groom &groom) {
    if (groom.StrandCount() == 0)
        throw Error("there are no strands to write");
    offsets_ = groom.strandOffsets;
    // The last frame is not known yet: whoever plays the file takes the samples that there are
    text_ = fmt::format(
        "#usda 1.0\n(\n    defaultPrim = \"hair\"\n    metersPerUnit = 0.01\n    upAxis = \"Y\"\n"
        "    startTimeCode = {}\n    timeCodesPerSecond = {}\n)\n\ndef BasisCurves \"hair\"\n{{\n",
        frame, framesPerSecond_);
    text_ += BasisLines(groom.spline);
    text_ += "    int[] curveVertexCounts = [";
    for (size_t s = 0; s < groom.StrandCount(); ++s)
        fmt::format_to(std::back_inserter(text_), "{}{}", s == 0 ? "" : ", ", groom.PointCount(s));
    text_ += "]\n    float[] widths = [";
    const bool varies = !groom.pointWidths.empty() || !groom.strandWidths.empty();
    if (!varies)
        fmt::format_to(std::back_inserter(text_), "{}", groom.width);
    for (size_t s = 0, n = 0; varies && s < groom.StrandCount(); ++s)
        for (size_t i = 0; i < groom.PointCount(s); ++i, ++n)
            fmt::format_to(std::back_inserter(text_), "{}{}", n == 0 ? "" : ", ", groom.Width(s, i));
    fmt::format_to(std::back_inserter(text_), "] (\n        interpolation = \"{}\"\n    )\n",
                   varies ? "vertex" : "constant");
    if (groom.hasColor) {
        text_ += "    color3f[] primvars:displayColor = [";
        const std::vector<Spectrum> one{groom.color};
        const std::vector<Spectrum> &colors = groom.pointColors.empty() ? one : groom.pointColors;
        for (size_t i = 0; i < colors.size(); ++i)
            fmt::format_to(std::back_inserter(text_), "{}({}, {}, {})", i == 0 ? "" : ", ", colors[i][0],
                           colors[i][1], colors[i][2]);
        fmt::format_to(std::back_inserter(text_), "] (\n        interpolation = \"{}\"\n    )\n",
                       groom.pointColors.empty() ? "constant" : "vertex");
    }
    text_ += "    point3f[] points.timeSamples = {\n";
    begun_ = true;
}

void UsdWriter::AddFrame(size_t frame, const Groom &groom) {
    if (!groom.placements.empty())
        throw Error(
            "strands under transformations that scale unevenly have no widths in a .usda file of ours");
    text_.clear();
    if (!begun_)
        Begin(frame, groom);
    else if (groom.strandOffsets != offsets_)
        throw Error("frame {} has other strands than the first", frame);
    fmt::format_to(std::back_inserter(text_), "        {}: ", frame);
    AppendPoints(groom.points, &text_);
    text_ += ",\n";
    file_.Write(text_);
}

void UsdWriter::Finish() {
    CHECK(begun_);
    file_.Write("    }\n}\n");
    file_.Commit();
}

} // namespace cuticle
