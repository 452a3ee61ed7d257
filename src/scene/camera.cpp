#include "scene/camera.h"

#include "core/error.h"
#include "core/sampling.h"

namespace cuticle {

namespace {
constexpr double kNearPlane = 1e-2, kFarPlane = 1000;
} // namespace

Camera::Camera(const Transform &worldToCamera, const CameraParameters &parameters, Point2i resolution)
    : worldToCamera_(worldToCamera), cameraToWorld_(worldToCamera.Inverse()), parameters_(parameters) {
    if (worldToCamera.IsSingular())
        throw Error("the camera's transformation has no inverse");
    cameraToScreen_ = Transform::Perspective(static_cast<double>(parameters.fov), kNearPlane, kFarPlane);
    // Raster coordinates run right and down from the window's upper left corner.
    const float *w = parameters.screenWindow;
    const double x0 = static_cast<double>(w[0]), x1 = static_cast<double>(w[1]);
    const double y0 = static_cast<double>(w[2]), y1 = static_cast<double>(w[3]);
    const double tanHalf = std::tan(static_cast<double>(parameters.fov) * kPi<double> / 360);
    x0_ = tanHalf * x0;
    y0_ = tanHalf * y1;
    dx_ = tanHalf * (x1 - x0) / resolution.x;
    dy_ = tanHalf * (y0 - y1) / resolution.y;
    worldToRaster_ = Transform::Scale(resolution.x, resolution.y, 1) *
                     Transform::Scale(1 / (x1 - x0), 1 / (y0 - y1), 1) * Transform::Translate({-x0, -y1, 0}) *
                     cameraToScreen_ * worldToCamera_;
}

Ray Camera::GenerateRay(Point2f pFilm, Point2f uLens) const {
    // The point of the plane z = 1 behind the film position; the pinhole ray goes through it.
    const double x = x0_ + dx_ * static_cast<double>(pFilm.x), y = y0_ + dy_ * static_cast<double>(pFilm.y);
    Point3f origin;
    Vector3f direction(static_cast<float>(x), static_cast<float>(y), 1);
    if (parameters_.lensRadius > 0) {
        // All rays of a film position meet at the plane of focus; divided by its distance, so that a far
        // focus loses nothing.
        const Point2f lens = ConcentricSampleDisk(uLens) * parameters_.lensRadius;
        origin = {lens.x, lens.y, 0};
        direction.x -= lens.x / parameters_.focalDistance;
        direction.y -= lens.y / parameters_.focalDistance;
    }
    return {cameraToWorld_.Point(origin), Normalize(cameraToWorld_.Vector(direction))};
}

Point2f Camera::WorldToRaster(const Point3f &p) const {
    const Point3f r = worldToRaster_.Point(p);
    return {r.x, r.y};
}

float Camera::PixelAngle() const { return static_cast<float>(std::max(std::abs(dx_), std::abs(dy_))); }

Camera MakeCamera(const Entity &entity, Point2i resolution) {
    constexpr std::string_view kNames[] = {"perspective", "orthographic", "environment", "realistic"};
    const ParamSet &params = entity.params;
    if (std::find(std::begin(kNames), std::end(kNames), entity.type) == std::end(kNames))
        throw Error(params.loc, "unknown camera \"" + entity.type + "\"." +
                                    Suggestion(entity.type, kNames, std::size(kNames)));
    if (entity.type != "perspective")
        Warning(params.loc, "camera not rendered",
                "camera \"" + entity.type +
                    "\" is not rendered in this version; a perspective camera takes its place");
    if (resolution.x <= 0 || resolution.y <= 0)
        throw Error(params.loc, "the film has no pixels (" + std::to_string(resolution.x) + " x " +
                                    std::to_string(resolution.y) + ")");
    CameraParameters c;
    // The shutter is read so that it does not count as unused; nothing moves while it is open.
    params.FindFloat("shutteropen", 0);
    params.FindFloat("shutterclose", 1);
    c.lensRadius = params.FindFloat("lensradius", 0);
    c.focalDistance = params.FindFloat("focaldistance", 1e6f);
    c.fov = params.FindFloat("fov", 90);
    if (const float half = params.FindFloat("halffov", -1); half > 0)
        c.fov = 2 * half;
    const float aspect = params.FindFloat("frameaspectratio", static_cast<float>(resolution.x) /
                                                                  static_cast<float>(resolution.y));
    // Comparisons are written so that NaN fails them.
    if (!(aspect > 0 && aspect < Infinity))
        throw Error(params.loc, "camera: frameaspectratio must be above 0");
    if (!(c.fov > 0 && c.fov < 180))
        throw Error(params.loc,
                    "camera: fov must be between 0 and 180 degrees, not " + std::to_string(c.fov));
    if (!(c.lensRadius >= 0 && c.lensRadius < Infinity))
        throw Error(params.loc, "camera: lensradius must be 0 or more");
    if (!(c.focalDistance > 0))
        throw Error(params.loc, "camera: focaldistance must be above 0");
    // The shorter axis spans -1 to 1.
    const float sx = aspect > 1 ? aspect : 1, sy = aspect > 1 ? 1 : 1 / aspect;
    float *w = c.screenWindow;
    w[0] = -sx, w[1] = sx, w[2] = -sy, w[3] = sy;
    if (const std::vector<float> given = params.FindFloats("screenwindow"); !given.empty()) {
        if (given.size() != 4)
            throw Error(params.loc, "camera: screenwindow needs four values (x0 x1 y0 y1), not " +
                                        std::to_string(given.size()));
        std::copy(given.begin(), given.end(), w);
    }
    if (!(std::abs(w[1] - w[0]) > 0 && std::abs(w[3] - w[2]) > 0 && std::abs(w[1] - w[0]) < Infinity &&
          std::abs(w[3] - w[2]) < Infinity))
        throw Error(params.loc, "camera: screenwindow has no area");
    if (entity.ctm.IsSingular())
        throw Error(params.loc,
                    "the camera's transformation has no inverse (a LookAt whose eye is its target, or "
                    "whose up points along the view?)");
    return {entity.ctm, c, resolution};
}

} // namespace cuticle
