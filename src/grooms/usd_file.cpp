#include "grooms/usd_file.h"

#include "core/error.h"
#include "grooms/binary_file.h"
#include "grooms/usd_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

namespace cuticle {

namespace {

// Numbers of the curve's points to numbers of Bezier control points, four by four; catmullRom with USD's
// tension of a half.
using BasisMatrix = std::array<std::array<double, 4>, 4>;
constexpr BasisMatrix kBSplineToBezier{{{1. / 6, 4. / 6, 1. / 6, 0},
                                        {0, 4. / 6, 2. / 6, 0},
                                        {0, 2. / 6, 4. / 6, 0},
                                        {0, 1. / 6, 4. / 6, 1. / 6}}};
constexpr BasisMatrix kCatmullRomToBezier{
    {{0, 1, 0, 0}, {-1. / 6, 1, 1. / 6, 0}, {0, 1. / 6, 1, -1. / 6}, {0, 0, 1, 0}}};

// Whole numbers beyond this are not exact in the binary32 that attributes are kept in.
constexpr float kMaxCount = 16777216;

// One BasisCurves prim, turned into strands of a groom that holds Bezier control points or (linear) points,
// with a width and a colour for each.
class CurvesBuilder {
  public:
    CurvesBuilder(const CurvesPrim &prim, const Transform &toLayer, const UsdText &text,
                  const std::string &name, bool bezierPoints)
        : prim_(prim), toLayer_(toLayer), isUneven_(toLayer.ScalesUnevenly()), text_(text), name_(name),
          linear_(prim.type == "linear"), bezierPoints_(bezierPoints) {
        if (!linear_ && prim.type != "cubic")
            text_.Fail(prim.at, "curves of type \"" + prim.type + "\"; linear or cubic was expected");
        if (!linear_ && prim.basis != "bezier" && prim.basis != "bspline" && prim.basis != "catmullRom")
            text_.Fail(prim.at,
                       "the basis \"" + prim.basis +
                           "\" of these curves is not known; bezier, bspline or catmullRom was expected");
        step_ = !linear_ && prim.basis == "bezier" ? 3 : 1;
        pinned_ = prim.wrap == "pinned" && !linear_ && step_ == 1;
    }

    // Appends to the groom's strands, its points, pointWidths and pointColors.
    void Build(Groom *groom) {
        const std::vector<size_t> counts = Counts();
        const UsdAttribute &widths = prim_.primvarWidths.given ? prim_.primvarWidths : prim_.widths;
        UsdAttribute color = prim_.color;
        ApplyIndices(&color);
        CheckSpread(&color, 3, "constant", "displayColor", counts);
        UsdAttribute width = widths;
        CheckSpread(&width, 1, "vertex", "widths", counts);
        if (std::any_of(width.values.begin(), width.values.end(), [](float v) { return v < 0; }))
            text_.Fail(width.at, "a width is negative");
        if (std::any_of(color.values.begin(), color.values.end(), [](float v) { return v < 0; }))
            text_.Fail(color.at, "a colour is negative");
        const auto scale = isUneven_ ? 1.f : static_cast<float>(std::cbrt(std::abs(toLayer_.Determinant())));
        size_t firstPoint = 0, firstVarying = 0;
        const size_t firstStrand = groom->StrandCount();
        for (size_t curve = 0; curve < counts.size(); ++curve) {
            const size_t n = counts[curve];
            if (Segments(n) == 0) {
                tooShort_ = true;
            } else {
                // One number of an attribute, at the points of the strand
                const auto at = [&](const std::vector<float> &values, std::string_view interpolation,
                                    size_t size, size_t component) {
                    if (interpolation == "vertex" || (linear_ && interpolation == "varying"))
                        return OverPoints(values.data() + firstPoint * size + component, size, n);
                    if (interpolation == "varying")
                        return OverJoints(values.data() + firstVarying * size + component, size, n);
                    const size_t i = interpolation == "uniform" ? curve : 0;
                    return std::vector<double>(StrandPoints(n),
                                               static_cast<double>(values[i * size + component]));
                };
                AddStrand(at, width, color, scale, groom);
            }
            firstPoint += n;
            firstVarying += Segments(n) + 1;
        }
        if (isUneven_ && groom->StrandCount() > firstStrand)
            groom->placements.push_back({firstStrand, groom->StrandCount(), toLayer_});
        if (tooShort_)
            Warning("USD curves of too few points",
                    name_ + ": curves with too few points for one segment of their basis are left out");
    }

