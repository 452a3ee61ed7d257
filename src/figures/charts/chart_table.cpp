#include "figures/charts/chart_table.h"

#include "figures/charts/charts.h"

#include <array>

namespace cuticle {

namespace {

// To add a chart: declare its function in charts.h, write it in a file of its own (methods as a table, their
// errors against something better, their times by TimeInTurns, a CostPanel, at least one law), and give it a
// row here. `cuticle chart`, the tests of its laws and the book's "```chart NAME" find it by the row.
constexpr std::array kCharts = std::to_array<Chart>({
    {"bessel",
     "The longitudinal lobe M_p and the Bessel function in it, computed in several ways: the largest error "
     "against 50 digits over v from 10^{-8} to 100, and the CPU time of a value, the smallest of many "
     "rounds.",
     BesselChart},
    {"models",
     "Models of a fiber against the simulated fiber, free parameters fitted to it for every fiber: "
     "root-mean-square error of the light over the sphere, relative to the light's, mean over the fibers. η "
     "= 1.55; lit from θ = 0 and 45° and, where the section is an ellipse, from 0, 45 and 90° around it from "
     "its longer axis. Marschner's model and the tabulated one know the section and its azimuth, the others "
     "take the fiber for round. Sampling is measured for brown hair.",
     ModelsChart},
    {"quadrature",
     "N_p through the Gaussian detector by Gauss-Legendre rules in h, over the width as printed or over half "
     "of it, and by our nodes: root-mean-square error around the fiber, relative to N_p's, against the "
     "roughness and the CPU time; η = 1.55, σ_a = 0.2.",
     QuadratureChart},
    {"roots",
     "The paths through a smooth fiber that leave at a given azimuth: how far from it the light of the paths "
     "found really leaves, at worst, and in how many cases their number is wrong, over the circle and η' = "
     "1.165 (under water), 1.3, 1.5, 1.55, 1.8 and 2.2.",
     RootsChart},
    {"curves",
     "Rays that bounce in a ball of hair, the nearest hit, one thread: wrong answers (missed, invented, "
     "another hair) and errors of the place across the hair and of the distance, against all roots found in "
     "extended precision.",
     CurvesChart},
    {"growth",
     "A ball of ever more and ever thinner hair that covers as much: CPU time of a bounce's ray and memory "
     "of "
     "a curve segment, accelerator and points together, by the number of segments; one thread. Broken lines: "
     "a ray for which any hit will do.",
     GrowthChart},
    {"keyhairs",
     "Hairs that follow key hairs, against the same hairs each simulated by itself: root-mean-square "
     "distance "
     "of their points after half a second of a shake, by the number of key hairs and the style.",
     KeyHairsChart},
    {"normals",
     "Normals of hair that it carries along its strands from rest, over a motion: their mean angle to those "
     "of "
     "a shell that is made anew for each frame, for points within two cells of it.",
     NormalsChart},
    {"render",
     "Relative mean squared error of pictures of shipped scenes against the CPU time of all threads from the "
     "scene's file to the picture, by integrator, sampler, model of a fiber, and samples per pixel (along "
     "each line, doubled).",
     RenderChart},
    {"efficiency",
     "Relative mean squared error times CPU time of pictures of hair, by pixel and in means of 8 x 8 pixels, "
     "by "
     "the number of curve segments: balls, their hairs the thinner the more there are, and shipped scenes. "
     "Lower is better: half of "
     "it "
     "is half the time for the same error.",
     EfficiencyChart},
    {"scattering",
     "Means to light what hair scatters on, against path tracing, for four colours of hair: the error of "
     "means "
     "over 8 x 8 pixels (root mean square, relative to the picture's mean) and the CPU time.",
     ScatteringChart},
});

} // namespace

std::span<const Chart> Charts() { return kCharts; }

const Chart &FindChart(const std::string &name) { return FindRow(Charts(), &Chart::name, name, "chart"); }

} // namespace cuticle
