// The papers' diagrams in space. Directions are those of the fiber: x along it toward the tip. The rays are
// traced with vectors, and a law checks the papers' formulas against them.
#include "fibers/fiber_angles.h"
#include "fibers/smooth_fiber.h"
#include "figures/papers/paper_figures.h"
#include "figures/papers/sheet.h"

#include <fmt/format.h>

#include <algorithm>

namespace cuticle {

namespace {

using V3 = Vector3<double>;

V3 Direction(double theta, double phi) {
    return {std::sin(theta), std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi)};
}

// Projects space onto the sheet, from above and beside: the fiber runs to the right, or upward.
struct ParallelProjection {
    bool upright = false;
    double turn = Radians(35.), lift = Radians(25.);
    P2 operator()(const V3 &w) const {
        const V3 p = Placed(w);
        return {p.x * std::cos(turn) - p.y * std::sin(turn),
                p.z * std::cos(lift) + (p.x * std::sin(turn) + p.y * std::cos(turn)) * std::sin(lift)};
    }
    // True for a direction that points to the side of the one who looks.
    bool Faces(const V3 &w) const {
        const V3 p = Placed(w);
        return p.z * std::sin(lift) > (p.x * std::sin(turn) + p.y * std::cos(turn)) * std::cos(lift);
    }

  private:
    V3 Placed(const V3 &w) const { return upright ? V3(w.y, w.z, w.x) : w; }
};

// Points of the sphere (or of one of another radius), at one inclination or at one azimuth.
std::vector<V3> Parallel(double theta, double from = 0, double to = 2 * kPi<double>, double radius = 1) {
    std::vector<V3> points;
    for (const double phi : Linspace(from, to, 181))
        points.push_back(Direction(theta, phi) * radius);
    return points;
}
std::vector<V3> Meridian(double phi, double from, double to, double radius = 1) {
    std::vector<V3> points;
    for (const double theta : Linspace(from, to, 91))
        points.push_back(Direction(theta, phi) * radius);
    return points;
}

void Draw(Sheet *sheet, const ParallelProjection &view, const std::vector<V3> &points, int color = kInk,
          PlotDash dash = PlotDash::Solid, double width = 1.5) {
    std::vector<P2> line(points.size());
    std::transform(points.begin(), points.end(), line.begin(), view);
    sheet->Line(line, color, dash, width);
}
// A line on a sphere or a tube: dotted where its normals point away from the one who looks.
void DrawOnSurface(Sheet *sheet, const ParallelProjection &view, const std::vector<V3> &points,
                   const std::vector<V3> &normals, int color, double width = 1.5) {
    for (size_t from = 0, to = 1; to <= points.size(); ++to)
        if (to == points.size() || view.Faces(normals[to]) != view.Faces(normals[from])) {
            const auto begin = points.begin() + static_cast<std::ptrdiff_t>(from);
            Draw(sheet, view,
                 {begin, points.begin() + static_cast<std::ptrdiff_t>(std::min(to + 1, points.size()))},
                 color, view.Faces(normals[from]) ? PlotDash::Solid : PlotDash::Dotted, width);
            from = to;
        }
}
void DrawOnSphere(Sheet *sheet, const ParallelProjection &view, const std::vector<V3> &points, int color,
                  double width = 1.5) {
    DrawOnSurface(sheet, view, points, points, color, width);
}

// Traces the ray from omegaI that meets a smooth cylinder of radius 1 at the offset h; returns the directions
// in which its light leaves after 0, 1, ... segments inside.
std::vector<V3> TraceInSpace(const V3 &omegaI, double h, size_t segments) {
    const auto across = [](const V3 &v) { return V3(0, v.y, v.z); };
    const V3 toward = Normalize(across(omegaI)), beside = Cross(V3(1, 0, 0), toward);
    V3 p = toward * std::sqrt(1 - h * h) + beside * h, inside;
    std::vector<V3> leaves = {ReflectAt(p, -omegaI)};
    RefractAt(p, -omegaI, kEta, &inside);
    while (leaves.size() <= segments) {
        const V3 way = across(inside);
        p = p - way * (2 * Dot(p, way) / Dot(way, way));
        V3 out;
        RefractAt(-p, inside, 1 / kEta, &out);
        leaves.push_back(out);
        inside = ReflectAt(-p, inside);
    }
    return leaves;
}

double LengthOf(const std::vector<V3> &points) {
    double length = 0;
    for (size_t k = 1; k < points.size(); ++k)
        length += std::sqrt(Dot(points[k] - points[k - 1], points[k] - points[k - 1]));
    return length;
}

} // namespace