  private:
    // Points of each curve, checked against the array of points.
    std::vector<size_t> Counts() const {
        std::vector<size_t> counts;
        size_t sum = 0;
        for (const float v : prim_.counts.values) {
            if (!(v >= 0) || v != std::floor(v) || v > kMaxCount)
                text_.Fail(prim_.counts.at,
                           "curveVertexCounts holds {:f}; whole numbers from 0 to 16777216 were expected", v);
            counts.push_back(static_cast<size_t>(v));
            sum += counts.back();
            if (step_ == 3 && counts.back() % 3 != 1)
                text_.Fail(prim_.counts.at, "a Bezier curve of {} points; 3 n + 1 points make n segments",
                           counts.back());
        }
        if (prim_.points.values.size() % 3 != 0 || sum != prim_.points.values.size() / 3)
            text_.Fail(
                prim_.points.given ? prim_.points.at : prim_.at,
                "curveVertexCounts adds up to {} points, and points holds {} numbers; three for each were "
                "expected",
                sum, prim_.points.values.size());
        return counts;
    }

    size_t Segments(size_t points) const {
        if (linear_ || pinned_)
            return points < 2 ? 0 : points - 1;
        return points < 4 ? 0 : (points - 4) / step_ + 1;
    }
    size_t StrandPoints(size_t points) const { return Segments(points) * (bezierPoints_ ? 3 : 1) + 1; }

    void ApplyIndices(UsdAttribute *color) const {
        if (!prim_.colorIndices.given || !color->given)
            return;
        std::vector<float> spread;
        for (const float i : prim_.colorIndices.values) {
            if (!(i >= 0) || i > kMaxCount || static_cast<size_t>(i) >= color->values.size() / 3)
                text_.Fail(prim_.colorIndices.at, "index {} of {} colours, counted from 0",
                           static_cast<long long>(i), color->values.size() / 3);
            const auto first = color->values.begin() + 3 * static_cast<ptrdiff_t>(i);
            spread.insert(spread.end(), first, first + 3);
        }
        color->values = std::move(spread);
    }

    // Settles the interpolation and checks that there are as many values as it needs. A single value is for
    // all.
    void CheckSpread(UsdAttribute *a, size_t size, const char *usual, const char *name,
                     const std::vector<size_t> &counts) const {
        if (!a->given)
            return;
        if (a->interpolation.empty())
            a->interpolation = a->values.size() == size ? "constant" : usual;
        size_t needed = 0;
        if (a->interpolation == "constant") {
            needed = 1;
        } else if (a->interpolation == "uniform") {
            needed = counts.size();
        } else if (a->interpolation == "vertex") {
            needed = prim_.points.values.size() / 3;
        } else if (a->interpolation == "varying") {
            for (const size_t n : counts)
                needed += linear_ ? n : Segments(n) + 1;
        } else {
            text_.Fail(a->at, std::string(name) + " has the interpolation \"" + a->interpolation +
                                  "\"; constant, uniform, varying or vertex was expected");
        }
        if (a->values.size() != needed * size)
            text_.Fail(a->at, "{} of {} interpolation needs {} values of {}, and has {} numbers", name,
                       a->interpolation, needed, size, a->values.size());
    }

