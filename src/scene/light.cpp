#include "scene/light.h"

#include "core/error.h"
#include "core/sampling.h"
#include "images/image.h"

#include <array>
#include <string>

namespace cuticle {

namespace {

// --- reading parameters ----------------------------------------------------------------------------------------

// What is brighter could leave binary32 when a sharp lobe multiplies it near by. The sun's disk has a radiance of 1e7
// W/(m^2 sr).
constexpr float kBrightest = 1e18f;

// A light sends no negative, undefined or absurd amounts.
Spectrum NonNegative(Spectrum s, const FileLoc &loc, const std::string &what) {
    for (int i = 0; i < 3; ++i)
        if (!(s[i] >= 0 && s[i] <= kBrightest)) {
            const float used = s[i] > kBrightest && s[i] < Infinity ? kBrightest : 0;
            Warning(loc, "light value out of range",
                    what + " has the value " + std::to_string(s[i]) + ", which is set to " +
                        (used > 0 ? "1e18" : "0"));
            s[i] = used;
        }
    return s;
}

Spectrum Scaled(const ParamSet &params, const char *name, const std::string &light) {
    const Spectrum value = params.FindSpectrum(name, Spectrum(1.f)),
                   scale = params.FindSpectrum("scale", Spectrum(1.f));
    return NonNegative(value * scale, params.loc, light + " light: " + name + " times scale");
}

// Radius of the scene's bounding sphere; 1 for an empty scene.
float WorldRadius(const Bounds3f &b) {
    const float r = b.IsEmpty() ? 0 : b.Diagonal().Length() / 2;
    return r > 0 && r < Infinity ? r : 1;
}

void RequireInvertible(const LightEntity &entity) {
    if (entity.ctm.IsSingular())
        throw Error(entity.params.loc, entity.type + " light: its transformation has no inverse");
}

// --- maps ------------------------------------------------------------------------------------------------------

// (phi / 2 pi, theta / pi) of a direction of any length, theta from +z, phi from +x; each in [0, 1).
Point2f SphericalMapPoint(const Vector3f &w) {
    float phi = std::atan2(w.y, w.x);
    if (phi < 0)
        phi += 2 * Pi;
    const float theta = std::atan2(std::sqrt(w.x * w.x + w.y * w.y), w.z);
    return {std::min(phi * (0.5f / Pi), OneMinusEpsilon), std::min(theta * (1 / Pi), OneMinusEpsilon)};
}

// The picture that a light shows, v down its rows. As in pbrt-v3, values of 8-bit files are taken as linear.
class LightMap {
  public:
    // Around: the left and the right border are one, as in a map of the sphere.
    enum class Border { Around, Held };

    // The file that "mapname" names, times scale; scale everywhere where there is no such parameter. Error at the parameter when the
    // file cannot be used. Values that are negative or not finite are set to 0 with a Warning.
    LightMap(const ParamSet &params, const Spectrum &scale, Border border);

    int Width() const { return width_; }
    int Height() const { return height_; }
    // Bilinear between texel centres; held at the borders, but where they are one.
    Spectrum Lookup(float u, float v) const {
        const auto clamped = [](float x, int size) {
            return std::clamp(x * static_cast<float>(size) - 0.5f, 0.f, static_cast<float>(size - 1));
        };
        const bool around = border_ == Border::Around;
        const float x = around ? u * static_cast<float>(width_) - 0.5f : clamped(u, width_);
        const float y = clamped(v, height_);
        const float xFloor = std::floor(x), yFloor = std::floor(y), fx = x - xFloor, fy = y - yFloor;
        const int left = static_cast<int>(xFloor), y0 = static_cast<int>(yFloor);
        const int x0 = around ? (left + width_) % width_ : left;
        const int x1 = around ? (x0 + 1) % width_ : std::min(left + 1, width_ - 1);
        const int y1 = std::min(y0 + 1, height_ - 1);
        return (Texel(x0, y0) * (1 - fx) + Texel(x1, y0) * fx) * (1 - fy) +
               (Texel(x0, y1) * (1 - fx) + Texel(x1, y1) * fx) * fy;
    }
    // The mean of Lookup over all directions, the map being one of the sphere.
    Spectrum MeanOverSphere() const;