FigureData Pharr1_3(const FigureOptions &) {
    // A tube about a bent curve in the x-z plane. Its normals are found as the cross product of its two
    // slopes.
    const double radius = 0.42, at = 0.15, step = 1e-5;
    const auto tangent = [](double s) { return Normalize(V3(1, 0, -0.5 * s)); };
    const auto surface = [&](double s, double angle) {
        const V3 across(0, 1, 0), up = Cross(tangent(s), across);
        return V3(s, 0, -0.25 * s * s) + (across * std::cos(angle) + up * std::sin(angle)) * radius;
    };
    const auto normal = [&](double s, double angle) {
        return Normalize(Cross(surface(s, angle + step) - surface(s, angle - step),
                               surface(s + step, angle) - surface(s - step, angle)));
    };
    const ParallelProjection view;
    Sheet sheet({-1.75, -1.55}, {1.75, 1.6});
    const std::vector<double> angles = Linspace(0, 2 * kPi<double>, 181);
    for (const double s : {-1.5, -0.9, at, 0.9, 1.5}) {
        std::vector<V3> ring, normals;
        for (const double angle : angles)
            ring.push_back(surface(s, angle)), normals.push_back(normal(s, angle));
        DrawOnSurface(&sheet, view, ring, normals, s == at ? kBlue : kInk, s == at ? 2.5 : 1);
    }
    for (const bool first : {true, false}) { // the outline, where the surface turns away
        std::vector<V3> outline;
        for (const double s : Linspace(-1.5, 1.5, 61))
            for (size_t k = 1; k < angles.size(); ++k)
                if (view.Faces(normal(s, angles[k])) != view.Faces(normal(s, angles[k - 1])) &&
                    view.Faces(normal(s, angles[k])) == first)
                    outline.push_back(surface(s, angles[k]));
        Draw(&sheet, view, outline);
    }
    const V3 middle = V3(at, 0, -0.25 * at * at), across(0, 1, 0), up = Cross(tangent(at), across);
    std::vector<V3> plane;
    for (const auto &[a, b] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}, {1, 1}})
        plane.push_back(middle + across * (1.05 * a) + up * (1.05 * b));
    Draw(&sheet, view, plane, kInk, PlotDash::Dashed);
    FigureData data{Table({"angle_deg", "x", "y", "z", "n_x", "n_y", "n_z"})};
    double along = 0;
    for (const double angle : Linspace(0, 2 * kPi<double>, 17)) {
        const V3 p = surface(at, angle), n = normal(at, angle);
        sheet.Arrow(view(p), view(p + n * 0.45), kOrange);
        data.table.Add({Degrees(angle), p.x, p.y, p.z, n.x, n.y, n.z});
        along = Worst(along, std::abs(Dot(n, tangent(at))));
    }
    sheet.Arrow(view(middle), view(middle + tangent(at) * 1.1), kGreen);
    sheet.Letters(view(middle + tangent(at) * 1.1), "x", kGreen);
    sheet.Letters(view(plane[0]) + P2{-0.2, 0.06}, "normal plane");
    data.plot.panels = {sheet.panel};
    data.plot.width = 600, data.plot.height = 520;
    data.checks = {{"the drawn normals have along the curve a part of at most", along, 0, 1e-6}};
    return data;
}

FigureData Pharr1_4(const FigureOptions &) {
    const ParallelProjection view;
    const double theta = Radians(40.), phi = Radians(60.);
    Sheet sheet({-1.4, -1.25}, {1.4, 1.25});
    Draw(&sheet, view, Parallel(0), kInk, PlotDash::Dashed);
    sheet.Arrow({}, view({1.3, 0, 0}));
    sheet.Arrow({}, view({0, 1.2, 0}));
    sheet.Arrow({}, view({0, 0, 1.2}));
    const V3 w = Direction(theta, phi), foot = Direction(0, phi);
    sheet.Arrow({}, view(w), kBlue);
    sheet.Line({{}, view(foot)}, kInk, PlotDash::Dotted);
    Draw(&sheet, view, Meridian(phi, 0, theta), kOrange, PlotDash::Solid, 2.5);
    Draw(&sheet, view, Parallel(0, 0, phi), kGreen, PlotDash::Solid, 2.5);
    sheet.Letters(view({1.3, 0, 0}), "x, to the tip");
    sheet.Letters(view({0, 1.2, 0}) + P2{0, 0.04}, "y");
    sheet.Letters(view({0, 0, 1.2}), "z");
    sheet.Letters(view(w), "ω", kBlue);
    sheet.Letters(view(Direction(theta / 2, phi)), "θ", kOrange);
    sheet.Letters(view(Direction(0, phi / 2)), "φ", kGreen);
    FigureData data =
        Finish(Table({"theta_deg", "phi_deg", "omega_x", "omega_y", "omega_z"}), sheet, 520, 470);
    data.table.Add({Degrees(theta), Degrees(phi), w.x, w.y, w.z});
    // The fiber models' own angles, which know nothing of how the arrow was drawn.
    const FiberAngles<double> angles = AnglesOf(w.x, w.y, w.z);
    data.checks = {
        {"the models find θ in the drawn direction, off by (rad)",
         std::abs(std::atan2(angles.sinTheta, angles.cosTheta) - theta), 0, 1e-12},
        {"and φ, from y toward z, off by (rad)", std::abs(std::atan2(angles.z, angles.y) - phi), 0, 1e-12},
        {"the arc of θ ends in the normal plane below ω: the plane of ω, its foot and the axis, off by",
         std::abs(w.y * foot.z - w.z * foot.y), 0, 1e-12}};
    return data;
}

