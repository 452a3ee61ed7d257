// These laws hold for strands from any file.
#pragma once

#include "fuzz/fuzz.h"
#include "grooms/groom.h"

namespace cuticle {

// The strands are the points in their order, and all that is made of them is finite.
template <class Parse>
void FuzzGroom(const Parse &parse, const uint8_t *data, size_t size, const std::string &name) {
    Groom groom;
    if (!Accepts([&] { groom = parse(Text(data, size), name); }))
        return;
    Require(groom.strandOffsets.front() == 0 && groom.strandOffsets.back() == groom.points.size());
    Require(groom.pointWidths.empty() || groom.pointWidths.size() == groom.points.size());
    Require(groom.pointColors.empty() || groom.pointColors.size() == groom.points.size());
    size_t segments = 0;
    const bool made = Accepts([&] {
        ForEachSegment(groom, {}, [&](const BezierSegment &s, size_t strand) {
            Require(strand < groom.StrandCount());
            for (const Point3f &p : s.cp)
                Require(IsFinite(p));
            for (const float w : s.width)
                Require(std::isfinite(w) && w >= 0);
            for (const float at : s.at)
                Require(groom.Color(strand, at).IsFinite());
            ++segments;
        });
    });
    Require(made && segments <= ExpectedSegments(groom, {}));
}

} // namespace cuticle
