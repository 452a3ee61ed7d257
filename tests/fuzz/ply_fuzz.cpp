// Bytes as a PLY mesh: every index of an accepted mesh is one of its vertices.
#include "fuzz/fuzz.h"
#include "shapes/ply.h"

using namespace cuticle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    TriangleMesh mesh;
    if (Accepts([&] { mesh = ReadPlyBytes(Text(data, size), "fuzz.ply"); })) {
        Require(mesh.indices.size() % 3 == 0);
        for (const uint32_t i : mesh.indices)
            Require(i < mesh.p.size());
        for (const Normal3f &n : mesh.n)
            Require(IsFinite(n));
        for (const Point2f &uv : mesh.uv)
            Require(std::isfinite(uv.x) && std::isfinite(uv.y));
    }
    return 0;
}