FigureData Marschner03(const FigureOptions &) {
    const double thetaI = Radians(-35.), phiI = Radians(55.), thetaR = Radians(30.), phiR = Radians(120.),
                 a = 0.75;
    const V3 i = Direction(thetaI, phiI), r = Direction(thetaR, phiR);
    const ParallelProjection view;
    Sheet sheet({-1.45, -1.1}, {1.75, 1.4});
    Draw(&sheet, view, Parallel(0), kInk, PlotDash::Dashed);
    std::vector<V3> section;
    for (const double angle : Linspace(0, 2 * kPi<double>, 181))
        section.push_back(V3(0, std::cos(angle), a * std::sin(angle)) * 0.22);
    Draw(&sheet, view, section, kPink, PlotDash::Solid, 2.5);
    const std::array<V3, 3> axes = {V3(1.4, 0, 0), V3(0, 1.3, 0), V3(0, 0, 1.3)};
    const std::array<const char *, 3> names = {"u, to the tip", "v", "w"};
    for (size_t k = 0; k < 3; ++k)
        sheet.Arrow({}, view(axes[k])), sheet.Letters(view(axes[k]) + P2{k == 0 ? -0.1 : 0, 0.05}, names[k]);
    struct Drawn {
        double theta, phi, radius;
        const char *omega, *inclination, *azimuth;
        int color;
    };
    for (const Drawn &d : {Drawn{thetaI, phiI, 0.75, "ω_i", "θ_i", "φ_i", kBlue},
                           Drawn{thetaR, phiR, 0.5, "ω_r", "θ_r", "φ_r", kOrange}}) {
        const V3 w = Direction(d.theta, d.phi);
        sheet.Arrow({}, view(w * 1.1), d.color);
        sheet.Letters(view(w * 1.1) + P2{0.02, 0.04}, d.omega, d.color);
        Draw(&sheet, view, {{}, Direction(0, d.phi)}, d.color, PlotDash::Dotted);
        Draw(&sheet, view, Meridian(d.phi, 0, d.theta), d.color, PlotDash::Solid, 2.5);
        sheet.Letters(view(Direction(d.theta / 2, d.phi)), d.inclination, d.color);
        Draw(&sheet, view, Parallel(0, 0, d.phi, d.radius), d.color, PlotDash::Solid, 2.5);
        sheet.Letters(view(Direction(0, d.phi * 0.7) * d.radius) + P2{-0.02, 0.05}, d.azimuth, d.color);
    }
    FigureData data = Finish(Table({"direction", "theta_deg", "phi_deg", "u", "v", "w"}), sheet, 600, 510);
    data.table.Add({"i", Degrees(thetaI), Degrees(phiI), i.x, i.y, i.z});
    data.table.Add({"r", Degrees(thetaR), Degrees(phiR), r.x, r.y, r.z});
    const SinCosine<double> turn = RelativeAzimuth(AnglesOf(i.x, i.y, i.z), AnglesOf(r.x, r.y, r.z));
    data.checks = {
        {"the model's azimuth between the drawn directions is φ_r - φ_i, off by (rad)",
         std::abs(std::atan2(turn.sin, turn.cos) - (phiR - phiI)), 0, 1e-12},
        // Along the fiber the half vector has 2 sin theta_h cos theta_d, whatever the azimuths.
        {"the drawn directions add up to 2 sin θ_h cos θ_d along the fiber, off by",
         std::abs(i.x + r.x - 2 * std::sin((thetaI + thetaR) / 2) * std::cos((thetaR - thetaI) / 2)), 0,
         1e-12},
        {"and the angle between them is that of θ_i, θ_r and φ on the sphere, off by (rad)",
         std::abs(std::acos(i.x * r.x + i.y * r.y + i.z * r.z) -
                  std::acos(std::sin(thetaI) * std::sin(thetaR) +
                            std::cos(thetaI) * std::cos(thetaR) * std::cos(std::atan2(turn.sin, turn.cos)))),
         0, 1e-12}};
    data.note = fmt::format(
        "Here θ_h = (θ_i + θ_r)/2 is {:.1f}°, θ_d = (θ_r - θ_i)/2 is {:.1f}° and φ = φ_r - φ_i is {:.0f}°.",
        Degrees(thetaI + thetaR) / 2, Degrees(thetaR - thetaI) / 2, Degrees(phiR - phiI));
    return data;
}

