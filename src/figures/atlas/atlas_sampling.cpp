// The atlas's maps of sampling: random numbers at their ends, directions that are rounded, rays that meet
// curves. Faults 17, 18, 19 and 22.
#include "core/sampling.h"
#include "figures/atlas/atlas.h"
#include "figures/atlas/atlas_fibers.h"
#include "shapes/curve.h"
#include "shapes/curve_set.h"

#include <bit>

namespace cuticle {

namespace {

// pbrt-v3's: the even and the odd bits of u 2^32, 16 each. (It stops the program where u 2^32 does not fit.)
uint32_t CompactBits(uint64_t x) {
    uint32_t half = 0;
    for (int i = 0; i < 17; ++i)
        half |= static_cast<uint32_t>((x >> (2 * i)) & 1) << i;
    return half;
}
Point2f PrintedDemux(float u) {
    const auto v = static_cast<uint64_t>(static_cast<double>(u) * 4294967296.);
    return {static_cast<float>(CompactBits(v)) * 0x1p-16f,
            static_cast<float>(CompactBits(v >> 1)) * 0x1p-16f};
}

AtlasMap DemuxMap() {
    AtlasMap map;
    map.name = "demux", map.title = "How many different halves DemuxFloat makes";
    map.quantity = "different numbers";
    map.x = {"u between 2^{-x-1} and 2^{-x}", "binade", 0, 8, 8};
    map.y = {"half of u: first, second", "half", 0, 2, 2};
    map.min = 1e2, map.max = 1e7;
    const auto count = [](bool published) {
        return [=](double x, double y) {
            const float low = std::ldexp(0.5f, -static_cast<int>(x));
            std::vector<bool> seen(size_t(1) << 24);
            size_t different = 0;
            const uint32_t first = std::bit_cast<uint32_t>(low);
            for (uint32_t k = 0; k < (1u << 23); ++k) {
                const float u = std::bit_cast<float>(first + k);
                const Point2f halves = published ? PrintedDemux(u) : DemuxFloat(u);
                const auto at = static_cast<size_t>((y < 1 ? halves.x : halves.y) * 0x1p24f);
                if (!seen[at])
                    seen[at] = true, ++different;
            }
            return static_cast<double>(different);
        };
    };
    map.panels = {{"published", FillMap(map.x, map.y, count(true))},
                  {"ours", FillMap(map.x, map.y, count(false))}};
    const auto at = [&](size_t panel, size_t half) { return map.panels[panel].values[half * map.x.cells]; };
    map.findings = {{17, "1 - the first half of u = 1, which must be above 0",
                     1 - static_cast<double>(PrintedDemux(1).x), 1 - static_cast<double>(DemuxFloat(1).x)},
                    {22, "different first halves of u in [0.5, 1)", at(0, 0), at(1, 0)},
                    {22, "different second halves of u in [0.5, 1)", at(0, 1), at(1, 1)}};
    return map;
}

// Share of the corners of the unit cube of random numbers where a sample has no density.
AtlasMap CornersMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "corners", map.title = "Random numbers of 0 and 1 - 2^{-24}: samples that have no density";
    map.quantity = "share of 16 corners";
    map.x = {"β_n", "beta_n", -3, 0, o.quick ? size_t(10) : size_t(30), true};
    map.y = {"β_m", "beta_m", -3, 0, o.quick ? size_t(10) : size_t(30), true};
    map.log = false, map.min = 0, map.max = 1;
    const auto share = [](const FiberInDouble &fiber) {
        int without = 0;
        for (int corner = 0; corner < 16; ++corner) {
            std::array<double, 4> u;
            for (size_t k = 0; k < 4; ++k)
                u[k] = (corner >> k) & 1 ? 1 - 0x1p-24 : 0;
            Vector3d wi;
            const double pdf = fiber.Sample(FiberDirection(0.3, 1), u, &wi).pdf;
            without += !(pdf > 0 && std::isfinite(pdf));
        }
        return without / 16.;
    };
    const auto at = [](double n, double m) {
        AtlasInputs in;
        in.betaN = n, in.betaM = m, in.sigmaA = 0.1;
        return in;
    };
    map.panels = {
        {"published",
         FillMap(map.x, map.y, [&](double n, double m) { return share(*PrintedFiber(at(n, m), false)); })},
        {"ours", FillMap(map.x, map.y, [&](double n, double m) { return share(*OurFiber(at(n, m))); })}};
    map.findings = {{22, "largest share of corners without a density", WorstOf(map.panels[0].values),
                     WorstOf(map.panels[1].values)}};
    return map;
}

// The weight of a gray fiber's samples is the sum of A_p, whatever the direction: what is off is rounding.
AtlasMap RoundTripMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "round-trip", map.title = "Weights of samples, f |cos| / pdf, against the light that leaves";
    map.quantity = "largest error";
    map.x = {"β_n", "beta_n", -4, 0, o.quick ? size_t(8) : size_t(32), true};
    map.y = {"θ_o (degrees)", "theta_o_deg", -90, 90, o.quick ? size_t(6) : size_t(24)};
    map.min = 1e-8, map.max = 1;
    const auto worst = [](const FiberInDouble &fiber, double theta) {
        double off = 0;
        for (size_t k = 0; k < 400; ++k) {
            Vector3d wi;
            const FiberValue<double> value =
                fiber.Sample(FiberDirection(theta * kDegree, 0.7), EvenlySpread(k), &wi);
            const double miss = std::abs(value.fCos[1] / value.pdf - 1); // NaN where there is no density
            if (!(miss <= off))
                off = miss;
        }
        return off;
    };
    const auto at = [](double n) {
        AtlasInputs in;
        in.betaN = n;
        return in;
    };
    map.panels = {
        {"published",
         FillMap(map.x, map.y, [&](double n, double t) { return worst(*PrintedFiber(at(n), false), t); })},
        {"ours", FillMap(map.x, map.y, [&](double n, double t) { return worst(*OurFiber(at(n)), t); })}};
    map.findings = {{19, "largest error of a white fiber's weight", WorstOf(map.panels[0].values),
                     WorstOf(map.panels[1].values)}};
    return map;
}

