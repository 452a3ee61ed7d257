// Laws of the density: mass, resampling, threads, and the tent against plain sums.
#include "volume/density.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/sampling.h"

#include <gtest/gtest.h>

#include <cstring>

namespace cuticle {
namespace {

// Crooked strands with widths, inside [-1, 1]^3 by nature of what they are made of.
struct Strands {
    std::vector<Point3f> points;
    std::vector<float> widths;
    std::vector<uint32_t> offsets{0};
    StrandSet Set(bool wide = true) const {
        return StrandsOf(points, wide ? std::span<const float>(widths) : std::span<const float>(), offsets);
    }
};
Strands RandomStrands(size_t count, size_t pointsEach, uint64_t seed) {
    RNG rng(seed);
    const auto coordinate = [&] { return 2 * rng.UniformFloat() - 1; };
    Strands s;
    for (size_t i = 0; i < count; ++i) {
        Point3f p{coordinate(), coordinate(), coordinate()};
        for (size_t k = 0; k < pointsEach; ++k) {
            s.points.push_back(p);
            s.widths.push_back(0.01f + 0.02f * rng.UniformFloat());
            p = p * 0.8f + Vector3f{coordinate(), coordinate(), coordinate()} * 0.2f;
        }
        s.offsets.push_back(static_cast<uint32_t>(s.points.size()));
    }
    return s;
}
// The same curves with every line cut into pieces, so that the new points lie on the old lines to rounding.
Strands Resampled(const Strands &from, size_t pieces) {
    Strands s;
    for (size_t i = 0; i + 1 < from.offsets.size(); ++i) {
        for (uint32_t k = from.offsets[i]; k + 1 < from.offsets[i + 1]; ++k)
            for (size_t j = 0; j < pieces; ++j) {
                // Uneven pieces: the square of an even step
                const float t = Sqr(static_cast<float>(j) / static_cast<float>(pieces));
                s.points.push_back(from.points[k] + (from.points[k + 1] - from.points[k]) * t);
                s.widths.push_back(Lerp(t, from.widths[k], from.widths[k + 1]));
            }
        s.points.push_back(from.points[from.offsets[i + 1] - 1]);
        s.widths.push_back(from.widths[from.offsets[i + 1] - 1]);
        s.offsets.push_back(static_cast<uint32_t>(s.points.size()));
    }
    return s;
}
GridBox TestBox(float cell = 0.1f) { return BoxAround({{-1, -1, -1}, {1, 1, 1}}, cell, 1); }
float MaxOf(const DenseGrid<float> &grid) {
    return *std::max_element(grid.values.begin(), grid.values.end());
}
float MaxDifference(const DenseGrid<float> &a, const DenseGrid<float> &b) {
    float most = 0;
    for (size_t i = 0; i < a.values.size(); ++i)
        most = std::max(most, std::abs(a.values[i] - b.values[i]));
    return most;
}

TEST(Tent, WeightsArePartitionOfUnityAndTheirDerivativesAreDifferences) {
    const GridBox::Vertex size{4, 5, 6};
    RNG rng(1);
    for (int n = 0; n < 200; ++n) {
        const Vector3d p{3. * static_cast<double>(rng.UniformFloat()),
                         4. * static_cast<double>(rng.UniformFloat()),
                         5. * static_cast<double>(rng.UniformFloat())};
        const TentWeights<double> tent(size, p);
        ASSERT_TRUE(tent.isInside);
        double sum = 0;
        Vector3d mean, slope;
        for (size_t c = 0; c < 8; ++c) {
            const Vector3d corner{static_cast<double>(tent.low[0] + (c & 1)),
                                  static_cast<double>(tent.low[1] + (c >> 1 & 1)),
                                  static_cast<double>(tent.low[2] + (c >> 2))};
            // Equation 1 as it is printed
            const Vector3d d = p - corner;
            EXPECT_NEAR(tent(c), (1 - std::abs(d.x)) * (1 - std::abs(d.y)) * (1 - std::abs(d.z)), 1e-15);
            sum += tent(c), mean += corner * tent(c), slope += tent.Gradient(c);
            for (size_t axis = 0; axis < 3; ++axis) { // linear in each coordinate: any step is exact
                TentWeights<double> up = tent, down = tent;
                up.at[axis] = 1, down.at[axis] = 0;
                EXPECT_NEAR(tent.Gradient(c)[axis], up(c) - down(c), 1e-15);
            }
        }
        EXPECT_NEAR(sum, 1, 1e-15);
        EXPECT_LT((mean - p).Length(), 1e-14); // the centre of mass stays
        EXPECT_LT(slope.Length(), 1e-14);
    }
}

TEST(Tent, PointsOnTheWallsOfTheBoxAreInsideAndOthersOutside) {
    const GridBox::Vertex size{3, 3, 3};
    for (const double x : {0., 1., 2.})
        EXPECT_TRUE(TentWeights<double>(size, {x, 2., 0.}).isInside) << x;
    for (const double x : {-1e-9, 2 + 1e-9, HUGE_VAL, -HUGE_VAL, std::nan("")})
        EXPECT_FALSE(TentWeights<double>(size, {x, 1., 1.}).isInside) << x;
    EXPECT_FALSE(TentWeights<double>({3, 1, 3}, {1., 0., 1.}).isInside) << "a plane has no cells";
}

TEST(Density, VerticesAndLengthsAndVolumesAreKept) {
    const Strands s = RandomStrands(300, 12, 2);
    const GridBox box = TestBox();
    const double cell = static_cast<double>(box.cell);
    EXPECT_NEAR(Mass(VertexDensity(s.Set(), box)) / Sqr(cell) / cell, 3600, 1e-3);
    const StrandTotals totals = TotalsOf(s.Set());
    EXPECT_EQ(totals.points, 3600u);
    EXPECT_NEAR(Mass(LineDensity(s.Set(false), box)) / totals.length, 1, 1e-6);
    EXPECT_NEAR(Mass(LineDensity(s.Set(), box)) / totals.volume, 1, 1e-6);
    EXPECT_EQ(TotalsOf(s.Set(false)).volume, 0);
}

// The law that the paper's density breaks.
TEST(Density, OfLinesDoesNotSeeResamplingThatOfVerticesDoes) {
    const Strands s = RandomStrands(200, 10, 3), fine = Resampled(s, 7);
    const GridBox box = TestBox();
    for (const bool wide : {false, true}) {
        const DenseGrid<float> a = LineDensity(s.Set(wide), box), b = LineDensity(fine.Set(wide), box);
        // New points are rounded to binary32: 1e-7 of a coordinate, which is 1e-6 of a cell
        EXPECT_LT(MaxDifference(a, b), 4e-6f * MaxOf(a)) << wide;
    }
    const DenseGrid<float> a = VertexDensity(s.Set(), box), b = VertexDensity(fine.Set(), box);
    EXPECT_GT(MaxDifference(a, b), 2 * MaxOf(a));
}

// Midpoint sums that know nothing of cells.
TEST(Density, OfALineIsTheIntegralOfTheTent) {
    const std::vector<Point3f> points{{-0.83f, -0.41f, 0.2f}, {0.71f, 0.66f, -0.55f}};
    const std::vector<float> widths{0.2f, 0.05f};
    const std::vector<uint32_t> offsets{0, 2};
    const GridBox box = TestBox(0.23f);
    const DenseGrid<float> grid = LineDensity(StrandsOf(points, widths, offsets), box);
    constexpr int n = 100000;
    const Vector3d a(points[0]), b(points[1]);
    const double step = (b - a).Length() / n, cell = static_cast<double>(box.cell);
    std::vector<double> sums(box.Count());
    for (int i = 0; i < n; ++i) {
        const double t = (i + 0.5) / n, w = Lerp(t, 0.2, 0.05);
        const Vector3d p = (a + (b - a) * t - Vector3d(box.origin)) / cell;
        for (size_t z = 0; z < box.size[2]; ++z)
            for (size_t y = 0; y < box.size[1]; ++y)
                for (size_t x = 0; x < box.size[0]; ++x) {
                    const double dx = std::abs(p.x - static_cast<double>(x)),
                                 dy = std::abs(p.y - static_cast<double>(y)),
                                 dz = std::abs(p.z - static_cast<double>(z));
                    if (dx < 1 && dy < 1 && dz < 1)
                        sums[box.Index(x, y, z)] += (1 - dx) * (1 - dy) * (1 - dz) * step * kPi<double> / 4 *
                                                    w * w / (cell * cell * cell);
                }
    }
    const double most = *std::max_element(sums.begin(), sums.end());
    for (size_t i = 0; i < sums.size(); ++i)
        ASSERT_NEAR(static_cast<double>(grid.values[i]), sums[i], 3e-7 * most) << i;
}

TEST(Density, IsTheSameBitsForAnyNumberOfThreads) {
    const Strands s = RandomStrands(9000, 3, 4); // more than one batch
    const GridBox box = TestBox(0.07f);
    DenseGrid<float> one, vertices;
    OnOneThread([&] { one = LineDensity(s.Set(), box), vertices = VertexDensity(s.Set(), box); });
    for (const size_t threads : {2, 7})
        OnThreads(threads, [&] {
            const DenseGrid<float> many = LineDensity(s.Set(), box);
            EXPECT_EQ(std::memcmp(many.values.data(), one.values.data(), one.Bytes()), 0) << threads;
            EXPECT_EQ(std::memcmp(VertexDensity(s.Set(), box).values.data(), vertices.values.data(),
                                  vertices.Bytes()),
                      0);
        });
}

// Parallel fibers, much finer than the cells, fill a known share of their section.
TEST(Density, OfADenseBundleIsTheShareOfSpaceThatItFills) {
    Strands s;
    for (int i = 0; i < 40; ++i)
        for (int j = 0; j < 40; ++j) {
            const float x = (static_cast<float>(i) + 0.5f) / 20 - 1,
                        y = (static_cast<float>(j) + 0.5f) / 20 - 1;
            s.points.insert(s.points.end(), {{x, y, -1}, {x, y, 1}});
            s.widths.insert(s.widths.end(), {0.01f, 0.01f});
            s.offsets.push_back(static_cast<uint32_t>(s.points.size()));
        }
    const DenseGrid<float> grid = LineDensity(s.Set(), TestBox(0.25f));
    EXPECT_NEAR(grid.Sample({0.01f, -0.02f, 0.03f}), Pi / 4 * Sqr(0.01f) * 20 * 20, 1e-6);
}

TEST(Density, LinesOutsideOfTheBoxAreCutOff) {
    const std::vector<Point3f> points{{-1e6f, 0, 0}, {1e6f, 0, 0}, {0, 0, 50}, {0, 0, 60}};
    const std::vector<uint32_t> offsets{0, 2, 4};
    const GridBox box{{-1, -1, -1}, 0.5f, {5, 5, 5}};
    const DenseGrid<float> grid = LineDensity(StrandsOf(points, {}, offsets), box);
    EXPECT_NEAR(Mass(grid), 2, 1e-5); // as much of the first as lies inside
    EXPECT_EQ(grid.At(2, 2, 0), 0);
}

TEST(Density, BoxesThatCannotBeAreRefused) {
    EXPECT_THROW(BoxAround({}, 1, 1), Error);
    EXPECT_THROW(BoxAround({{0, 0, 0}, {1, 1, 1}}, 0, 1), Error);
    EXPECT_THROW(BoxAround({{0, 0, 0}, {1, 1, 1}}, std::nanf(""), 1), Error);
    EXPECT_THROW(BoxAround({{0, 0, 0}, {1, 1, 1}}, 1e-4f, 1), Error);
    EXPECT_THROW(BoxAround({{0, 0, 0}, {1e18f, 1, 1}}, 1e-20f, 1), Error);
    const std::vector<Point3f> points{{0, 0, 0}, {std::nanf(""), 0, 0}};
    const std::vector<uint32_t> offsets{0, 2};
    EXPECT_THROW(BoundsOf(StrandsOf(points, {}, offsets)), Error);
}

TEST(Density, CurvesOfAGroomAreAsLongAsTheirPieces) {
    Groom groom;
    groom.points = {{0, 0, 0}, {1, 1, 0}, {2, 0, 0}, {5, 5, 5}};
    groom.strandOffsets = {0, 3, 4};
    groom.width = 0.1f;
    const StrandTotals straight = TotalsOf(ControlPoints(groom)), curved = TotalsOf(CurvesOf(groom, 64));
    EXPECT_EQ(straight.points, 4u);
    EXPECT_NEAR(straight.length, 2 * std::sqrt(2.), 1e-6);
    EXPECT_GT(curved.length, straight.length * 1.01); // it bends through the points
    EXPECT_LT(curved.length, straight.length * 1.3);
    EXPECT_NEAR(curved.volume, curved.length * kPi<double> / 4 * 0.01, 1e-4);
}

// One point spreads to the binomial weights; next to a wall too nothing is lost.
TEST(Grid, SmoothingIsBinomialAndKeepsTheSum) {
    DenseGrid<float> grid(GridBox{{}, 1, {7, 8, 9}});
    grid.At(3, 3, 3) = 64;
    grid.At(0, 7, 8) = 1;
    const DenseGrid<float> once = Smoothed(grid, 1), often = Smoothed(grid, 4);
    EXPECT_EQ(once.At(3, 3, 3), 8);
    EXPECT_EQ(once.At(3, 4, 3), 4);
    EXPECT_EQ(once.At(2, 3, 4), 2);
    EXPECT_EQ(once.At(2, 4, 4), 1);
    EXPECT_EQ(once.At(5, 3, 3), 0);
    EXPECT_NEAR(Mass(once), 65, 1e-4);
    EXPECT_NEAR(Mass(often), 65, 1e-4);
}

// The gradient of a linear field is constant everywhere, of the grid's sampled field too.
TEST(Grid, SamplesAndGradientsOfALinearFieldAreExact) {
    DenseGrid<float> grid(GridBox{{1, 2, 3}, 0.5f, {5, 4, 3}});
    for (size_t k = 0; k < 3; ++k)
        for (size_t j = 0; j < 4; ++j)
            for (size_t i = 0; i < 5; ++i) {
                const Point3f p = grid.box.Position(i, j, k);
                grid.At(i, j, k) = 2 * p.x - 3 * p.y + 5 * p.z;
            }
    for (const Point3f &p : {Point3f{1, 2, 3}, {1.3f, 2.9f, 3.7f}, {3, 3.5f, 4}}) {
        EXPECT_NEAR(grid.Sample(p), 2 * p.x - 3 * p.y + 5 * p.z, 1e-5f);
        EXPECT_LT((SampleGradient(grid, p) - Vector3f{2, -3, 5}).Length(), 1e-4f);
    }
    EXPECT_EQ(grid.Sample({-100, std::nanf(""), 100}), grid.At(0, 0, 2)); // clamped
}

} // namespace
} // namespace cuticle
