#include "figures/plot_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

namespace cuticle {

namespace {

// Labels are set in 12 points: this many pixels for 1 em.
constexpr double kEm = 16;
// The legend's line or marker, and the gaps beside and behind the text.
constexpr double kLegendSample = 72;

// --- letters beside points ---------------------------------------------------------------------------------

struct PixelBox {
    double left, right, bottom, top;
    bool Overlaps(const PixelBox &b) const {
        return left < b.right && b.left < right && bottom < b.top && b.bottom < top;
    }
};

// Data to pixels, about as gnuplot does it: the axes leave room for numbers and labels.
class PixelScale {
  public:
    PixelScale(const PlotPanel &panel, int width, int height)
        : x_(panel.x),
          y_(panel.y), axes_{100, (panel.right > 0 ? panel.right : 0.95) * width, 75, height - 40.} {
        if (panel.kind != PlotKind::Diagram)
            return;
        const double w = *x_.max - *x_.min, h = *y_.max - *y_.min,
                     unit =
                         std::min(0.95 * width / w, 0.95 * height / h); // x and y on one scale, in the middle
        axes_ = {(width - unit * w) / 2, (width + unit * w) / 2, (height - unit * h) / 2,
                 (height + unit * h) / 2};
    }
    PixelBox Axes() const { return axes_; }
    double X(double x) const { return axes_.left + (axes_.right - axes_.left) * Share(x_, x); }
    double Y(double y) const { return axes_.bottom + (axes_.top - axes_.bottom) * Share(y_, y); }

  private:
    static double Share(const PlotAxis &axis, double v) {
        return axis.log ? std::log(v / *axis.min) / std::log(*axis.max / *axis.min)
                        : (v - *axis.min) / (*axis.max - *axis.min);
    }
    PlotAxis x_, y_;
    PixelBox axes_;
};

// A letter at an offset (in gnuplot's characters) from a point.
PixelBox MarkBox(double x, double y, const std::array<double, 2> &offset, double textWidth) {
    const double near = x + 9.5 * offset[0], middle = y + 18 * offset[1];
    return {offset[0] < 0 ? near - textWidth : near, offset[0] < 0 ? near : near + textWidth, middle - 7,
            middle + 7};
}

// Boxes around the points of the panel, and along its lines.
std::vector<PixelBox> BoxesOfData(const PlotPanel &panel, const PixelScale &scale) {
    std::vector<PixelBox> boxes;
    const auto add = [&boxes](double x, double y, double reach) {
        if (std::isfinite(x) && std::isfinite(y))
            boxes.push_back({x - reach, x + reach, y - reach, y + reach});
    };
    for (const PlotSeries &s : panel.series)
        for (size_t i = 0; i < s.x.size(); ++i) {
            const double x = scale.X(s.x[i]), y = scale.Y(s.y[i]);
            add(x, y, s.style == PlotStyle::Line ? 1 : 4);
            if (s.style == PlotStyle::Points || i == 0)
                continue;
            const double dx = x - scale.X(s.x[i - 1]), dy = y - scale.Y(s.y[i - 1]),
                         length = std::hypot(dx, dy);
            for (double at = 3; std::isfinite(length) && at < length; at += 3)
                add(x - dx * at / length, y - dy * at / length, 1);
        }
    return boxes;
}

} // namespace

double TextWidth(const std::string &text) {
    double em = 0;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if ((byte & 0xC0) == 0x80 || std::string_view("{}_^\\").find(c) != std::string_view::npos)
            continue; // the rest of a letter in UTF-8, or a mark
        em += std::string_view(" ijl',.:;|!ftrI()[]-/").find(c) != std::string_view::npos ? 0.41
              : std::string_view("mwMW%@").find(c) != std::string_view::npos              ? 0.98
              : c >= 'A' && c <= 'Z'                                                      ? 0.75
                                                                                          : 0.64;
    }
    return kEm * em;
}

std::vector<std::string> BrokenLines(const std::string &text, size_t maxLetters) {
    std::vector<std::string> lines;
    size_t letters = 0;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find(' ', at), text.size());
        const std::string word = text.substr(at, end - at);
        // Bytes that continue a letter of UTF-8 begin with the bits 10.
        const auto length = static_cast<size_t>(std::count_if(
            word.begin(), word.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
        if (lines.empty() || letters + 1 + length > maxLetters)
            lines.push_back(word), letters = length;
        else
            lines.back() += " " + word, letters += 1 + length;
        at = end + 1;
    }
    return lines;
}

void FitLegends(Plot *plot) {
    std::map<double, double> ends; // of the axes, by what was asked for
    for (const PlotPanel &panel : plot->panels)
        for (const PlotSeries &s : panel.series)
            if (double &end = ends.try_emplace(panel.right, panel.right).first->second; !s.label.empty())
                end = std::min(end, 1 - (kLegendSample + TextWidth(s.label)) / plot->width);
    for (PlotPanel &panel : plot->panels)
        if (panel.right > 0 && !panel.series.empty())
            panel.right = ends.at(panel.right);
}

void PlaceMarks(PlotPanel *panel, int width, int height) {
    if ((panel->kind != PlotKind::Cartesian && panel->kind != PlotKind::Diagram) || !panel->x.min ||
        !panel->x.max || !panel->y.min || !panel->y.max)
        return;
    constexpr std::array<std::array<double, 2>, 18> offsets = {{{0.7, 0.4},
                                                                {-0.7, 0.4},
                                                                {0.7, -0.4},
                                                                {-0.7, -0.4},
                                                                {0.9, 0},
                                                                {-0.9, 0},
                                                                {0.4, 0.9},
                                                                {-0.4, 0.9},
                                                                {0.4, -0.9},
                                                                {-0.4, -0.9},
                                                                {1.4, 0.8},
                                                                {-1.4, 0.8},
                                                                {1.4, -0.8},
                                                                {-1.4, -0.8},
                                                                {1.8, 0},
                                                                {-1.8, 0},
                                                                {0.8, 1.5},
                                                                {0.8, -1.5}}};
    const PixelScale scale(*panel, width, height);
    std::vector<PixelBox> taken = BoxesOfData(*panel, scale);
    const PixelBox axes = scale.Axes();
    for (PlotSeries &s : panel->series) {
        if (s.mark.empty() || s.x.empty())
            continue;
        const double textWidth = TextWidth(s.mark) * 10 / 12;
        size_t fewest = SIZE_MAX;
        PixelBox best{};
        for (const auto &offset : offsets) {
            const PixelBox box = MarkBox(scale.X(s.x[0]), scale.Y(s.y[0]), offset, textWidth);
            const auto hits = static_cast<size_t>(std::count_if(
                taken.begin(), taken.end(), [&](const PixelBox &b) { return b.Overlaps(box); }));
            const bool outside = box.right > axes.right || box.left < axes.left;
            if (hits + (outside ? 100 : 0) < fewest)
                fewest = hits + (outside ? 100 : 0), best = box, s.markOffset = offset;
        }
        // Letters on letters are the worst.
        taken.insert(taken.end(), 20, best);
    }
}

} // namespace cuticle
