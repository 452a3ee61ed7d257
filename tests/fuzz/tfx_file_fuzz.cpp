// Bytes as a .tfx file.
#include "fuzz/groom_fuzz.h"
#include "grooms/tfx_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    cuticle::FuzzGroom(cuticle::ParseTfxFile, data, size, "fuzz.tfx");
    return 0;
}
