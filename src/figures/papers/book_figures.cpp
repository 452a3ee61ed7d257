// Pictures that the book draws for itself, beside those of the papers: the recursion along a curve, the
// capsule around a piece, one random number made two, two ways to find a lamp, and the colours of pigments.
#include "core/sampling.h"
#include "fibers/hair.h"
#include "figures/papers/paper_figures.h"
#include "figures/papers/sheet.h"
#include "shapes/curve_capsule.h"

#include <fmt/format.h>

#include <algorithm>

namespace cuticle {

namespace {

// --- the recursion -----------------------------------------------------------------------------------------

// A part of a plane cubic, between its parameters u0 and u1.
struct CurvePart {
    std::array<P2, 4> cp;
    double u0, u1;
    P2 operator()(double t) const { // t from 0 to 1 within the part
        const double q = 1 - t;
        return cp[0] * (q * q * q) + cp[1] * (3 * q * q * t) + cp[2] * (3 * q * t * t) + cp[3] * (t * t * t);
    }
    // The larger of the second differences, along either axis.
    double Bend() const {
        double bend = 0;
        for (size_t i = 0; i < 2; ++i) {
            const P2 d = cp[i] - cp[i + 1] * 2 + cp[i + 2];
            bend = std::max({bend, std::abs(d.x), std::abs(d.y)});
        }
        return bend;
    }
};
std::array<CurvePart, 2> Halves(const CurvePart &part) {
    const auto &p = part.cp;
    const P2 a = (p[0] + p[1]) * 0.5, m = (p[1] + p[2]) * 0.5, d = (p[2] + p[3]) * 0.5, b = (a + m) * 0.5,
             c = (m + d) * 0.5, middle = (b + c) * 0.5;
    const double u = (part.u0 + part.u1) / 2;
    return {CurvePart{{p[0], a, b, middle}, part.u0, u}, CurvePart{{middle, c, d, p[3]}, u, part.u1}};
}
struct SheetBox {
    P2 low, high;
    bool HoldsOrigin() const { return low.x <= 0 && low.y <= 0 && high.x >= 0 && high.y >= 0; }
};
SheetBox SheetBoxOf(const CurvePart &part, double radius) {
    const auto [x0, x1] = std::minmax({part.cp[0].x, part.cp[1].x, part.cp[2].x, part.cp[3].x});
    const auto [y0, y1] = std::minmax({part.cp[0].y, part.cp[1].y, part.cp[2].y, part.cp[3].y});
    return {{x0 - radius, y0 - radius}, {x1 + radius, y1 + radius}};
}
std::vector<P2> Points(const CurvePart &part) {
    std::vector<P2> points;
    for (const double t : Linspace(0, 1, 61))
        points.push_back(part(t));
    return points;
}

// --- two ways to find a lamp -------------------------------------------------------------------------------

// Sums of samples that give their mean and standard deviation.
struct RunningMoments {
    double sum = 0, squares = 0;
    size_t n = 0;
    void Add(double x) { sum += x, squares += x * x, ++n; }
    double Mean() const { return sum / static_cast<double>(n); }
    double Deviation() const {
        return std::sqrt(std::max(0., squares / static_cast<double>(n) - Mean() * Mean()));
    }
};
// A hair, its viewer and a lamp: a cone of even radiance that holds one unit of light.
struct LitHair {
    float beta;
    Vector3f wo;
    Frame lamp; // z: to the middle of the lamp
    Float cosLamp;
    double Radiance() const { return static_cast<double>(UniformConePdf(cosLamp)); }
    bool InLamp(const Vector3f &wi) const { return Dot(wi, lamp.z) >= cosLamp; }
    HairBSDF At(Float h) const { return HairBSDF(h, 1.55f, Spectrum(0.1f), beta, beta, 0); }
};
struct LampEstimates {
    RunningMoments byLamp, byHair, together;
    size_t found = 0; // times that sampling the hair has found the lamp
};
// Takes samples where a ray has met the hair: one by the lamp, one by the hair, and the two together by the
// power heuristic.
void SampleLamp(const LitHair &scene, RNG *rng, LampEstimates *e) {
    const auto u = [rng] { return rng->UniformFloat(); };
    const HairBSDF hair = scene.At(2 * u() - 1);
    const Float lampPdf = UniformConePdf(scene.cosLamp);
    const Vector3f toLamp = scene.lamp.FromLocal(UniformSampleCone({u(), u()}, scene.cosLamp));
    Float hairPdf = 0;
    const Spectrum value = hair.FPdf(scene.wo, toLamp, &hairPdf);
    const double first = static_cast<double>(value[1] * std::abs(toLamp.z) / lampPdf) * scene.Radiance();
    const double firstWeight = static_cast<double>(PowerHeuristic(lampPdf, hairPdf));
    Vector3f wi;
    const Spectrum f = hair.Sample_f(scene.wo, &wi, {u(), u(), u(), u()}, &hairPdf);
    double second = 0, secondWeight = 0;
    if (hairPdf > 0 && scene.InLamp(wi)) {
        second = static_cast<double>(f[1] * std::abs(wi.z) / hairPdf) * scene.Radiance();
        secondWeight = static_cast<double>(PowerHeuristic(hairPdf, lampPdf));
        ++e->found;
    }
    e->byLamp.Add(first), e->byHair.Add(second);
    e->together.Add(first * firstWeight + second * secondWeight);
}

} // namespace

FigureData BookCapsule(const FigureOptions &) {
    const CurvePart part = {{P2{-1.6, -0.3}, {-0.6, 0.75}, {0.5, 0.8}, {1.6, -0.1}}, 0, 1};
    const double radius = 0.12;
    CurveSegment segment;
    for (size_t i = 0; i < 4; ++i)
        segment.cp[i] = Point3f(Vector3d(part.cp[i].x, part.cp[i].y, 0));
    segment.width[0] = segment.width[1] = static_cast<float>(2 * radius);
    const CurveCapsule capsule = CapsuleOf(segment, 0, 1);
    const P2 chord = part.cp[3] - part.cp[0], axis = {capsule.p.x, capsule.p.y};
    const double length = std::sqrt(Dot(chord, chord));
    const P2 across = {-chord.y / length, chord.x / length};

    Sheet sheet({-2.75, -1.4}, {2.75, 1});
    FigureData data{Table({"u", "x", "y", "from_chord", "from_axis"})};
    const auto draw = [&](P2 from, double r, int color, PlotDash dash) {
        const double angle = std::atan2(chord.y, chord.x), quarter = kPi<double> / 2;
        sheet.Line({from + across * r, from + chord + across * r}, color, dash, 2);
        sheet.Line({from - across * r, from + chord - across * r}, color, dash, 2);
        sheet.Arc(from, r, angle + quarter, angle + 3 * quarter, color, dash);
        sheet.Arc(from + chord, r, angle - quarter, angle + quarter, color, dash);
    };
    sheet.Line({part.cp.begin(), part.cp.end()}, kGreen, PlotDash::Dashed);
    sheet.Line({part.cp[0], part.cp[3]}, kInk, PlotDash::Dotted);
    std::vector<P2> upper, lower;
    double fromChord = 0, fromAxis = 0;
    for (const double u : Linspace(0, 1, 61)) {
        const P2 p = part(u), d = part(u + 1e-6) - part(u - 1e-6);
        const P2 side = P2{-d.y, d.x} * (radius / std::sqrt(Dot(d, d)));
        upper.push_back(p + side), lower.push_back(p - side);
        // Both distances are to lines: the piece does not overshoot its chord.
        const double c = std::abs(Dot(p - part.cp[0], across)), a = std::abs(Dot(p - axis, across));
        data.table.Add({u, p.x, p.y, c, a});
        fromChord = Worst(fromChord, c), fromAxis = Worst(fromAxis, a);
    }
    sheet.Line(Points(part), kOrange, PlotDash::Solid, 3);
    sheet.Line(upper, kOrange), sheet.Line(lower, kOrange);
    draw(part.cp[0], radius + fromChord, kInk, PlotDash::Dashed);
    draw(axis, capsule.radius, kBlue, PlotDash::Solid);
    sheet.Line({axis, axis + chord}, kBlue, PlotDash::Dotted);
    data.plot.panels.push_back(sheet.panel);
    data.plot.width = 620, data.plot.height = 300;
    data.checks = {
        {"the piece is inside the capsule: its distance from the axis and half its width, of the radius",
         (fromAxis + radius) / capsule.radius, 0.9, 1},
        {"its distance from the axis, of that from the chord", fromAxis / fromChord, 0.45, 0.6},
    };
    return data;
}

FigureData BookRecursion(const FigureOptions &) {
    const CurvePart whole = {{P2{-1.7, -0.45}, {-0.8, 1.05}, {0.1, -1.1}, {1.75, 0.3}}, 0, 1};
    const double radius = 0.1;
    double nearest = 0; // the parameter where the curve comes nearest to the ray
    for (const double u : Linspace(0, 1, 100001))
        if (Dot(whole(u), whole(u)) < Dot(whole(nearest), whole(nearest)))
            nearest = u;
    FigureData data{Table({"depth", "u_0", "u_1", "x_low", "y_low", "x_high", "y_high", "kept"})};
    std::vector<CurvePart> parts = {whole};
    double quarter = 0;
    size_t lost = 0, looked = 0;
    for (int depth = 0; depth < 4; ++depth) {
        Sheet sheet({-2, -1.25}, {2, 1.25});
        sheet.panel.title = fmt::format("depth {}", depth);
        sheet.Line(Points(whole), kInk);
        std::vector<CurvePart> next;
        bool found = false;
        for (const CurvePart &part : parts) {
            const SheetBox box = SheetBoxOf(part, radius);
            const bool kept = box.HoldsOrigin();
            ++looked;
            sheet.Line({box.low, {box.high.x, box.low.y}, box.high, {box.low.x, box.high.y}, box.low},
                       kept ? kOrange : kBlue, kept ? PlotDash::Solid : PlotDash::Dotted, kept ? 2 : 1.5);
            data.table.Add({static_cast<double>(depth), part.u0, part.u1, box.low.x, box.low.y, box.high.x,
                            box.high.y, kept ? 1. : 0.});
            if (!kept)
                continue;
            sheet.Line({part.cp.begin(), part.cp.end()}, kGreen, PlotDash::Dashed);
            sheet.Line(Points(part), kOrange, PlotDash::Solid, 3);
            found = found || (part.u0 <= nearest && nearest <= part.u1);
            for (const CurvePart &half : Halves(part)) {
                quarter = Worst(quarter, half.Bend() / part.Bend());
                next.push_back(half);
            }
        }
        lost += !found;
        for (const double r : {0.015, 0.03, 0.045})
            sheet.Arc({}, r, 0, 2 * kPi<double>, kPink);
        sheet.Letters({0.04, 0.16}, "ray", kPink);
        data.plot.panels.push_back(sheet.panel);
        parts = next;
    }
    data.plot.columns = 2, data.plot.width = 400, data.plot.height = 250;
    data.checks = {
        {"depths at which no part that is kept holds the nearest point", static_cast<double>(lost), 0, 0},
        {"a half's second differences are, of the whole's, at most", quarter, 0, 0.25 + 1e-12}};
    data.note = fmt::format("The boxes of {} parts were looked at, of 15 in the whole tree.", looked);
    return data;
}

FigureData BookDemux(const FigureOptions &) {
    constexpr size_t kCells = 8;
    const std::vector<double> edges = Linspace(0, 1, kCells + 1);
    struct Split {
        const char *name;
        Point2f (*halves)(Float);
    };
    const std::array<Split, 2> splits = {
        Split{"leading digits, then the others",
              [](Float u) {
                  const Float first = std::floor(u * 4096) / 4096;
                  return Point2f(first, (u - first) * 4096);
              }},
        Split{"DemuxFloat: digits dealt out in turn", [](Float u) { return DemuxFloat(u); }}};
    FigureData data{Table({"split", "u", "x", "y"})};
    std::array<size_t, 2> empty = {}, fullest = {};
    for (size_t s = 0; s < splits.size(); ++s) {
        Sheet sheet({-0.05, -0.05}, {1.05, 1.05});
        sheet.panel.title = splits[s].name;
        for (const double edge : edges)
            sheet.Line({{edge, 0}, {edge, 1}}, kInk, PlotDash::Dotted, 1),
                sheet.Line({{0, edge}, {1, edge}}, kInk, PlotDash::Dotted, 1);
        RNG rng(MixBits(1));
        std::array<size_t, kCells *kCells> count = {};
        std::vector<P2> walk;
        for (size_t k = 0; k < count.size(); ++k) { // one in each 64th of the interval
            const float u = (static_cast<float>(k) + rng.UniformFloat()) / static_cast<float>(count.size());
            const Point2f p = splits[s].halves(u);
            walk.push_back({static_cast<double>(p.x), static_cast<double>(p.y)});
            data.table.Add({splits[s].name, static_cast<double>(u), walk.back().x, walk.back().y});
            ++count[static_cast<size_t>(p.y * kCells) * kCells + static_cast<size_t>(p.x * kCells)];
        }
        if (s == 1)
            sheet.Line(walk, kBlue, PlotDash::Solid, 0.7);
        for (const P2 &p : walk)
            sheet.Arc(p, 0.008, 0, 2 * kPi<double>, kOrange);
        empty[s] = static_cast<size_t>(std::count(count.begin(), count.end(), size_t(0)));
        fullest[s] = *std::max_element(count.begin(), count.end());
        data.plot.panels.push_back(sheet.panel);
    }
    data.plot.columns = 2, data.plot.width = 440, data.plot.height = 440;
    data.checks = {{"of 64 cells DemuxFloat leaves empty", static_cast<double>(empty[1]), 0, 0},
                   {"and the fullest has, of 64 points,", static_cast<double>(fullest[1]), 1, 1},
                   {"the leading digits leave empty", static_cast<double>(empty[0]), 8, 56}};
    data.note = fmt::format("On the left {} of the 64 cells are empty, on the right none.", empty[0]);
    return data;
}

// The empty panel of one roughness: noise over the lamp's size, by what is sampled.
static PlotPanel LampPanel(float beta, const std::vector<double> &angles) {
    PlotPanel panel;
    panel.title = fmt::format("β_m = β_n = {:g}", static_cast<double>(beta));
    panel.legend = "bottom right";
    panel.x = {.label = "half-angle of the lamp (degrees)",
               .log = true,
               .min = angles.front(),
               .max = angles.back()};
    panel.y = {.label = "deviation over mean", .log = true, .min = 0.5, .max = 100};
    panel.series.resize(3);
    const std::array<const char *, 3> names = {"lamp sampled", "hair sampled", "both, power heuristic"};
    for (size_t k = 0; k < 3; ++k) {
        PlotSeries &s = panel.series[k];
        s.label = names[k], s.color = k == 0 ? kBlue : k == 1 ? kOrange : kInk;
        s.dash = k == 2 ? PlotDash::Solid : PlotDash::Dashed, s.width = k == 2 ? 3 : 2;
    }
    return panel;
}

FigureData BookMis(const FigureOptions &options) {
    const size_t samples = options.quick ? 20000 : 200000;
    const std::vector<double> angles = Logspace(0.5, 90, 13);
    FigureData data{Table({"beta", "lamp_deg", "by_lamp", "by_hair", "together"})};
    const Vector3f wo = Normalize(Vector3f(0.3f, 0.2f, 1));
    const Vector3f toLamp = Normalize(Vector3f(-0.3f, -0.9f, 0.5f)); // on the specular cone, nearly
    double disagree = 0, excess = -INFINITY, ratio = 0, smallest = INFINITY, largest = INFINITY;
    for (const float beta : {0.1f, 0.5f}) {
        PlotPanel panel = LampPanel(beta, angles);
        for (const double degrees : angles) {
            const LitHair scene{beta, wo, Frame::FromZ(toLamp),
                                static_cast<Float>(std::cos(degrees * kDegree))};
            RNG rng(MixBits(static_cast<uint64_t>(degrees * 100)));
            LampEstimates e;
            for (size_t k = 0; k < samples; ++k)
                SampleLamp(scene, &rng, &e);
            // Equal effort: two samples of one kind against one of each.
            const double mean = e.together.Mean(), lamp = e.byLamp.Deviation() / std::sqrt(2.) / mean,
                         hair = e.byHair.Deviation() / std::sqrt(2.) / mean,
                         both = e.together.Deviation() / mean;
            // Found a few times only, the lamp says nothing of the deviation.
            const bool known = e.found >= 100;
            for (const auto &[k, value] :
                 {std::pair<size_t, double>{0, lamp}, {1, known ? hair : NAN}, {2, both}})
                panel.series[k].x.push_back(degrees), panel.series[k].y.push_back(value);
            data.table.Add({static_cast<double>(beta), degrees, lamp, known ? hair : NAN, both});
            const double better = known ? std::min(lamp, hair) : lamp;
            excess = Worst(excess, both * both - 2 * better * better), ratio = Worst(ratio, both / better);
            if (!known)
                continue;
            disagree =
                Worst(disagree, std::abs(e.byHair.Mean() - e.byLamp.Mean()) / mean / std::hypot(lamp, hair) *
                                    std::sqrt(static_cast<double>(samples) / 2));
            if (smallest == INFINITY)
                smallest = hair / lamp;
            if (beta < 0.2f)
                largest = lamp / hair;
        }
        data.plot.panels.push_back(panel);
    }
    data.plot.columns = 2, data.plot.width = 480, data.plot.height = 380;
    data.checks = {
        {"the two ways estimate the same light, apart by at most (standard errors)", disagree, 0, 4.5},
        {"both together have a variance, over one sample of the better, in squared means, of at most", excess,
         -INFINITY, 0.5}, // Veach's bound
        {"both together deviate, of two samples of the better, at most", ratio, 0, std::sqrt(2.) + 0.1},
        {"of a narrow lobe and a small lamp, sampling the lamp is better by a factor of", smallest, 1, 1e6},
        {"of a narrow lobe and the largest lamp, sampling the hair by a factor of", largest, 1, 1e6}};
    data.note = fmt::format(
        "Both together deviate at most {:.2f} times as much as two samples of the better.", ratio);
    return data;
}

FigureData BookPigments(const FigureOptions &) {
    const float betaN = 0.3f;
    // sigma_a = (ln c / s)^2: the s of this roughness is what makes c = 1/e.
    const double s =
        1 /
        std::sqrt(static_cast<double>(HairBSDF::SigmaAFromReflectance(Spectrum(std::exp(-1.f)), betaN)[0]));
    FigureData data{Table({"eumelanin", "pheomelanin", "red", "green", "blue"})};
    PlotHeatMap map;
    map.columns = 70, map.rows = 70;
    map.xMin = map.yMin = -2.5, map.xMax = map.yMax = 1;
    double off = 0, brighter = 0;
    std::vector<double> below(map.columns, INFINITY);
    for (size_t j = 0; j < map.rows; ++j)
        for (size_t i = 0; i < map.columns; ++i) {
            const auto share = [](size_t k) {
                return static_cast<float>(std::pow(10, -2.5 + (static_cast<double>(k) + 0.5) / 20));
            };
            const float e = share(i), p = share(j);
            const Spectrum sigma = HairBSDF::SigmaAFromConcentration(e, p);
            Spectrum c;
            for (int k = 0; k < 3; ++k)
                c[k] = static_cast<float>(std::exp(-std::sqrt(static_cast<double>(sigma[k])) * s));
            const Spectrum back = HairBSDF::SigmaAFromReflectance(c, betaN);
            for (int k = 0; k < 3; ++k)
                if (c[k] > 1.01e-4f)
                    off = Worst(off, static_cast<double>(std::abs(back[k] / sigma[k] - 1)));
            brighter = Worst(brighter, static_cast<double>(c[1]) - below[i]);
            below[i] = static_cast<double>(c[1]);
            map.colors.push_back(c);
            data.table.Add({static_cast<double>(e), static_cast<double>(p), static_cast<double>(c[0]),
                            static_cast<double>(c[1]), static_cast<double>(c[2])});
        }
    PlotPanel panel;
    panel.kind = PlotKind::HeatMap;
    panel.x = {.label = "eumelanin", .min = -2.5, .max = 1, .step = 1, .exponents = true};
    panel.y = {.label = "pheomelanin", .min = -2.5, .max = 1, .step = 1, .exponents = true};
    panel.heatMap = map;
    data.plot.panels = {panel};
    data.plot.width = 520, data.plot.height = 500;
    data.checks = {
        {"the colour inverts to the pigments' absorption, off by (relative)", off, 0, 1e-4},
        {"more pheomelanin makes no colour brighter; green grows by at most", brighter, -INFINITY, 0}};
    return data;
}

} // namespace cuticle
