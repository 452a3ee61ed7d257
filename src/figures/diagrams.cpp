// The papers' diagrams, from rays that are traced with vectors: what a formula of the text says is then checked against them.
#include "core/vecmath.h"
#include "fibers/smooth_fiber.h"
#include "figures/paper_figures.h"

#include <cmath>

namespace cuticle {

namespace {

constexpr double kEta = 1.55;
constexpr int kBlue = 0, kOrange = 1, kGreen = 2, kPink = 3, kInk = 7;

double Degrees(double radians) { return radians * 180 / kPi<double>; }

struct P2 {
    double x = 0, y = 0;
    P2 operator+(P2 b) const { return {x + b.x, y + b.y}; }
    P2 operator-(P2 b) const { return {x - b.x, y - b.y}; }
    P2 operator*(double s) const { return {x * s, y * s}; }
};
double Dot2(P2 a, P2 b) { return a.x * b.x + a.y * b.y; }
P2 At(double angle, double radius = 1) { return {radius * std::cos(angle), radius * std::sin(angle)}; }

// Lines, arrows, arcs and letters on one sheet without axes.
class Sheet {
  public:
    Sheet(P2 low, P2 high) {
        panel.kind = PlotKind::Diagram;
        panel.x.min = low.x, panel.x.max = high.x, panel.y.min = low.y, panel.y.max = high.y;
    }
    void Line(const std::vector<P2> &points, int color = kInk, PlotDash dash = PlotDash::Solid,
              double width = 1.5) {
        PlotSeries s;
        for (const P2 &p : points)
            s.x.push_back(p.x), s.y.push_back(p.y);
        s.color = color, s.dash = dash, s.width = width;
        panel.series.push_back(s);
    }
    // With a head at the share `where` of the way from a to b.
    void Arrow(P2 a, P2 b, int color = kInk, PlotDash dash = PlotDash::Solid, double where = 1) {
        Line({a, b}, color, dash, 2);
        const P2 tip = a + (b - a) * where;
        const double back = std::atan2(a.y - b.y, a.x - b.x);
        Line({tip + At(back + 0.4, kHead), tip, tip + At(back - 0.4, kHead)}, color, PlotDash::Solid, 2);
    }
    void Arc(P2 centre, double radius, double from, double to, int color = kInk,
             PlotDash dash = PlotDash::Solid) {
        std::vector<P2> points;
        for (const double angle : Linspace(from, to, 90))
            points.push_back(centre + At(angle, radius));
        Line(points, color, dash);
    }
    void Letters(P2 at, const std::string &text, int color = kInk) {
        Line({at}, color);
        panel.series.back().mark = text;
    }
    PlotPanel panel;