  private:
    const Spectrum &Texel(int x, int y) const {
        return texels_[static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)];
    }

    int width_ = 1, height_ = 1;
    Border border_ = Border::Held;
    std::vector<Spectrum> texels_;
};

LightMap::LightMap(const ParamSet &params, const Spectrum &scale, Border border) : border_(border) {
    const std::string filename = params.FindFilename("mapname");
    if (filename.empty()) {
        texels_.assign(1, scale);
        return;
    }
    const FileLoc &loc = params.Find("mapname")->loc;
    Image image;
    try {
        image = ReadImage(filename, false);
    } catch (const Error &e) {
        throw Error(loc, "the light's map cannot be used: " + e.Message());
    }
    width_ = image.width, height_ = image.height;
    if (width_ < 1 || height_ < 1 || width_ > (1 << 20) || height_ > (1 << 20))
        throw Error(loc, filename + ": " + std::to_string(width_) + " x " + std::to_string(height_) +
                             " pixels are no map of a light");
    texels_.resize(static_cast<size_t>(width_) * static_cast<size_t>(height_));
    size_t bad = 0, i = 0;
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x, ++i) {
            const Spectrum s = image.RGB(x, y) * scale;
            for (int c = 0; c < 3; ++c) {
                const bool good = s[c] >= 0 && s[c] <= kBrightest;
                texels_[i][c] = good ? s[c] : 0;
                bad += !good;
            }
        }
    if (bad > 0)
        Warning(loc, "map values out of range",
                filename + ": " + std::to_string(bad) +
                    " values are negative, NaN, infinite or above 1e18, and set to 0");
}

Spectrum LightMap::MeanOverSphere() const {
    // Between the centres of two rows at theta0 and theta1 their weights are linear; times sin theta, integrated.
    const double step = kPi<double> / height_;
    std::vector<double> weight(static_cast<size_t>(height_), 0);
    weight.front() += 1 - std::cos(step / 2);
    weight.back() += 1 - std::cos(step / 2);
    for (size_t j = 0; j + 1 < weight.size(); ++j) {
        const double theta0 = step * (static_cast<double>(j) + 0.5), theta1 = theta0 + step;
        const double slope = (std::sin(theta1) - std::sin(theta0)) / step;
        weight[j] += std::cos(theta0) - slope;
        weight[j + 1] += slope - std::cos(theta1);
    }
    std::array<double, 3> total{};
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x)
            for (int c = 0; c < 3; ++c)
                total[static_cast<size_t>(c)] +=
                    weight[static_cast<size_t>(y)] * static_cast<double>(Texel(x, y)[c]);
    const auto mean = [&](size_t c) { return static_cast<float>(total[c] / (2. * width_)); };
    return {mean(0), mean(1), mean(2)};
}

// --- lights at a point -----------------------------------------------------------------------------------------

class PointLight : public Light {
  public:
    PointLight(const Point3f &p, const Spectrum &I) : p_(p), I_(I) {}
    bool Sample_Li(const Point3f &ref, const Point2f &, LightSample *sample) const override {
        const Vector3f toLight = p_ - ref;
        const float d2 = toLight.LengthSquared();
        const Spectrum I = I_ * Falloff(-toLight);
        if (!(d2 > 0 && d2 < Infinity) || I.IsBlack())
            return false;
        const float d = std::sqrt(d2);
        *sample = {toLight / d, 1, d, I / d2, true};
        return sample->L.IsFinite();
    }
    Spectrum Power() const override { return I_ * (4 * Pi); }
    bool IsDelta() const override { return true; }

  protected:
    // Relative intensity toward w, of any length.
    virtual Spectrum Falloff(const Vector3f & /*w*/) const { return Spectrum(1.f); }
    Point3f p_;
    Spectrum I_;
};

// A point light in a cone around +z of its own space; smooth from falloffStart to totalWidth (pbrt-v3,
// 12.3.1).
class SpotLight : public PointLight {
  public:
    SpotLight(const Transform &lightToWorld, const Spectrum &I, float totalWidth, float falloffStart)
        : PointLight(lightToWorld.Point({}), I), worldToLight_(lightToWorld.Inverse()),
          cosTotalWidth_(std::cos(Radians(totalWidth))), cosFalloffStart_(std::cos(Radians(falloffStart))) {}
    Spectrum Power() const override {
        return I_ * (2 * Pi * (1 - 0.5f * (cosFalloffStart_ + cosTotalWidth_)));
    }

