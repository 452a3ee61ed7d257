// Bytes as a .hair file: the strands of an accepted groom are the points, all of them finite.
#include "fuzz/fuzz.h"
#include "grooms/hair_file.h"

using namespace cuticle;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    Groom groom;
    if (Accepts([&] { groom = ParseHairFile(Text(data, size), "fuzz.hair"); })) {
        Require(groom.strandOffsets.back() == groom.points.size());
        for (const Point3f &p : groom.points)
            Require(IsFinite(p));
        Accepts([&] {
            ForEachSegment(groom, {}, [](const BezierSegment &s, size_t) {
                for (const Point3f &p : s.cp)
                    Require(IsFinite(p));
            });
        });
    }
    return 0;
}
