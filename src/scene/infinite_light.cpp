#include "core/sampling.h"
#include "scene/light_makers.h"
#include "scene/light_map.h"

#include <cmath>

namespace cuticle {

namespace {

class ConstantInfiniteLight : public Light {
  public:
    ConstantInfiniteLight(const Spectrum &L, float worldRadius) : L_(L), worldRadius_(worldRadius) {}
    bool Sample_Li(const Point3f &, const Point2f &u, LightSample *sample) const override {
        *sample = {UniformSampleSphere(u), UniformSpherePdf(), Infinity, L_, false};
        return !L_.IsBlack();
    }
    float Pdf_Li(const Point3f &, const Vector3f &) const override {
        return L_.IsBlack() ? 0 : UniformSpherePdf();
    }
    Spectrum Le(const Ray &) const override { return L_; }
    // Every direction sends L through the disk of the bounding sphere (pbrt-v3 omits the 4 pi).
    Spectrum Power() const override { return L_ * (4 * Pi * Pi * Sqr(worldRadius_)); }
    LightKind Kind() const override { return LightKind::Infinite; }

  private:
    Spectrum L_;
    float worldRadius_;
};

// Shrinks a row of equal cells to `cells` equal cells, each the mean of what it covers.
void ShrinkRow(std::vector<float> *row, size_t cells) {
    const size_t n = row->size();
    if (cells >= n)
        return;
    std::vector<float> out(cells);
    const double ratio = static_cast<double>(n) / static_cast<double>(cells);
    for (size_t i = 0; i < cells; ++i) {
        const double begin = ratio * static_cast<double>(i), end = ratio * static_cast<double>(i + 1);
        double sum = 0;
        for (auto k = static_cast<size_t>(begin); k < n && static_cast<double>(k) < end; ++k)
            sum += double{(*row)[k]} *
                   (std::min(end, static_cast<double>(k + 1)) - std::max(begin, static_cast<double>(k)));
        out[i] = static_cast<float>(sum / ratio);
    }
    *row = std::move(out);
}

// An environment map with pbrt-v3's orientation: theta from +z down the rows, phi from +x along them. It is
// held at the poles (pbrt-v3 wraps there too, which mixes zenith and nadir).
class MapInfiniteLight : public Light {
  public:
    MapInfiniteLight(const Transform &lightToWorld, LightMap map, float worldRadius)
        : map_(std::move(map)), worldRadius_(worldRadius), worldToLight_(lightToWorld.Inverse()),
          lightToWorld_(lightToWorld), meanRadiance_(map_.MeanOverSphere()) {
        BuildDistribution();
    }

    bool Sample_Li(const Point3f &, const Point2f &u, LightSample *sample) const override {
        float mapPdf;
        const Point2f uv = distribution_->SampleContinuous(u, &mapPdf);
        // Within a row of cells cos theta is uniform, so the density per solid angle is constant in a cell
        // and has no pole.
        const double v = double{uv.y} * static_cast<double>(Rows());
        const size_t row = std::min(static_cast<size_t>(v), Rows() - 1);
        const double z =
            Lerp(std::clamp(v - static_cast<double>(row), 0., 1.), cosTheta_[row], cosTheta_[row + 1]);
        const double sinTheta = std::sqrt(std::max(0., (1 - z) * (1 + z)));
        const double phi = 2 * kPi<double> * double{uv.x};
        const Vector3f local(Vector3d(sinTheta * std::cos(phi), sinTheta * std::sin(phi), z));
        const Vector3f wi = Normalize(lightToWorld_.Vector(local));
        // Look up the rounded direction, as a ray that finds it by other means will
        const Vector3f w = worldToLight_.Vector(wi);
        const Point2f found = SphericalMapPoint(w);
        *sample = {wi, Density(found, w), Infinity, map_.Lookup(found.x, found.y), false};
        return sample->pdf > 0 && !sample->L.IsBlack();
    }

    float Pdf_Li(const Point3f &, const Vector3f &wi) const override {
        const Vector3f w = worldToLight_.Vector(wi);
        return Density(SphericalMapPoint(w), w);
    }

    Spectrum Le(const Ray &ray) const override {
        const Point2f uv = SphericalMapPoint(worldToLight_.Vector(ray.d));
        return map_.Lookup(uv.x, uv.y);
    }

    Spectrum Power() const override { return meanRadiance_ * (4 * Pi * Pi * Sqr(worldRadius_)); }
    LightKind Kind() const override { return LightKind::Infinite; }

  private:
    // The size of the sampling table is at most this (16 MB); finer maps are averaged.
    static constexpr size_t kMaxColumns = 2048, kMaxRows = 1024;
    size_t Rows() const { return cosTheta_.size() - 1; } // of the sampling table

