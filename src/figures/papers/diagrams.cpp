// The papers' diagrams in the section and from the side. The rays are traced with vectors, and a law checks
// the papers' formulas against them.
#include "fibers/ap.h"
#include "fibers/gaussian.h"
#include "fibers/smooth_fiber.h"
#include "figures/papers/paper_figures.h"
#include "figures/papers/sheet.h"

#include <fmt/format.h>

#include <cmath>

namespace cuticle {

namespace {

// The path of a ray from the left through the unit circle: the points where it meets the circle, the first
// one included, and for each the direction in which light leaves there.
struct SectionPath {
    std::vector<P2> points, leaves;
};
SectionPath TraceSection(double h, int segments) {
    SectionPath path;
    P2 p = {-std::sqrt(1 - h * h), h}, d = {1, 0}, inside;
    path.points.push_back(p), path.leaves.push_back(ReflectAt(p, d));
    RefractAt(p, d, kEta, &inside);
    for (int k = 0; k < segments; ++k) {
        p = p + inside * (-2 * Dot(p, inside));
        const P2 n = p * -1;
        P2 out;
        RefractAt(n, inside, 1 / kEta, &out);
        path.points.push_back(p), path.leaves.push_back(out);
        inside = ReflectAt(n, inside);
    }
    return path;
}

// The largest distance of the azimuths at which a path leaves from Phi(p, h), counted from the side that the
// ray comes from.
double OffPhi(double h, const SectionPath &path) {
    const SmoothFiber<double> fiber(1, kEta);
    double off = 0;
    for (size_t p = 0; p < path.leaves.size(); ++p) {
        const double phi = std::atan2(path.leaves[p].y, path.leaves[p].x) - kPi<double>;
        const double here =
            std::abs(std::remainder(phi - fiber.Phi(static_cast<int>(p), std::asin(h)), 2 * kPi<double>));
        off = Worst(off, here);
    }
    return off;
}

void AddRows(Table *table, double h, const SectionPath &path) {
    for (size_t p = 0; p < path.points.size(); ++p)
        table->Add({h, static_cast<double>(p), path.points[p].x, path.points[p].y,
                    Degrees(std::atan2(path.leaves[p].y, path.leaves[p].x))});
}

Table SectionTable() { return Table({"h", "p", "x", "y", "leaves_deg"}); }

void DrawSection(Sheet *sheet) { sheet->Arc({}, 1, 0, 2 * kPi<double>); }

// The path of a ray in the side view: a slab whose surfaces lie at y = 1 and -1, the tip at the right; facets
// lean by alpha, their normals toward the root. Inclinations are positive toward the tip.
struct SidePath {
    std::vector<P2> points, leaves;
    double Theta(size_t p) const { return std::atan2(leaves[p].x, std::abs(leaves[p].y)); }
};
SidePath TraceSide(double thetaI, double alpha, int segments = 2) {
    SidePath path;
    P2 p = {0, 1}, d = {-std::sin(thetaI), -std::cos(thetaI)}, inside;
    const auto normal = [alpha](double side) { return P2{-std::sin(alpha), side * std::cos(alpha)}; };
    path.points.push_back(p), path.leaves.push_back(ReflectAt(normal(1), d));
    RefractAt(normal(1), d, kEta, &inside);
    for (int k = 0; k < segments; ++k) {
        const double side = k % 2 == 0 ? -1 : 1;
        p = p + inside * (2 / std::abs(inside.y));
        const P2 n = normal(side) * -1;
        P2 out;
        RefractAt(n, inside, 1 / kEta, &out);
        path.points.push_back(p), path.leaves.push_back(out);
        inside = ReflectAt(n, inside);
    }
    return path;
}

// Draws a path through the fiber, and the light that leaves at each of its points.
void DrawPath(Sheet *sheet, const std::vector<P2> &points, const std::vector<P2> &leaves, PlotDash dash) {
    for (size_t p = 0; p < points.size(); ++p) {
        if (p > 0)
            sheet->Line({points[p - 1], points[p]}, kInk, dash, 2);
        sheet->Arrow(points[p], points[p] + leaves[p] * 1.2, kPathColors[p], dash);
    }
}
void DrawSide(Sheet *sheet, const SidePath &path, double thetaI, PlotDash dash) {
    const P2 from = path.points[0] + P2{std::sin(thetaI), std::cos(thetaI)} * 1.3;
    sheet->Arrow(from, path.points[0], kInk, dash, 0.6);
    DrawPath(sheet, path.points, path.leaves, dash);
}
// Writes names beside the arrows' heads, below those that point down.
void NamePaths(Sheet *sheet, const std::vector<P2> &points, const std::vector<P2> &leaves) {
    for (size_t p = 0; p < points.size(); ++p)
        sheet->Letters(points[p] + leaves[p] * 1.22 + (leaves[p].y < 0 ? P2{-0.1, -0.25} : P2{}),
                       kPathNames[p], kPathColors[p]);
}
Table SideTable() { return Table({"alpha_deg", "p", "theta_i_deg", "theta_o_deg"}); }
void AddRows(Table *table, double alpha, double thetaI, const SidePath &path) {
    for (size_t p = 0; p < path.points.size(); ++p)
        table->Add({Degrees(alpha), static_cast<double>(p), Degrees(thetaI), Degrees(path.Theta(p))});
}

// The outline of the scales above or below (side 1 or -1) from x = a to b: facets that rise toward the tip,
// and risers.
std::vector<P2> Saw(double a, double b, double length, double alpha, double side) {
    std::vector<P2> saw;
    const double half = length / 2 * std::tan(alpha);
    const auto scales = static_cast<int>(std::ceil((b - a) / length - 1e-9));
    for (int i = 0; i < scales; ++i) {
        const double x = a + i * length;
        saw.push_back({x, side * (1 - half)}), saw.push_back({x + length, side * (1 + half)});
    }
    return saw;
}

} // namespace

FigureData Pharr1_5(const FigureOptions &) {
    const double h = 0.6, gamma = std::asin(h);
    const SectionPath path = TraceSection(h, 1);
    const P2 p = path.points[0];
    Sheet sheet({-2.1, -1.2}, {1.3, 1.45});
    DrawSection(&sheet);
    sheet.Line({{-2, 0}, {1, 0}}, kInk, PlotDash::Dashed);
    sheet.Arrow({-2, h}, p, kBlue, PlotDash::Solid, 0.6);
    sheet.Line({p, {0, h}}, kBlue, PlotDash::Dotted);
    sheet.Line({{}, p * 1.6}, kInk);
    sheet.Arrow({0, 0}, {0, h}, kOrange);
    sheet.Letters({0.02, h / 2}, "h", kOrange);
    sheet.Arc(p, 0.45, kPi<double> - gamma, kPi<double>, kGreen);
    sheet.Letters(p + At(kPi<double> - gamma / 2, 0.62) + P2{-0.06, -0.06}, "γ_o", kGreen);
    sheet.Arc({}, 0.35, kPi<double> - gamma, kPi<double>, kGreen);
    sheet.Letters(At(kPi<double> - gamma / 2, 0.5) + P2{-0.08, -0.06}, "γ_o", kGreen);
    sheet.Letters(p * 1.6, "n");
    sheet.Letters({-2, h + 0.03}, "from the viewer", kBlue);
    FigureData data = Finish(SectionTable(), sheet, 560, 440);
    AddRows(&data.table, h, path);
    // A mirror turns the ray by pi - 2 gamma_o: traced, not taken from h.
    const double turn = std::acos(Dot(path.leaves[0], {1, 0}));
    data.checks = {
        {"a mirror there turns the traced ray by π − 2 γ_o, off by (rad)",
         std::abs(turn - (kPi<double> - 2 * gamma)), 0, 1e-12},
        {"the fiber's own angle between ray and normal is γ_o, off by (rad)",
         std::abs(Refract(1., h, std::sqrt(1 - h * h), kEta, Sqr(kEta) - 1).cosIncident - std::cos(gamma)), 0,
         1e-12}};
    return data;
}

FigureData Pharr1_6(const FigureOptions &) {
    const double alpha = Radians(15.), length = 0.9;
    const std::vector<P2> above = Saw(-2.7, 1.8, length, alpha, 1), below = Saw(-2.7, 1.8, length, alpha, -1);
    Sheet sheet({-3.2, -1.3}, {2.3, 2.4});
    for (const double side : {1., -1.})
        sheet.Line({{-2.7, side}, {1.8, side}}, kInk, PlotDash::Dashed);
    sheet.Line(above, kBlue, PlotDash::Solid, 2.5), sheet.Line(below, kBlue, PlotDash::Solid, 2.5);
    // The third scale, and the normals above its middle.
    const P2 from = above[4], to = above[5], middle = (from + to) * 0.5;
    const double facet = std::atan2(to.y - from.y, to.x - from.x), normal = facet + kPi<double> / 2;
    sheet.Arrow(middle, middle + P2{0, 1.2}, kInk, PlotDash::Dashed);
    sheet.Arrow(middle, middle + At(normal, 1.2), kOrange);
    sheet.Arc(middle, 0.75, kPi<double> / 2, normal, kGreen);
    sheet.Letters(middle + At((normal + kPi<double> / 2) / 2, 0.88) + P2{-0.06, 0}, "α", kGreen);
    sheet.Letters(middle + P2{0.06, 1.1}, "normal of the cylinder");
    sheet.Letters(middle + At(normal, 1.1) + P2{-1.5, 0.02}, "normal of the scale", kOrange);
    sheet.Letters({-3.15, 0}, "root"), sheet.Letters({1.95, 0}, "tip");
    FigureData data = Finish(Table({"side", "x", "y"}), sheet, 620, 420);
    double mean = 0;
    for (size_t k = 0; k < above.size(); ++k) {
        data.table.Add({1., above[k].x, above[k].y}), data.table.Add({-1., below[k].x, below[k].y});
        mean += above[k].y / static_cast<double>(above.size());
    }
    data.checks = {
        {"light straight from above is reflected toward the root, by 2 α, off by (rad)",
         std::abs(std::atan2(ReflectAt(At(normal), P2{0, -1}).x, ReflectAt(At(normal), P2{0, -1}).y) +
                  2 * alpha),
         0, 1e-12},
        {"the scales lie about the cylinder, their mean height off by", std::abs(mean - 1), 0, 1e-12}};
    return data;
}

FigureData Pharr1_7(const FigureOptions &) {
    const double thetaI = Radians(35.);
    const SidePath path = TraceSide(thetaI, 0);
    Sheet sheet({-2.9, -2.3}, {1.6, 2.5});
    for (const double y : {1., -1.})
        sheet.Line({{-2.8, y}, {1.4, y}}, kInk, PlotDash::Solid, 2);
    DrawSide(&sheet, path, thetaI, PlotDash::Solid);
    NamePaths(&sheet, path.points, path.leaves);
    sheet.Letters({-2.85, 0}, "root"), sheet.Letters({1.1, 0}, "tip");
    FigureData data = Finish(SideTable(), sheet, 620, 560);
    AddRows(&data.table, 0, thetaI, path);
    for (const size_t p : {0u, 1u, 2u})
        data.checks.push_back(
            {fmt::format("without tilt the path with {} segments leaves at θ_o = -θ_i, off by", p),
             std::abs(path.Theta(p) + thetaI), 0, 1e-12});
    return data;
}

FigureData Pharr1_11(const FigureOptions &) {
    const double h = 0.75;
    const SectionPath path = TraceSection(h, 1);
    const P2 p = path.points[0], inside = path.points[1] - p;
    const double normal = std::atan2(p.y, p.x), along = std::atan2(inside.y, inside.x),
                 inward = normal - kPi<double>;
    Sheet sheet({-1.9, -1.1}, {1.2, 1.4});
    DrawSection(&sheet);
    sheet.Arrow({-1.8, h}, p, kBlue, PlotDash::Solid, 0.6);
    sheet.Arrow(p, p + inside * 0.7, kBlue);
    sheet.Line({{}, p * 1.6}, kInk, PlotDash::Dashed);
    sheet.Arc(p, 0.4, normal, kPi<double>, kOrange);
    sheet.Letters(p + At((normal + kPi<double>) / 2, 0.42) + P2{-0.16, 0}, "γ_o", kOrange);
    sheet.Arc(p, 0.5, inward, along, kGreen);
    sheet.Letters(p + At((inward + along) / 2, 0.52), "γ_t", kGreen);
    FigureData data = Finish(SectionTable(), sheet, 560, 420);
    AddRows(&data.table, h, path);
    data.checks = {{"for the traced ray sin γ_o is η sin γ_t, off by",
                    std::abs(std::sin(kPi<double> - normal) - kEta * std::sin(along - inward)), 0, 1e-12}};
    return data;
}

FigureData Pharr1_12(const FigureOptions &) {
    const double h = 0.75;
    const SectionPath path = TraceSection(h, 1);
    const P2 a = path.points[0], b = path.points[1], middle = (a + b) * 0.5;
    const SmoothFiber<double> fiber(1, kEta);
    const double gammaT = fiber.GammaT(h);
    Sheet sheet({-1.9, -1.15}, {1.3, 1.2});
    DrawSection(&sheet);
    sheet.Arrow({-1.8, h}, a, kInk, PlotDash::Solid, 0.6);
    sheet.Line({a, b}, kBlue, PlotDash::Solid, 2.5);
    sheet.Line({a, {}, b}, kInk, PlotDash::Dashed);
    sheet.Line({{}, middle}, kInk, PlotDash::Dotted);
    const double inward = std::atan2(-a.y, -a.x), along = std::atan2(b.y - a.y, b.x - a.x);
    sheet.Arc(a, 0.4, inward, along, kGreen);
    sheet.Letters(a + At((inward + along) / 2, 0.42) + P2{-0.02, -0.04}, "γ_t", kGreen);
    sheet.Letters(middle + P2{0, 0.06}, "2 cos γ_t", kBlue);
    sheet.Letters(a * 0.5 + P2{-0.16, -0.14}, "1"), sheet.Letters(b * 0.5 + P2{0, -0.16}, "1");
    FigureData data = Finish(SectionTable(), sheet, 560, 420);
    AddRows(&data.table, h, path);
    const double chord = std::hypot(b.x - a.x, b.y - a.y);
    data.checks = {
        {"the traced chord is 2 cos γ_t long, off by", std::abs(chord - 2 * std::cos(gammaT)), 0, 1e-12}};
    data.note = fmt::format(
        "Here the chord is {:.3f} radii long; 2 + 2 cos 2γ_t, as two papers print it, would be {:.3f}.",
        chord, 2 + 2 * std::cos(2 * gammaT));
    return data;
}

FigureData Pharr1_13(const FigureOptions &) {
    const double thetaO = Radians(50.), chord = 2;
    P2 inside;
    RefractAt(P2{0, 1}, {-std::sin(thetaO), -std::cos(thetaO)}, kEta, &inside);
    const double length = chord / std::abs(inside.y);
    const P2 a = {0, 1}, b = a + inside * length;
    Sheet sheet({-2.3, -1.4}, {1.7, 2.1});
    for (const double y : {1., -1.})
        sheet.Line({{-2.2, y}, {1.6, y}}, kInk, PlotDash::Solid, 2);
    sheet.Arrow(a + P2{std::sin(thetaO), std::cos(thetaO)} * 1.4, a, kInk, PlotDash::Solid, 0.6);
    sheet.Line({a, b}, kBlue, PlotDash::Solid, 2.5);
    sheet.Line({{0, 2}, {0, -1}}, kInk, PlotDash::Dashed);
    sheet.Arc(a, 0.6, kPi<double> / 2 - thetaO, kPi<double> / 2, kOrange);
    sheet.Letters(a + At(kPi<double> / 2 - thetaO / 2, 0.62), "θ_o", kOrange);
    const double down = std::atan2(inside.y, inside.x);
    sheet.Arc(a, 0.8, down, -kPi<double> / 2, kGreen);
    sheet.Letters(a + At((down - kPi<double> / 2) / 2, 1.0) + P2{-0.1, -0.02}, "θ_t", kGreen);
    sheet.Letters({0.02, -0.1}, "2 cos γ_t");
    sheet.Letters((a + b) * 0.5 + P2{-1.5, -0.1}, "2 cos γ_t / cos θ_t", kBlue);
    FigureData data = Finish(Table({"theta_o_deg", "theta_t_deg", "length_radii"}), sheet, 560, 490);
    const double thetaT = std::asin(std::sin(thetaO) / kEta);
    data.table.Add({Degrees(thetaO), Degrees(thetaT), length});
    data.checks = {{"the traced segment is 2 cos γ_t / cos θ_t long, off by",
                    std::abs(length - chord / std::cos(thetaT)), 0, 1e-12}};
    return data;
}

FigureData Pharr1_14(const FigureOptions &) {
    const double h = 0.5;
    const SectionPath path = TraceSection(h, 2);
    const std::array<const char *, 3> names = {"R: -2γ_o", "TT: 2γ_t - 2γ_o + π", "TRT: 4γ_t - 2γ_o + 2π"};
    Sheet sheet({-2.4, -1.5}, {3.3, 1.9});
    DrawSection(&sheet);
    sheet.Arrow({-2.3, h}, path.points[0], kInk, PlotDash::Solid, 0.5);
    for (size_t p = 0; p < 3; ++p) {
        sheet.Line({{}, path.points[p] * 1.25}, kInk, PlotDash::Dotted);
        if (p > 0)
            sheet.Line({path.points[p - 1], path.points[p]}, kInk, PlotDash::Solid, 2);
        const P2 end = path.points[p] + path.leaves[p] * 0.9, n = path.points[p];
        sheet.Arrow(path.points[p], end, kPathColors[p]);
        sheet.Letters(end, names[p], kPathColors[p]);
        // Between the normal outside and each ray there gamma_o, between that inside and each ray gamma_t
        const auto angle = [&](P2 from, P2 to, double radius, const char *name, int color) {
            const double a = std::atan2(from.y, from.x),
                         b = a + std::remainder(std::atan2(to.y, to.x) - a, 2 * kPi<double>);
            sheet.Arc(n, radius, a, b, color);
            sheet.Letters(n + At((a + b) / 2, radius * 1.2), name, color);
        };
        angle(n, path.leaves[p], 0.3, "γ_o", kOrange);
        if (p == 0)
            angle(n, {-1, 0}, 0.3, "γ_o", kOrange);
        if (p > 0)
            angle(n * -1, path.points[p - 1] - n, 0.35, "γ_t", kPink);
        if (p < 2)
            angle(n * -1, path.points[p + 1] - n, 0.35, "γ_t", kPink);
    }
    FigureData data = Finish(SectionTable(), sheet, 640, 460);
    AddRows(&data.table, h, path);
    data.checks = {{"the traced rays leave at Φ(p, h), off by (rad)", OffPhi(h, path), 0, 1e-12}};
    return data;
}

FigureData Marschner01(const FigureOptions &) {
    const double thetaI = Radians(25.), alpha = Radians(3.);
    const SidePath tilted = TraceSide(thetaI, alpha), plain = TraceSide(thetaI, 0);
    Sheet sheet({-2.9, -2.4}, {1.9, 2.5});
    for (const double side : {1., -1.})
        sheet.Line(Saw(-2.7, 1.5, 0.6, alpha, side), kInk, PlotDash::Solid, 2);
    DrawSide(&sheet, plain, thetaI, PlotDash::Dotted);
    DrawSide(&sheet, tilted, thetaI, PlotDash::Solid);
    NamePaths(&sheet, tilted.points, tilted.leaves);
    sheet.Letters({-2.85, 0}, "root"), sheet.Letters({1.4, 0}, "tip");
    FigureData data = Finish(SideTable(), sheet, 640, 600);
    AddRows(&data.table, 0, thetaI, plain);
    AddRows(&data.table, alpha, thetaI, tilted);
    for (const size_t p : {0u, 1u, 2u}) {
        // To first order in alpha the sum of the inclinations is 2 alpha (p eta' - 1) in the middle of the
        // fiber.
        const double sum = tilted.Theta(p) + thetaI;
        const double etaPrime = SmoothFiber<double>(std::cos((tilted.Theta(p) - thetaI) / 2), kEta).etaPrime;
        const double first = 2 * alpha * (static_cast<double>(p) * etaPrime - 1);
        data.checks.push_back(
            {std::string("θ_i + θ_o of ") + kPathNames[p] + " agrees with its first order in α to (degrees)",
             std::abs(Degrees(sum - first)), 0, p == 0 ? 1e-9 : 0.6});
        data.note +=
            fmt::format("{}{:.1f}° for {}", p == 0 ? "θ_i + θ_o is " : ", ", Degrees(sum), kPathNames[p]);
    }
    data.note += ".";
    return data;
}

FigureData Marschner09(const FigureOptions &) {
    FigureData data{SectionTable()};
    double off = 0;
    for (size_t p = 0; p < 3; ++p) {
        Sheet sheet({-2.6, -2.2}, {2.6, 2.2});
        sheet.panel.title = kPathNames[p];
        DrawSection(&sheet);
        for (const double h : Linspace(-0.9, 0.9, 13)) {
            const SectionPath path = TraceSection(h, static_cast<int>(p));
            off = Worst(off, OffPhi(h, path));
            AddRows(&data.table, h, path);
            std::vector<P2> line = {{-2.5, h}};
            line.insert(line.end(), path.points.begin(), path.points.end());
            sheet.Line(line, kInk, PlotDash::Solid, 1);
            sheet.Arrow(path.points[p], path.points[p] + path.leaves[p] * 1.1, kPathColors[p]);
        }
        data.plot.panels.push_back(sheet.panel);
    }
    data.plot.columns = 3, data.plot.width = 380, data.plot.height = 350;
    data.checks = {{"the traced rays leave at Φ(p, h), off by (rad)", off, 0, 1e-12}};
    return data;
}

FigureData Deon01(const FigureOptions &) {
    const double thetaI = Radians(35.), h = 0.4;
    const SidePath side = TraceSide(thetaI, 0, 3);
    const SectionPath section = TraceSection(h, 3);
    Sheet left({-3.4, -2.6}, {1.6, 2.6});
    left.panel.title = "from the side";
    for (const double y : {1., -1.})
        left.Line({{-3.3, y}, {1.5, y}}, kInk, PlotDash::Solid, 2);
    DrawSide(&left, side, thetaI, PlotDash::Solid);
    NamePaths(&left, side.points, side.leaves);
    Sheet right({-2.6, -2.6}, {2.6, 2.6});
    right.panel.title = "along the fiber";
    DrawSection(&right);
    right.Arrow({-2.5, h}, section.points[0], kInk, PlotDash::Solid, 0.5);
    DrawPath(&right, section.points, section.leaves, PlotDash::Solid);
    NamePaths(&right, section.points, section.leaves);
    FigureData data{SectionTable()};
    AddRows(&data.table, h, section);
    data.plot.panels = {left.panel, right.panel};
    data.plot.columns = 2, data.plot.width = 440, data.plot.height = 430;
    data.checks = {
        {"in section the traced rays leave at Φ(p, h), off by (rad)", OffPhi(h, section), 0, 1e-12}};
    for (size_t p = 0; p < side.points.size(); ++p)
        data.checks.push_back({std::string(kPathNames[p]) + " leaves at θ_o = -θ_i, off by (rad)",
                               std::abs(side.Theta(p) + thetaI), 0, 1e-12});
    return data;
}

// The Gaussian detector spreads the light of TT at each offset: lobes whose height over the exit point is the
// density.
FigureData Deon07(const FigureOptions &) {
    const double beta = Radians(10.), reach = 0.9;
    const std::vector<double> azimuths = Linspace(-kPi<double>, kPi<double>, 1441);
    const double step = azimuths[1] - azimuths[0];
    Sheet sheet({-2.4, -1.2}, {2.3, 1.3});
    DrawSection(&sheet);
    Table table({"h", "phi_deg", "density"});
    double off = 0, peakOff = 0, massOff = 0;
    const std::array<double, 5> offsets = {-0.9, -0.5, 0, 0.5, 0.9};
    for (size_t k = 0; k < offsets.size(); ++k) {
        const double h = offsets[k];
        const SectionPath path = TraceSection(h, 1);
        const int color = k < kPathColors.size() ? kPathColors[k] : kInk;
        const P2 exit = path.points[1], leaves = path.leaves[1];
        const double Phi = SmoothFiber<double>(1, kEta).Phi(1, std::asin(h)); // from the viewer's side
        std::vector<P2> lobe;
        double mass = 0, peak = 0;
        P2 toward;
        for (const double phi : azimuths) {
            const double density = GaussianDetector(beta, phi - Phi);
            const P2 direction = At(phi + kPi<double>);
            mass += phi < azimuths.back() ? density * step : 0; // -π and π are one
            if (density > peak)
                peak = density, toward = direction;
            if (density > 1e-3)
                lobe.push_back(exit + direction * (density * reach / GaussianDetector(beta, 0.)));
            if (density > 1e-3 && lobe.size() % 8 == 0)
                table.Add({h, Degrees(phi), density});
        }
        sheet.Line({{-2.2, h}, path.points[0], exit}, color, PlotDash::Solid, 1.5);
        sheet.Line({exit, exit + leaves * 1.1}, color, PlotDash::Dashed, 1);
        sheet.Line(lobe, color, PlotDash::Solid, 2.5);
        sheet.Letters({-2.35, h + 0.08}, fmt::format("h = {:g}", h), color);
        off = Worst(off, OffPhi(h, path));
        peakOff = Worst(peakOff, std::acos(std::min(1., Dot(toward, leaves))));
        massOff = Worst(massOff, std::abs(mass - 1));
    }
    FigureData data = Finish(std::move(table), sheet, 640, 360);
    data.checks = {{"the traced rays leave at Φ(p, h), off by (rad)", off, 0, 1e-12},
                   {"each drawn lobe is longest along its ray, off by (rad)", peakOff, 0, step},
                   {"each lobe's density adds up to 1 around the circle, off by", massOff, 0, 1e-6}};
    return data;
}

} // namespace cuticle