// Appendix A: reflection (or refraction) over all normals turns one direction into these, on the unit sphere.
Sheet SphereOfNormals(const V3 &omegaI, bool refracted, Table *table, double *off) {
    const ParallelProjection view{.upright = true};
    Sheet sheet({-1.3, -1.4}, {1.3, 1.35});
    sheet.panel.title = refracted ? "b: refracted" : "a: reflected";
    sheet.Arc({}, 1, 0, 2 * kPi<double>);
    sheet.Arrow({}, view({1.25, 0, 0})), sheet.Letters(view({1.25, 0, 0}) + P2{0.04, 0}, "u");
    const double theta = std::asin(omegaI.x), height = omegaI.x / (refracted ? kEta : 1);
    DrawOnSphere(&sheet, view, Parallel(0), kInk);
    DrawOnSphere(&sheet, view, Parallel(theta), kBlue);
    DrawOnSphere(&sheet, view, Parallel(-std::asin(height)), kOrange, 2.5);
    const double azimuth = std::atan2(omegaI.z, omegaI.y);
    for (int k = -3; k <= 3; ++k) {
        const double turn = Radians(25 * static_cast<float>(k));
        const V3 n = Direction(0, azimuth + turn);
        V3 leaves = ReflectAt(n, -omegaI);
        if (refracted)
            RefractAt(n, -omegaI, kEta, &leaves);
        table->Add({refracted ? "refracted" : "reflected", Degrees(turn), leaves.x, leaves.y, leaves.z});
        *off = Worst(*off, std::abs(leaves.x + height));
        const bool one = k == -1;
        sheet.Arrow({}, view(leaves), kOrange, one ? PlotDash::Solid : PlotDash::Dotted);
        if (!one)
            continue;
        sheet.Arrow({}, view(n), kGreen), sheet.Letters(view(n) + P2{0.04, 0.02}, "n", kGreen);
        sheet.Letters(view(leaves) + P2{0.04, -0.06}, refracted ? "v_t" : "v_r", kOrange);
    }
    sheet.Arrow({}, view(omegaI), kBlue), sheet.Letters(view(omegaI) + P2{0.08, 0.06}, "v_i", kBlue);
    return sheet;
}

// Appendix B: one refraction, and its shadow on the plane of the normals.
Sheet BravaisProjection(const V3 &omegaI, double *off) {
    const ParallelProjection view;
    const V3 n(0, 0, 1);
    V3 t;
    RefractAt(n, -omegaI, kEta, &t);
    Sheet sheet({-1.3, -1.4}, {1.3, 1.35});
    sheet.panel.title = "c: projected";
    for (const bool vertical : {false, true}) {
        std::vector<V3> plane;
        for (const auto &[a, b] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}, {1, 1}})
            plane.push_back(vertical ? V3(0, a, b) : V3(0.8 * a, b, 0));
        Draw(&sheet, view, plane, kInk, vertical ? PlotDash::Dashed : PlotDash::Solid, 1);
    }
    sheet.Arrow({}, view({1.1, 0, 0})), sheet.Letters(view({1.1, 0, 0}), "u");
    sheet.Arrow({}, view(n * 1.2), kGreen), sheet.Letters(view(n * 1.2) + P2{0.04, 0}, "n", kGreen);
    const auto shadow = [](const V3 &v) { return V3(0, v.y, v.z); };
    const std::array<V3, 2> directions = {omegaI, t};
    for (size_t k = 0; k < 2; ++k) {
        const V3 &v = directions[k];
        const int color = k == 0 ? kBlue : kOrange;
        const std::string name = k == 0 ? "v_i" : "v_t";
        sheet.Arrow({}, view(v), color), sheet.Letters(view(v) + P2{0.04, 0.03}, name, color);
        sheet.Arrow({}, view(shadow(v)), color, PlotDash::Dashed);
        sheet.Letters(view(shadow(v)) + P2{-0.22, 0.04}, name + "'", color);
        Draw(&sheet, view, {v, shadow(v)}, color, PlotDash::Dotted);
    }
    const auto sine = [&](const V3 &v) { return std::abs(shadow(v).y) / std::hypot(v.y, v.z); };
    const SmoothFiber<double> fiber(std::hypot(omegaI.y, omegaI.z), kEta);
    *off = std::abs(sine(omegaI) - fiber.etaPrime * sine(t));
    return sheet;
}

