#include "figures/papers/figure_table.h"

#include "core/error.h"
#include "figures/papers/paper_figures.h"
#include "figures/rendered.h"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <sstream>

namespace cuticle {

namespace figure_rows {

using enum FigureKind;

// To add a figure: declare its function in paper_figures.h and write it beside its like (a function that
// computes a table, the panels and at least one law, as short as its caption); then give it a row here, at
// its number. `cuticle figure`, the tests of its laws and the book's "```figure ID" find it by the row. A
// figure that is rendered names its scenes (scenes/ID.pbrt, or ID-a.pbrt and so on; what they share stands in
// scenes/parts) and a function that measures their pictures.
constexpr std::array kFigures = std::to_array<Figure>({
    // Marschner, Jensen, Cammarano, Worley and Hanrahan 2003
    {"marschner-01", Diagram,
     "Side view of a fiber whose scales lean by 3°: the paths R, TT and TRT, and (dotted) without the lean; "
     "η = 1.55.",
     Marschner01},
    {"marschner-02", Photo, "Electron micrograph of a hair.", nullptr},
    {"marschner-03", Diagram,
     "Notation: the fiber's axis u, the axes v and w of its section, inclinations θ and azimuths φ.",
     Marschner03},
    {"marschner-04", Plot,
     "Scattering in the incidence plane, light from the tip's side (θ_i = 45°) and from the root's (−45°), "
     "above, logarithmic. Angles: θ_r, beyond ±90° on the far side.",
     Marschner04},
    {"marschner-05", Plot,
     "Scattering in the incidence plane against θ_h for several θ_d, red and blue light, ± one standard "
     "error.",
     Marschner05},
    {"marschner-06", Plot,
     "TRT around an elliptical fiber (0.8:1, light along the minor axis), 10° off the specular cone; the "
     "model dashed over the simulated fiber.",
     Marschner06},
    {"marschner-07", Plot,
     "TRT of an elliptical fiber around it, light in the normal plane, θ_r = 10°, by the azimuth φ_i of the "
     "light; angle: φ, each panel to its own scale.",
     Marschner07},
    {"marschner-08", Plot, "Scattering over the hemispheres, light from the root's side, θ_i = −45°.",
     Marschner08},
    {"marschner-09", Diagram, "Parallel rays through a circle, η = 1.55: where R, TT and TRT leave.",
     Marschner09},
    {"marschner-10", Plot,
     "The shading model under the conditions of figure 4, blond, logarithmic: α_R = -4°, β_R = 2.5°, k_G = "
     "0.5 and what Table 1 derives from them. Angles: θ_r, beyond ±90° on the far side.",
     Marschner10},
    {"marschner-11", Photo, "Photograph of brown hair.", nullptr},
    {"marschner-12", Render,
     "Combed brown hair, a lamp near the camera: Kajiya and Kay's model against Marschner's, whose second "
     "highlight has the hair's colour.",
     nullptr, "marschner-12-a marschner-12-b", MeasureMarschner12},
    {"marschner-13", Render, "62,000 fibers under a sky.", nullptr, "marschner-13", MeasureMarschner13},
    {"marschner-14", Render,
     "Direct light on combed hair: R alone, TRT alone, all; fibers of a section 0.9:1; the same enlarged.",
     nullptr, "marschner-14-a marschner-14-b marschner-14-c marschner-14-d marschner-14-e",
     MeasureMarschner14},
    {"marschner-15", Render, "The same hair under a lamp in several places.", nullptr,
     "marschner-15-a marschner-15-b marschner-15-c marschner-15-d", MeasureMarschner15},
    {"marschner-16", Diagram,
     "Reflection and refraction over all normals n of a fiber, on the unit sphere with the fiber's axis u "
     "upright, and one refraction projected on the plane of the normals; η = 1.55.",
     Marschner16},

    // d'Eon, Francois, Hill, Letteri and Aubry 2011
    {"deon-01", Diagram, "The paths R, TT, TRT and TRRT through a smooth fiber, η = 1.55.", Deon01},
    {"deon-02", Diagram,
     "Left: rays that one beam sends through a smooth fiber (η = 1.55) all leave on one cone. Right: a "
     "roughness that turns them toward the normal plane spreads them over a wider one.",
     Deon02},
    {"deon-03", Plot,
     "Total reflectance against θ_i of a fiber that reflects all light (η = ∞), by the form of the "
     "longitudinal lobe and its roughness β. At 1 energy is conserved.",
     Deon03},
    {"deon-04", Plot,
     "M_p against θ_r (along the circle; the distance from the centre is M_p) for θ_i = -1, -1.1, -1.2, "
     "-1.3, -1.4 rad; v = 0.02. Orange: the specular cones θ_r = -θ_i.",
     Deon04},
    {"deon-05", Plot,
     "Total reflectance against θ_i of a white smooth fiber (η = 1.55, no absorption), all paths up to one "
     "with p segments.",
     Deon05},
    {"deon-06", Plot,
     "Rough N_{TT} against φ, no absorption, θ_d = 0.8 rad, β_{TT} = 25°: the Gaussian detector, and Zinke "
     "and Weber's treatment of 2007 (dashed), which does not see light beyond ±π.",
     Deon06},
    {"deon-07", Diagram,
     "TT of a rough fiber: for each offset h the azimuth Φ(1, h) of a smooth fiber (dashed) is the centre of "
     "a Gaussian of exit azimuths; β = 10°, η = 1.55.",
     Deon07},
    {"deon-08", Plot,
     "Colour of N_{TT} around a nearly smooth (β = 0.5°, top) and a rough (25°, middle) brown fiber, "
     "eumelanin 1.3, θ_d = 0; every column as bright. Bottom: blue over red.",
     Deon08},
    {"deon-09", Plot,
     "Colour of D65 light through eumelanin and pheomelanin against thickness, in the unit of the RGB "
     "cross-sections. Top and bottom: the pure pigments, outer half of the strip by 40 spectral bands, inner "
     "half by RGB. Between: mixtures, by bands. Below: the difference.",
     Deon09},
    {"deon-10", Render,
     "Above, pure eumelanin; below, pure pheomelanin; between, both; concentration grows to the right.",
     nullptr, "deon-10", MeasureDeon10},
    {"deon-11", Render,
     "Light hair by dual scattering, a lamp at its left: Gaussian against energy-conserving M, and paths.",
     nullptr, "deon-11-a deon-11-b deon-11-c", MeasureDeon11},
    {"deon-12", Render, "Natural colours by dual scattering, with glints that nothing controls.", nullptr,
     "deon-12", MeasureDeon12},
    {"deon-13", Photo, "Feathers, which the paper leaves to future work.", nullptr},

    // Pharr 2016
    {"pharr-1.1", Render, "Light curly hair, path traced.", nullptr, "pharr-1.1", MeasurePharr1_1},
    {"pharr-1.2", Render, "The hair of figure 1.1 with direct light only.", nullptr, "pharr-1.2 pharr-1.1",
     MeasurePharr1_2},
    {"pharr-1.3", Diagram, "All normals of a fiber at one place along it lie in one plane, the normal plane.",
     Pharr1_3},
    {"pharr-1.4", Diagram, "The angles θ, from the normal plane, and φ, around the fiber.", Pharr1_4},
    {"pharr-1.5", Diagram, "The offset h and the angle γ_o in the section of a fiber.", Pharr1_5},
    {"pharr-1.6", Diagram,
     "The scales of the cuticle, seen from the side: they rise toward the tip, and their normals lean toward "
     "the root by α (2° to 4° on hair, here 15°).",
     Pharr1_6},
    {"pharr-1.7", Diagram, "The paths R, TT and TRT through a smooth fiber, from the side; η = 1.55.",
     Pharr1_7},
    {"pharr-1.8", Render, "Brown hair under a skylight, by its longitudinal roughness.", nullptr,
     "pharr-1.8-a pharr-1.8-b pharr-1.8-c", MeasurePharr1_8},
    {"pharr-1.9", Plot, "M_p against θ_i for fixed θ_o; v = 0.02. Dashed: the specular direction θ_i = -θ_o.",
     Pharr1_9},
    {"pharr-1.10", Render, "Hair by its absorption, β_m = 0.125, β_n = 0.3.", nullptr,
     "pharr-1.10-a pharr-1.10-b pharr-1.10-c", MeasurePharr1_10},
    {"pharr-1.11", Diagram, "Refraction at the fiber: γ_o outside, γ_t inside; η = 1.55.", Pharr1_11},
    {"pharr-1.12", Diagram, "The length of a segment, seen along the fiber.", Pharr1_12},
    {"pharr-1.13", Diagram, "The length of a segment, seen from the side.", Pharr1_13},
    {"pharr-1.14", Diagram,
     "The turns that make up Φ(p, h): γ_o where light enters, leaves or is reflected, γ_t inside.",
     Pharr1_14},
    {"pharr-1.15", Plot, "Φ(1, h), the turn of light that passes straight through the fiber; η = 1.55.",
     Pharr1_15},
    {"pharr-1.16", Plot, "The logistic function trimmed to ±π.", Pharr1_16},
    {"pharr-1.17", Plot,
     "N_1 around the fiber (distance from the centre; φ = 0 is back to the viewer); β_n = 0.1, θ_o = 0, η = "
     "1.55.",
     Pharr1_17},
    {"pharr-1.18", Render, "Hair by its azimuthal roughness, β_m = 0.3: rougher is lighter.", nullptr,
     "pharr-1.18-a pharr-1.18-b pharr-1.18-c", MeasurePharr1_18},
    {"pharr-1.19", Render,
     "Hair whose scales lie flat, and hair whose scales are tilted by 2°: white and coloured highlight part.",
     nullptr, "pharr-1.19-a pharr-1.19-b", MeasurePharr1_19},
    {"pharr-1.20", Render, "Two spheres beside two cubes of hairs of their colours, under a white dome.",
     nullptr, "pharr-1.20", MeasurePharr1_20},

    // Petrovic, Henne and Anderson
    {"petrovic-1", Render, "Simulated and shaded volumetric hair.", Petrovic1},
    {"petrovic-2", Plot, "A hair model, and two planes through the signed distance S to its shell.",
     Petrovic2},
    {"petrovic-3", Render,
     "The hair's shell; hair by Kajiya and Kay's model with the shell's normals; by the model alone.",
     Petrovic3},
    {"petrovic-4", Render, "A simulated frame without and with smoothed velocities.", Petrovic4},
    {"petrovic-5", Render, "Start shape, target shape, shape reached by density forces.", Petrovic5},
    {"petrovic-6", Render, "Several styles, gelled and loose.", Petrovic6},
    {"petrovic-videos", Animation, "Level set, normals, simulation, directed simulation.", nullptr},

    // The book's own
    {"book-recursion", Diagram,
     "The search along a curve, as the ray sees it: at each depth the boxes of the parts, grown by half the "
     "width; dotted those that the ray cannot reach, solid those that are halved again.",
     BookRecursion},
    {"book-capsule", Diagram,
     "A piece of a curve and its width (orange) between the control points, its chord (dotted), the capsule "
     "around the chord (dashed), and the one around the middle of the bow.",
     BookCapsule},
    {"book-demux", Diagram,
     "64 random numbers, one in each 64th of the interval, split into the two coordinates of a point; cells "
     "of an eighth by an eighth.",
     BookDemux},
    {"book-pigments", Plot,
     "The colour of a mass of hair with so much of the two pigments, by the fit of Chiang and others; β_n = "
     "0.3.",
     BookPigments},
    {"book-mis", Plot,
     "The noise of two samples of the light that a hair, met anywhere over its width, scatters to the viewer "
     "from a lamp: by the lamp's size, and by what is sampled. Both together take one sample of each.",
     BookMis},
});

} // namespace figure_rows

std::span<const Figure> Figures() { return figure_rows::kFigures; }

std::vector<std::string> Figure::Scenes() const {
    std::istringstream words(scenes);
    return {std::istream_iterator<std::string>(words), {}};
}

const Figure &FindFigure(const std::string &id) {
    const Figure &figure = FindRow(Figures(), &Figure::id, id, "figure");
    if (figure.Made())
        return figure;
    if (figure.kind == FigureKind::Photo)
        throw Error("figure {} is a photograph, which cannot be computed", id);
    throw Error("figure {} ({}) is not made; cuticle figure --list shows which are", id,
                ToString(figure.kind));
}

namespace {

// Says how large the pictures of a figure are, and what they took.
std::string Effort(std::span<const FigurePicture> pictures) {
    const FigurePicture &first = pictures.front();
    double seconds = 0;
    for (const FigurePicture &p : pictures)
        seconds += p.cpuSeconds;
    return fmt::format("{} × {} pixels, {} samples each{}.", first.image.width, first.image.height,
                       first.samples, seconds > 0 ? fmt::format(", {:.0f} s of CPU time", seconds) : "");
}

} // namespace

FigureData MakeFigure(const Figure &figure, const FigureOptions &options) {
    if (figure.make != nullptr)
        return figure.make(options);
    std::vector<FigurePicture> pictures;
    for (const std::string &name : figure.Scenes())
        pictures.push_back(options.pictures.empty() ? RenderScene(name, options)
                                                    : ReadPicture(name, options.pictures));
    FigureData data = figure.measure(options, pictures);
    data.note += (data.note.empty() ? "" : " ") + Effort(pictures);
    data.pictures = std::move(pictures);
    return data;
}

std::string ToString(FigureKind kind) {
    using enum FigureKind;
    switch (kind) {
    case Plot:
        return "plot";
    case Render:
        return "render";
    case Diagram:
        return "diagram";
    case Photo:
        return "photo";
    case Animation:
        return "animation";
    }
    return "";
}

} // namespace cuticle
