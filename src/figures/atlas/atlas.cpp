#include "figures/atlas/atlas.h"

#include "core/error.h"
#include "core/parallel.h"
#include "files/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

namespace cuticle {

double AtlasAxis::At(size_t i) const {
    const double x = low + (high - low) * (static_cast<double>(i) + 0.5) / static_cast<double>(cells);
    return exponent ? std::pow(10, x) : x;
}

std::vector<double> FillMap(const AtlasAxis &x, const AtlasAxis &y,
                            const std::function<double(double, double)> &f) {
    std::vector<double> values(x.cells * y.cells);
    ParallelFor(values.size(), [&](size_t i) { values[i] = f(x.At(i % x.cells), y.At(i / x.cells)); });
    return values;
}

double WorstOf(const std::vector<double> &values) {
    double worst = 0;
    for (const double v : values)
        worst = std::isfinite(v) ? std::max(worst, std::abs(v)) : std::numeric_limits<double>::infinity();
    return worst;
}

namespace {

// To add a fault: give it the next number here, let a map's findings name that number, and write the tests
// that watch it; a test finds them by their names.
constexpr std::array kFaults = std::to_array<AtlasFault>({
    {1, "I0 by ten terms of its series up to x = 12", "mended",
     "AsPrinted.BesselSeriesIsShortAndItsLogarithmHalvesATerm I0e.AgreesWithFiftyDigits"},
    {2, "log I0 beyond x = 12 with its second term halved", "mended",
     "AsPrinted.BesselSeriesIsShortAndItsLogarithmHalvesATerm I0e.AgreesWithFiftyDigits"},
    {3, "so M_p does not conserve energy", "mended",
     "AsPrinted.MpDoesNotConserveEnergy Hair.WhiteFurnaceByQuadratureInFloat"},
    {4, "log I0 - b - 1/v cancels in binary32", "mended", "AsPrinted.MpCancelsInBinary32 HairVectors.Mp"},
    {5, "the sampled cosine 1 + v log(...) rounds to 1", "mended", "HairModel.SampledCosineKeepsNarrowLobes"},
    {6, "the scales' tilt applied to theta_i, after sampling", "mended",
     "AsPrinted.TiltOfThetaILosesEnergy HairFurnace.OverTheSphere"},
    {7, "the edge of a clear fiber is 0/0 in the last lobe", "mended", "Hair.HOnTheEdge"},
    {8, "cos theta = 0 makes eta' infinite; the loop that wraps an angle does not end", "mended",
     "Hair.GrazingCosThetaZero HairModel.WrapsAnglesByRounding"},
    {9, "absorption from a reflectance of 0 is infinite, from one above 1 it grows again", "mended",
     "HairColor.SigmaAFromReflectanceIsClamped"},
    {10, "35 nodes of quadrature are said to suffice for N_p above 2 degrees", "mended",
     "DEon.ThirtyFiveNodes DEon.QuadratureIsAccurateAtEveryRoughness Atlas.ThirtyFiveNodesAreTooFew"},
    {11, "azimuths wrapped once or not at all", "mended",
     "Gaussian.DetectorIsTheSumOverImages DEon.TheNearestDetectorLosesLightAtPi "
     "HairModel.LogisticAtBetaNOneIsTrimmed"},
    {12, "one lobe, uniform in azimuth, for all orders from 3 on", "mended",
     "HairModel.ShareOfTheLastLobe ChosenLobes.LeaveNoMoreThanTheirShare ChosenLobes.KeepAllLight "
     "HairModels.ChiangWithAShareForTheTail"},
    {13, "Marschner's cubic in place of Snell's law", "mended",
     "RootMethods.ErrorOfTheCubic RootMethods.PolishedRootsAreExact"},
    {14, "the width of Marschner's caustics grows without bound at eta' = 2", "stated",
     "Marschner.GlintsAreBoundedWhereCausticsMeet"},
    {15, "Gaussian M in theta_h returns twice the light", "mended", "LongitudinalLobe.EnergyOfTheThreeForms"},
    {16, "A_p depends on theta_o alone: not reciprocal", "stated", "HairModel.AttenuationIsNotReciprocal"},
    {17, "DemuxFloat of u = 1 overflows", "mended", "DemuxFloat.UOfOneAndBeyondStaysInside"},
    {18, "v across a curve from a point that is not the nearest; rays that leave a hair pass its neighbours",
     "mended", "CurveSetOracle.AgreesWithAllRoots CurveSet.LeavesItsHairAndMeetsCloseNeighbours"},
    {19, "phi recovered from a rounded direction", "mended",
     "Hair.SampleAgreesWithFAndPdf Hair.SamplingWeights"},
    {20, "edges of the parameters stop the program or give NaN", "mended",
     "Hair.BetaMZeroIsADeltaCone Hair.BetaNZeroIsANarrowLogistic Hair.EtaOneReflectsNothing "
     "Hair.EtaOneBlackFiberHasNoDirection Hair.EtaBelowOneReflectsTotally"},
    {21, "a furnace that samples the BSDF cannot fail", "mended", "HairFurnace.OverTheSphere"},
    {22, "DemuxFloat makes few different numbers; u = 0 gives density 0", "mended",
     "DemuxFloat.KeepsTheBitsOfU DemuxFloat.ValuesAreSpreadWithinTheirCells "
     "Hair.RandomNumbersAtTheEndsHaveADensity"},
    {23, "explicit springs: stable for steps below the root of mass over stiffness", "mended",
     "Atlas.SpringsAreStableBelowTheirLimit Springs.HoldCurlsButLetStraightHairHang"},
    {24, "plain steps toward a density raise its energy above a factor that depends on it", "mended",
     "Directing.TheStiffnessBoundsTheStep"},
    {25, "a load without measure, or a number that is none, ends a strand", "mended",
     "Simulations.HugeAndMissingNumbersStayFinite"},
    {26, "Fresnel's reflectances averaged over polarisations at every bounce", "stated",
     "Polarisation.ACirclesOrdersAreTheProductsOfMatrices "
     "Polarisation.AtRightAnglesTheTwoPolarisationsStayApart"},
});

// To add a map: let the function of its chapter return it too. To add a chapter: declare its function in
// atlas.h, write it in a file of its own, and give it a row here; `cuticle atlas --chapter` finds it by its
// name.
constexpr std::array kChapters = std::to_array<AtlasChapter>({
    {"longitudinal", "the Bessel function, M_p, its sampling", LongitudinalMaps},
    {"azimuthal", "N_p: quadrature, wrapping, caustics", AzimuthalMaps},
    {"paths", "A_p, the last lobe, the cubic, reciprocity of A_p", PathMaps},
    {"sampling", "DemuxFloat, numbers at the ends, curves", SamplingMaps},
    {"dynamics", "springs and rods, loads, the pull toward a density", DynamicsMaps},
    {"roughness", "every model over its roughness", RoughnessMaps},
    {"models", "every model over its other parameters", ModelMaps},
});

} // namespace

std::span<const AtlasFault> AtlasFaults() { return kFaults; }
std::span<const AtlasChapter> AtlasChapters() { return kChapters; }

namespace {

PlotAxis AxisOf(const AtlasAxis &axis) {
    PlotAxis plot;
    plot.label = axis.label;
    plot.min = axis.low, plot.max = axis.high;
    plot.exponents = axis.exponent;
    const double decades = axis.high - axis.low;
    if (axis.exponent)
        plot.step = decades > 24 ? 12 : decades > 6 ? 2 : decades > 2 ? 1 : 0.5;
    return plot;
}

// Lines of text in the place of a map.
PlotPanel NoteOf(const AtlasPanel &panel) {
    PlotPanel note;
    note.kind = PlotKind::Diagram;
    note.title = panel.title;
    note.x.min = note.y.min = 0, note.x.max = note.y.max = 10;
    double y = 6.2;
    for (const std::string &line : panel.note) {
        PlotSeries s;
        s.x = {0.5}, s.y = {y};
        s.mark = line;
        s.color = kPlotColors - 1, s.width = 0;
        note.series.push_back(s);
        y -= 0.8;
    }
    return note;
}

PlotPanel PanelOf(const AtlasMap &map, const AtlasPanel &panel) {
    if (panel.values.empty())
        return NoteOf(panel);
    PlotPanel plot;
    plot.kind = PlotKind::HeatMap;
    plot.title = panel.title;
    plot.right = 0.78; // room for the colour scale's label
    plot.x = AxisOf(map.x), plot.y = AxisOf(map.y);
    PlotHeatMap &heat = plot.heatMap;
    heat.xMin = map.x.low, heat.xMax = map.x.high, heat.yMin = map.y.low, heat.yMax = map.y.high;
    heat.columns = map.x.cells, heat.rows = map.y.cells;
    heat.log = map.log, heat.min = map.min, heat.max = map.max;
    heat.label = map.quantity;
    heat.values = panel.values;
    for (double &v : heat.values)
        v = std::isfinite(v) ? std::clamp(v, map.min, map.max) : NAN;
    return plot;
}

Table TableOf(const AtlasMap &map) {
    std::vector<std::string> columns = {map.x.column, map.y.column};
    for (const AtlasPanel &panel : map.panels)
        if (!panel.values.empty())
            columns.push_back(panel.title);
    Table table(columns);
    for (size_t i = 0; i < map.x.cells * map.y.cells; ++i) {
        std::vector<Table::Cell> row = {map.x.At(i % map.x.cells), map.y.At(i / map.x.cells)};
        for (const AtlasPanel &panel : map.panels)
            if (!panel.values.empty())
                row.emplace_back(panel.values[i]);
        table.Add(row);
    }
    return table;
}

// The fault's number, or nothing for 0.
std::string FaultNumber(int row) { return row > 0 ? fmt::format("{}", row) : ""; }
// The number, or nothing for NaN.
std::string NumberOf(double x, int digits) { return std::isnan(x) ? "" : fmt::format("{:.{}g}", x, digits); }

// "1 as published, 2 ours, 3 in double"; what is equal in print, once.
std::string NumbersOf(const AtlasFinding &f) {
    const std::string published = NumberOf(f.published, 3), ours = NumberOf(f.ours, 3),
                      inDouble = NumberOf(f.inDouble, 3);
    std::string text = published.empty() || published == ours ? "" : published + " as published, ";
    text += ours + (inDouble == ours ? " ours, also in double" : published == ours ? "" : " ours");
    return text + (inDouble.empty() || inDouble == ours ? "" : ", " + inDouble + " in double");
}

} // namespace

void WriteAtlasMap(const std::string &folder, const AtlasMap &map) {
    FigureData data{TableOf(map)};
    data.plot.title = map.title;
    const size_t panels = map.panels.size();
    data.plot.columns =
        map.columns > 0 ? map.columns : static_cast<int>(panels == 4 ? 2 : std::min<size_t>(panels, 3));
    data.plot.width = map.panels.size() == 1 ? 800 : 480; // a title needs room
    data.plot.height = 360;
    for (const AtlasPanel &panel : map.panels)
        data.plot.panels.push_back(PanelOf(map, panel));
    std::string caption = "Colour: " + map.quantity + ". White: no finite number.";
    if (!map.note.empty())
        caption += " " + map.note;
    for (const AtlasFinding &f : map.findings) {
        caption += " " + PlainText(f.quantity) + ": " + NumbersOf(f);
        caption += f.row > 0 ? " (fault " + FaultNumber(f.row) + ")." : ".";
    }
    WriteFigure(folder, map.name, caption, data);
}

Table AtlasIndex(std::span<const AtlasMap> maps) {
    Table index({"fault", "what", "map", "quantity", "published", "ours", "double", "state", "tests"});
    const auto add = [&index](const AtlasMap &map, const AtlasFinding &f, const std::string &what,
                              const char *state, const char *tests) {
        index.Add({FaultNumber(f.row), what, map.name + ".svg", f.quantity, NumberOf(f.published, 4),
                   NumberOf(f.ours, 4), NumberOf(f.inDouble, 4), state, tests});
    };
    for (const AtlasFault &fault : AtlasFaults())
        for (const AtlasMap &map : maps)
            for (const AtlasFinding &f : map.findings)
                if (f.row == fault.row)
                    add(map, f, fault.fault, f.stated ? "stated" : fault.state, fault.tests);
    for (const AtlasMap &map : maps)
        for (const AtlasFinding &f : map.findings)
            if (f.row == 0)
                add(map, f, map.title, "", "");
    return index;
}

} // namespace cuticle