    // Builds the sampling table of cells of half a texel: over each the interpolated map is one bilinear
    // patch, whose mean is its value at the centre. So a cell has probability 0 only if the map is black all
    // over it.
    void BuildDistribution() {
        const size_t width = 2 * map_.Width(), height = 2 * map_.Height(); // of half texels
        const size_t columns = std::min(width, kMaxColumns), rows = std::min(height, kMaxRows);
        for (size_t j = 0; j < rows; ++j)
            cosTheta_.push_back(std::cos(kPi<double> * static_cast<double>(j) / static_cast<double>(rows)));
        cosTheta_.push_back(-1);

        std::vector<float> cells(columns * rows);
        // Fine rows go to the coarse rows they overlap, by the share of the coarse row that they cover.
        const double ratio = static_cast<double>(rows) / static_cast<double>(height);
        for (size_t y = 0; y < height; ++y) {
            const std::vector<float> line = RowImportance(y, columns);
            const double begin = static_cast<double>(y) * ratio, end = static_cast<double>(y + 1) * ratio;
            for (auto j = static_cast<size_t>(begin); j < rows && static_cast<double>(j) < end; ++j) {
                const double first = static_cast<double>(j);
                const double share = std::min(end, first + 1) - std::max(begin, first);
                for (size_t x = 0; share > 0 && x < columns; ++x)
                    cells[j * columns + x] += static_cast<float>(share) * line[x];
            }
        }
        for (size_t j = 0; j < rows; ++j) {
            const auto band = static_cast<float>(cosTheta_[j] - cosTheta_[j + 1]);
            for (size_t x = 0; x < columns; ++x)
                cells[j * columns + x] *= band;
        }
        distribution_ = std::make_unique<Distribution2D>(cells.data(), columns, rows);
        const Transform::Matrix &m = worldToLight_.M();
        determinant_ = std::abs(worldToLight_.Determinant() / (m[3][3] * m[3][3] * m[3][3]));
    }

    // The importance of row y of half texels, in `columns` cells.
    std::vector<float> RowImportance(size_t y, size_t columns) const {
        std::vector<float> line(2 * map_.Width());
        const auto centre = [](size_t i, size_t n) {
            return (static_cast<float>(i) + 0.5f) / static_cast<float>(n);
        };
        const float v = centre(y, 2 * map_.Height());
        for (size_t x = 0; x < line.size(); ++x)
            line[x] = Importance(map_.Lookup(centre(x, line.size()), v));
        ShrinkRow(&line, columns);
        return line;
    }

    // Luminance, and a little of each channel: a saturated blue has next to no luminance, yet must be found.
    static float Importance(const Spectrum &s) { return 0.9f * s.y() + 0.1f * ((s[0] + s[1] + s[2]) / 3); }

    // The density per steradian of the world, of the direction whose image in the light's space is w, at map
    // point uv.
    float Density(const Point2f &uv, const Vector3f &w) const {
        const auto rows = static_cast<float>(Rows());
        const size_t row = std::min(static_cast<size_t>(uv.y * rows), Rows() - 1);
        const double solidAngle = 2 * kPi<double> * (cosTheta_[row] - cosTheta_[row + 1]) * double{rows};
        const float middle = (static_cast<float>(row) + 0.5f) / rows;
        const double pdf = double{distribution_->Pdf({uv.x, middle})} / solidAngle;
        // A transformation that is no rotation spreads directions unevenly: d omega in the light's space per
        // d omega in the world is |det| / |w|^3 for a direction of unit length.
        const double length2{w.LengthSquared()};
        return static_cast<float>(pdf * determinant_ / (length2 * std::sqrt(length2)));
    }
    LightMap map_;
    float worldRadius_;
    Transform worldToLight_, lightToWorld_;
    double determinant_ = 1; // |det| of worldToLight_
    Spectrum meanRadiance_;
    std::vector<double> cosTheta_; // at the borders of the table's rows, from 1 to -1
    std::unique_ptr<Distribution2D> distribution_;
};

} // namespace

std::unique_ptr<Light> MakeInfinite(const LightEntity &entity, const Bounds3f &worldBound) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    const Spectrum scale = ScaledLightValue(params, "L", "infinite");
    const float radius = WorldRadius(worldBound);
    std::unique_ptr<Light> light;
    if (params.FindFilename("mapname").empty())
        light = std::make_unique<ConstantInfiniteLight>(scale, radius);
    else
        light = std::make_unique<MapInfiniteLight>(entity.ctm,
                                                   LightMap(params, scale, LightMap::Border::Around), radius);
    light->SetSamples(params.FindInt("samples", params.FindInt("nsamples", 1)));
    return light;
}

} // namespace cuticle
