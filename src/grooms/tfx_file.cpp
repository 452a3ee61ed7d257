#include "grooms/tfx_file.h"

#include "grooms/binary_file.h"

namespace cuticle {

namespace {

// The header: the version as a float, two counts, offsets of five arrays (0: not in the file), 32 reserved
// words. The strands' and points' texture coordinates, at 16 and 20, are of no use without the mesh that they
// lie on.
constexpr size_t kHeaderBytes = 160;
constexpr size_t kStrandsAt = 4, kPointsPerStrandAt = 8, kPositionsAt = 12, kThicknessAt = 24, kColorsAt = 28;

// Calls use(i, values) for `count` runs of four floats.
template <typename Use>
void ForEachFour(const BinaryFile &file, size_t start, size_t count, const char *what, bool (*valid)(float),
                 Use use) {
    for (size_t i = 0; i < count; ++i) {
        float v[4];
        file.ReadFloats(start + 16 * i, 4, v, what, valid);
        use(i, v);
    }
}

} // namespace

bool IsTfxFile(std::string_view bytes) {
    float version = 0;
    if (bytes.size() >= sizeof version)
        std::memcpy(&version, bytes.data(), sizeof version);
    return version >= 4 && version < 5;
}

Groom ParseTfxFile(std::string_view bytes, const std::string &name) {
    const BinaryFile file{bytes, name};
    if (bytes.size() < kHeaderBytes)
        file.Fail(bytes.size(), "the file ends within the header of 160 bytes of a .tfx file");
    if (!IsTfxFile(bytes))
        file.Fail(
            0,
            "this is not a .tfx file of version 4, which begins with the number 4 as a float; the float here "
            "is {:f}",
            file.Read<float>(0));
    const size_t strands = file.Read<uint32_t>(kStrandsAt), run = file.Read<uint32_t>(kPointsPerStrandAt);
    if (run == 0)
        file.Fail(kPointsPerStrandAt, "strands of no points");
    // An array's offset, checked before anything is allocated; 0: not there.
    const auto place = [&](size_t field, size_t count, size_t size, const std::string &what) -> size_t {
        const size_t at = file.Read<uint32_t>(field);
        if (at == 0)
            return 0;
        if (at < kHeaderBytes)
            file.Fail(field, "the {} are said to begin at byte {}, within the header of 160 bytes", what, at);
        file.NeedArray(at, count, size, what);
        return at;
    };
    if (strands > 0xffffffffull / run)
        file.Fail(kStrandsAt, "{} strands of {} points are more than 4294967295 points", strands, run);
    const size_t points = strands * run;
    const size_t positions = place(kPositionsAt, points, 16, "positions");
    const size_t thickness = place(kThicknessAt, strands, 4, "thicknesses");
    const size_t colors = place(kColorsAt, points, 16, "colours");
    if (positions == 0)
        file.Fail(kPositionsAt, "the file holds no positions");

    Groom groom;
    groom.width = 0;
    groom.strandOffsets.resize(strands + 1);
    for (size_t i = 0; i <= strands; ++i)
        groom.strandOffsets[i] = static_cast<uint32_t>(i * run);
    groom.points.resize(points);
    ForEachFour(file, positions, points, "a coordinate", IsCoordinate, [&](size_t i, const float *v) {
        groom.points[i] = {v[0], v[1], v[2]};
    });
    if (thickness != 0) {
        std::vector<float> widths(strands);
        file.ReadFloats(thickness, strands, widths.data(), "a thickness", IsNotNegative);
        groom.strandWidths.resize(strands);
        for (size_t i = 0; i < strands; ++i)
            groom.strandWidths[i] = {widths[i], widths[i]};
    }
    if (colors != 0) {
        bool opaque = true;
        groom.hasColor = true;
        groom.pointColors.resize(points);
        ForEachFour(file, colors, points, "a colour", IsNotNegative, [&](size_t i, const float *v) {
            groom.pointColors[i] = {v[0], v[1], v[2]};
            opaque &= v[3] >= 1;
        });
        if (!opaque)
            Warning("transparent strands", name +
                                               ": the colours' alpha is not rendered; the hairs are opaque "
                                               "but for what the material lets through");
    }
    return groom;
}

} // namespace cuticle
