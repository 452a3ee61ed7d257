#include "grooms/pbrt_writer.h"

#include "core/check.h"
#include "core/error.h"
#include "core/parallel.h"
#include "files/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <numeric>

namespace cuticle {

namespace {

constexpr double kPowers[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};

// v rounded to `digits` places after the point, without trailing zeros.
void AppendNumber(float value, int digits, std::string *out) {
    const double scaled = std::round(static_cast<double>(value) * kPowers[digits]);
    char buffer[40];
    if (!(std::abs(scaled) < 1e15)) { // far away: all the digits that a float has
        const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
        out->append(buffer, end);
        return;
    }
    auto n = static_cast<int64_t>(scaled);
    if (n < 0)
        out->push_back('-');
    n = std::abs(n);
    int places = digits;
    while (places > 0 && n % 10 == 0) {
        n /= 10;
        --places;
    }
    const auto power = static_cast<int64_t>(kPowers[places]);
    char *end = std::to_chars(buffer, buffer + sizeof buffer, n / power).ptr;
    if (places > 0) {
        *end++ = '.';
        int64_t fraction = n % power;
        for (int k = places - 1; k >= 0; --k) {
            end[k] = static_cast<char>('0' + fraction % 10);
            fraction /= 10;
        }
        end += places;
    }
    out->append(buffer, end);
}

// Digits after the point that a groom's coordinates need: an error of 1/200 of the thinnest hair's width.
int Digits(const Groom &groom) {
    float least = groom.pointWidths.empty() && groom.strandWidths.empty() ? groom.width : Infinity;
    for (const float w : groom.pointWidths)
        if (w > 0)
            least = std::min(least, w);
    for (const auto &w : groom.strandWidths)
        least = std::min(least, w[0]); // tips may go to nothing
    if (!(least > 0) || !std::isfinite(least))
        return 6;
    return std::clamp(static_cast<int>(std::ceil(-std::log10(least / 100))), 0, 9);
}

// Shortest text that gives the same float back.
void AppendExact(float value, std::string *out) {
    char buffer[40];
    out->append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

// The pieces [first, last) as one statement.
void AppendStatement(const std::vector<BezierSegment> &pieces, size_t first, size_t last, int digits,
                     const PbrtCurveOptions &options, std::string *out) {
    *out += "Shape \"curve\" \"string type\" \"";
    *out += options.curveType;
    *out += "\" \"point P\" [";
    const auto point = [&](const Point3f &p) {
        for (int c = 0; c < 3; ++c) {
            AppendNumber(p[c], digits, out);
            out->push_back(' ');
        }
    };
    point(pieces[first].cp[0]);
    for (size_t i = first; i < last; ++i)
        for (int k = 1; k < 4; ++k)
            point(pieces[i].cp[k]);
    out->back() = ']';
    const float w0 = pieces[first].width[0] * options.widthScale,
                w1 = pieces[last - 1].width[1] * options.widthScale;
    *out += " \"float width0\" ";
    AppendExact(w0, out);
    *out += " \"float width1\" ";
    AppendExact(w1, out);
    out->push_back('\n');
}

void AppendPieces(const std::vector<BezierSegment> &pieces, int digits, const PbrtCurveOptions &options,
                  std::string *out, PbrtCurveCounts *counts) {
    counts->segments += pieces.size();
    for (size_t first = 0; first < pieces.size();) {
        // One statement as far as the width stays linear in the segment's number, since a statement has two
        // widths.
        size_t last = first + 1;
        const float w0 = pieces[first].width[0], slope = pieces[first].width[1] - w0;
        while (!options.perSegment && last < pieces.size()) {
            const float expected = w0 + slope * static_cast<float>(last - first + 1);
            if (!(std::abs(pieces[last].width[1] - expected) <= 1e-3f * std::max(w0, pieces[last].width[1])))
                break;
            ++last;
        }
        AppendStatement(pieces, first, last, digits, options, out);
        ++counts->statements;
        first = last;
    }
}

// Formats the given strands in parallel batches and writes them in order.
void WriteStrandsPlain(const Groom &groom, const std::vector<uint32_t> &order, int digits,
                       const PbrtCurveOptions &options, OutputFile *out, PbrtCurveCounts *counts) {
    constexpr size_t kChunk = 256, kChunks = 64;
    for (size_t begin = 0; begin < order.size(); begin += kChunk * kChunks) {
        std::vector<std::string> text(kChunks);
        std::vector<PbrtCurveCounts> part(kChunks);
        ParallelFor(kChunks, [&](size_t c) {
            std::vector<BezierSegment> pieces;
            const size_t last = std::min(order.size(), begin + (c + 1) * kChunk);
            for (size_t i = begin + c * kChunk; i < last; ++i) {
                pieces.clear();
                AppendSegments(groom, order[i], options.segments, &pieces);
                AppendPieces(pieces, digits, options, &text[c], &part[c]);
                ++part[c].strands;
            }
        });
        for (size_t c = 0; c < kChunks; ++c) {
            out->Write(text[c]);
            counts->strands += part[c].strands;
            counts->segments += part[c].segments;
            counts->statements += part[c].statements;
        }
    }
}

// The same, each run of strands under its placement.
void WriteStrands(const Groom &groom, const std::vector<uint32_t> &order, int digits,
                  const PbrtCurveOptions &options, OutputFile *out, PbrtCurveCounts *counts) {
    ForEachPlacement(groom, [&](const StrandRange &range, const Transform *toGroom) {
        const auto first = std::lower_bound(order.begin(), order.end(), range.begin);
        const auto last = std::lower_bound(first, order.end(), range.end);
        if (first == last)
            return;
        if (toGroom) {
            std::string head = "TransformBegin\nConcatTransform [";
            for (size_t column = 0; column < 4; ++column)
                for (size_t row = 0; row < 4; ++row)
                    head += fmt::format("{} ", toGroom->M()[row][column]);
            head.back() = ']';
            out->Write(head + "\n");
        }
        WriteStrandsPlain(groom, {first, last}, digits, options, out, counts);
        if (toGroom)
            out->Write("TransformEnd\n");
    });
}

} // namespace

void AppendPbrtCurves(const Groom &groom, size_t begin, size_t end, const PbrtCurveOptions &options,
                      std::string *out, PbrtCurveCounts *counts) {
    CHECK(groom.placements.empty()); // WritePbrtCurves writes them
    const int digits = Digits(groom);
    std::vector<BezierSegment> pieces;
    for (size_t i = begin; i < end; ++i) {
        pieces.clear();
        AppendSegments(groom, i, options.segments, &pieces);
        AppendPieces(pieces, digits, options, out, counts);
        ++counts->strands;
    }
}

void WritePbrtCurves(const Groom &groom, const PbrtCurveOptions &options, OutputFile *out,
                     PbrtCurveCounts *counts) {
    const int digits = Digits(groom);
    const size_t n = groom.StrandCount();
    if (!options.colors || !groom.hasColor) {
        std::vector<uint32_t> order(n);
        std::iota(order.begin(), order.end(), 0u);
        WriteStrands(groom, order, digits, options, out, counts);
        return;
    }
    // Strands of one colour stand together under one material: a material changes the state of the reader,
    // and there may be as many colours as strands.
    std::map<std::array<float, 3>, std::vector<uint32_t>> byColor;
    const auto clamped = [](const Spectrum &c) { return c.Clamp(0, 1).c; };
    for (size_t i = 0; i < n && byColor.size() <= 256; ++i)
        byColor[clamped(groom.StrandColor(i))];
    const bool round = byColor.size() > 256;
    byColor.clear();
    for (size_t i = 0; i < n; ++i) {
        std::array<float, 3> c = clamped(groom.StrandColor(i));
        if (round)
            for (float &v : c) { // even steps in the square root, as the eye sees them
                const auto levels = static_cast<float>(std::max(2, options.colorLevels) - 1);
                v = Sqr(std::round(std::sqrt(v) * levels) / levels);
            }
        byColor[c].push_back(static_cast<uint32_t>(i));
    }
    for (const auto &[color, strands] : byColor) {
        std::string head = "AttributeBegin\nMaterial \"hair\" \"rgb color\" [";
        for (const float v : color) {
            AppendExact(v, &head);
            head += ' ';
        }
        head.back() = ']';
        head += " \"float beta_m\" ";
        AppendExact(options.betaM, &head);
        head += " \"float beta_n\" ";
        AppendExact(options.betaN, &head);
        out->Write(head + "\n");
        WriteStrands(groom, strands, digits, options, out, counts);
        out->Write("AttributeEnd\n");
        ++counts->materials;
    }
}

void WritePbrtMesh(const SurfaceMesh &mesh, OutputFile *out) {
    std::string text = "Shape \"trianglemesh\" \"integer indices\" [";
    for (size_t i = 0; i < mesh.indices.size(); ++i)
        text += std::to_string(mesh.indices[i]) + (i % 30 == 29 ? "\n" : " ");
    const auto vectors = [&](const char *name, const std::vector<Point3f> &values) {
        text += "]\n  ";
        text += name;
        text += " [";
        for (size_t i = 0; i < values.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                AppendNumber(values[i][c], 5, &text);
                text.push_back(i % 8 == 7 && c == 2 ? '\n' : ' ');
            }
    };
    vectors("\"point P\"", mesh.points);
    vectors("\"normal N\"", mesh.normals);
    out->Write(text + "]\n");
}

} // namespace cuticle
