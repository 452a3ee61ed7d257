// The lights that arrive from one direction at a point: point, spot, goniometric, projection and distant.
#include "core/error.h"
#include "core/sampling.h"
#include "scene/light_makers.h"
#include "scene/light_map.h"

#include <array>

namespace cuticle {

namespace {

class PointLight : public Light {
  public:
    PointLight(const Point3f &p, const Spectrum &I) : p_(p), I_(I) {}
    bool Sample_Li(const Point3f &ref, const Point2f &, LightSample *sample) const override {
        // In double: the square of a small distance keeps its digits, and that of a large one is finite
        const Vector3d way(p_ - ref);
        const double d2 = way.LengthSquared(), d = std::sqrt(d2);
        const Vector3f toLight(way / d);
        const Spectrum I = d > 0 ? I_ * Falloff(-toLight) : Spectrum(0.f);
        if (!(d < HUGE_VAL) || I.IsBlack())
            return false;
        const auto over = [d2](float x) { return static_cast<float>(double{x} / d2); };
        *sample = {toLight, 1, static_cast<float>(d), {over(I[0]), over(I[1]), over(I[2])}, true};
        return sample->L.IsFinite();
    }
    Spectrum Power() const override { return I_ * (4 * Pi); }
    bool IsDelta() const override { return true; }
    EmissionBound Bound() const override { return {.box = {p_, p_}}; }

  protected:
    // Relative intensity toward w, of unit length.
    virtual Spectrum Falloff(const Vector3f & /*w*/) const { return Spectrum(1.f); }
    Point3f p_;
    Spectrum I_;
};

// The bound of a light at p that shines into a cone around +z of its own space. A transformation may bend
// the cone out of shape: then it is taken to shine everywhere.
constexpr float kConeSlack = 1e-3f; // in radians, far above what rounding moves a cone's rim
EmissionBound ConeBound(const Point3f &p, const Transform &worldToLight, float angle) {
    EmissionBound bound{.box = {p, p}};
    if (worldToLight.ScalesUnevenly())
        return bound;
    bound.axis = Normalize(worldToLight.Inverse().Vector({0, 0, 1}));
    bound.normals = std::min(angle, Pi);
    return bound;
}

// A point light in a cone around +z of its own space, smooth from falloffStart to totalWidth, both in
// degrees (pbrt-v3, section 12.3.1).
class SpotLight : public PointLight {
  public:
    SpotLight(const Transform &lightToWorld, const Spectrum &I, float totalWidth, float falloffStart)
        : PointLight(lightToWorld.Point({}), I), worldToLight_(lightToWorld.Inverse()),
          cosTotalWidth_(std::cos(Radians(totalWidth))), cosFalloffStart_(std::cos(Radians(falloffStart))) {}
    Spectrum Power() const override {
        return I_ * (2 * Pi * (1 - 0.5f * (cosFalloffStart_ + cosTotalWidth_)));
    }
    EmissionBound Bound() const override {
        EmissionBound bound = ConeBound(p_, worldToLight_, std::acos(cosTotalWidth_));
        bound.spread = kConeSlack;
        return bound;
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

// A point light whose intensity over directions is a map of the sphere: theta from its own +y down the rows,
// phi from +x toward +z along them (pbrt-v3, section 12.3.3). Its power, which only decides how often a
// light is sampled, uses the mean over directions where pbrt-v3 weighs all pixels alike.
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

// A slide projector along +z of its own space (pbrt-v3, section 12.3.2); fov, in degrees, spans the
// picture's shorter side. The top row of the picture is at -y, as in pbrt-v3: in the space of a camera that
// sees y upward it hangs upside down. The picture is held at its borders, where pbrt-v3 repeats it, which
// mixes opposite borders over half a pixel.
class ProjectionLight : public PointLight {
  public:
    ProjectionLight(const Transform &lightToWorld, const Spectrum &I, LightMap map, float fov)
        : PointLight(lightToWorld.Point({}), I), worldToLight_(lightToWorld.Inverse()), map_(std::move(map)) {
        const float aspect = static_cast<float>(map_.Width()) / static_cast<float>(map_.Height());
        const float tanHalf = std::tan(Radians(fov) / 2);
        xMax_ = tanHalf * std::max(1.f, aspect);
        yMax_ = tanHalf * std::max(1.f, 1 / aspect);
    }
    // Sums over the solid angles of many cells of the picture (pbrt-v3 takes the cone around it).
    Spectrum Power() const override;
    EmissionBound Bound() const override {
        EmissionBound bound = ConeBound(p_, worldToLight_, std::atan(std::hypot(xMax_, yMax_)));
        bound.spread = kConeSlack;
        return bound;
    }

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
    // The solid angle of the rectangle from the axis to (x, y) of the plane z = 1, negative where one of
    // them is.
    const auto corner = [](double x, double y) { return std::atan(x * y / std::sqrt(1 + x * x + y * y)); };
    const auto cells = [](size_t pixels) { return 2 * pixels * std::max(size_t{1}, 32 / pixels); };
    const size_t columns = cells(map_.Width()), rows = cells(map_.Height());
    const double xMax{xMax_}, yMax{yMax_}, nx = static_cast<double>(columns), ny = static_cast<double>(rows);
    Vector3d total;
    for (size_t row = 0; row < rows; ++row) {
        const double j = static_cast<double>(row);
        const double y0 = yMax * (2. * j / ny - 1), y1 = yMax * (2. * (j + 1) / ny - 1);
        for (size_t column = 0; column < columns; ++column) {
            const double i = static_cast<double>(column);
            const double x0 = xMax * (2. * i / nx - 1), x1 = xMax * (2. * (i + 1) / nx - 1);
            const double solidAngle = corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0);
            const Spectrum s = map_.Lookup((static_cast<float>(column) + 0.5f) / static_cast<float>(columns),
                                           (static_cast<float>(row) + 0.5f) / static_cast<float>(rows));
            for (int c = 0; c < 3; ++c)
                total[c] += solidAngle * double{s[c]};
        }
    }
    const Vector3f power(total);
    return I_ * Spectrum(power.x, power.y, power.z);
}

class DistantLight : public Light {
  public:
    DistantLight(const Vector3f &wLight, const Spectrum &L, float worldRadius)
        : wLight_(wLight), L_(L), worldRadius_(worldRadius) {}
    bool Sample_Li(const Point3f &, const Point2f &, LightSample *sample) const override {
        *sample = {wLight_, 1, Infinity, L_, true};
        return !L_.IsBlack();
    }
    LightKind Kind() const override { return LightKind::Distant; }
    Spectrum Power() const override { return L_ * (Pi * Sqr(worldRadius_)); }
    bool IsDelta() const override { return true; }