  private:
    static constexpr double kHead = 0.07;
};

// Refracts d (unit length) at a surface with the normal n against it; eta: index behind over index before. False where
// all is reflected.
bool Refract2(P2 d, P2 n, double eta, P2 *t) {
    const double cos = -Dot2(d, n), sinSquared = (1 - cos * cos) / (eta * eta);
    if (sinSquared >= 1)
        return false;
    *t = d * (1 / eta) + n * (cos / eta - std::sqrt(1 - sinSquared));
    return true;
}
P2 Reflect2(P2 d, P2 n) { return d - n * (2 * Dot2(d, n)); }

// A ray from the left at the height h through the unit circle: the points where it meets the circle, the first one
// included, and for each the direction in which light leaves there.
struct SectionPath {
    std::vector<P2> points, leaves;
};
SectionPath TraceSection(double h, int segments) {
    SectionPath path;
    P2 p = {-std::sqrt(1 - h * h), h}, d = {1, 0}, inside;
    path.points.push_back(p), path.leaves.push_back(Reflect2(d, p));
    Refract2(d, p, kEta, &inside);
    for (int k = 0; k < segments; ++k) {
        p = p + inside * (-2 * Dot2(p, inside));
        const P2 n = p * -1;
        P2 out;
        Refract2(inside, n, 1 / kEta, &out);
        path.points.push_back(p), path.leaves.push_back(out);
        inside = Reflect2(inside, n);
    }
    return path;
}

// How far the azimuths at which a path leaves are from Phi(p, h), counted from the side that the ray comes from.
double OffPhi(double h, const SectionPath &path) {
    const SmoothFiber<double> fiber(1, kEta);
    double off = 0;
    for (size_t p = 0; p < path.leaves.size(); ++p) {
        const double phi = std::atan2(path.leaves[p].y, path.leaves[p].x) - kPi<double>;
        const double here =
            std::abs(std::remainder(phi - fiber.Phi(static_cast<int>(p), std::asin(h)), 2 * kPi<double>));
        if (!(here <= off)) // NaN stays
            off = here;
    }
    return off;
}

void AddRows(Table *table, double h, const SectionPath &path) {
    for (size_t p = 0; p < path.points.size(); ++p)
        table->Add({h, static_cast<double>(p), path.points[p].x, path.points[p].y,
                    Degrees(std::atan2(path.leaves[p].y, path.leaves[p].x))});
}

FigureData Finish(Table table, const Sheet &sheet, int width, int height) {
    FigureData data{std::move(table), {}, "", {}};
    data.plot.panels = {sheet.panel};
    data.plot.width = width, data.plot.height = height;
    return data;
}
Table SectionTable() { return Table({"h", "p", "x", "y", "leaves_deg"}); }

void DrawSection(Sheet *sheet) { sheet->Arc({}, 1, 0, 2 * kPi<double>); }

// The side view: a slab whose surfaces lie at y = 1 and -1, the tip at the right; facets lean by alpha, their normals
// toward the root. The points that a ray meets and the inclinations at which it leaves, positive toward the tip.
struct SidePath {
    std::vector<P2> points, leaves;
    double Theta(size_t p) const { return std::atan2(leaves[p].x, std::abs(leaves[p].y)); }
};
SidePath TraceSide(double thetaI, double alpha, int segments = 2) {
    SidePath path;
    P2 p = {0, 1}, d = {-std::sin(thetaI), -std::cos(thetaI)}, inside;
    const auto normal = [alpha](double side) { return P2{-std::sin(alpha), side * std::cos(alpha)}; };
    path.points.push_back(p), path.leaves.push_back(Reflect2(d, normal(1)));
    Refract2(d, normal(1), kEta, &inside);
    for (int k = 0; k < segments; ++k) {
        const double side = k % 2 == 0 ? -1 : 1;
        p = p + inside * (2 / std::abs(inside.y));
        const P2 n = normal(side) * -1;
        P2 out;
        Refract2(inside, n, 1 / kEta, &out);
        path.points.push_back(p), path.leaves.push_back(out);
        inside = Reflect2(inside, n);
    }
    return path;
}

constexpr std::array<const char *, 4> kPathNames = {"R", "TT", "TRT", "TRRT"};
constexpr std::array<int, 4> kPathColors = {kBlue, kOrange, kGreen, kPink};

// A path's way through the fiber after it has met it, and the light that leaves at each point.
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
// Beside the arrows' heads, below those that point down.
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

// The saw of the scales on both surfaces, from x = a to b.
void DrawScales(Sheet *sheet, double a, double b, double alpha) {
    const double length = 0.6;
    for (const double side : {1., -1.}) {
        std::vector<P2> saw;
        for (double x = a; x < b - 1e-9; x += length) {
            const double half = length / 2 * std::tan(alpha);
            saw.push_back({x, side * (1 - half)}), saw.push_back({x + length, side * (1 + half)});
        }
        sheet->Line(saw, kInk, PlotDash::Solid, 2);
    }
}

} // namespace

FigureData Pharr1_4(const FigureOptions &) {
    // Seen from above and beside; x along the fiber.
    const double turn = Radians(35.), lift = Radians(25.);
    const auto project = [&](Vector3<double> w) {
        return P2{w.x * std::cos(turn) - w.y * std::sin(turn),
                  w.z * std::cos(lift) + (w.x * std::sin(turn) + w.y * std::cos(turn)) * std::sin(lift)};
    };
    const double theta = Radians(40.), phi = Radians(60.);
    const auto direction = [](double t, double f) {
        return Vector3<double>{std::sin(t), std::cos(t) * std::cos(f), std::cos(t) * std::sin(f)};
    };
    const auto arc = [&](auto point, double from, double to) {
        std::vector<P2> points;
        for (const double a : Linspace(from, to, 90))
            points.push_back(project(point(a)));
        return points;
    };
    Sheet sheet({-1.4, -1.25}, {1.4, 1.25});
    sheet.Line(arc([&](double a) { return direction(0, a); }, 0, 2 * kPi<double>), kInk, PlotDash::Dashed);
    sheet.Arrow({}, project({1.3, 0, 0}));
    sheet.Arrow({}, project({0, 1.2, 0}));
    sheet.Arrow({}, project({0, 0, 1.2}));
    const Vector3<double> w = direction(theta, phi), foot = direction(0, phi);
    sheet.Arrow({}, project(w), kBlue);
    sheet.Line({{}, project(foot)}, kInk, PlotDash::Dotted);
    sheet.Line(arc([&](double a) { return direction(a, phi); }, 0, theta), kOrange, PlotDash::Solid, 2.5);
    sheet.Line(arc([&](double a) { return direction(0, a); }, 0, phi), kGreen, PlotDash::Solid, 2.5);
    sheet.Letters(project({1.3, 0, 0}), "x, to the tip");
    sheet.Letters(project({0, 1.2, 0}) + P2{0, 0.04}, "y");
    sheet.Letters(project({0, 0, 1.2}), "z");
    sheet.Letters(project(w), "ω", kBlue);
    sheet.Letters(project(direction(theta / 2, phi)), "θ", kOrange);
    sheet.Letters(project(direction(0, phi / 2)), "φ", kGreen);
    FigureData data =
        Finish(Table({"theta_deg", "phi_deg", "omega_x", "omega_y", "omega_z"}), sheet, 520, 470);
    data.table.Add({Degrees(theta), Degrees(phi), w.x, w.y, w.z});
    data.checks = {{"the length of the drawn direction is", std::sqrt(w.x * w.x + w.y * w.y + w.z * w.z),
                    1 - 1e-12, 1 + 1e-12},
                   {"θ is the angle between ω and its foot in the normal plane, off by",
                    std::abs(std::acos(w.y * foot.y + w.z * foot.z) - theta), 0, 1e-7}};
    return data;
}

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
    data.checks = {{"sin γ_o at the drawn point is h, off by",
                    std::abs(std::sin(std::acos(Dot2(p, {-1, 0}))) - h), 0, 1e-12}};
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
        data.checks.push_back({Printed("without tilt the path with %g segments leaves at θ_o = -θ_i, off by",
                                       static_cast<double>(p)),
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
    data.note =
        Printed("Here the chord is %.3f radii long;", chord) +
        Printed(" 2 + 2 cos 2γ_t, as two papers print it, would be %.3f.", 2 + 2 * std::cos(2 * gammaT));
    return data;
}

FigureData Pharr1_13(const FigureOptions &) {
    const double thetaO = Radians(50.), chord = 2;
    P2 inside;
    Refract2({-std::sin(thetaO), -std::cos(thetaO)}, {0, 1}, kEta, &inside);
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
    Sheet sheet({-2.4, -1.5}, {2.6, 1.9});
    DrawSection(&sheet);
    sheet.Arrow({-2.3, h}, path.points[0], kInk, PlotDash::Solid, 0.5);
    for (size_t p = 0; p < 3; ++p) {
        sheet.Line({{}, path.points[p] * 1.25}, kInk, PlotDash::Dotted);
        if (p > 0)
            sheet.Line({path.points[p - 1], path.points[p]}, kInk, PlotDash::Solid, 2);
        const P2 end = path.points[p] + path.leaves[p] * 0.9;
        sheet.Arrow(path.points[p], end, kPathColors[p]);
        sheet.Letters(end + P2{p == 2 ? -0.4 : 0, p == 2 ? -0.12 : 0}, names[p], kPathColors[p]);
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
    DrawScales(&sheet, -2.7, 1.5, alpha);
    DrawSide(&sheet, plain, thetaI, PlotDash::Dotted);
    DrawSide(&sheet, tilted, thetaI, PlotDash::Solid);
    NamePaths(&sheet, tilted.points, tilted.leaves);
    sheet.Letters({-2.85, 0}, "root"), sheet.Letters({1.4, 0}, "tip");
    FigureData data = Finish(SideTable(), sheet, 640, 600);
    AddRows(&data.table, 0, thetaI, plain);
    AddRows(&data.table, alpha, thetaI, tilted);
    for (const size_t p : {0u, 1u, 2u}) {
        // To first order in alpha the sum of the inclinations is 2 alpha (p eta' - 1) in the middle of the fiber.
        const double sum = tilted.Theta(p) + thetaI;
        const double etaPrime = SmoothFiber<double>(std::cos((tilted.Theta(p) - thetaI) / 2), kEta).etaPrime;
        const double first = 2 * alpha * (static_cast<double>(p) * etaPrime - 1);
        data.checks.push_back(
            {std::string("θ_i + θ_o of ") + kPathNames[p] + " agrees with its first order in α to (degrees)",
             std::abs(Degrees(sum - first)), 0, p == 0 ? 1e-9 : 0.6});
        data.note += Printed(p == 0 ? "θ_i + θ_o is %.1f" : ", %.1f", Degrees(sum)) + std::string("° for ") +
                     kPathNames[p];
    }
    data.note += ".";
    return data;
}

FigureData Marschner09(const FigureOptions &) {
    FigureData data{SectionTable(), {}, "", {}};
    double off = 0;
    for (size_t p = 0; p < 3; ++p) {
        Sheet sheet({-2.6, -2.2}, {2.6, 2.2});
        sheet.panel.title = kPathNames[p];
        DrawSection(&sheet);
        for (const double h : Linspace(-0.9, 0.9, 13)) {
            const SectionPath path = TraceSection(h, static_cast<int>(p));
            if (const double here = OffPhi(h, path); !(here <= off)) // NaN stays
                off = here;
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
    FigureData data{SectionTable(), {}, "", {}};
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

} // namespace cuticle
