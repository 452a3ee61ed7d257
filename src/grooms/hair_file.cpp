#include "grooms/hair_file.h"

#include "core/error.h"
#include "files/file.h"
#include "grooms/binary_file.h"

#include <cstring>

namespace cuticle {

namespace {

// The header, byte by byte: "HAIR", strands, points, which arrays follow (bits), and the values that stand
// for the arrays that do not.
constexpr size_t kHeaderBytes = 128;
constexpr size_t kStrandsAt = 4, kPointsAt = 8, kArraysAt = 12, kSegmentsAt = 16, kThicknessAt = 20,
                 kTransparencyAt = 24, kColorAt = 28, kInfoAt = 40;
enum ArrayBit : uint32_t {
    kHasSegments = 1, // uint16 per strand
    kHasPoints = 2,   // three floats per point
    kHasThickness = 4,
    kHasTransparency = 8,
    kHasColors = 16, // three floats per point
    kKnownArrays = 31
};

void CheckTransparency(const BinaryFile &file, size_t start, size_t count) {
    size_t transparent = 0;
    for (size_t i = 0; i < count; ++i) {
        const auto v = file.Read<float>(start + 4 * i);
        if (!std::isfinite(v))
            file.Fail(start + 4 * i, "a transparency is not a finite number");
        transparent += v != 0;
    }
    if (transparent > 0)
        Warning("transparent strands",
                file.name +
                    ": the file's transparency is not rendered; its hairs are opaque but for what the "
                    "material lets through");
}

} // namespace

Groom ParseHairFile(std::string_view bytes, const std::string &name) {
    const BinaryFile file{bytes, name};
    if (bytes.size() < 4 || bytes.substr(0, 4) != "HAIR")
        file.Fail(0, "this is not a .hair file, which begins with the letters HAIR");
    if (bytes.size() < kHeaderBytes)
        file.Fail(bytes.size(), "the file ends within the header of 128 bytes");
    const size_t strands = file.Read<uint32_t>(kStrandsAt);
    const size_t points = file.Read<uint32_t>(kPointsAt);
    const auto arrays = file.Read<uint32_t>(kArraysAt);
    const size_t defaultSegments = file.Read<uint32_t>(kSegmentsAt);
    if ((arrays & kHasPoints) == 0)
        file.Fail(kArraysAt, "the file holds no points");
    if ((arrays & ~static_cast<uint32_t>(kKnownArrays)) != 0)
        Warning(".hair with unknown arrays", name + ": arrays that this reader does not know are left out");

    // Check all sizes before anything is allocated: a count is believed only if the file is long enough for
    // it.
    size_t end = kHeaderBytes;
    const auto place = [&](uint32_t bit, size_t count, size_t size, const char *what) {
        const size_t at = end;
        if ((arrays & bit) == 0)
            return at;
        file.NeedArray(at, count, size, what);
        end += count * size;
        return at;
    };
    const size_t segmentsStart = place(kHasSegments, strands, 2, "segment counts");
    const size_t pointsStart = place(kHasPoints, points, 12, "points");
    const size_t thicknessStart = place(kHasThickness, points, 4, "thicknesses");
    const size_t transparencyStart = place(kHasTransparency, points, 4, "transparencies");
    const size_t colorsStart = place(kHasColors, points, 12, "colours");
    if (end < bytes.size() && (arrays & ~static_cast<uint32_t>(kKnownArrays)) == 0)
        Warning(".hair with bytes left over",
                fmt::format("{}: {} bytes after the last array are ignored", name, bytes.size() - end));
    // With no array of them each strand holds the same number of points, at least one: the points are in the
    // file, so this bounds the strands too.
    if ((arrays & kHasSegments) == 0 && strands * (defaultSegments + 1) != points)
        file.Fail(kStrandsAt, "{} strands of {} segments need {} points, and the header says {}", strands,
                  defaultSegments, strands * (defaultSegments + 1), points);

    Groom groom;
    groom.strandOffsets.resize(strands + 1);
    size_t offset = 0;
    for (size_t i = 0; i < strands; ++i) {
        const size_t segments =
            (arrays & kHasSegments) != 0 ? file.Read<uint16_t>(segmentsStart + 2 * i) : defaultSegments;
        offset += segments + 1;
        if (offset > points)
            file.Fail((arrays & kHasSegments) != 0 ? segmentsStart + 2 * i : kSegmentsAt,
                      "strand {} of {} segments needs point {} of {}", i, segments, offset, points);
        groom.strandOffsets[i + 1] = static_cast<uint32_t>(offset);
    }
    if (offset != points)
        file.Fail(kPointsAt, "the strands use {} points of {}", offset, points);

    groom.points.resize(points);
    static_assert(sizeof(Point3f) == 12 && sizeof(Spectrum) == 12);
    file.ReadFloats(pointsStart, 3 * points, reinterpret_cast<float *>(groom.points.data()), "a coordinate",
                    IsCoordinate);
    if ((arrays & kHasThickness) != 0) {
        groom.pointWidths.resize(points);
        file.ReadFloats(thicknessStart, points, groom.pointWidths.data(), "a thickness", IsNotNegative);
    } else {
        file.ReadFloats(kThicknessAt, 1, &groom.width, "the thickness", IsNotNegative);
    }
    CheckTransparency(file, (arrays & kHasTransparency) != 0 ? transparencyStart : kTransparencyAt,
                      (arrays & kHasTransparency) != 0 ? points : 1);
    // The header's colour stands in every file, meant or not: it is no colour of the strands
    if ((arrays & kHasColors) != 0) {
        groom.hasColor = true;
        groom.pointColors.resize(points);
        file.ReadFloats(colorsStart, 3 * points, reinterpret_cast<float *>(groom.pointColors.data()),
                        "a colour", IsNotNegative);
    } else {
        file.ReadFloats(kColorAt, 3, groom.color.c.data(), "the colour", IsNotNegative);
    }
    return groom;
}

namespace {
[[noreturn]] void Refuse(const std::string &name, const std::string &what) {
    throw Error(FileLoc{std::make_shared<const std::string>(name)}, what);
}
} // namespace

void WriteHairFile(const std::string &filename, const Groom &groom) {
    const size_t strands = groom.StrandCount();
    if (groom.spline == StrandSpline::Bezier)
        Refuse(filename, "a .hair file holds points on the strands, no Bezier control points");
    if (strands > 0xffffffffull || groom.points.size() > 0xffffffffull)
        Refuse(filename, "a .hair file holds at most 4294967295 strands and points");
    bool sameLength = strands > 0;
    for (size_t i = 0; i < strands; ++i) {
        const size_t n = groom.PointCount(i);
        if (n == 0 || n > 65536)
            Refuse(filename,
                   fmt::format("strand {} has {} points; a .hair file holds strands of 1 to 65536", i, n));
        sameLength = sameLength && n == groom.PointCount(0);
    }
    const bool thickness = !groom.pointWidths.empty() || !groom.strandWidths.empty();
    // Always for each point: readers take the header's colour for none
    const bool colors = groom.hasColor;

    std::string header(kHeaderBytes, '\0');
    const auto put = [&](size_t at, auto value) { std::memcpy(header.data() + at, &value, sizeof value); };
    std::memcpy(header.data(), "HAIR", 4);
    put(kStrandsAt, static_cast<uint32_t>(strands));
    put(kPointsAt, static_cast<uint32_t>(groom.points.size()));
    put(kArraysAt, static_cast<uint32_t>(kHasPoints | (sameLength ? 0u : kHasSegments) |
                                         (thickness ? kHasThickness : 0u) | (colors ? kHasColors : 0u)));
    put(kSegmentsAt, sameLength ? static_cast<uint32_t>(groom.PointCount(0) - 1) : 0u);
    put(kThicknessAt, groom.width);
    put(kTransparencyAt, 0.f);
    for (size_t c = 0; c < 3; ++c)
        put(kColorAt + 4 * c, groom.color.c[c]);
    constexpr std::string_view info = "written by Cuticle";
    std::memcpy(header.data() + kInfoAt, info.data(), info.size());

    OutputFile out(filename);
    out.Write(header);
    const auto bytesOf = [](const auto &v) {
        return std::string_view(reinterpret_cast<const char *>(v.data()), v.size() * sizeof(v[0]));
    };
    if (!sameLength) {
        std::vector<uint16_t> segments(strands);
        for (size_t i = 0; i < strands; ++i)
            segments[i] = static_cast<uint16_t>(groom.PointCount(i) - 1);
        out.Write(bytesOf(segments));
    }
    out.Write(bytesOf(groom.points));
    if (thickness) {
        std::vector<float> widths;
        for (size_t i = 0; i < strands; ++i) {
            widths.clear();
            for (size_t k = 0; k < groom.PointCount(i); ++k)
                widths.push_back(groom.Width(i, k));
            out.Write(bytesOf(widths));
        }
    }
    if (colors && !groom.pointColors.empty())
        out.Write(bytesOf(groom.pointColors));
    else if (colors)
        out.Write(bytesOf(std::vector<Spectrum>(groom.points.size(), groom.color)));
    out.Commit();
}

} // namespace cuticle
