#include "scene/camera.h"

#include "core/error.h"
#include "core/sampling.h"
#include "files/file.h"
#include "scene/plugins.h"

#include <sstream>

namespace cuticle {

namespace {

constexpr double kNearPlane = 1e-2, kFarPlane = 1000;

// --- the stand-in for a camera of lens elements -------------------------------------------------------

// The focal length in mm of the lens system in a file of pbrt-v3: rows of radius of curvature, thickness,
// index of refraction (0: air) and aperture, from the front; # begins a comment. Traces a ray near the axis:
// at a surface n u changes by -y (n' - n) / R, across a gap y by its thickness times u. 0 if the file cannot
// be read or does not collect light.
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
    const std::string source = found > 0 ? fmt::format(", as long as that of \"{}\"", file)
                               : file.empty()
                                   ? " (it has no \"lensfile\")"
                                   : fmt::format(" (no focal length could be found in \"{}\")", file);
    Warning(
        params.loc, "camera not rendered",
        fmt::format(
            "camera \"realistic\" is not rendered; a perspective camera with a thin lens of {} mm takes its "
            "place{}",
            std::lround(f), source));
}

// --- reading parameters -------------------------------------------------------------------------------

// Reads the screen window, whose shorter axis spans -1 to 1 unless "screenwindow" gives all of it.
void ReadScreenWindow(const ParamSet &params, Point2i resolution, CameraParameters *c) {
    const float aspect = params.FindFloat("frameaspectratio", static_cast<float>(resolution.x) /
                                                                  static_cast<float>(resolution.y));
    // Comparisons are written so that NaN fails them.
    if (!(aspect > 0 && aspect < Infinity))
        throw Error(params.loc, "camera: frameaspectratio must be above 0");
    const float sx = aspect > 1 ? aspect : 1, sy = aspect > 1 ? 1 : 1 / aspect;
    float *w = c->screenWindow;
    w[0] = -sx, w[1] = sx, w[2] = -sy, w[3] = sy;
    if (const std::vector<float> given = params.FindFloats("screenwindow"); !given.empty()) {
        if (given.size() == 4)
            std::copy(given.begin(), given.end(), w);
        else
            Warning(
                params.loc, "wrong number of values",
                fmt::format("camera: screenwindow needs four values (x0 x1 y0 y1), not {}; it is ignored, as "
                            "by pbrt-v3",
                            given.size()));
    }
}

// Error where numbers are too large or too small for binary32, so that rays have no direction, or begin
// where no shape may be.
void CheckRays(const Camera &camera, Point2i resolution, const FileLoc &loc) {
    const auto isUnit = [](const Vector3f &d) { return std::abs(d.LengthSquared() - 1) < 1e-3f; };
    const Point2f corner(static_cast<float>(resolution.x), static_cast<float>(resolution.y));
    for (const Point2f p : {Point2f(0, 0), Point2f(corner.x, 0), Point2f(0, corner.y), corner})
        for (const Point2f lens :
             {Point2f(0, 0.5f), Point2f(0.5f, 0), Point2f(OneMinusEpsilon, OneMinusEpsilon)})
            if (const Ray ray = camera.GenerateRay(p, lens); !IsWithinReach(ray.o) || !isUnit(ray.d))
                throw Error(loc,
                            "the camera's rays are out of range: one begins at {:g} {:g} {:g} (its fov, "
                            "screenwindow, lensradius, focaldistance or transformation is extreme)",
                            ray.o.x, ray.o.y, ray.o.z)
                    .WithRemedy("a scene reaches to 1e18");
}

// --- the table of cameras -----------------------------------------------------------------------------

constexpr ParamInfo kAspect{"frameaspectratio", "float", "", "the film's",
                            "width over height of the screen window"};
constexpr ParamInfo kScreenWindow{"screenwindow", "floats", "", "from frameaspectratio",
                                  "x0 x1 y0 y1; the shorter axis from -1 to 1 where it is not given"};
constexpr ParamInfo kShutterOpen{"shutteropen", "float", "s", "0", "no effect: nothing moves"};
constexpr ParamInfo kShutterClose{"shutterclose", "float", "s", "1", "no effect: nothing moves"};
constexpr ParamInfo kLensRadius{
    "lensradius", "float", "camera units", "0", "radius of a thin lens; 0: a pinhole", 0};
constexpr ParamInfo kFocalDistance{
    "focaldistance", "float", "camera units", "1e6", "distance of the plane in focus", 0};
constexpr ParamInfo kPerspectiveParams[] = {
    {"fov", "float", "degrees", "90", "angle over the shorter axis of the screen window", 0, 180},
    {"halffov", "float", "degrees", "", "half of fov, instead of it", 0, 90},
    kLensRadius,
    kFocalDistance,
    kAspect,
    kScreenWindow,
    kShutterOpen,
    kShutterClose,
};
constexpr ParamInfo kOrthographicParams[] = {
    kLensRadius, kFocalDistance, kAspect, kScreenWindow, kShutterOpen, kShutterClose,
};
constexpr ParamInfo kEnvironmentParams[] = {
    {"lensradius", "float", "camera units", "0", "no effect"},
    {"focaldistance", "float", "camera units", "1e6", "no effect"},
    {"frameaspectratio", "float", "", "the film's", "no effect"},
    {"screenwindow", "floats", "", "", "no effect"},
    kShutterOpen,
    kShutterClose,
};
constexpr ParamInfo kRealisticParams[] = {
    {"lensfile", "string", "", "", "rows of radius of curvature, thickness, index and aperture, in mm"},
    {"aperturediameter", "float", "mm", "1", "diameter of the lens"},
    {"focusdistance", "float", "lengths of the scene", "10", "distance of the plane in focus"},
    {"simpleweighting", "bool", "", "true", "no effect"},
    kAspect,
    kScreenWindow,
    kShutterOpen,
    kShutterClose,
};

// To add a camera: a row here, a Projection, its rays in Camera::GenerateRay, and how MakeCamera reads it.
constexpr PluginInfo kCameras[] = {
    {"perspective", kPerspectiveParams, "a pinhole or thin lens"},
    {"orthographic", kOrthographicParams, "parallel rays, with a thin lens for each"},
    {"environment", kEnvironmentParams, "the whole sphere around a point"},
    {"realistic", kRealisticParams, "a system of lenses",
     "a perspective camera with a thin lens of the same focal length"},
};

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
        cameraToScreen_ = Transform::Perspective(double{parameters.fov}, kNearPlane, kFarPlane);
        scale = std::tan(double{parameters.fov} * kPi<double> / 360);
    }
    // Raster coordinates run right and down from the window's upper left corner.
    const float *w = parameters.screenWindow;
    const double x0{w[0]}, x1{w[1]}, y0{w[2]}, y1{w[3]};
    x0_ = scale * x0;
    y0_ = scale * y1;
    dx_ = scale * (x1 - x0) / resolution.x;
    dy_ = scale * (y0 - y1) / resolution.y;
    worldToRaster_ = Transform::Scale(resolution.x, resolution.y, 1) *
                     Transform::Scale(1 / (x1 - x0), 1 / (y0 - y1), 1) * Transform::Translate({-x0, -y1, 0}) *
                     cameraToScreen_ * worldToCamera_;
}

