//> Declare the tabulated model
#pragma once

#include "fibers/bxdf.h"
#include "fibers/fiber_simulator.h"

#include <memory>
#include <span>

namespace cuticle {

//> Say what a table holds
// A table keeps what the simulator finds for a grid of directions of the viewer and for a list of
// absorptions: fiber.sigmaA, ascending, each a "channel" of the simulation and a level of the table. For
// every direction and level it holds the share of the light that leaves into each cell of the sphere. Far
// field.
class FiberTable {
  public:
    // samples: rays for each direction of the viewer. Throws Error where SimulateFiber does, and for levels
    // that do not ascend. Directions are simulated in parallel.
    FiberTable(const FiberDescription &fiber, uint64_t samples);
    // Rays for each direction that make a table good enough for pictures, and soon: see the chapter.
    static uint64_t UsualSamples(const FiberDescription &fiber) {
        return fiber.axisRatio == 1 ? 16384 : 2048;
    }
    // The same table for the same parameters, while somebody holds it; the newest is always held.
    static std::shared_ptr<const FiberTable> Cached(const FiberDescription &fiber, uint64_t samples);

    const std::vector<double> &Levels() const { return fiber_.sigmaA; }
    size_t MemoryBytes() const {
        return (shares_.size() + rowShares_.size() + totals_.size()) * sizeof(float);
    }

    //> Lay out the grid
    static constexpr size_t kThetas =
        36; // of the viewer, in the middles of equal steps from -90 to 90 degrees
    // Azimuths of the viewer, from the first semi-axis to the second; the ellipse's symmetry gives the rest.
    // A circle needs 1.
    static constexpr size_t kPhis = 13;
    static constexpr size_t kRows = 72, kColumns = 96; // of cells; columns of phi_i - phi_o from -pi to pi
    // Half the rows lie on each side of the specular cone, whatever thetaO is: lobes stay where they are in
    // the table while the viewer moves.
    static SphereCells Cells(double thetaO);
    static double LastTheta() { return kPi<double> / 2 * (1 - 1. / kThetas); }
    //<

    //> Ask a table
    // A few entries of the grid and their weights, which sum to 1: linear interpolation. mirrored: phi_i -
    // phi_o counts the other way round.
    struct Place {
        size_t entry[4], count;
        float weight[4];
        bool mirrored;
    };
    Place At(double thetaO, double phiO) const; // phiO from the first semi-axis; NaN: any place
    // The shares of one entry and level: all cells in rows, the sums of rows, the sum of all.
    std::span<const float> Shares(size_t entry, size_t level) const;
    std::span<const float> RowShares(size_t entry, size_t level) const;
    float Total(size_t entry, size_t level) const { return totals_[entry * Levels().size() + level]; }
    //<

  private:
    void Fill(size_t entry, uint64_t samples);
    size_t PhiCount() const { return fiber_.axisRatio == 1 ? 1 : kPhis; }

    FiberDescription fiber_;
    std::vector<float> shares_, rowShares_, totals_;
};
//<

//> Write the tabulated model for any kind of number
// T is float or double. Directions are unit vectors in the local frame of the fiber, x along it.
template <typename T>
class Tabulated {
  public:
    // sigmaA: per radius, for each colour; between two levels it is interpolated, beyond the last it is the
    // last. axis: azimuth of the section's first semi-axis in the local frame, radians. The table must
    // outlive the model.
    Tabulated(const FiberTable *table, const std::array<double, 3> &sigmaA, double axis);

    FiberValue<T> Evaluate(const Vector3<T> &wo, const Vector3<T> &wi) const;
    // Chooses *wi from four numbers in (0, 1).
    FiberValue<T> Sample(const Vector3<T> &wo, const std::array<T, 4> &u, Vector3<T> *wi) const;
    const FiberTable *Table() const { return table_; }

  private:
    struct Blend { // of two levels, for one colour; from up to four, what their blend is to hold
        std::array<size_t, 2> level;
        T above; // the weight of the second where the totals tell none
        std::array<size_t, 4> near;
        std::array<T, 4> share;
        size_t nearCount = 0; // 0: a level itself
    };
    struct View;
    T WeightAbove(size_t entry, const Blend &blend) const;
    View ViewOf(const Vector3<T> &wo) const;
    template <typename F>
    void ForEachPart(const View &view, const F &f) const;
    FiberValue<T> Look(const View &view, T thetaI, T cosThetaI, T phi) const;

    const FiberTable *table_;
    std::array<Blend, 3> blends_;
    T axis_;
};
//<

//> Say what the tabulated class takes
// Light in a fiber as the simulator finds it (exercises 1.1 and 1.2 of Pharr 2016, after Ogaki and others
// 2010). Throws Error for numbers that are not finite; negative absorptions count as 0.
class TabulatedBSDF final : public BxDFOf<Tabulated<Float>> {
  public:
    TabulatedBSDF(const FiberTable *table, const Spectrum &sigmaA, Float axis);
    std::string ToString() const override;
};
//<

} // namespace cuticle
//<
