#include "scene/camera.h"

#include "core/error.h"
#include "core/sampling.h"
#include "files/file.h"

#include <sstream>

namespace cuticle {

namespace {

constexpr double kNearPlane = 1e-2, kFarPlane = 1000;

// --- the stand-in for a camera of lens elements -------------------------------------------------------------------

// The focal length in mm of the lens system in a file of pbrt-v3: rows of radius of curvature, thickness, index of
// refraction (0: air) and aperture, from the front; # begins a comment. By a ray near the axis: at a surface n u changes
// by -y (n' - n) / R, across a gap y by its thickness times u. 0 if the file cannot be read or does not collect light.
float FocalLength(const std::string &filename) {
    std::istringstream file;
    try {
        file.str(ReadFile(filename, "the lens file"));
    } catch (const Error &) { // the caller says that there is none
        return 0;
    }
    double y = 1, u = 0, n = 1, thickness = 0;
    std::string line;
    while (std::getline(file, line)) {
        std::istringstream row(line.substr(0, line.find('#')));
        double radius, gap, eta, aperture;
        if (!(row >> radius >> gap >> eta >> aperture))
            continue;
        y += thickness * u;
        const double next = eta == 0 ? 1 : eta;
        if (radius != 0) { // 0 is the stop
            u = (n * u - y * (next - n) / radius) / next;
            n = next;
        }
        thickness = gap;
    }
    const double f = -1 / u;
    return f > 0 && f < 1e6 ? static_cast<float>(f) : 0;
}

void ReadRealistic(const ParamSet &params, Point2i resolution, float filmDiagonal, CameraParameters *c) {
    const std::string file = params.FindFilename("lensfile");
    const float found = FocalLength(file), f = found > 0 ? found : 50;
    // pbrt-v3 measures lenses in mm and scenes in m.
    c->lensRadius = 0.0005f * params.FindFloat("aperturediameter", 1);
    c->focalDistance = params.FindFloat("focusdistance", 10);
    params.FindBool("simpleweighting", true);
    const float w = static_cast<float>(resolution.x), h = static_cast<float>(resolution.y);
    c->fov = Degrees(2 * std::atan(0.5f * filmDiagonal * std::min(w, h) / std::hypot(w, h) / f));
    Warning(params.loc, "camera not rendered",
            "camera \"realistic\" is not rendered; a perspective camera with a thin lens of " +
                std::to_string(static_cast<int>(std::lround(f))) + " mm takes its place" +
                (found > 0      ? ", as long as that of \"" + file + "\""
                 : file.empty() ? " (it has no \"lensfile\")"
                                : " (no focal length could be found in \"" + file + "\")"));
}

} // namespace

Camera::Camera(const Transform &worldToCamera, const CameraParameters &parameters, Point2i resolution)
    : worldToCamera_(worldToCamera), cameraToWorld_(worldToCamera.Inverse()), parameters_(parameters) {
    if (worldToCamera.IsSingular())
        throw Error("the camera's transformation has no inverse");
    if (parameters.projection == Projection::Environment) {
        dx_ = 2 * kPi<double> / resolution.x;
        dy_ = kPi<double> / resolution.y;
        return;
    }
    double scale = 1; // from the screen window to the film plane
    if (parameters.projection == Projection::Perspective) {
        cameraToScreen_ = Transform::Perspective(static_cast<double>(parameters.fov), kNearPlane, kFarPlane);
        scale = std::tan(static_cast<double>(parameters.fov) * kPi<double> / 360);
    }
    // Raster coordinates run right and down from the window's upper left corner.
    const float *w = parameters.screenWindow;
    const double x0 = static_cast<double>(w[0]), x1 = static_cast<double>(w[1]);
    const double y0 = static_cast<double>(w[2]), y1 = static_cast<double>(w[3]);
    x0_ = scale * x0;
    y0_ = scale * y1;
    dx_ = scale * (x1 - x0) / resolution.x;
    dy_ = scale * (y0 - y1) / resolution.y;
    worldToRaster_ = Transform::Scale(resolution.x, resolution.y, 1) *
                     Transform::Scale(1 / (x1 - x0), 1 / (y0 - y1), 1) * Transform::Translate({-x0, -y1, 0}) *
                     cameraToScreen_ * worldToCamera_;
}

Ray Camera::GenerateRay(Point2f pFilm, Point2f uLens) const {
    const double x = x0_ + dx_ * static_cast<double>(pFilm.x), y = y0_ + dy_ * static_cast<double>(pFilm.y);
    Point3f origin;
    Vector3f direction;
    switch (parameters_.projection) {
    case Projection::Environment:
        direction = Vector3f(Vector3d(std::sin(y) * std::cos(x), std::cos(y), std::sin(y) * std::sin(x)));
        return {cameraToWorld_.Point(origin), Normalize(cameraToWorld_.Vector(direction))};
    case Projection::Perspective: // the pinhole's ray, through the point of the plane z = 1
        direction = Vector3f(static_cast<float>(x), static_cast<float>(y), 1);
        break;
    case Projection::Orthographic:
        origin = {static_cast<float>(x), static_cast<float>(y), 0};
        direction = {0, 0, 1};
        break;
    }
    if (parameters_.lensRadius > 0) {
        // All rays of a film position meet at the plane of focus; divided by its distance, so that a far
        // focus loses nothing.
        const Point2f lens = ConcentricSampleDisk(uLens) * parameters_.lensRadius;
        origin += Vector3f(lens.x, lens.y, 0);
        direction.x -= lens.x / parameters_.focalDistance;
        direction.y -= lens.y / parameters_.focalDistance;
    }
    return {cameraToWorld_.Point(origin), Normalize(cameraToWorld_.Vector(direction))};
}

Point2f Camera::WorldToRaster(const Point3f &p) const {
    if (parameters_.projection != Projection::Environment) {
        const Point3f r = worldToRaster_.Point(p);
        return {r.x, r.y};
    }
    const Vector3d v(worldToCamera_.Point(p));
    const double theta = std::atan2(std::hypot(v.x, v.z), v.y), phi = std::atan2(v.z, v.x);
    return {static_cast<float>((phi < 0 ? phi + 2 * kPi<double> : phi) / dx_),
            static_cast<float>(theta / dy_)};
}

float Camera::PixelAngle() const {
    if (parameters_.projection == Projection::Orthographic)
        return 0;
    return static_cast<float>(std::max(std::abs(dx_), std::abs(dy_)));
}

Camera MakeCamera(const Entity &entity, Point2i resolution, float filmDiagonal) {
    constexpr std::string_view kNames[] = {"perspective", "orthographic", "environment", "realistic"};
    const ParamSet &params = entity.params;
    if (std::find(std::begin(kNames), std::end(kNames), entity.type) == std::end(kNames))
        throw Error(params.loc, "unknown camera \"" + entity.type + "\". " +
                                    Suggestion(entity.type, kNames, std::size(kNames)));
    if (resolution.x <= 0 || resolution.y <= 0)
        throw Error(params.loc, "the film has no pixels (" + std::to_string(resolution.x) + " x " +
                                    std::to_string(resolution.y) + ")");
    CameraParameters c;
    // The shutter is read so that it does not count as unused; nothing moves while it is open.
    params.FindFloat("shutteropen", 0);
    params.FindFloat("shutterclose", 1);
    if (entity.type == "orthographic")
        c.projection = Projection::Orthographic;
    else if (entity.type == "environment")
        c.projection = Projection::Environment;
    if (entity.type == "realistic") {
        ReadRealistic(params, resolution, filmDiagonal, &c);
    } else {
        c.lensRadius = params.FindFloat("lensradius", 0);
        c.focalDistance = params.FindFloat("focaldistance", 1e6f);
    }
    if (entity.type == "perspective") {
        c.fov = params.FindFloat("fov", 90);
        if (const float half = params.FindFloat("halffov", -1); half > 0)
            c.fov = 2 * half;
    }
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
    params.ReportUnused("Camera \"" + entity.type + "\"");
    Camera camera(entity.ctm, c, resolution);
    // Where numbers are too large or too small for binary32, rays have no direction
    const auto isUnit = [](const Vector3f &d) { return std::abs(d.LengthSquared() - 1) < 1e-3f; };
    const Point2f corner(static_cast<float>(resolution.x), static_cast<float>(resolution.y));
    for (const Point2f p : {Point2f(0, 0), Point2f(corner.x, 0), Point2f(0, corner.y), corner})
        for (const Point2f lens :
             {Point2f(0, 0.5f), Point2f(0.5f, 0), Point2f(OneMinusEpsilon, OneMinusEpsilon)})
            if (const Ray ray = camera.GenerateRay(p, lens); !IsFinite(ray.o) || !isUnit(ray.d))
                throw Error(params.loc,
                            "the camera's rays are out of range (its fov, screenwindow, lensradius, "
                            "focaldistance or transformation is extreme)");
    return camera;
}

} // namespace cuticle