  private:
    Vector3f wLight_; // toward the light
    Spectrum L_;
    float worldRadius_;
};

} // namespace

std::unique_ptr<Light> MakeDistant(const LightEntity &entity, const Bounds3f &worldBound) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    const Spectrum L = ScaledLightValue(params, "L", "distant");
    const Vector3f direction = params.FindPoint3f("from", {0, 0, 0}) - params.FindPoint3f("to", {0, 0, 1});
    const Vector3f w = Normalize(entity.ctm.Vector(direction));
    if (!IsFinite(w))
        throw Error(params.loc, "distant light: from and to are the same point");
    return std::make_unique<DistantLight>(w, L, WorldRadius(worldBound));
}

// Returns the place of a light in the world, unless it is beyond what a scene reaches to.
static Point3f RequireReach(const LightEntity &entity, const Point3f &p) {
    if (!IsWithinReach(p))
        throw Error(entity.params.loc, "{} light: its place ({:g}, {:g}, {:g}) is out of reach", entity.type,
                    p.x, p.y, p.z)
            .WithRemedy("a scene reaches to 1e18");
    return p;
}

std::unique_ptr<Light> MakePoint(const LightEntity &entity, const Bounds3f &) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    const Spectrum I = ScaledLightValue(params, "I", entity.type);
    // pbrt-v3 moves the transformed origin by "from", in world space.
    const Point3f p = entity.ctm.Point({}) + params.FindPoint3f("from", {0, 0, 0});
    return std::make_unique<PointLight>(RequireReach(entity, p), I);
}

std::unique_ptr<Light> MakeSpot(const LightEntity &entity, const Bounds3f &) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    const Spectrum I = ScaledLightValue(params, "I", "spot");
    const float cone = params.FindFloat("coneangle", 30), delta = params.FindFloat("conedeltaangle", 5);
    if (!(cone >= 0 && cone <= 180 && delta >= 0))
        throw Error(params.loc, "spot light: coneangle must be 0 to 180 degrees, conedeltaangle 0 or more");
    const Point3f from = params.FindPoint3f("from", {0, 0, 0}), to = params.FindPoint3f("to", {0, 0, 1});
    const Vector3d z = Normalize(Vector3d(to) - Vector3d(from));
    if (!IsFinite(Vector3f(z)) || !IsFinite(from))
        throw Error(params.loc, "spot light: from and to are the same point");
    RequireReach(entity, entity.ctm.Point(from));
    Vector3d x, y;
    CoordinateSystem(z, &x, &y);
    const Vector3d o(from);
    const Transform axes(
        Transform::Matrix{{{x.x, y.x, z.x, o.x}, {x.y, y.y, z.y, o.y}, {x.z, y.z, z.z, o.z}, {0, 0, 0, 1}}});
    return std::make_unique<SpotLight>(entity.ctm * axes, I, cone, std::max(0.f, cone - delta));
}

std::unique_ptr<Light> MakeGoniometric(const LightEntity &entity, const Bounds3f &) {
    RequireInvertible(entity);
    RequireReach(entity, entity.ctm.Point({}));
    return std::make_unique<GoniometricLight>(
        entity.ctm, ScaledLightValue(entity.params, "I", "goniometric"),
        LightMap(entity.params, Spectrum(1.f), LightMap::Border::Around));
}

std::unique_ptr<Light> MakeProjection(const LightEntity &entity, const Bounds3f &) {
    const ParamSet &params = entity.params;
    RequireInvertible(entity);
    RequireReach(entity, entity.ctm.Point({}));
    const float fov = params.FindFloat("fov", 45);
    if (!(fov > 0 && fov < 180))
        throw Error(params.loc, "projection light: fov must be between 0 and 180 degrees");
    return std::make_unique<ProjectionLight>(entity.ctm, ScaledLightValue(params, "I", "projection"),
                                             LightMap(params, Spectrum(1.f), LightMap::Border::Held), fov);
}

} // namespace cuticle
