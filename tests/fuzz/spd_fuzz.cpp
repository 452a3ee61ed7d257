// Text as a spectrum file: the colour of an accepted one is finite.
#include "fuzz/fuzz.h"
#include "parser/spd_file.h"

using namespace cuticle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    Spectrum s;
    if (Accepts([&] { s = ParseSPD(Text(data, size), "fuzz.spd"); }))
        Require(s.IsFinite());
    return 0;
}
