//> Declare the histogram of scattered light
#pragma once

#include "core/vecmath.h"

#include <cstdint>
#include <string>
#include <vector>

namespace cuticle {

//> Cut the sphere of directions into cells
// rows of theta from -pi/2 (row 0, toward the root) to pi/2, either of equal height in sin theta, so that all
// cells have one solid angle, or of equal theta, which resolves lobes alike everywhere; columns of phi from
// -pi to pi.
struct SphereCells {
    size_t rows = 180, columns = 360;
    bool equalSolidAngle = false;
    double middle = 0; // rows of equal theta, half of them below it and half above; |middle| < pi/2

    size_t Count() const { return rows * columns; }
    double ThetaEdge(size_t row) const; // row = 0 ... rows
    double Theta(size_t row) const { return (ThetaEdge(row) + ThetaEdge(row + 1)) / 2; }
    double PhiEdge(size_t column) const {
        return kPi<double> * (2 * static_cast<double>(column) / static_cast<double>(columns) - 1);
    }
    double Phi(size_t column) const { return (PhiEdge(column) + PhiEdge(column + 1)) / 2; }
    double SolidAngle(size_t row) const; // of each cell in a row
    // The cell of a unit vector, x along the fiber, phi = atan2(w.z, w.y).
    size_t CellOf(const Vector3d &w) const;
    size_t RowOf(double theta) const;
    size_t ColumnOf(double phi) const; // of any angle
};
//<

//> Describe a measured curve
// A cut through a histogram: at each angle (radians) the mean density over the cells of the cut, 1/sr, and
// its standard error.
struct LobeSlice {
    std::vector<double> angle, value, error;
};
//<

//> Declare the histogram
// Holds what a fiber, lit from one direction, scatters into each cell of the sphere: of the power that meets
// the fiber, the share that leaves into the cell, with sums of squares for the error, apart for each class of
// paths and each channel (colour). Classes: p = 0 (R), 1 (TT), 2 (TRT), ... up to orders - 1; Rest(): all
// higher p; Medulla(): scattered in the medulla at least once; Sum(): everything.
//
// Density is p(w | w_lit), the share per steradian. It is what a BSDF gives for f(w_lit, w) |w.z| with w_lit
// the viewer's direction: averaged over h in the far field, and at the same h in the near field. Marschner's
// S, in which radiance from a fiber is the integral of S L_i cos theta_i, is p / cos theta of w; S is
// symmetric in its two directions (for an ellipse, S times the width that the fiber shows to the light is).
class FiberHistogram {
  public:
    FiberHistogram(const SphereCells &cells, int orders, size_t channels);

    const SphereCells &Cells() const { return cells_; }
    size_t Orders() const { return orders_; }
    size_t Channels() const { return channels_; }
    size_t Rest() const { return orders_; }
    size_t Medulla() const { return orders_ + 1; }
    size_t Sum() const { return orders_ + 2; }
    size_t Classes() const { return orders_ + 3; }
    std::string ClassName(size_t c) const; // R, TT, TRT, TR2T, TR3T, ..., rest, medulla, sum

    //> Ask a histogram
    double Density(size_t c, size_t channel, size_t row, size_t column) const;
    double DensityError(size_t c, size_t channel, size_t row, size_t column) const; // one standard error
    double Density(size_t c, size_t channel, const Vector3d &w) const;
    // The share of all power that meets the fiber, and its standard error.
    double Albedo(size_t c, size_t channel) const { return Mean(c, channel, cells_.Count()); }
    double AlbedoError(size_t c, size_t channel) const { return Error(c, channel, cells_.Count()); }
    uint64_t Samples() const { return samples_; }
    // The share of light whose paths were given up because they would not end: 0 but for directions along the
    // axis.
    double Lost() const { return samples_ > 0 ? lost_ / static_cast<double>(samples_) : 0; }
    //<

    //> Cut a histogram
    // Cells whose centres lie within halfWidth of phi (of theta) are averaged, the nearest alone if there are
    // none. Over the rows, at phi: angle is theta, -pi/2 to pi/2.
    LobeSlice AlongTheta(size_t c, size_t channel, double phi, double halfWidth) const;
    // Around the fiber, at theta: angle is phi, -pi to pi. theta = 0 is the normal plane, minus the light's
    // theta the specular cone.
    LobeSlice AroundPhi(size_t c, size_t channel, double theta, double halfWidth) const;
    // All around the plane of the fiber and the light, at azimuth phi: angle is theta on the light's side and
    // pi - theta beyond, -pi/2 to 3 pi/2.
    LobeSlice IncidencePlane(size_t c, size_t channel, double phi, double halfWidth) const;
    //<

    // Comma-separated: one line for each class and cell with its edges in degrees, solid angle, and for each
    // channel density and standard error. The first line names the columns.
    std::string ToCsv() const;

    //> Add to a histogram
    // One sample's merged share in a cell, channels numbers; cell Count() stands for the whole sphere.
    void Add(size_t c, size_t cell, const double *share);
    void CountSamples(uint64_t samples, double lost) { samples_ += samples, lost_ += lost; }
    //<

  private:
    size_t Index(size_t c, size_t channel, size_t cell) const {
        return (c * (cells_.Count() + 1) + cell) * channels_ + channel;
    }
    double Mean(size_t c, size_t channel, size_t cell) const;
    double Error(size_t c, size_t channel, size_t cell) const;
    double ErrorOf(double sum, double squares) const;
    template <typename Inside>
    void AddPoint(LobeSlice *slice, double angle, size_t c, size_t channel, const Inside &inside) const;

    SphereCells cells_;
    size_t orders_, channels_;
    std::vector<double> sums_, squares_;
    uint64_t samples_ = 0;
    double lost_ = 0;
};
//<

} // namespace cuticle
//<
