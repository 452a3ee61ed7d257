#include "materials/texture_mapping.h"

#include "materials/texture_makers.h"

#include <array>
#include <cmath>

namespace cuticle {

namespace {

class UVMapping2D final : public TextureMapping2D {
  public:
    UVMapping2D(float su, float sv, float du, float dv) : su_(su), sv_(sv), du_(du), dv_(dv) {}
    Point2f Map(const TexturePoint &point) const override {
        return {su_ * point.uv.x + du_, sv_ * point.uv.y + dv_};
    }

  private:
    float su_, sv_, du_, dv_;
};

// Gives (theta / pi, phi / 2 pi) of the direction from the texture's origin; the origin itself maps to (0,
// 0).
class SphericalMapping2D final : public TextureMapping2D {
  public:
    explicit SphericalMapping2D(const Transform &worldToTexture) : worldToTexture_(worldToTexture) {}
    Point2f Map(const TexturePoint &point) const override {
        const Vector3f v = worldToTexture_.Point(point.p);
        const float theta = std::atan2(std::hypot(v.x, v.y), v.z), phi = std::atan2(v.y, v.x);
        return {theta / Pi, (phi < 0 ? phi + 2 * Pi : phi) / (2 * Pi)};
    }

  private:
    Transform worldToTexture_;
};

// Gives the angle about z and the cosine to z. pbrt-v3 normalises the point first, so that t is the cosine
// and not the height. At the origin, which has no direction, t is 0.
class CylindricalMapping2D final : public TextureMapping2D {
  public:
    explicit CylindricalMapping2D(const Transform &worldToTexture) : worldToTexture_(worldToTexture) {}
    Point2f Map(const TexturePoint &point) const override {
        const Vector3f v = worldToTexture_.Point(point.p);
        const float length = v.Length();
        return {(Pi + std::atan2(v.y, v.x)) / (2 * Pi), length == 0 ? 0 : v.z / length};
    }

  private:
    Transform worldToTexture_;
};

class PlanarMapping2D final : public TextureMapping2D {
  public:
    PlanarMapping2D(const Vector3f &vs, const Vector3f &vt, float ds, float dt)
        : vs_(vs), vt_(vt), ds_(ds), dt_(dt) {}
    Point2f Map(const TexturePoint &point) const override {
        return {ds_ + Dot(point.p, vs_), dt_ + Dot(point.p, vt_)};
    }

  private:
    Vector3f vs_, vt_;
    float ds_, dt_;
};

} // namespace

std::unique_ptr<TextureMapping2D> MakeMapping(const TextureEntity &e) {
    const ParamSet &p = e.params;
    const std::string type = p.FindString("mapping", "uv");
    if (type == "uv")
        return std::make_unique<UVMapping2D>(p.FindFloat("uscale", 1), p.FindFloat("vscale", 1),
                                             p.FindFloat("udelta", 0), p.FindFloat("vdelta", 0));
    if (type == "planar")
        return std::make_unique<PlanarMapping2D>(p.FindVector3f("v1", {1, 0, 0}),
                                                 p.FindVector3f("v2", {0, 1, 0}), p.FindFloat("udelta", 0),
                                                 p.FindFloat("vdelta", 0));
    if (type != "spherical" && type != "cylindrical") {
        static constexpr std::array<std::string_view, 4> kMappings = {"uv", "spherical", "cylindrical",
                                                                      "planar"};
        Warning(LocOf(p, "mapping"), "unknown texture mapping",
                fmt::format("there is no texture mapping \"{}\"; it is \"uv\", as in pbrt-v3. {}", type,
                            Suggestion(type, kMappings.data(), kMappings.size())));
        return std::make_unique<UVMapping2D>(1.f, 1.f, 0.f, 0.f);
    }
    if (e.ctm.IsSingular())
        throw ErrorAtLine(LocOf(p, "mapping"), "a {} mapping needs a transformation that can be inverted",
                          type);
    if (type == "spherical")
        return std::make_unique<SphericalMapping2D>(e.ctm.Inverse());
    return std::make_unique<CylindricalMapping2D>(e.ctm.Inverse());
}

} // namespace cuticle
