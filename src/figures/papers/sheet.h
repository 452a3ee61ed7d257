// Line art of the diagrams: a sheet to draw on, and a ray's refraction and reflection at a surface.
#pragma once

#include "core/vecmath.h"
#include "figures/figure.h"

#include <array>
#include <cmath>

namespace cuticle {

inline constexpr double kEta = 1.55; // of the fibers in diagrams
// Colours of plot.h's palette.
inline constexpr int kBlue = 0, kOrange = 1, kGreen = 2, kPink = 3, kInk = 7;

// A point or a vector of the sheet.
struct P2 {
    double x = 0, y = 0;
    P2 operator+(P2 b) const { return {x + b.x, y + b.y}; }
    P2 operator-(P2 b) const { return {x - b.x, y - b.y}; }
    P2 operator*(double s) const { return {x * s, y * s}; }
};
inline double Dot(P2 a, P2 b) { return a.x * b.x + a.y * b.y; }
// The point at an angle, radians counter-clockwise from the right.
inline P2 At(double angle, double radius = 1) { return {radius * std::cos(angle), radius * std::sin(angle)}; }

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
    // The arrow from a to b has its head at the share `where` of the way.
    void Arrow(P2 a, P2 b, int color = kInk, PlotDash dash = PlotDash::Solid, double where = 1) {
        Line({a, b}, color, dash, 2);
        const P2 tip = a + (b - a) * where;
        const double back = std::atan2(a.y - b.y, a.x - b.x);
        Line({tip + At(back + 0.4, kHead), tip, tip + At(back - 0.4, kHead)}, color, PlotDash::Solid, 2);
    }
    // Angles in radians, counter-clockwise from the right.
    void Arc(P2 centre, double radius, double from, double to, int color = kInk,
             PlotDash dash = PlotDash::Solid) {
        std::vector<P2> points;
        for (const double angle : Linspace(from, to, 90))
            points.push_back(centre + At(angle, radius));
        Line(points, color, dash);
    }
    // The text begins a little to the right of the point and above it.
    void Letters(P2 at, const std::string &text, int color = kInk) {
        Line({at}, color);
        panel.series.back().mark = text;
    }
    PlotPanel panel;

  private:
    static constexpr double kHead = 0.07;
};

// Refracts d (unit length) at a surface whose normal n points against it, in the plane or in space; eta is
// the index behind over the index before. Returns false where all is reflected.
template <typename V>
bool RefractAt(const V &n, const V &d, double eta, V *t) {
    const double cos = -Dot(d, n), sinSquared = (1 - cos * cos) / (eta * eta);
    if (sinSquared >= 1)
        return false;
    *t = d * (1 / eta) + n * (cos / eta - std::sqrt(1 - sinSquared));
    return true;
}
template <typename V>
V ReflectAt(const V &n, const V &d) {
    return d - n * (2 * Dot(d, n));
}

inline constexpr std::array<const char *, 4> kPathNames = {"R", "TT", "TRT", "TRRT"};
inline constexpr std::array<int, 4> kPathColors = {kBlue, kOrange, kGreen, kPink};

// The figure of one sheet; width and height in pixels.
inline FigureData Finish(Table table, const Sheet &sheet, int width, int height) {
    FigureData data{std::move(table)};
    data.plot.panels = {sheet.panel};
    data.plot.width = width, data.plot.height = height;
    return data;
}

} // namespace cuticle