    // Numbers given at a curve's n points, `stride` apart, at the points of its strand.
    std::vector<double> OverPoints(const float *v, size_t stride, size_t n) const {
        const auto value = [&](size_t i) { return static_cast<double>(v[i * stride]); };
        std::vector<double> in;
        for (size_t i = 0; i < n; ++i)
            in.push_back(value(i));
        if (linear_)
            return bezierPoints_ ? Thirds(in) : in;
        if (step_ == 3)
            return in;
        if (pinned_) { // phantom points that make the curve begin and end at its first and last point
            in.insert(in.begin(), 2 * value(0) - value(1));
            in.push_back(2 * value(n - 1) - value(n - 2));
        }
        const BasisMatrix &m = prim_.basis == "bspline" ? kBSplineToBezier : kCatmullRomToBezier;
        std::vector<double> out;
        for (size_t i = 0; i + 3 < in.size(); ++i)
            for (size_t k = i == 0 ? 0 : 1; k < 4; ++k)
                out.push_back(m[k][0] * in[i] + m[k][1] * in[i + 1] + m[k][2] * in[i + 2] +
                              m[k][3] * in[i + 3]);
        return out;
    }
    // Numbers given where its segments join.
    std::vector<double> OverJoints(const float *v, size_t stride, size_t n) const {
        std::vector<double> in;
        for (size_t i = 0; i <= Segments(n); ++i)
            in.push_back(static_cast<double>(v[i * stride]));
        return Thirds(in);
    }
    static std::vector<double> Thirds(const std::vector<double> &in) {
        std::vector<double> out{in[0]};
        for (size_t i = 0; i + 1 < in.size(); ++i) {
            out.push_back((2 * in[i] + in[i + 1]) / 3);
            out.push_back((in[i] + 2 * in[i + 1]) / 3);
            out.push_back(in[i + 1]);
        }
        return out;
    }

    template <typename At>
    void AddStrand(At at, const UsdAttribute &width, const UsdAttribute &color, float scale, Groom *groom) {
        std::array<std::vector<double>, 3> p, c;
        for (size_t k = 0; k < 3; ++k) {
            p[k] = at(prim_.points.values, "vertex", 3, k);
            if (color.given)
                c[k] = at(color.values, color.interpolation, 3, k);
        }
        std::vector<double> w;
        if (width.given)
            w = at(width.values, width.interpolation, 1, 0);
        const size_t n = p[0].size();
        if (groom->points.size() + n > std::numeric_limits<uint32_t>::max())
            text_.Fail(prim_.points.at, "a groom holds at most 4294967295 points");
        for (size_t i = 0; i < n; ++i) {
            const Point3f own{static_cast<float>(p[0][i]), static_cast<float>(p[1][i]),
                              static_cast<float>(p[2][i])};
            const Point3f q = toLayer_.Point(own);
            if (!(IsCoordinate(q.x) && IsCoordinate(q.y) && IsCoordinate(q.z)))
                text_.Fail(prim_.points.at, "a point, transformed, lies too far out");
            groom->points.push_back(isUneven_ ? own : q);
            // A B-spline of widths stays positive, a Catmull-Rom spline may overshoot
            groom->pointWidths.push_back(w.empty() ? -1 : std::max(0.f, static_cast<float>(w[i])) * scale);
            Spectrum rgb(-1);
            for (int k = 0; k < 3 && color.given; ++k)
                rgb[k] = std::max(0.f, static_cast<float>(c[static_cast<size_t>(k)][i]));
            groom->pointColors.push_back(rgb);
        }
        groom->strandOffsets.push_back(static_cast<uint32_t>(groom->points.size()));
    }