  protected:
    Spectrum Falloff(const Vector3f &w) const override {
        const Vector3f local = worldToLight_.Vector(w);
        const float cosTheta = local.z / local.Length();
        if (!(cosTheta >= cosTotalWidth_))
            return Spectrum(0.f);
        if (cosTheta >= cosFalloffStart_)
            return Spectrum(1.f);
        const float delta = (cosTheta - cosTotalWidth_) / (cosFalloffStart_ - cosTotalWidth_);
        return Spectrum(Sqr(Sqr(delta)));
    }

  private:
    Transform worldToLight_;
    float cosTotalWidth_, cosFalloffStart_;
};

// A point light whose intensity over directions is a map of the sphere: theta from its own +y down the rows, phi from +x
// toward +z along them (pbrt-v3, 12.3.3). pbrt-v3 weighs all pixels alike in the power, which is the mean over directions
// here; it only decides how often a light is sampled.
class GoniometricLight : public PointLight {
  public:
    GoniometricLight(const Transform &lightToWorld, const Spectrum &I, LightMap map)
        : PointLight(lightToWorld.Point({}), I), worldToLight_(lightToWorld.Inverse()), map_(std::move(map)) {
    }
    Spectrum Power() const override { return I_ * map_.MeanOverSphere() * (4 * Pi); }

  protected:
    Spectrum Falloff(const Vector3f &w) const override {
        const Vector3f local = worldToLight_.Vector(w);
        const Point2f uv = SphericalMapPoint({local.x, local.z, local.y});
        return map_.Lookup(uv.x, uv.y);
    }

  private:
    Transform worldToLight_;
    LightMap map_;
};

// A slide projector along +z of its own space (pbrt-v3, 12.3.2). fov spans the picture's shorter side. The top row of the
// picture is at -y, as in pbrt-v3: in the space of a camera that sees y upward it hangs upside down. pbrt-v3 repeats the
// picture at its borders, which mixes opposite ones over half a pixel; here they are held.
class ProjectionLight : public PointLight {
  public:
    ProjectionLight(const Transform &lightToWorld, const Spectrum &I, LightMap map, float fov)
        : PointLight(lightToWorld.Point({}), I), worldToLight_(lightToWorld.Inverse()), map_(std::move(map)) {
        const float aspect = static_cast<float>(map_.Width()) / static_cast<float>(map_.Height());
        const float tanHalf = std::tan(Radians(fov) / 2);
        xMax_ = tanHalf * std::max(1.f, aspect);
        yMax_ = tanHalf * std::max(1.f, 1 / aspect);
    }
    // By the solid angle of each of many cells of the picture (pbrt-v3 takes the cone around it).
    Spectrum Power() const override;

  protected:
    Spectrum Falloff(const Vector3f &w) const override {
        const Vector3f local = worldToLight_.Vector(w);
        if (!(local.z > 0))
            return Spectrum(0.f);
        const float x = local.x / (local.z * xMax_), y = local.y / (local.z * yMax_);
        if (!(std::abs(x) <= 1 && std::abs(y) <= 1))
            return Spectrum(0.f);
        return map_.Lookup(0.5f + 0.5f * x, 0.5f + 0.5f * y);
    }

  private:
    Transform worldToLight_;
    LightMap map_;
    float xMax_, yMax_; // half sizes of the picture on the plane z = 1
};

