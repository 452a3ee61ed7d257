// Plots of what a fiber scatters, measured by the fiber simulator.
#pragma once

#include "fibers/fiber_simulator.h"
#include "figures/plot.h"

namespace cuticle {

// The cuts that goniometers make: the plane of fiber and light; around the fiber at theta = 0; around it on the specular
// cone, theta = minus the light's; and all directions.
enum class GoniometerPlane { Incidence, Normal, Cone, Hemisphere };

// Density: the share of the light per steradian, p. S: Marschner's, p / cos theta of the direction.
enum class GoniometerQuantity { Density, S };

struct GoniometerView {
    GoniometerPlane plane = GoniometerPlane::Incidence;
    GoniometerQuantity quantity = GoniometerQuantity::Density;
    double halfWidth = 1 * kPi<double> / 180; // of the cut, radians
    double thetaOffset = 0;                   // Normal and Cone: the cut lies so far toward the tip, radians
    size_t channel = 0;                       // that is drawn
};

// The cut of a view (not Hemisphere) through one class; angles in radians. Around the fiber they are phi - light.phi, in
// [-pi, pi]; in the plane of incidence theta, continued by pi - theta on the far side.
LobeSlice GoniometerSlice(const FiberHistogram &histogram, const FiberLight &light,
                          const GoniometerView &view, size_t c, size_t channel);

// The curve in degrees, with its standard errors.
PlotSeries LobeSeries(const LobeSlice &slice, const std::string &label);

// A picture of the view: each class of paths that holds light and their sum, as a polar diagram with a logarithmic radius
// and as curves with error bars; the hemisphere as maps.
Plot GoniometerPlot(const FiberHistogram &histogram, const FiberLight &light, const GoniometerView &view,
                    const std::string &title);

} // namespace cuticle