    const CurvesPrim &prim_;
    const Transform toLayer_;
    const bool isUneven_; // the strands stay in the prim's coordinates
    const UsdText &text_;
    const std::string &name_;
    bool linear_, bezierPoints_, pinned_ = false, tooShort_ = false;
    size_t step_ = 1; // points from one segment's first point to the next one's
};

// Widths and colours that are the same everywhere are kept once; those of curves without any (negative so
// far) take the mean of the rest.
void Settle(const std::string &name, Groom *groom) {
    double width = 0;
    std::array<double, 3> color{};
    size_t widths = 0, colors = 0;
    for (size_t i = 0; i < groom->points.size(); ++i) {
        if (groom->pointWidths[i] >= 0)
            width += static_cast<double>(groom->pointWidths[i]), ++widths;
        if (groom->pointColors[i][0] >= 0) {
            for (size_t k = 0; k < 3; ++k)
                color[k] += static_cast<double>(groom->pointColors[i][k]);
            ++colors;
        }
    }
    groom->hasColor = colors > 0;
    groom->width = widths > 0 ? static_cast<float>(width / static_cast<double>(widths)) : 0;
    for (size_t k = 0; k < 3 && colors > 0; ++k)
        groom->color[k] = static_cast<float>(color[k] / static_cast<double>(colors));
    if (widths > 0 && widths < groom->points.size())
        Warning("strands without widths",
                name + ": some of the file's curves have no widths; the mean of the others' is used");
    for (size_t i = 0; i < groom->points.size(); ++i) {
        if (groom->pointWidths[i] < 0)
            groom->pointWidths[i] = groom->width;
        if (groom->pointColors[i][0] < 0)
            groom->pointColors[i] = groom->color;
    }
    const auto collapse = [](auto *values, auto *one) {
        const auto first = values->empty() ? *one : values->front();
        if (!std::all_of(values->begin(), values->end(), [&](const auto &v) { return v == first; }))
            return;
        *one = first;
        values->clear();
        values->shrink_to_fit();
    };
    collapse(&groom->pointWidths, &groom->width);
    collapse(&groom->pointColors, &groom->color);
}

// Says what a layer's axes and units are; returns the turn that makes y the axis that is up.
Transform AxesAndUnits(const UsdLayer &layer, const UsdText &text, const std::string &name) {
    if (layer.upAxis != "Y" && layer.upAxis != "Z")
        text.Fail(layer.upAxisAt, "upAxis is \"Y\" or \"Z\", not \"{}\"", layer.upAxis);
    const bool zUp = layer.upAxis == "Z";
    if (zUp)
        Warning("USD up axis",
                name + ": the layer's z axis is up; it is turned so that y is, (x, y, z) to (x, z, -y)");
    if (layer.metersPerUnit > 0)
        Warning("USD units",
                fmt::format("{}: a unit of this layer is {:g} m; its lengths are taken as they stand, a "
                            "unit of the scene for each",
                            name, layer.metersPerUnit));
    return zUp ? Transform(Transform::Matrix{{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1}}})
               : Transform();
}

} // namespace

Groom ParseUsdFile(std::string_view text, const std::string &name) { return ParseUsdFileAt(text, name, {}); }

Groom ParseUsdFileAt(std::string_view text, const std::string &name, std::optional<double> time) {
    if (!text.starts_with("#usda"))
        throw Error(FileLoc{std::make_shared<const std::string>(name), 1, 1},
                    "this is not USD in its text form, which begins with #usda 1.0");
    UsdText layer(text, name);
    const UsdLayer read = ReadUsdLayer(layer, name, time);
    const std::vector<UsdPrim> &prims = read.prims;
    const Transform toYUp = AxesAndUnits(read, layer, name);
    const auto isRendered = [&](size_t i) {
        if (!prims[i].curves || IsHiddenUsdPrim(prims, i))
            return false;
        const CurvesPrim &c = *prims[i].curves;
        if (c.wrap == "periodic")
            Warning("USD curves that are closed",
                    name + ": periodic curves are not rendered, no hair is closed; they are left out");
        else if (c.wrap != "nonperiodic" && c.wrap != "pinned")
            layer.Fail(c.at, "the wrap \"" + c.wrap +
                                 "\" of these curves is not known; nonperiodic or pinned was expected");
        return c.wrap != "periodic";
    };
    std::vector<size_t> rendered;
    bool allLinear = true;
    for (size_t i = 0; i < prims.size(); ++i)
        if (isRendered(i)) {
            rendered.push_back(i);
            allLinear &= prims[i].curves->type == "linear";
        }
    if (rendered.empty())
        throw Error(FileLoc{std::make_shared<const std::string>(name)},
                    "this layer holds no BasisCurves that are visible, and only they are strands of hair");
    Groom groom;
    groom.spline = allLinear ? StrandSpline::Linear : StrandSpline::Bezier;
    for (const size_t i : rendered)
        CurvesBuilder(*prims[i].curves, toYUp * UsdPrimToLayer(prims, i, name), layer, name, !allLinear)
            .Build(&groom);
    Settle(name, &groom);
    return groom;
}

} // namespace cuticle