Spectrum ProjectionLight::Power() const {
    // Solid angle of the rectangle from the axis to (x, y) of the plane z = 1, negative where one of them is.
    const auto corner = [](double x, double y) { return std::atan(x * y / std::sqrt(1 + x * x + y * y)); };
    const auto cells = [](int pixels) { return 2 * pixels * std::max(1, 32 / pixels); };
    const int nx = cells(map_.Width()), ny = cells(map_.Height());
    const double xMax = static_cast<double>(xMax_), yMax = static_cast<double>(yMax_);
    std::array<double, 3> total{};
    for (int j = 0; j < ny; ++j) {
        const double y0 = yMax * (2. * j / ny - 1), y1 = yMax * (2. * (j + 1) / ny - 1);
        for (int i = 0; i < nx; ++i) {
            const double x0 = xMax * (2. * i / nx - 1), x1 = xMax * (2. * (i + 1) / nx - 1);
            const double solidAngle = corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0);
            const Spectrum s = map_.Lookup((static_cast<float>(i) + 0.5f) / static_cast<float>(nx),
                                           (static_cast<float>(j) + 0.5f) / static_cast<float>(ny));
            for (int c = 0; c < 3; ++c)
                total[static_cast<size_t>(c)] += solidAngle * static_cast<double>(s[c]);
        }
    }
    return I_ *
           Spectrum(static_cast<float>(total[0]), static_cast<float>(total[1]), static_cast<float>(total[2]));
}

// --- lights far away -------------------------------------------------------------------------------------------

class DistantLight : public Light {
  public:
    DistantLight(const Vector3f &wLight, const Spectrum &L, float worldRadius)
        : wLight_(wLight), L_(L), worldRadius_(worldRadius) {}
    bool Sample_Li(const Point3f &, const Point2f &, LightSample *sample) const override {
        *sample = {wLight_, 1, Infinity, L_, true};
        return !L_.IsBlack();
    }
    Spectrum Power() const override { return L_ * (Pi * Sqr(worldRadius_)); }
    bool IsDelta() const override { return true; }

  private:
    Vector3f wLight_; // toward the light
    Spectrum L_;
    float worldRadius_;
};

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
    // Every direction sends L through the disk of the bounding sphere (pbrt-v3 leaves out the 4 pi).
    Spectrum Power() const override { return L_ * (4 * Pi * Pi * Sqr(worldRadius_)); }
    bool IsInfinite() const override { return true; }

  private:
    Spectrum L_;
    float worldRadius_;
};

// Shrinks a row of equal cells to `cells` equal cells, each the mean of what it covers.
void Reduce(std::vector<float> *row, size_t cells) {
    const size_t n = row->size();
    if (cells >= n)
        return;
    std::vector<float> out(cells);
    const double ratio = static_cast<double>(n) / static_cast<double>(cells);
    for (size_t i = 0; i < cells; ++i) {
        const double begin = ratio * static_cast<double>(i), end = ratio * static_cast<double>(i + 1);
        double sum = 0;
        for (auto k = static_cast<size_t>(begin); k < n && static_cast<double>(k) < end; ++k)
            sum += static_cast<double>((*row)[k]) *
                   (std::min(end, static_cast<double>(k + 1)) - std::max(begin, static_cast<double>(k)));
        out[i] = static_cast<float>(sum / ratio);
    }
    *row = std::move(out);
}