// --- curves ------------------------------------------------------------------------------------------------

constexpr float kWidth = 0.02f;

// A straight curve from 0 to 1 along x, its inner control points drawn toward the root by uneven in [0, 1).
CurveSegment Straight(double uneven, float y = 0) {
    const auto at = [&](double x) { return Point3f(static_cast<float>(x), y, 0); };
    return {{at(0), at((1 - uneven) / 3), at(2 * (1 - uneven) / 3), at(1)}, {kWidth, kWidth}};
}

AtlasMap AcrossMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "curve-across",
    map.title = "The place v across a straight curve whose control points are not evenly spaced";
    map.quantity = "error of v (1: not met at all)";
    map.x = {"ray to curve (degrees)", "angle_deg", 0, 90, o.quick ? size_t(9) : size_t(45)};
    map.y = {"unevenness", "uneven", 0, 1, o.quick ? size_t(8) : size_t(40)};
    map.min = 1e-8, map.max = 1;
    const auto error = [](const auto &set, double angle) {
        // At 0.15 widths from the middle: the ray passes there whatever its angle.
        Ray ray;
        ray.d = {static_cast<float>(std::cos(angle * kDegree)), 0,
                 static_cast<float>(std::sin(angle * kDegree))};
        ray.o = Point3f(0.37f, 0.15f * kWidth, 0) - ray.d * 3.f;
        CurveHit hit;
        return set.Intersect(ray, nullptr, &hit) ? std::abs(std::abs(static_cast<double>(hit.v) - 0.5) - 0.15)
                                                 : 1.;
    };
    map.panels = {{"published: pbrt-v3's recursion",
                   FillMap(map.x, map.y,
                           [&](double angle, double uneven) {
                               return error(BinaryCurveBvh({Straight(uneven)}, {CurveType::Flat}), angle);
                           })},
                  {"ours", FillMap(map.x, map.y, [&](double angle, double uneven) {
                       return error(CurveSet({Straight(uneven)}, {CurveType::Flat}), angle);
                   })}};
    map.findings = {{18, "largest error of v", WorstOf(map.panels[0].values), WorstOf(map.panels[1].values)}};
    return map;
}

AtlasMap NeighbourMap(const AtlasOptions &o) {
    AtlasMap map;
    map.name = "curve-neighbour", map.title = "Rays that leave a hair toward a parallel neighbour";
    map.quantity = "1: neighbour missed";
    map.x = {"distance of the hairs' axes (widths)", "distance_widths", 0.1, 4.1,
             o.quick ? size_t(10) : size_t(40)};
    map.y = {"ray to hairs (degrees)", "angle_deg", 0, 90, o.quick ? size_t(9) : size_t(36)};
    map.log = false, map.min = 0, map.max = 1;
    const auto missed = [](const auto &set, double angle) {
        Ray ray;
        ray.o = {0.1f, 0, 0};
        ray.d = {static_cast<float>(std::cos(angle * kDegree)), static_cast<float>(std::sin(angle * kDegree)),
                 0};
        const CurveOrigin origin{0, 0.1f};
        CurveHit hit;
        return set.Intersect(ray, &origin, &hit) && hit.segment == 1 ? 0. : 1.;
    };
    const auto hairs = [](double distance) {
        // The neighbour is long enough for every angle of the map.
        CurveSegment neighbour = Straight(0, static_cast<float>(distance) * kWidth);
        for (Point3f &p : neighbour.cp)
            p.x = p.x * 20 - 1;
        return std::vector<CurveSegment>{Straight(0), neighbour};
    };
    map.panels = {{"published: skips two widths",
                   FillMap(map.x, map.y,
                           [&](double distance, double angle) {
                               return missed(BinaryCurveBvh(hairs(distance), {CurveType::Flat}), angle);
                           })},
                  {"ours", FillMap(map.x, map.y, [&](double distance, double angle) {
                       return missed(CurveSet(hairs(distance), {CurveType::Flat}), angle);
                   })}};
    const auto mean = [](const std::vector<double> &values) {
        double sum = 0;
        for (const double v : values)
            sum += v;
        return sum / static_cast<double>(values.size());
    };
    map.findings = {{18, "share of the map where the neighbour is missed", mean(map.panels[0].values),
                     mean(map.panels[1].values)}};
    return map;
}

} // namespace

std::vector<AtlasMap> SamplingMaps(const AtlasOptions &options) {
    return {DemuxMap(), CornersMap(options), RoundTripMap(options), AcrossMap(options),
            NeighbourMap(options)};
}

} // namespace cuticle
