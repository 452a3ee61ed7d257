// Bytes as a .usda file.
#include "fuzz/groom_fuzz.h"
#include "grooms/usd_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    cuticle::FuzzGroom(cuticle::ParseUsdFile, data, size, "fuzz.usda");
    return 0;
}
