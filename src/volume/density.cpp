//> Define how strands become a density
#include "volume/density.h"

#include "core/check.h"
#include "core/parallel.h"

#include <algorithm>

namespace cuticle {

//> Find the lattice around points
GridBox BoxAround(const Bounds3f &bounds, float cell, size_t margin) {
    CHECK_GE(margin, 1u);
    if (bounds.IsEmpty() || !IsFinite(bounds.pMin) || !IsFinite(bounds.pMax))
        throw Error("there is no box around strands that have no points, or none that are finite");
    if (!(cell > 0 && cell <= kMaxCoordinate))
        throw Error("cells of {} to a side", cell).WithRemedy("the side of a cell is a positive number");
    GridBox box;
    box.cell = cell;
    const double side = static_cast<double>(cell);
    double count = 1;
    std::array<double, 3> sizes{};
    for (size_t axis = 0; axis < 3; ++axis) {
        const double extent = static_cast<double>(bounds.pMax[axis]) - static_cast<double>(bounds.pMin[axis]);
        sizes[axis] = std::floor(extent / side) + 2 + 2 * static_cast<double>(margin);
        count *= sizes[axis];
    }
    if (!(count <= static_cast<double>(kMaxGridVertices)))
        throw Error("a grid of {:.0f} x {:.0f} x {:.0f} vertices", sizes[0], sizes[1], sizes[2])
            .WithRemedy("at most {} in all; choose larger cells", kMaxGridVertices);
    for (size_t axis = 0; axis < 3; ++axis) {
        box.size[axis] = static_cast<size_t>(sizes[axis]);
        // What is left over is shared by both sides
        const double extent = static_cast<double>(bounds.pMax[axis]) + static_cast<double>(bounds.pMin[axis]);
        box.origin[axis] = static_cast<float>((extent - (sizes[axis] - 1) * side) / 2);
    }
    return box;
}
//<

//> Take differences on the lattice
Vector3f GradientAt(const DenseGrid<float> &grid, const GridBox::Vertex &at) {
    Vector3f gradient;
    const size_t index = grid.box.Index(at[0], at[1], at[2]);
    for (size_t axis = 0; axis < 3; ++axis) {
        const size_t stride = grid.box.Stride(axis);
        const size_t up = at[axis] + 1 < grid.box.size[axis] ? 1 : 0, down = at[axis] > 0 ? 1 : 0;
        if (up + down > 0)
            gradient[axis] = (grid.values[index + up * stride] - grid.values[index - down * stride]) /
                             (static_cast<float>(up + down) * grid.box.cell);
    }
    return gradient;
}

Vector3f SampleGradient(const DenseGrid<float> &grid, const Point3f &p) {
    Vector3f q = grid.box.InCells<float>(p);
    for (size_t axis = 0; axis < 3; ++axis)
        q[axis] = q[axis] > 0 ? std::min(q[axis], static_cast<float>(grid.box.size[axis] - 1)) : 0.f;
    const TentWeights<float> tent(grid.box.size, q);
    Vector3f sum;
    for (size_t c = 0; c < 8; ++c)
        sum += GradientAt(grid, {tent.low[0] + (c & 1), tent.low[1] + (c >> 1 & 1), tent.low[2] + (c >> 2)}) *
               tent(c);
    return sum;
}
//<

//> Read strands from arrays and from grooms
StrandSet StrandsOf(std::span<const Point3f> points, std::span<const float> widths,
                    std::span<const uint32_t> offsets) {
    CHECK(widths.empty() || widths.size() == points.size());
    return {offsets.empty() ? 0 : offsets.size() - 1, [=](size_t i, StrandRun *run) {
                run->points.assign(points.begin() + offsets[i], points.begin() + offsets[i + 1]);
                if (!widths.empty())
                    run->widths.assign(widths.begin() + offsets[i], widths.begin() + offsets[i + 1]);
            }};
}

StrandSet ControlPoints(const Groom &groom) {
    CHECK(groom.placements.empty());
    return {groom.StrandCount(), [&groom](size_t i, StrandRun *run) {
                const auto strand = groom.Strand(i);
                run->points.assign(strand.begin(), strand.end());
                for (size_t k = 0; k < strand.size(); ++k)
                    run->widths.push_back(groom.Width(i, k));
            }};
}

StrandSet CurvesOf(const Groom &groom, size_t chords) {
    CHECK(groom.placements.empty() && chords >= 1);
    return {groom.StrandCount(), [&groom, chords](size_t i, StrandRun *run) {
                std::vector<BezierSegment> pieces;
                AppendSegments(groom, i, {}, &pieces);
                for (const BezierSegment &piece : pieces)
                    for (size_t k = run->points.empty() ? 0 : 1; k <= chords; ++k) {
                        const float u = static_cast<float>(k) / static_cast<float>(chords), v = 1 - u;
                        run->points.push_back(piece.cp[0] * (v * v * v) + piece.cp[1] * (3 * u * v * v) +
                                              piece.cp[2] * (3 * u * u * v) + piece.cp[3] * (u * u * u));
                        run->widths.push_back(Lerp(u, piece.width[0], piece.width[1]));
                    }
            }};
}
//<

namespace {

//> Gather what cells receive, by layers
// A cell and what it gives to its corners is kept in one piece.
struct CellMass {
    GridBox::Vertex low;
    std::array<double, 8> mass;
};

// Takes points in and keeps what cells receive from them, sorted by the layer of cells along z. Points that
// follow each other in one cell, as those of a strand do, are added up at once.
class LayeredMasses {
  public:
    explicit LayeredMasses(const GridBox &box) : size_(box.size) {}
    // p: in cells; outside of the box it gives nothing.
    void Add(const Vector3d &p, double mass) {
        const TentWeights<double> tent(size_, p);
        if (!tent.isInside)
            return;
        if (cells_.empty() || cells_.back().low != tent.low)
            cells_.push_back({tent.low, {}});
        for (size_t corner = 0; corner < 8; ++corner)
            cells_.back().mass[corner] += tent(corner) * mass;
    }
    void Clear() { cells_.clear(); }
    // A counting sort, of numbers, which keeps the order within a layer.
    void Sort() {
        first_.assign(size_[2] + 1, 0);
        for (const CellMass &cell : cells_)
            ++first_[cell.low[2] + 1];
        for (size_t k = 1; k < first_.size(); ++k)
            first_[k] += first_[k - 1];
        std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
        order_.resize(cells_.size());
        for (uint32_t i = 0; i < cells_.size(); ++i)
            order_[next[cells_[i].low[2]]++] = i;
    }
    // Calls use(cell) for the cells of a layer.
    template <class Use>
    void ForLayer(size_t k, const Use &use) const {
        for (size_t i = first_[k]; i < first_[k + 1]; ++i)
            use(cells_[order_[i]]);
    }

