// Bytes as a .hair file.
#include "fuzz/groom_fuzz.h"
#include "grooms/hair_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    cuticle::FuzzGroom(cuticle::ParseHairFile, data, size, "fuzz.hair");
    return 0;
}
