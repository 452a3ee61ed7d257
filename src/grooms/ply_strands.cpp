#include "grooms/ply_strands.h"

#include "files/ply_file.h"
#include "grooms/binary_file.h"

#include <array>

namespace cuticle {

namespace {

void ReadPoints(PlyValues &values, PlyElement &element, const PlySource &source, Groom *groom) {
    constexpr std::array<std::string_view, 3> kNames{"x", "y", "z"};
    unsigned found = 0;
    for (PlyProperty &property : element.properties)
        for (size_t k = 0; k < 3; ++k)
            if (property.name == kNames[k] && !property.countType && !(found & 1u << k)) {
                property.target = static_cast<int>(k);
                found |= 1u << k;
            }
    if (found != 7)
        source.Fail("its vertices lack x, y or z");
    if (element.count > UINT32_MAX)
        source.Fail("a groom holds at most 4294967295 points, not {}", element.count);
    groom->points.reserve(CautiousReserve(element.count));
    for (uint64_t i = 0; i < element.count; ++i) {
        values.SetPlace(&element, i);
        Point3f p;
        for (const PlyProperty &property : element.properties)
            for (uint64_t n = property.countType ? values.ReadCount(property) : 1; n > 0; --n) {
                const double v = values.Read(property.type);
                if (property.target >= 0)
                    p[property.target] = static_cast<float>(v);
            }
        if (!(IsCoordinate(p.x) && IsCoordinate(p.y) && IsCoordinate(p.z)))
            source.Fail("vertex {} is not finite or lies too far out", i);
        groom->points.push_back(p);
    }
}

} // namespace

Groom ParsePlyStrands(std::string_view bytes, const std::string &name, size_t pointsPerStrand) {
    PlySource source(bytes, name);
    PlyHeader header = ReadPlyHeader(source);
    PlyValues values(source, header.format);
    Groom groom;
    groom.width = 0;
    for (const PlyElement &element : header.elements)
        if (element.name == "face" && element.count > 0)
            source.Fail("holds {} faces: it is a mesh, which Shape \"plymesh\" reads, and no strands",
                        element.count);
    for (PlyElement &element : header.elements) {
        if (element.name == "vertex") {
            ReadPoints(values, element, source, &groom);
            break;
        }
        SkipPlyElement(values, element);
    }
    const size_t points = groom.points.size(),
                 run = pointsPerStrand > 0 ? pointsPerStrand : kPlyPointsPerStrand;
    if (points == 0)
        source.Fail("holds no points");
    if (points % run != 0 || run < 2)
        source.Fail(
            "holds {} points, which are no strands of {}{}; say how many points make a strand, by \"integer "
            "pointsperstrand\" or --points-per-strand",
            points, run, pointsPerStrand > 0 ? "" : ", the usual number");
    for (size_t end = run; end <= points; end += run)
        groom.strandOffsets.push_back(static_cast<uint32_t>(end));
    return groom;
}

} // namespace cuticle