  private:
    GridBox::Vertex size_;
    std::vector<CellMass> cells_;
    std::vector<uint32_t> first_, order_;
};
//<

//> Add what a layer gives to one of the planes that bound it
// upper: the plane above the layer, else the one below it.
void AddLayer(const LayeredMasses &masses, size_t layer, bool upper, const GridBox &box, double *plane) {
    masses.ForLayer(layer, [&](const CellMass &cell) {
        double *corner = plane + cell.low[1] * box.size[0] + cell.low[0];
        const double *mass = &cell.mass[upper ? 4 : 0];
        corner[0] += mass[0];
        corner[1] += mass[1];
        corner[box.size[0]] += mass[2];
        corner[box.size[0] + 1] += mass[3];
    });
}
//<

//> Spread all points, by a loop over planes
// emit(run, &masses) turns a strand into points with masses; factor multiplies the sums.
template <class Emit>
DenseGrid<float> Spread(const StrandSet &strands, const GridBox &box, double factor, const Emit &emit) {
    CHECK(box.size[0] >= 2 && box.size[1] >= 2 && box.size[2] >= 2);
    constexpr size_t kPiece = 64, kPieces = 64; // pieces of so many strands, so many at a time
    std::vector<double> sums(box.Count());
    std::vector<LayeredMasses> pieces(std::min(kPieces, (strands.count + kPiece - 1) / kPiece),
                                      LayeredMasses(box));
    for (size_t begin = 0; begin < strands.count; begin += kPiece * kPieces) {
        const size_t end = std::min(strands.count, begin + kPiece * kPieces);
        ParallelFor(pieces.size(), [&](size_t piece) {
            StrandRun run;
            pieces[piece].Clear();
            const size_t first = begin + piece * kPiece;
            for (size_t i = first; i < std::min(end, first + kPiece); ++i) {
                run.Clear();
                strands.read(i, &run);
                emit(run, &pieces[piece]);
            }
            pieces[piece].Sort();
        });
        ParallelFor(box.size[2], [&](size_t k) {
            double *plane = sums.data() + k * box.Stride(2);
            for (const LayeredMasses &masses : pieces) {
                if (k > 0)
                    AddLayer(masses, k - 1, true, box, plane);
                if (k + 1 < box.size[2])
                    AddLayer(masses, k, false, box, plane);
            }
        });
    }
    DenseGrid<float> grid(box);
    ParallelForRange(sums.size(), 65536, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i)
            grid.values[i] = static_cast<float>(sums[i] * factor);
    });
    return grid;
}
//<