// A latitude-longitude map with pbrt-v3's orientation: theta from +z down the rows, phi from +x along them. It is held at
// the poles (pbrt-v3 wraps there too, which mixes zenith and nadir).
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
        const double rows = static_cast<double>(cosTheta_.size() - 1), v = static_cast<double>(uv.y) * rows;
        const size_t row = std::min(static_cast<size_t>(v), cosTheta_.size() - 2);
        const double z =
            Lerp(std::clamp(v - static_cast<double>(row), 0., 1.), cosTheta_[row], cosTheta_[row + 1]);
        const double sinTheta = std::sqrt(std::max(0., (1 - z) * (1 + z)));
        const double phi = 2 * kPi<double> * static_cast<double>(uv.x);
        const Vector3f local(Vector3d(sinTheta * std::cos(phi), sinTheta * std::sin(phi), z));
        const Vector3f wi = Normalize(lightToWorld_.Vector(local));
        // From the rounded direction, as a ray that finds it by other means will have it.
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
    bool IsInfinite() const override { return true; }

  private:
    // At most this many cells in the sampling table (16 MB); finer maps are averaged.
    static constexpr int kMaxColumns = 2048, kMaxRows = 1024;

    // Cells of half a texel: over each the interpolated map is one bilinear patch, whose mean is its value at
    // the centre. So a cell has probability 0 only if the map is black all over it.
    void BuildDistribution() {
        const int width = map_.Width(), height = map_.Height();
        const int columns = std::min(2 * width, kMaxColumns), rows = std::min(2 * height, kMaxRows);
        cosTheta_.resize(static_cast<size_t>(rows) + 1);
        for (int j = 0; j <= rows; ++j)
            cosTheta_[static_cast<size_t>(j)] = std::cos(kPi<double> * j / rows);
        cosTheta_.back() = -1;

        std::vector<float> cells(static_cast<size_t>(columns) * static_cast<size_t>(rows));
        std::vector<float> line(size_t{2} * static_cast<size_t>(width));
        // Fine rows go to the coarse rows they overlap, by the share of the coarse row that they cover.
        const double ratio = static_cast<double>(rows) / (2.0 * height);
        for (int y = 0; y < 2 * height; ++y) {
            line.assign(size_t{2} * static_cast<size_t>(width), 0);
            const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(2 * height);
            for (int x = 0; x < 2 * width; ++x) {
                const Spectrum s =
                    map_.Lookup((static_cast<float>(x) + 0.5f) / static_cast<float>(2 * width), v);
                // Not luminance alone: a saturated blue has next to none, yet must be found.
                line[static_cast<size_t>(x)] = Importance(s);
            }
            Reduce(&line, static_cast<size_t>(columns));
            const double begin = y * ratio, end = (y + 1) * ratio;
            for (int j = static_cast<int>(begin); j < rows && j < end; ++j) {
                const double share = std::min(end, j + 1.0) - std::max(begin, static_cast<double>(j));
                for (int x = 0; share > 0 && x < columns; ++x)
                    cells[static_cast<size_t>(j) * static_cast<size_t>(columns) + static_cast<size_t>(x)] +=
                        static_cast<float>(share) * line[static_cast<size_t>(x)];
            }
        }
        for (int j = 0; j < rows; ++j) {
            const auto band =
                static_cast<float>(cosTheta_[static_cast<size_t>(j)] - cosTheta_[static_cast<size_t>(j) + 1]);
            for (int x = 0; x < columns; ++x)
                cells[static_cast<size_t>(j) * static_cast<size_t>(columns) + static_cast<size_t>(x)] *= band;
        }
        distribution_ = std::make_unique<Distribution2D>(cells.data(), columns, rows);
        const Transform::Matrix &m = worldToLight_.M();
        determinant_ = std::abs(worldToLight_.Determinant() / (m[3][3] * m[3][3] * m[3][3]));
    }

    // Luminance, and a little of each channel so that no colour is overlooked.
    static float Importance(const Spectrum &s) { return 0.9f * s.y() + 0.1f * ((s[0] + s[1] + s[2]) / 3); }

    // Per steradian of the world, of the direction whose image in the light's space is w, at map point uv.
    float Density(const Point2f &uv, const Vector3f &w) const {
        const size_t rows = cosTheta_.size() - 1;
        const size_t row = std::min(static_cast<size_t>(uv.y * static_cast<float>(rows)), rows - 1);
        const double solidAngle =
            2 * kPi<double> * (cosTheta_[row] - cosTheta_[row + 1]) * static_cast<double>(rows);
        const float middle = (static_cast<float>(row) + 0.5f) / static_cast<float>(rows);
        const double pdf = static_cast<double>(distribution_->Pdf({uv.x, middle})) / solidAngle;
        // A transformation that is no rotation spreads directions unevenly: d omega in the light's space per
        // d omega in the world is |det| / |w|^3 for a direction of unit length.
        const double length2 = static_cast<double>(w.LengthSquared());
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

// --- the table of names ----------------------------------------------------------------------------------------

std::unique_ptr<Light> MakeInfinite(const LightEntity &entity, const Bounds3f &worldBound) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    const Spectrum scale = Scaled(params, "L", "infinite");
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

std::unique_ptr<Light> MakeDistant(const LightEntity &entity, const Bounds3f &worldBound) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    const Spectrum L = Scaled(params, "L", "distant");
    const Vector3f direction = params.FindPoint3f("from", {0, 0, 0}) - params.FindPoint3f("to", {0, 0, 1});
    const Vector3f w = Normalize(entity.ctm.Vector(direction));
    if (!IsFinite(w))
        throw Error(params.loc, "distant light: from and to are the same point");
    return std::make_unique<DistantLight>(w, L, WorldRadius(worldBound));
}

