#include "shapes/ply.h"

#include "core/error.h"
#include "files/ply_file.h"

namespace cuticle {

namespace {

// Targets: of a vertex 0..2 position, 3..5 normal, 6..7 uv; of a face 0 the list of corners.
void ReadVertices(PlyValues &values, PlyElement &element, const PlySource &source, TriangleMesh *mesh) {
    constexpr std::string_view kTargets[][5] = {{"x"},
                                                {"y"},
                                                {"z"},
                                                {"nx"},
                                                {"ny"},
                                                {"nz"},
                                                {"u", "s", "texture_u", "texture_s"},
                                                {"v", "t", "texture_v", "texture_t"}};
    bool has[8] = {};
    for (PlyProperty &property : element.properties)
        for (size_t k = 0; k < 8; ++k)
            for (const std::string_view name : kTargets[k])
                if (!has[k] && !property.countType && property.name == name)
                    property.target = static_cast<int>(k), has[k] = true;
    if (!(has[0] && has[1] && has[2]))
        source.Fail("its vertices lack x, y or z");
    if (element.count > 0xfffffffeull)
        source.Fail("{} vertices: more than 4294967294", element.count);
    const bool hasN = has[3] && has[4] && has[5], hasUV = has[6] && has[7];
    mesh->p.reserve(CautiousReserve(element.count));
    uint64_t notFinite = 0;
    for (uint64_t i = 0; i < element.count; ++i) {
        values.SetPlace(&element, i);
        float v[8] = {};
        for (const PlyProperty &property : element.properties) {
            const uint64_t length = property.countType ? values.ReadCount(property) : 1;
            for (uint64_t k = 0; k < length; ++k) {
                const double value = values.Read(property.type);
                if (property.target >= 0)
                    v[property.target] = static_cast<float>(value);
            }
        }
        // Triangles of a point that is not finite are dropped where they are made into a shape
        bool finite = true;
        for (size_t k = 3; k < 8; ++k)
            if (!std::isfinite(v[k]))
                v[k] = 0, finite = false;
        notFinite += !finite;
        mesh->p.push_back({v[0], v[1], v[2]});
        if (hasN)
            mesh->n.push_back({v[3], v[4], v[5]});
        if (hasUV)
            mesh->uv.push_back({v[6], v[7]});
    }
    if (notFinite > 0)
        Warning(
            "PLY values out of range",
            fmt::format("{}: the normals or texture coordinates of {} vertices are not finite, and set to 0",
                        source.Name(), notFinite));
}

void ReadFaces(PlyValues &values, PlyElement &element, const PlySource &source, TriangleMesh *mesh) {
    bool hasCorners = false;
    for (PlyProperty &property : element.properties)
        if (!hasCorners && property.countType &&
            (property.name == "vertex_indices" || property.name == "vertex_index"))
            property.target = 0, hasCorners = true;
    if (!hasCorners)
        source.Fail("its faces lack a list vertex_indices");
    mesh->indices.reserve(mesh->indices.size() + 3 * CautiousReserve(element.count));
    uint64_t dropped = 0;
    for (uint64_t i = 0; i < element.count; ++i) {
        values.SetPlace(&element, i);
        for (const PlyProperty &property : element.properties) {
            const uint64_t length = property.countType ? values.ReadCount(property) : 1;
            uint32_t first = 0, previous = 0;
            for (uint64_t k = 0; k < length; ++k) {
                const double value = values.Read(property.type);
                if (property.target < 0)
                    continue;
                if (!(value >= 0 && value <= 4294967294.0 && value == std::floor(value)))
                    source.Fail("face {} has the vertex index {:f}", i, value);
                const auto index = static_cast<uint32_t>(value);
                if (k == 0)
                    first = index;
                else if (k == 1)
                    ;
                else if (k == 2)
                    mesh->indices.insert(mesh->indices.end(), {first, previous, index});
                else // pbrt-v3's order for the second half of a quad: the new corner first
                    mesh->indices.insert(mesh->indices.end(), {index, first, previous});
                previous = index;
            }
            dropped += property.target >= 0 && length < 3;
        }
    }
    if (dropped > 0)
        Warning("PLY faces dropped", fmt::format("{}: {} of {} faces have fewer than three corners",
                                                 source.Name(), dropped, element.count));
}

TriangleMesh ReadFrom(PlySource &source) {
    PlyHeader header = ReadPlyHeader(source);
    PlyValues values(source, header.format);
    TriangleMesh mesh;
    bool vertices = false, faces = false;
    for (PlyElement &element : header.elements) {
        if (element.name == "vertex" && !vertices) {
            ReadVertices(values, element, source, &mesh);
            vertices = true;
        } else if (element.name == "face" && !faces) {
            ReadFaces(values, element, source, &mesh);
            faces = true;
        } else if (!(vertices && faces)) {
            SkipPlyElement(values, element);
        }
    }
    if (!vertices || mesh.p.empty())
        source.Fail("holds no vertices");
    if (!faces || mesh.indices.empty())
        source.Fail(
            "holds no faces; if its points are strands of hair, Shape \"hairfile\" reads them, and so does "
            "cuticle groom from");
    for (const uint32_t index : mesh.indices)
        if (index >= mesh.p.size())
            source.Fail("a face has the vertex index {}, but there are {} vertices", index, mesh.p.size());
    return mesh;
}

} // namespace

TriangleMesh ReadPly(const std::string &filename) {
    PlySource source(filename);
    return ReadFrom(source);
}

TriangleMesh ReadPlyBytes(std::string_view bytes, const std::string &name) {
    PlySource source(bytes, name);
    return ReadFrom(source);
}

} // namespace cuticle