//> Cut a line at the walls of the cells
// Finds where the line from a to b, t from 0 to 1, meets a wall of the lattice; with both ends, in order. In
// cells.
void FindWalls(const Vector3d &a, const Vector3d &b, const GridBox::Vertex &size, std::vector<double> *ts) {
    ts->assign({0, 1});
    for (size_t axis = 0; axis < 3; ++axis) {
        const double low = std::min(a[axis], b[axis]), high = std::max(a[axis], b[axis]);
        const double last = std::min(high, static_cast<double>(size[axis]));
        for (double wall = std::max(std::floor(low) + 1, 0.); wall < last; ++wall)
            ts->push_back((wall - a[axis]) / (b[axis] - a[axis]));
    }
    std::sort(ts->begin(), ts->end());
}
//<

//> Integrate the tent along a line by three points a cell
// Area of a fiber's section where its width goes from w0 to w1.
double SectionAt(double w0, double w1, double t) { return kPi<double> / 4 * Sqr(Lerp(t, w0, w1)); }

// Adds points whose tents add up to the integral of the tent along the line. widths: at both ends; null: the
// mass is the length.
void AddLine(const GridBox &box, const Point3f *ends, const float *widths, std::vector<double> *ts,
             LayeredMasses *masses) {
    // Gauss and Legendre's three nodes on [0, 1], exact up to the fifth power
    constexpr double kNode = 0.38729833462074169, kWeights[3] = {5. / 18, 8. / 18, 5. / 18};
    const Vector3d a = box.InCells<double>(ends[0]), b = box.InCells<double>(ends[1]);
    const double length = (b - a).Length() * static_cast<double>(box.cell);
    FindWalls(a, b, box.size, ts);
    for (size_t i = 0; i + 1 < ts->size(); ++i) {
        const double t0 = (*ts)[i], t1 = (*ts)[i + 1];
        for (size_t k = 0; k < 3 && t1 > t0; ++k) {
            const double t = Lerp(0.5 + (static_cast<double>(k) - 1) * kNode, t0, t1);
            const double section =
                widths ? SectionAt(static_cast<double>(widths[0]), static_cast<double>(widths[1]), t) : 1;
            masses->Add(a + (b - a) * t, length * (t1 - t0) * kWeights[k] * section);
        }
    }
}
//<

} // namespace

//> Take the density of vertices, and of lines
DenseGrid<float> VertexDensity(const StrandSet &strands, const GridBox &box) {
    return Spread(strands, box, 1, [&](const StrandRun &run, LayeredMasses *masses) {
        for (const Point3f &p : run.points)
            masses->Add(box.InCells<double>(p), 1);
    });
}

