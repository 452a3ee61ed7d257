// Text as a spectrum file: the colour of an accepted one is finite.
#include "core/color.h"
#include "fuzz/fuzz.h"

using namespace cuticle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    Spectrum s;
    if (Accepts([&] { s = ParseSPD(Text(data, size), "fuzz.spd"); }))
        Require(s.IsFinite());
    return 0;
}