std::unique_ptr<Light> MakePoint(const LightEntity &entity, const Bounds3f &) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    const Spectrum I = Scaled(params, "I", entity.type);
    // pbrt-v3 moves the transformed origin by "from", in world space.
    const Point3f p = entity.ctm.Point({}) + params.FindPoint3f("from", {0, 0, 0});
    if (!IsFinite(p))
        throw Error(params.loc, entity.type + " light: its position is not finite");
    return std::make_unique<PointLight>(p, I);
}

std::unique_ptr<Light> MakeSpot(const LightEntity &entity, const Bounds3f &) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    const Spectrum I = Scaled(params, "I", "spot");
    const float cone = params.FindFloat("coneangle", 30), delta = params.FindFloat("conedeltaangle", 5);
    if (!(cone >= 0 && cone <= 180 && delta >= 0))
        throw Error(params.loc, "spot light: coneangle must be 0 to 180 degrees, conedeltaangle 0 or more");
    const Point3f from = params.FindPoint3f("from", {0, 0, 0}), to = params.FindPoint3f("to", {0, 0, 1});
    const Vector3d z = Normalize(Vector3d(to) - Vector3d(from));
    if (!IsFinite(Vector3f(z)) || !IsFinite(from))
        throw Error(params.loc, "spot light: from and to are the same point");
    Vector3d x, y;
    CoordinateSystem(z, &x, &y);
    const Transform axes(Transform::Matrix{{{x.x, y.x, z.x, static_cast<double>(from.x)},
                                            {x.y, y.y, z.y, static_cast<double>(from.y)},
                                            {x.z, y.z, z.z, static_cast<double>(from.z)},
                                            {0, 0, 0, 1}}});
    return std::make_unique<SpotLight>(entity.ctm * axes, I, cone, std::max(0.f, cone - delta));
}

std::unique_ptr<Light> MakeGoniometric(const LightEntity &entity, const Bounds3f &) {
    RequireInvertible(entity);
    return std::make_unique<GoniometricLight>(
        entity.ctm, Scaled(entity.params, "I", "goniometric"),
        LightMap(entity.params, Spectrum(1.f), LightMap::Border::Around));
}

std::unique_ptr<Light> MakeProjection(const LightEntity &entity, const Bounds3f &) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    const float fov = params.FindFloat("fov", 45);
    if (!(fov > 0 && fov < 180))
        throw Error(params.loc, "projection light: fov must be between 0 and 180 degrees");
    return std::make_unique<ProjectionLight>(entity.ctm, Scaled(params, "I", "projection"),
                                             LightMap(params, Spectrum(1.f), LightMap::Border::Held), fov);
}

struct LightName {
    std::string_view name;
    std::unique_ptr<Light> (*make)(const LightEntity &, const Bounds3f &);
};
constexpr LightName kLights[] = {
    {"infinite", MakeInfinite},    {"exinfinite", MakeInfinite}, {"distant", MakeDistant},
    {"point", MakePoint},          {"spot", MakeSpot},           {"goniometric", MakeGoniometric},
    {"projection", MakeProjection}};

} // namespace

std::unique_ptr<Light> MakeLight(const LightEntity &entity, const Bounds3f &worldBound) {
    std::array<std::string_view, std::size(kLights)> names;
    const PlaceScope here(entity.params.loc);
    for (size_t i = 0; i < names.size(); ++i) {
        if (kLights[i].name == entity.type)
            return kLights[i].make(entity, worldBound);
        names[i] = kLights[i].name;
    }
    throw Error(entity.params.loc, "unknown light \"" + entity.type + "\". " +
                                       Suggestion(entity.type, names.data(), names.size()));
}