Ray Camera::GenerateRay(Point2f pFilm, Point2f uLens) const {
    const double x = x0_ + dx_ * double{pFilm.x}, y = y0_ + dy_ * double{pFilm.y};
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

float Camera::PixelWidthAt(float distance) const {
    if (parameters_.projection != Projection::Orthographic)
        return PixelAngle() * distance;
    const auto step = [&](float x, float y) { return cameraToWorld_.Vector({x, y, 0}).Length(); };
    return std::max(step(static_cast<float>(std::abs(dx_)), 0), step(0, static_cast<float>(std::abs(dy_))));
}

const PluginTable &CameraPlugins() {
    static const PluginTable table{PluginKind::Camera,
                                   {std::begin(kCameras), std::end(kCameras)},
                                   {"spherical"},
                                   {},
                                   "the first two with a thin lens"};
    return table;
}

Camera MakeCamera(const Entity &entity, Point2i resolution, float filmDiagonal) {
    const ParamSet &params = entity.params;
    if (!CameraPlugins().Find(entity.type)) {
        const std::vector<std::string_view> names = CameraPlugins().Names();
        throw Error(params.loc, "unknown camera \"{}\"", entity.type)
            .WithRemedy(Suggestion(entity.type, names.data(), names.size()));
    }
    if (resolution.x <= 0 || resolution.y <= 0)
        throw Error(params.loc, "the film has no pixels ({} x {})", resolution.x, resolution.y);
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
    ReadScreenWindow(params, resolution, &c);
    if (!(c.fov > 0 && c.fov < 180))
        throw Error(params.loc, "camera: fov must be between 0 and 180 degrees, not {:f}", c.fov);
    if (!(c.lensRadius >= 0 && c.lensRadius < Infinity))
        throw Error(params.loc, "camera: lensradius must be 0 or more");
    if (!(c.focalDistance > 0))
        throw Error(params.loc, "camera: focaldistance must be above 0");
    const float *w = c.screenWindow;
    if (!(std::abs(w[1] - w[0]) > 0 && std::abs(w[3] - w[2]) > 0 && std::abs(w[1] - w[0]) < Infinity &&
          std::abs(w[3] - w[2]) < Infinity))
        throw Error(params.loc, "camera: screenwindow has no area");
    if (entity.ctm.IsSingular())
        throw Error(params.loc,
                    "the camera's transformation has no inverse (a LookAt whose eye is its target, or "
                    "whose up points along the view?)");
    params.ReportUnused(fmt::format("Camera \"{}\"", entity.type));
    Camera camera(entity.ctm, c, resolution);
    CheckRays(camera, resolution, params.loc);
    return camera;
}

} // namespace cuticle
