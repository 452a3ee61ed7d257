#include "grooms/usd_file.h"

#include "core/error.h"
#include "grooms/binary_file.h"
#include "grooms/usd_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

namespace cuticle {

namespace {

// An attribute's numbers as written, where they stand, and how they spread over the curves.
struct Attribute {
    std::vector<float> values;
    size_t at = 0;
    std::string interpolation;
    bool given = false, byTime = false;
};

// The properties of a BasisCurves prim; the defaults are the schema's.
struct CurvesPrim {
    size_t at = 0;
    std::string type = "cubic", basis = "bezier", wrap = "nonperiodic";
    Attribute counts, points, widths, primvarWidths, color, colorIndices;
};

struct Prim {
    ptrdiff_t parent = -1;
    std::map<std::string, Transform, std::less<>> operations;
    std::vector<std::string> order;
    bool hidden = false;                // invisible, a guide, a class, or not active
    std::unique_ptr<CurvesPrim> curves; // of a BasisCurves prim
};

Transform FromUsdMatrix(const std::vector<double> &v) {
    Transform::Matrix m;
    for (size_t row = 0; row < 4; ++row)
        for (size_t column = 0; column < 4; ++column)
            m[row][column] = v[4 * column + row]; // theirs acts on rows
    return Transform(m);
}

// The operation's kind is the second part of its name: xformOp:rotateXYZ:pivot. Returns false for an unknown
// one.
bool MakeOperation(std::string_view name, const std::vector<double> &v, Transform *out) {
    name.remove_prefix(std::string_view("xformOp:").size());
    const std::string_view kind = name.substr(0, name.find(':'));
    const auto turn = [&](char axis, double degrees) {
        return Transform::Rotate(degrees,
                                 {axis == 'X' ? 1. : 0., axis == 'Y' ? 1. : 0., axis == 'Z' ? 1. : 0.});
    };
    if (kind == "translate" && v.size() == 3) {
        *out = Transform::Translate({v[0], v[1], v[2]});
    } else if (kind == "scale" && v.size() == 3) {
        *out = Transform::Scale(v[0], v[1], v[2]);
    } else if (kind == "transform" && v.size() == 16) {
        *out = FromUsdMatrix(v);
    } else if (kind == "orient" && v.size() == 4) {
        const double length = std::sqrt(v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
        *out = length > 0 ? Transform::Rotate(2 * std::atan2(length, v[0]) * 180 / 3.141592653589793,
                                              {v[1] / length, v[2] / length, v[3] / length})
                          : Transform();
    } else if (kind.starts_with("rotate") && kind.size() == 7 && v.size() == 1) {
        *out = turn(kind[6], v[0]);
    } else if (kind.starts_with("rotate") && kind.size() == 9 && v.size() == 3) {
        // The first letter turns first
        Transform all;
        for (const char axis : kind.substr(6)) {
            if (axis < 'X' || axis > 'Z')
                return false;
            all = turn(axis, v[static_cast<size_t>(axis - 'X')]) * all;
        }
        *out = all;
    } else {
        return false;
    }
    return true;
}

// Reads the prims of a layer.
class LayerReader {
  public:
    LayerReader(std::string_view text, const std::string &name) : text_(text, name), name_(name) {}

    std::vector<Prim> Read() {
        text_.Metadata([&](std::string_view key) {
            if (key == "subLayers")
                WarnOfComposition("sublayers");
            return false;
        });
        while (text_.Peek() != '\0')
            Statement(-1);
        return std::move(prims_);
    }
    const UsdText &Text() const { return text_; }

  private:
    void WarnOfComposition(const std::string &what) const {
        Warning("USD composition",
                name_ + ": " + what +
                    " are not followed; what they add is left out. USD's own usdcat --flatten "
                    "writes one layer with all");
    }

    // A prim, a set of variants or a property, in a prim or (parent -1) in the layer.
    void Statement(ptrdiff_t parent) {
        if (text_.Take(';'))
            return;
        const size_t at = text_.At();
        std::string_view word = text_.Word();
        if (word == "def" || word == "over" || word == "class")
            return ReadPrim(word, parent);
        if (word == "variantSet") {
            WarnOfComposition("variants");
            text_.String();
            text_.Expect('=', "after a variant set's name");
            text_.SkipValue();
            return;
        }
        while (word == "custom" || word == "uniform" || word == "varying" || word == "config" ||
               word == "prepend" || word == "append" || word == "add" || word == "delete" ||
               word == "reorder")
            word = text_.Word();
        if (word.empty())
            text_.Fail(at, parent < 0 ? "\"def\", \"over\" or \"class\" was expected"
                                      : "a property or a prim was expected");
        if (parent < 0 && word != "rootPrims")
            text_.Fail(at, "\"{}\" begins no prim; \"def\", \"over\" or \"class\" was expected", word);
        Property(parent, at);
    }

    void ReadPrim(std::string_view specifier, ptrdiff_t parent) {
        constexpr size_t kMaxDepth = 200; // far beyond any scene; the recursion needs a bound
        size_t depth = 0;
        for (ptrdiff_t p = parent; p >= 0; p = prims_[static_cast<size_t>(p)].parent)
            ++depth;
        if (depth > kMaxDepth)
            text_.Fail(text_.At(), "prims lie more than {} deep in each other", kMaxDepth);
        const size_t index = prims_.size();
        prims_.emplace_back();
        prims_[index].parent = parent;
        prims_[index].hidden = specifier == "class";
        const size_t at = text_.At();
        const std::string_view type = text_.Word();
        text_.String();
        if (type == "BasisCurves") {
            prims_[index].curves = std::make_unique<CurvesPrim>();
            prims_[index].curves->at = at;
        } else if (type == "NurbsCurves" || type == "HermiteCurves") {
            Warning("USD curves of other kinds",
                    name_ + ": " + std::string(type) +
                        " are not rendered, only BasisCurves are; they are left out");
        }
        text_.Metadata([&](std::string_view key) {
            if (key == "references" || key == "payload" || key == "inherits" || key == "specializes")
                WarnOfComposition(std::string(key));
            if (key != "active")
                return false;
            if (text_.OneString() == "false")
                prims_[index].hidden = true;
            return true;
        });
        text_.Expect('{', "before what a prim holds");
        while (!text_.Take('}')) {
            if (text_.Peek() == '\0')
                text_.Fail(at, "the file ends within this prim, which no '}' closes");
            Statement(static_cast<ptrdiff_t>(index));
        }
    }

    // The rest of a property after its type.
    void Property(ptrdiff_t parent, size_t at) {
        const std::string_view full = text_.Word();
        if (full.empty() && text_.Peek() != '=')
            text_.Fail(at, "this property has no name");
        std::string_view property = full;
        const bool byTime = property.ends_with(".timeSamples");
        if (byTime)
            property.remove_suffix(std::string_view(".timeSamples").size());
        Attribute *attribute =
            parent >= 0 ? AttributeOf(&prims_[static_cast<size_t>(parent)], property) : nullptr;
        if (text_.Take('=')) {
            const size_t value = text_.At();
            if (parent < 0 || text_.Peek() == 'N' || !Value(parent, property, attribute, byTime, value))
                text_.SkipValue();
        }
        text_.Metadata([&](std::string_view key) {
            if (key != "interpolation" || attribute == nullptr)
                return false;
            attribute->interpolation = text_.OneString();
            return true;
        });
    }

    static Attribute *AttributeOf(Prim *prim, std::string_view property) {
        if (!prim->curves)
            return nullptr;
        CurvesPrim &c = *prim->curves;
        const std::pair<std::string_view, Attribute *> names[] = {
            {"curveVertexCounts", &c.counts},
            {"points", &c.points},
            {"widths", &c.widths},
            {"primvars:widths", &c.primvarWidths},
            {"primvars:displayColor", &c.color},
            {"primvars:displayColor:indices", &c.colorIndices}};
        for (const auto &[name, attribute] : names)
            if (name == property)
                return attribute;
        return nullptr;
    }

    // Reads the value that comes next if it is of use here; false: it is not, and is still to be passed over.
    bool Value(ptrdiff_t parent, std::string_view property, Attribute *attribute, bool byTime, size_t at) {
        Prim &prim = prims_[static_cast<size_t>(parent)];
        const bool operation = property.starts_with("xformOp:");
        if (attribute == nullptr && !operation && byTime)
            return false;
        if (byTime && (attribute == nullptr || !attribute->given)) {
            Warning("USD time samples",
                    name_ + ": values that change with time are taken at their first sample");
            return FirstSample([&] { Value(parent, property, attribute, false, at); }, attribute);
        }
        if (attribute != nullptr) {
            if (byTime)
                return false; // the value at the default time has been read already
            attribute->values = text_.Floats();
            attribute->at = at;
            attribute->given = true;
            return true;
        }
        if (operation) {
            Transform t;
            if (MakeOperation(property, text_.Numbers(), &t))
                prim.operations.insert_or_assign(std::string(property), t);
            return true;
        }
        if (property == "xformOpOrder") {
            prim.order = text_.Strings();
        } else if (property == "visibility") {
            prim.hidden |= text_.OneString() == "invisible";
        } else if (property == "purpose") {
            prim.hidden |= text_.OneString() == "guide";
        } else if (prim.curves && (property == "type" || property == "basis" || property == "wrap")) {
            CurvesPrim &c = *prim.curves;
            (property == "type" ? c.type : property == "basis" ? c.basis : c.wrap) = text_.OneString();
        } else if (prim.curves && property == "primvars:displayOpacity") {
            const std::vector<float> opacity = text_.Floats();
            if (std::any_of(opacity.begin(), opacity.end(), [](float v) { return v < 1; }))
                Warning("transparent strands", name_ +
                                                   ": displayOpacity is not rendered; the hairs are opaque "
                                                   "but for what the material lets through");
        } else {
            return false;
        }
        return true;
    }

    // { 1: value, 2: value, ... }: the first one is read.
    template <typename ReadOne>
    bool FirstSample(ReadOne readOne, Attribute *attribute) {
        text_.Expect('{', "before time samples");
        for (bool first = true; !text_.Take('}'); first = false) {
            text_.Numbers();
            text_.Expect(':', "after a sample's time");
            if (first && text_.Peek() != 'N')
                readOne();
            else
                text_.SkipValue();
            if (text_.Peek() != '}')
                text_.Expect(',', "between time samples");
        }
        if (attribute != nullptr)
            attribute->byTime = true;
        return true;
    }

    UsdText text_;
    const std::string &name_;
    std::vector<Prim> prims_;
};

// The way from a prim's coordinates to the layer's.
Transform ToLayer(const std::vector<Prim> &prims, size_t index, const std::string &name) {
    Transform all;
    for (auto i = static_cast<ptrdiff_t>(index); i >= 0; i = prims[static_cast<size_t>(i)].parent) {
        const Prim &prim = prims[static_cast<size_t>(i)];
        Transform own; // the first operation of the order is the outermost
        bool reset = false;
        for (std::string_view operation : prim.order) {
            if (operation == "!resetXformStack!") {
                reset = true;
                continue;
            }
            const bool invert = operation.starts_with("!invert!");
            if (invert)
                operation.remove_prefix(std::string_view("!invert!").size());
            const auto found = prim.operations.find(operation);
            if (found == prim.operations.end() || (invert && found->second.IsSingular()))
                Warning("USD transformations", name + ": the operation \"" + std::string(operation) +
                                                   "\" is not known or has no value; it is left out");
            else
                own = own * (invert ? found->second.Inverse() : found->second);
        }
        all = own * all;
        if (reset)
            break;
    }
    return all;
}

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
        : prim_(prim), toLayer_(toLayer), text_(text), name_(name), linear_(prim.type == "linear"),
          bezierPoints_(bezierPoints) {
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
        const Attribute &widths = prim_.primvarWidths.given ? prim_.primvarWidths : prim_.widths;
        Attribute color = prim_.color;
        ApplyIndices(&color);
        CheckSpread(&color, 3, "constant", "displayColor", counts);
        Attribute width = widths;
        CheckSpread(&width, 1, "vertex", "widths", counts);
        if (std::any_of(width.values.begin(), width.values.end(), [](float v) { return v < 0; }))
            text_.Fail(width.at, "a width is negative");
        if (std::any_of(color.values.begin(), color.values.end(), [](float v) { return v < 0; }))
            text_.Fail(color.at, "a colour is negative");
        const auto scale = static_cast<float>(std::cbrt(std::abs(toLayer_.Determinant())));
        size_t firstPoint = 0, firstVarying = 0;
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

    void ApplyIndices(Attribute *color) const {
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
    void CheckSpread(Attribute *a, size_t size, const char *usual, const char *name,
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
    void AddStrand(At at, const Attribute &width, const Attribute &color, float scale, Groom *groom) {
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
            const Point3f q = toLayer_.Point(
                {static_cast<float>(p[0][i]), static_cast<float>(p[1][i]), static_cast<float>(p[2][i])});
            if (!(IsCoordinate(q.x) && IsCoordinate(q.y) && IsCoordinate(q.z)))
                text_.Fail(prim_.points.at, "a point, transformed, lies too far out");
            groom->points.push_back(q);
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
    const UsdText &text_;
    const std::string &name_;
    bool linear_, bezierPoints_, pinned_ = false, tooShort_ = false;
    size_t step_ = 1; // points from one segment's first point to the next one's
};

bool IsHidden(const std::vector<Prim> &prims, size_t index) {
    for (auto i = static_cast<ptrdiff_t>(index); i >= 0; i = prims[static_cast<size_t>(i)].parent)
        if (prims[static_cast<size_t>(i)].hidden)
            return true;
    return false;
}

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
            for (int k = 0; k < 3; ++k)
                color[static_cast<size_t>(k)] += static_cast<double>(groom->pointColors[i][k]);
            ++colors;
        }
    }
    groom->hasColor = colors > 0;
    groom->width = widths > 0 ? static_cast<float>(width / static_cast<double>(widths)) : 0;
    for (int k = 0; k < 3 && colors > 0; ++k)
        groom->color[k] = static_cast<float>(color[static_cast<size_t>(k)] / static_cast<double>(colors));
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

} // namespace

Groom ParseUsdFile(std::string_view text, const std::string &name) {
    if (!text.starts_with("#usda"))
        throw Error(FileLoc{std::make_shared<const std::string>(name), 1, 1},
                    "this is not USD in its text form, which begins with #usda 1.0");
    LayerReader reader(text, name);
    const std::vector<Prim> prims = reader.Read();
    const auto isRendered = [&](size_t i) {
        if (!prims[i].curves || IsHidden(prims, i))
            return false;
        const CurvesPrim &c = *prims[i].curves;
        if (c.wrap == "periodic")
            Warning("USD curves that are closed",
                    name + ": periodic curves are not rendered, no hair is closed; they are left out");
        else if (c.wrap != "nonperiodic" && c.wrap != "pinned")
            reader.Text().Fail(c.at,
                               "the wrap \"" + c.wrap +
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
        CurvesBuilder(*prims[i].curves, ToLayer(prims, i, name), reader.Text(), name, !allLinear)
            .Build(&groom);
    Settle(name, &groom);
    return groom;
}

} // namespace cuticle