std::unique_ptr<DiffuseAreaLight> MakeAreaLight(const Entity &entity, const SolidSet *solids,
                                                uint32_t geometryId) {
    constexpr std::string_view kNames[] = {"diffuse", "area"};
    const ParamSet &params = entity.params;
    if (std::find(std::begin(kNames), std::end(kNames), entity.type) == std::end(kNames))
        throw Error(params.loc, "unknown area light \"" + entity.type + "\". " +
                                    Suggestion(entity.type, kNames, std::size(kNames)));
    const Spectrum L = Scaled(params, "L", "area");
    const bool twoSided = params.FindBool("twosided", false);
    auto light = std::make_unique<DiffuseAreaLight>(L, twoSided, solids, geometryId);
    light->SetSamples(params.FindInt("samples", params.FindInt("nsamples", 1)));
    return light;
}

DiffuseAreaLight::DiffuseAreaLight(const Spectrum &L, bool twoSided, const SolidSet *solids,
                                   uint32_t geometryId)
    : L_(L), twoSided_(twoSided), solids_(solids), geometryId_(geometryId) {}

bool DiffuseAreaLight::Sample_Li(const Point3f &ref, const Point2f &u, LightSample *sample) const {
    ShapeSample point;
    if (L_.IsBlack() || !solids_->Sample(geometryId_, ref, u, &point))
        return false;
    const Vector3f toLight = point.p - ref;
    const float distance = toLight.Length();
    if (!(distance > 0 && distance < Infinity))
        return false;
    const Vector3f wi = toLight / distance;
    const Spectrum radiance = L(point.n, -wi);
    if (radiance.IsBlack())
        return false;
    // Stop short of the emitter by what rounding may have moved its point, the start and the direction's far
    // end across its plane, seen along the ray.
    const Vector3f n(std::abs(point.n.x), std::abs(point.n.y), std::abs(point.n.z));
    const Vector3f from(std::abs(ref.x), std::abs(ref.y), std::abs(ref.z));
    const float across = Dot(n, point.pError + from * 0x1p-22f) + distance * 0x1p-21f;
    const float slack = across / std::max(AbsDot(point.n, wi), 1e-4f);
    *sample = {wi, point.pdf, std::max(0.f, distance - slack), radiance, false};
    return true;
}

Spectrum DiffuseAreaLight::Power() const {
    return L_ * (solids_->Area(geometryId_) * Pi * (twoSided_ ? 2.f : 1.f));
}

LightSampler::LightSampler(const std::vector<const Light *> &lights) : probability_(lights.size(), 0.f) {
    std::vector<double> power;
    double total = 0, lit = 0;
    for (const Light *light : lights) {
        // The channels' mean joins in, so that a light whose luminance rounds to nothing is still a light.
        const Spectrum p = light->Power();
        const double y = 0.9 * static_cast<double>(p.y()) + 0.1 * static_cast<double>(p[0] + p[1] + p[2]) / 3;
        power.push_back(y > 0 && y < HUGE_VAL ? y : 0);
        total += power.back();
        lit += power.back() > 0;
    }
    constexpr double kEven = 0.1;
    cdf_.assign(lights.size() + 1, 0.f);
    double sum = 0;
    for (size_t i = 0; i < lights.size(); ++i) {
        if (power[i] > 0)
            sum += (1 - kEven) * power[i] / total + kEven / lit;
        cdf_[i + 1] = static_cast<float>(sum);
    }
    if (lit == 0)
        return;
    // The last light that is lit takes what rounding left; probabilities are then what Sample does, to the
    // bit.
    const float last = cdf_.back();
    for (size_t i = lights.size(); cdf_[i] == last; --i)
        cdf_[i] = 1;
    for (size_t i = 0; i < lights.size(); ++i)
        probability_[i] = cdf_[i + 1] - cdf_[i];
}

int LightSampler::Sample(float u, float *probability, float *uRemapped) const {
    if (cdf_.empty() || cdf_.back() == 0)
        return -1;
    u = std::clamp(u, 0.f, OneMinusEpsilon);
    const auto light = static_cast<size_t>(std::upper_bound(cdf_.begin(), cdf_.end(), u) - cdf_.begin()) - 1;
    *probability = probability_[light];
    if (uRemapped)
        *uRemapped = std::clamp((u - cdf_[light]) / probability_[light], 0.f, OneMinusEpsilon);
    return static_cast<int>(light);
}

} // namespace cuticle
