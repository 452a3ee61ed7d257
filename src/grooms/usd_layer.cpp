#include "grooms/usd_layer.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace cuticle {

namespace {

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
    LayerReader(UsdText &text, const std::string &name, std::optional<double> time, UsdSamples samples)
        : time_(time), samples_(samples), text_(text), name_(name) {}

    UsdLayer Read() {
        UsdLayer layer;
        text_.Metadata([&](std::string_view key) {
            if (key == "subLayers")
                WarnOfComposition("sublayers");
            if (key == "upAxis") {
                layer.upAxisAt = text_.At();
                layer.upAxis = text_.OneString();
                return true;
            }
            double *number = key == "metersPerUnit"        ? &layer.metersPerUnit
                             : key == "timeCodesPerSecond" ? &layer.timeCodesPerSecond
                                                           : nullptr;
            if (number == nullptr)
                return false;
            const size_t at = text_.At();
            const std::vector<double> numbers = text_.Numbers();
            if (numbers.size() != 1 || !(numbers[0] > 0))
                text_.Fail(at, "{} takes one number above 0", key);
            *number = numbers[0];
            return true;
        });
        while (text_.Peek() != '\0')
            Statement(-1);
        layer.prims = std::move(prims_);
        return layer;
    }

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
        prims_[index].hidden = specifier != "def";
        const size_t at = text_.At();
        const std::string_view type = text_.Word();
        prims_[index].name = text_.String();
        if (type == "PointInstancer") {
            prims_[index].hidden = true;
            Warning("USD point instancers", name_ +
                                                ": a PointInstancer is not rendered; what lies in it, which "
                                                "is to be copied to its points, is left out");
        }
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
        UsdAttribute *attribute =
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

    static UsdAttribute *AttributeOf(UsdPrim *prim, std::string_view property) {
        if (!prim->curves)
            return nullptr;
        CurvesPrim &c = *prim->curves;
        const std::pair<std::string_view, UsdAttribute *> names[] = {
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
    bool Value(ptrdiff_t parent, std::string_view property, UsdAttribute *attribute, bool byTime, size_t at) {
        UsdPrim &prim = prims_[static_cast<size_t>(parent)];
        const bool operation = property.starts_with("xformOp:");
        if (attribute == nullptr && !operation && byTime)
            return false;
        if (operation && byTime && samples_ == UsdSamples::Keep)
            return KeepSamples(property, &prim);
        if (byTime && (attribute == nullptr || !attribute->given)) {
            if (!time_)
                Warning("USD time samples",
                        name_ + ": values that change with time are taken at their first sample");
            return SampleAtTime([&] { Value(parent, property, attribute, false, at); }, attribute);
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
            prim.purpose = text_.OneString();
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

    // All samples of an operation.
    bool KeepSamples(std::string_view property, UsdPrim *prim) {
        auto &samples = prim->samples[std::string(property)];
        text_.Expect('{', "before time samples");
        while (!text_.Take('}')) {
            const double time = SampleTime();
            if (text_.Peek() == 'N') {
                text_.SkipValue();
            } else {
                const size_t at = text_.At();
                std::vector<double> numbers = text_.Numbers();
                if (!samples.empty() && numbers.size() != samples.begin()->second.size())
                    text_.Fail(at, "this sample has {} numbers, the first has {}", numbers.size(),
                               samples.begin()->second.size());
                samples.insert_or_assign(time, std::move(numbers));
            }
            if (text_.Peek() != '}')
                text_.Expect(',', "between time samples");
        }
        if (samples.empty())
            prim->samples.erase(std::string(property));
        return true;
    }
    // The time before a sample's value, and the colon.
    double SampleTime() {
        const size_t at = text_.At();
        const std::vector<double> time = text_.Numbers();
        if (time.size() != 1)
            text_.Fail(at, "a sample's time was expected, one number");
        text_.Expect(':', "after a sample's time");
        return time[0];
    }

    // { 1: value, 2: value, ... }: the last one that is no later than the time asked for is read, or the
    // first.
    template <typename ReadOne>
    bool SampleAtTime(ReadOne readOne, UsdAttribute *attribute) {
        text_.Expect('{', "before time samples");
        double best = 0, earliest = INFINITY, latest = -INFINITY;
        for (bool first = true; !text_.Take('}'); first = false) {
            const double time = SampleTime();
            earliest = std::min(earliest, time), latest = std::max(latest, time);
            const bool nearer = time_ && time <= *time_ && (best > *time_ || time >= best);
            if (text_.Peek() != 'N' && (first || nearer)) {
                readOne();
                best = time;
            } else {
                text_.SkipValue();
            }
            if (text_.Peek() != '}')
                text_.Expect(',', "between time samples");
        }
        if (time_ && latest > earliest && !(*time_ >= earliest && *time_ <= latest))
            Warning("time beyond the samples",
                    fmt::format("{}: there are samples from time {} to {}; for {} the nearest is taken",
                                name_, earliest, latest, *time_));
        if (attribute != nullptr)
            attribute->byTime = true;
        return true;
    }

    std::optional<double> time_;
    UsdSamples samples_;
    UsdText &text_;
    const std::string &name_;
    std::vector<UsdPrim> prims_;
};

} // namespace

UsdLayer ReadUsdLayer(UsdText &text, const std::string &name, std::optional<double> time,
                      UsdSamples samples) {
    return LayerReader(text, name, time, samples).Read();
}

void SetUsdTime(std::vector<UsdPrim> *prims, double time) {
    for (UsdPrim &prim : *prims)
        for (const auto &[name, samples] : prim.samples) {
            const auto above = samples.lower_bound(time);
            std::vector<double> numbers = above == samples.end() ? samples.rbegin()->second : above->second;
            if (above != samples.end() && above != samples.begin()) {
                const auto below = std::prev(above);
                const double f = (time - below->first) / (above->first - below->first);
                // A quaternion and its negative are the same turn
                double product = 0;
                for (size_t k = 0; k < numbers.size(); ++k)
                    product += numbers[k] * below->second[k];
                const double sign = name.starts_with("xformOp:orient") && product < 0 ? -1 : 1;
                for (size_t k = 0; k < numbers.size(); ++k)
                    numbers[k] = numbers[k] * f + below->second[k] * sign * (1 - f);
            }
            Transform t;
            if (MakeOperation(name, numbers, &t))
                prim.operations.insert_or_assign(name, t);
        }
}

std::string UsdPrimPath(const std::vector<UsdPrim> &prims, size_t index) {
    std::string path;
    for (auto i = static_cast<ptrdiff_t>(index); i >= 0; i = prims[static_cast<size_t>(i)].parent)
        path = "/" + prims[static_cast<size_t>(i)].name + path;
    return path;
}

Transform UsdPrimToLayer(const std::vector<UsdPrim> &prims, size_t index, const std::string &name) {
    Transform all;
    for (auto i = static_cast<ptrdiff_t>(index); i >= 0; i = prims[static_cast<size_t>(i)].parent) {
        const UsdPrim &prim = prims[static_cast<size_t>(i)];
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

bool IsHiddenUsdPrim(const std::vector<UsdPrim> &prims, size_t index) {
    std::string_view purpose; // the nearest one that is given counts
    for (auto i = static_cast<ptrdiff_t>(index); i >= 0; i = prims[static_cast<size_t>(i)].parent) {
        const UsdPrim &prim = prims[static_cast<size_t>(i)];
        if (prim.hidden)
            return true;
        if (purpose.empty())
            purpose = prim.purpose;
    }
    return purpose == "guide" || purpose == "proxy";
}

} // namespace cuticle
