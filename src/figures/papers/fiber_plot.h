// Plots of the light that a fiber scatters, measured by the fiber simulator.
#pragma once

#include "fibers/fiber_simulator.h"
#include "figures/figure.h"

namespace cuticle {

// The cuts that goniometers make: the plane of fiber and light; around the fiber at theta = 0; around it on
// the specular cone, where theta is minus the light's; and all directions.
enum class GoniometerPlane { Incidence, Normal, Cone, Hemisphere };

// Density is p, the share of the light per steradian; S is Marschner's, p / cos theta of the direction.
enum class GoniometerQuantity { Density, S };

struct GoniometerView {
    GoniometerPlane plane = GoniometerPlane::Incidence;
    GoniometerQuantity quantity = GoniometerQuantity::Density;
    double halfWidth = kDegree; // of the cut, radians
    double thetaOffset = 0;     // Normal and Cone: the cut lies so far toward the tip, radians
    size_t channel = 0;         // the colour that is drawn
};

// Cuts the view (not Hemisphere) through one class of paths, c; angles are in radians. Around the fiber they
// are phi - light.phi, in [-pi, pi]; in the plane of incidence theta, continued by pi - theta on the far
// side.
LobeSlice GoniometerSlice(const FiberHistogram &histogram, const FiberLight &light,
                          const GoniometerView &view, size_t c, size_t channel);

// Makes a curve over degrees, with its standard errors.
PlotSeries LobeSeries(const LobeSlice &slice, const std::string &label);

// Draws the view: each class of paths that holds light and their sum, as a polar diagram with a logarithmic
// radius and as curves with error bars; the hemisphere as maps.
Plot GoniometerPlot(const FiberHistogram &histogram, const FiberLight &light, const GoniometerView &view,
                    const std::string &title);

} // namespace cuticle