FigureData Marschner16(const FigureOptions &) {
    FigureData data{Table({"construction", "normal_deg", "u", "v", "w"})};
    double reflected = 0, refracted = 0, projected = 0;
    const V3 omegaI = Direction(Radians(35.), Radians(-60.));
    data.plot.panels = {SphereOfNormals(omegaI, false, &data.table, &reflected).panel,
                        SphereOfNormals(omegaI, true, &data.table, &refracted).panel,
                        BravaisProjection(Direction(Radians(-35.), Radians(50.)), &projected).panel};
    data.plot.columns = 3, data.plot.width = 380, data.plot.height = 380;
    data.checks = {{"all reflected directions are as far below the equator as v_i is above, off by",
                    reflected, 0, 1e-12},
                   {"all refracted ones are η times nearer to it, off by", refracted, 0, 1e-12},
                   {"the projected directions obey Snell's law with η', off by", projected, 0, 1e-12}};
    return data;
}

FigureData Deon02(const FigureOptions &) {
    const double thetaI = Radians(40.), toward = Radians(22.);
    const V3 omegaI = Direction(thetaI, Radians(-110.));
    const ParallelProjection view;
    FigureData data{Table({"h", "p", "x", "y", "z"})};
    const auto sheet = [&](const char *title) {
        Sheet s({-1.5, -1.1}, {1.5, 1.1});
        s.panel.title = title;
        Draw(&s, view, {{-1.4, 0, 0}, {1.4, 0, 0}}, kInk, PlotDash::Solid, 4);
        s.Letters(view({1.4, 0, 0}) + P2{-0.12, 0.12}, "tip");
        s.Arrow(view(omegaI * 1.35), {}, kInk, PlotDash::Solid, 0.5);
        s.Letters(view(omegaI * 1.35) + P2{0.05, 0}, "light");
        return s;
    };
    Sheet smooth = sheet("smooth: the specular cone"), rough = sheet("rough: a wider cone");
    Draw(&smooth, view, Parallel(-thetaI), kInk, PlotDash::Dashed);
    double off = 0;
    for (const double h : Linspace(-0.95, 0.95, 9)) {
        const std::vector<V3> leaves = TraceInSpace(omegaI, h, 2);
        for (size_t p = 0; p < leaves.size(); ++p) {
            data.table.Add({h, static_cast<double>(p), leaves[p].x, leaves[p].y, leaves[p].z});
            off = Worst(off, std::abs(std::acos(-leaves[p].x) - (kPi<double> / 2 - thetaI)));
            smooth.Arrow({}, view(leaves[p]), kPathColors[p]);
        }
    }
    for (size_t p = 0; p < 3; ++p)
        smooth.Letters({-1.4, 0.95 - 0.15 * static_cast<double>(p)}, kPathNames[p], kPathColors[p]);
    const std::vector<V3> specular = Parallel(-thetaI), wider = Parallel(toward - thetaI);
    Draw(&rough, view, specular, kInk, PlotDash::Dashed);
    Draw(&rough, view, wider, kOrange, PlotDash::Solid, 2.5);
    for (const double phi : Linspace(0, 2 * kPi<double>, 17)) {
        Draw(&rough, view, {{}, Direction(-thetaI, phi)}, kInk, PlotDash::Dotted, 1);
        rough.Arrow(view(Direction(-thetaI, phi)), view(Direction(toward - thetaI, phi)), kOrange);
    }
    data.plot.panels = {smooth.panel, rough.panel};
    data.plot.columns = 2, data.plot.width = 460, data.plot.height = 360;
    const double ratio = LengthOf(wider) / LengthOf(specular);
    data.checks = {{"every traced ray leaves at 90° - θ_i from the fiber, off by (rad)", off, 0, 1e-12},
                   {"the drawn cones' circles are as cos θ_r to cos θ_i, off by",
                    std::abs(ratio - std::cos(toward - thetaI) / std::cos(thetaI)), 0, 1e-9}};
    data.note = fmt::format("The circle of the wider cone is {:.2f} times as long, so the same light is "
                            "spread over {:.2f} times the solid angle.",
                            ratio, ratio);
    return data;
}

} // namespace cuticle