DenseGrid<float> LineDensity(const StrandSet &strands, const GridBox &box) {
    const double cell = static_cast<double>(box.cell);
    return Spread(strands, box, 1 / (cell * cell * cell), [&](const StrandRun &run, LayeredMasses *masses) {
        std::vector<double> ts;
        for (size_t k = 0; k + 1 < run.points.size(); ++k)
            AddLine(box, &run.points[k], run.widths.empty() ? nullptr : &run.widths[k], &ts, masses);
    });
}
//<

//> Smooth a field
// Replaces a row of `count` values by its means; what would leave over a wall stays at the wall.
static void SmoothRow(float *row, size_t count, size_t stride) {
    float before = row[0];
    for (size_t i = 0; i < count; ++i) {
        const float here = row[i * stride], after = row[std::min(i + 1, count - 1) * stride];
        row[i * stride] = 0.25f * before + 0.5f * here + 0.25f * after;
        before = here;
    }
}

DenseGrid<float> Smoothed(DenseGrid<float> grid, size_t passes) {
    const GridBox &box = grid.box;
    for (size_t pass = 0; pass < passes; ++pass)
        for (size_t axis = 0; axis < 3; ++axis) {
            // Rows along the axis; those that begin in one plane or line, at a time
            const size_t outer = axis == 2 ? 1 : 2, inner = axis == 0 ? 1 : 0;
            ParallelFor(box.size[outer], [&](size_t a) {
                for (size_t b = 0; b < box.size[inner]; ++b)
                    SmoothRow(&grid.values[a * box.Stride(outer) + b * box.Stride(inner)], box.size[axis],
                              box.Stride(axis));
            });
        }
    return grid;
}
//<

//> Add up masses, lengths and bounds
double Mass(const DenseGrid<float> &density) {
    const double sum = ParallelReduce(
        density.values.size(), 65536, 0.,
        [&](size_t first, size_t last) {
            double part = 0;
            for (size_t i = first; i < last; ++i)
                part += static_cast<double>(density.values[i]);
            return part;
        },
        [](double *total, double part) { *total += part; });
    const double cell = static_cast<double>(density.box.cell);
    return sum * cell * cell * cell;
}

Bounds3f BoundsOf(const StrandSet &strands) {
    return ParallelReduce(
        strands.count, 512, Bounds3f{},
        [&](size_t first, size_t last) {
            Bounds3f bounds;
            StrandRun run;
            for (size_t i = first; i < last; ++i) {
                run.Clear();
                strands.read(i, &run);
                for (const Point3f &p : run.points) {
                    if (!IsWithinReach(p))
                        throw Error("a point of strand {} is at ({}, {}, {})", i, p.x, p.y, p.z)
                            .WithRemedy("coordinates go to {:g}", kMaxCoordinate);
                    bounds.Extend(p);
                }
            }
            return bounds;
        },
        [](Bounds3f *total, const Bounds3f &part) { total->Extend(part); });
}

StrandTotals TotalsOf(const StrandSet &strands) {
    return ParallelReduce(
        strands.count, 512, StrandTotals{},
        [&](size_t first, size_t last) {
            StrandTotals part;
            StrandRun run;
            for (size_t i = first; i < last; ++i) {
                run.Clear();
                strands.read(i, &run);
                part.points += run.points.size();
                for (size_t k = 0; k + 1 < run.points.size(); ++k) {
                    const double length = (Vector3d(run.points[k + 1]) - Vector3d(run.points[k])).Length();
                    part.length += length;
                    if (run.widths.empty())
                        continue;
                    // Of a cone's frustum: widths vary along it
                    const double a = static_cast<double>(run.widths[k]),
                                 b = static_cast<double>(run.widths[k + 1]);
                    part.volume += length * kPi<double> / 12 * (a * a + a * b + b * b);
                }
            }
            return part;
        },
        [](StrandTotals *total, const StrandTotals &part) {
            total->points += part.points;
            total->length += part.length;
            total->volume += part.volume;
        });
}
//<

} // namespace cuticle
//<
