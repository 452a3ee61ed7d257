// Bytes as a .ply file of points that are strands, two points each.
#include "fuzz/groom_fuzz.h"
#include "grooms/ply_strands.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const auto parse = [](std::string_view bytes, const std::string &name) {
        return cuticle::ParsePlyStrands(bytes, name, 2);
    };
    cuticle::FuzzGroom(parse, data, size, "fuzz.ply");
    return 0;
}
