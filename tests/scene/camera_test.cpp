// The camera against its own projection, and against what pbrt-v3 says its parameters mean.
#include "scene/camera.h"
#include "warnings.h"

#include "core/error.h"
#include "core/sampling.h"
#include "sampler_ends.h"
#include "scene/plugins.h"

#include <gtest/gtest.h>

#include <fstream>

namespace cuticle {
namespace {

void Set(Entity *entity, const std::string &name, std::vector<double> values) {
    Param p;
    p.type = ParamType::Float;
    p.name = name;
    p.numbers = std::move(values);
    entity->params.params.push_back(std::move(p));
}
Entity Perspective(const Transform &worldToCamera = Transform()) {
    Entity entity;
    entity.type = "perspective";
    entity.ctm = worldToCamera;
    return entity;
}
float Distance(const Vector3f &a, const Vector3f &b) { return (a - b).Length(); }

TEST(Camera, LooksAlongZWithRasterYDown) {
    const Camera camera = MakeCamera(Perspective(), {200, 100});
    const Ray centre = camera.GenerateRay({100, 50}, {});
    EXPECT_LT(Distance(centre.d, {0, 0, 1}), 1e-6f);
    EXPECT_EQ(centre.o, Point3f(0, 0, 0));
    EXPECT_LT(camera.GenerateRay({0, 50}, {}).d.x, 0);
    EXPECT_GT(camera.GenerateRay({100, 0}, {}).d.y, 0);
}

// fov is the full angle over the shorter axis, whichever that is.
TEST(Camera, FovSpansTheShorterAxis) {
    for (const float fov : {1.f, 33.f, 90.f, 170.f})
        for (const Point2i &resolution : {Point2i(300, 200), Point2i(200, 300), Point2i(64, 64)}) {
            Entity entity = Perspective();
            Set(&entity, "fov", {static_cast<double>(fov)});
            const Camera camera = MakeCamera(entity, resolution);
            const float w = static_cast<float>(resolution.x), h = static_cast<float>(resolution.y);
            const bool wide = w > h;
            const Ray a = camera.GenerateRay(wide ? Point2f(w / 2, 0) : Point2f(0, h / 2), {});
            const Ray b = camera.GenerateRay(wide ? Point2f(w / 2, h) : Point2f(w, h / 2), {});
            EXPECT_NEAR(Degrees(std::atan2(Cross(a.d, b.d).Length(), Dot(a.d, b.d))), fov, 1e-3f);
            // Square pixels: the longer axis in proportion.
            const Ray c = camera.GenerateRay(wide ? Point2f(0, h / 2) : Point2f(w / 2, 0), {});
            const float tangent = std::hypot(c.d.x, c.d.y) / c.d.z;
            EXPECT_NEAR(tangent / std::tan(Radians(fov / 2)), std::max(w, h) / std::min(w, h), 1e-4f);
        }
    Entity half = Perspective();
    Set(&half, "halffov", {15});
    EXPECT_EQ(MakeCamera(half, {10, 10}).Parameters().fov, 30);
}

TEST(Camera, WorldToRasterInvertsGenerateRay) {
    RNG rng(1);
    for (int i = 0; i < 2000; ++i) {
        const auto r = [&](float s) { return static_cast<double>(s * (2 * rng.UniformFloat() - 1)); };
        const double x = r(5), y = r(5), z = r(5), lx = r(5), ly = r(5);
        // A mirror, as exporters write it, and a scale, which must not change the picture.
        const Transform worldToCamera = Transform::Scale(i % 2 ? -1 : 1, 1, 1) *
                                        Transform::Scale(0.5, 0.5, 0.5) *
                                        Transform::LookAt({x, y, z}, {lx, ly, 20}, {0, 1, 0});
        Entity entity = Perspective(worldToCamera);
        Set(&entity, "fov", {20 + 60 * static_cast<double>(rng.UniformFloat())});
        if (i % 3 == 0)
            Set(&entity, "screenwindow", {-0.3, 1.1, -0.2, 0.7});
        if (i % 5 == 0)
            Set(&entity, "frameaspectratio", {2.2});
        const Camera camera = MakeCamera(entity, {640, 480});
        const Point2f film{640 * rng.UniformFloat(), 480 * rng.UniformFloat()};
        const Ray ray = camera.GenerateRay(film, {});
        EXPECT_NEAR(ray.d.Length(), 1, 1e-5);
        EXPECT_LT(Distance(ray.o, Point3f(Vector3d(x, y, z))), 1e-5f);
        const Point2f back = camera.WorldToRaster(ray(1 + 30 * rng.UniformFloat()));
        EXPECT_NEAR(back.x, film.x, 2e-2);
        EXPECT_NEAR(back.y, film.y, 2e-2);
    }
}

// Every lens point sees a film point's place on the plane of focus, and the lens is a disk.
TEST(Camera, ThinLensFocusesOnAPlane) {
    Entity entity = Perspective();
    Set(&entity, "lensradius", {0.25});
    Set(&entity, "focaldistance", {7});
    const Camera camera = MakeCamera(entity, {320, 240});
    RNG rng(2);
    double mean2 = 0;
    constexpr int n = 4096;
    for (int i = 0; i < n; ++i) {
        const Point2f film{320 * rng.UniformFloat(), 240 * rng.UniformFloat()};
        const Ray ray = camera.GenerateRay(
            film, {(static_cast<float>(i % 64) + 0.5f) / 64, (static_cast<float>(i / 64) + 0.5f) / 64});
        EXPECT_LE(ray.o.Length(), 0.25f * (1 + 1e-6f));
        EXPECT_EQ(ray.o.z, 0);
        mean2 += static_cast<double>(ray.o.LengthSquared());
        const Point3f focus = ray(7 / ray.d.z);
        const Point2f back = camera.WorldToRaster(focus);
        EXPECT_NEAR(back.x, film.x, 1e-3);
        EXPECT_NEAR(back.y, film.y, 1e-3);
    }
    // Uniform over the disk: mean squared radius r^2 / 2, which midpoints of cells of h = 1/32 miss by h^2 /
    // 4.
    EXPECT_NEAR(mean2 / n, 0.25 * 0.25 / 2, 0.25 * 0.25 * Sqr(1. / 32) / 2);
}

TEST(Camera, APinholeIgnoresTheLensSample) {
    const Camera camera = MakeCamera(Perspective(), {8, 8});
    EXPECT_EQ(camera.GenerateRay({1, 2}, {0.1f, 0.9f}).d, camera.GenerateRay({1, 2}, {0.7f, 0.3f}).d);
}

TEST(Camera, PixelAngleIsTheStepBetweenPixels) {
    Entity entity = Perspective();
    Set(&entity, "fov", {40});
    const Camera camera = MakeCamera(entity, {500, 400});
    const Vector3f a = camera.GenerateRay({250, 200}, {}).d, b = camera.GenerateRay({251, 200}, {}).d;
    EXPECT_NEAR(camera.PixelAngle() / (a - b).Length(), 1, 1e-3);
}

Entity OfType(const std::string &type, const Transform &worldToCamera = Transform()) {
    Entity entity = Perspective(worldToCamera);
    entity.type = type;
    return entity;
}

// Parallel rays over the screen window, which is in units of the camera's space.
TEST(OrthographicCamera, RaysAreParallelOverTheScreenWindow) {
    const Transform worldToCamera = Transform::LookAt({1, 2, 3}, {4, 4, 4}, {0, 1, 0});
    Entity entity = OfType("orthographic", worldToCamera);
    const Camera standard = MakeCamera(entity, {200, 100});
    const auto inCamera = [&](const Ray &ray) { return worldToCamera.Point(ray.o); };
    EXPECT_LT(Distance(inCamera(standard.GenerateRay({0, 0}, {})), {-2, 1, 0}), 1e-6f);
    EXPECT_LT(Distance(inCamera(standard.GenerateRay({200, 100}, {})), {2, -1, 0}), 1e-6f);
    EXPECT_EQ(standard.PixelAngle(), 0);
    Set(&entity, "screenwindow", {-3, 5, -1, 2});
    const Camera camera = MakeCamera(entity, {200, 100});
    RNG rng(3);
    for (int i = 0; i < 1000; ++i) {
        const Point2f film{200 * rng.UniformFloat(), 100 * rng.UniformFloat()};
        const Ray ray = camera.GenerateRay(film, {0.2f, 0.9f});
        EXPECT_LT(Distance(worldToCamera.Vector(ray.d), {0, 0, 1}), 1e-6f);
        EXPECT_LT(Distance(inCamera(ray), {-3 + 8 * film.x / 200, 2 - 3 * film.y / 100, 0}), 1e-5f);
        const Point2f back = camera.WorldToRaster(ray(40 * rng.UniformFloat()));
        EXPECT_NEAR(back.x, film.x, 1e-3);
        EXPECT_NEAR(back.y, film.y, 1e-3);
        // The matrix of the picture's header: to the screen window
        ASSERT_TRUE(camera.HasCameraToScreen());
        const Point3f screen = (camera.CameraToScreen() * camera.WorldToCamera()).Point(ray(7));
        EXPECT_LT(Distance(screen, {-3 + 8 * film.x / 200, 2 - 3 * film.y / 100, 7}), 1e-5f);
    }
}

// The lens of a film position lies around its ray: all its rays meet at the plane of focus, and a lens that
// shrinks leaves the pinhole's picture.
TEST(OrthographicCamera, ThinLensFocusesOnAPlane) {
    Entity entity = OfType("orthographic");
    Set(&entity, "lensradius", {0.25});
    Set(&entity, "focaldistance", {7});
    const Camera camera = MakeCamera(entity, {320, 240});
    RNG rng(5);
    float widest = 0;
    for (int i = 0; i < 2000; ++i) {
        const Point2f film{320 * rng.UniformFloat(), 240 * rng.UniformFloat()};
        const Ray ray = camera.GenerateRay(film, {rng.UniformFloat(), rng.UniformFloat()});
        const Ray pinhole = MakeCamera(OfType("orthographic"), {320, 240}).GenerateRay(film, {});
        const float offset = Distance(ray.o, pinhole.o);
        EXPECT_LE(offset, 0.25f * (1 + 1e-5f));
        widest = std::max(widest, offset);
        EXPECT_LT(Distance(ray(7 / ray.d.z), pinhole(7)), 1e-5f);
    }
    EXPECT_GT(widest, 0.24f);
}

// Equal areas of the film get solid angles by the sine of their row: together, with that weight, the rays
// cover the sphere once, and the direction of each pixel is the one of pbrt-v3.
TEST(EnvironmentCamera, CoversTheSphere) {
    const Transform worldToCamera = Transform::Rotate(50, {1, 2, 1}) * Transform::Translate({-1, -2, -3});
    const Point2i resolution{80, 40};
    const Camera camera = MakeCamera(OfType("environment", worldToCamera), resolution);
    double area = 0, moments[3][3] = {};
    Vector3d sum;
    for (int y = 0; y < resolution.y; ++y)
        for (int x = 0; x < resolution.x; ++x) {
            const Point2f film{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
            const Ray ray = camera.GenerateRay(film, {0.1f, 0.8f});
            EXPECT_LT(Distance(ray.o, {1, 2, 3}), 1e-6f);
            EXPECT_NEAR(ray.d.Length(), 1, 1e-6);
            const Point2f back = camera.WorldToRaster(ray(3));
            EXPECT_NEAR(back.x, film.x, 1e-3);
            EXPECT_NEAR(back.y, film.y, 1e-3);
            const double theta = kPi<double> * (y + 0.5) / resolution.y;
            const double weight = std::sin(theta) * 2 * Sqr(kPi<double>) / (resolution.x * resolution.y);
            const Vector3d d(ray.d);
            area += weight;
            sum += d * weight;
            const double v[3] = {d.x, d.y, d.z};
            for (size_t i = 0; i < 3; ++i)
                for (size_t j = 0; j < 3; ++j)
                    moments[i][j] += v[i] * v[j] * weight;
        }
    EXPECT_NEAR(area, 4 * kPi<double>, 1e-2);
    EXPECT_LT(sum.Length(), 1e-4);
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j)
            EXPECT_NEAR(moments[i][j], i == j ? 4 * kPi<double> / 3 : 0, 1e-2);
    // Up, and the four sides
    const Camera plain = MakeCamera(OfType("environment"), {4, 2});
    EXPECT_LT(Distance(plain.GenerateRay({1, 0}, {}).d, {0, 1, 0}), 1e-6f);
    EXPECT_LT(Distance(plain.GenerateRay({0, 1}, {}).d, {1, 0, 0}), 1e-6f);
    EXPECT_LT(Distance(plain.GenerateRay({1, 1}, {}).d, {0, 0, 1}), 1e-6f);
    EXPECT_LT(Distance(plain.GenerateRay({2, 1}, {}).d, {-1, 0, 0}), 1e-6f);
    EXPECT_LT(Distance(plain.GenerateRay({3, 1}, {}).d, {0, 0, -1}), 1e-6f);
    EXPECT_FALSE(plain.HasCameraToScreen());
}

// Two thin lenses in one: the lensmaker's formula gives the stand-in's focal length, with the film's
// diagonal its view.
TEST(RealisticCamera, StandsInWithTheLensesFocalLength) {
    const std::string path = testing::TempDir() + "cuticle_lens.dat";
    // Glass of 1.5 between radii of 60 and -30 mm, 4 mm thick, behind it a stop.
    std::ofstream(path) << "# radius thickness eta aperture\n60 4 1.5 20\n-30 1 1 20\n0 40 0 15 # the stop\n";
    const double power = 0.5 * (1 / 60. + 1 / 30. - 0.5 * 4 / (1.5 * 60 * 30));
    Entity entity = OfType("realistic");
    Param file;
    file.type = ParamType::String;
    file.name = "lensfile";
    file.strings = {path};
    entity.params.params.push_back(file);
    Set(&entity, "aperturediameter", {8});
    Set(&entity, "focusdistance", {2});
    FlushWarnings();
    const CameraParameters p = MakeCamera(entity, {300, 400}, 50).Parameters();
    EXPECT_EQ(FlushWarnings(), 1u);
    EXPECT_NEAR(p.fov, 2 * std::atan(15 * power) * 180 / kPi<double>, 1e-3);
    EXPECT_FLOAT_EQ(p.lensRadius, 0.004f);
    EXPECT_EQ(p.focalDistance, 2);
    // A photographer's lens: Tronnier's double Gauss (US patent 2673491), scaled to 50 mm
    std::ofstream(path)
        << "29.475 3.76 1.67 25.2\n84.83 .12 1 25.2\n19.275 4.025 1.67 23\n40.77 3.275 1.699 23\n"
           "12.75 5.705 1 18\n0 4.5 0 17.1\n-14.495 1.18 1.603 17\n40.77 6.065 1.658 20\n"
           "-20.385 .19 1 20\n437.065 3.22 1.717 20\n-39.73 5 1 20\n";
    const float view = MakeCamera(entity, {300, 400}, 50).Parameters().fov;
    EXPECT_NEAR(15 / std::tan(Radians(view / 2)), 50, 0.5);
    EXPECT_EQ(FlushWarnings(), 1u);
    // No file: 50 mm
    testing::internal::CaptureStderr();
    EXPECT_NEAR(MakeCamera(OfType("realistic"), {300, 400}, 50).Parameters().fov,
                Degrees(2 * std::atan(15 / 50.f)), 1e-3);
    EXPECT_EQ(FlushWarnings(), 1u);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("(it has no \"lensfile\")"), std::string::npos);
}

// For the ends of film and lens, every camera of the table gives a ray of unit length from its lens; all rays
// of one film position meet at the plane of focus.
TEST(Camera, RaysHoldAtTheEnds) {
    testing::internal::CaptureStderr(); // a camera that is not rendered is told of
    for (const PluginInfo &row : CameraPlugins().rows)
        for (const double lens : {0., 1e-6, 0.25, 50.})
            for (const double focus : {1e-2, 7., 1e6})
                for (const double fov : {0.1, 90., 179.}) {
                    Entity entity = OfType(std::string(row.name));
                    const auto set = [&](std::string_view name, double value) {
                        if (row.FindParam(name))
                            Set(&entity, std::string(name), {value});
                    };
                    set("lensradius", lens), set("focaldistance", focus), set("fov", fov);
                    set("aperturediameter", 2000 * lens), set("focusdistance", focus);
                    const Camera camera = MakeCamera(entity, {640, 480});
                    const float radius = camera.Parameters().lensRadius;
                    const bool lensless = camera.Parameters().projection == Projection::Environment;
                    ForEachEnd([&](const Point2f &film) {
                        const Point2f p(640 * film.x, 480 * film.y);
                        const Ray middle = camera.GenerateRay(p, {0.5f, 0.5f});
                        const auto inFocus = [&](const Ray &ray) {
                            return Vector3d(ray.o) + Vector3d(ray.d) * (focus / double{ray.d.z});
                        };
                        ForEachEnd([&](const Point2f &u) {
                            const Ray ray = camera.GenerateRay(p, u);
                            ASSERT_TRUE(IsFinite(ray.o) && IsUnit(ray.d)) << row.name << film << u;
                            ASSERT_LE(Distance(ray.o, middle.o),
                                      radius * (1 + 1e-6f) + 2e-7f * ray.o.Length())
                                << row.name << film << u;
                            if (lensless)
                                return;
                            const Vector3d a = inFocus(ray), b = inFocus(middle);
                            // A direction is rounded by 1e-7, seen at its slant
                            const double slant = std::min(double{ray.d.z}, double{middle.d.z});
                            ASSERT_LT((a - b).Length(),
                                      4e-7 * (focus / Sqr(slant) + double{radius} + b.Length()))
                                << row.name << film << u << " " << lens << " " << focus << " " << fov;
                        });
                    });
                }
    FlushWarnings();
    testing::internal::GetCapturedStderr();
}

TEST(Camera, RefusesNonsense) {
    const auto with = [](const std::string &name, std::vector<double> values) {
        Entity entity = Perspective();
        Set(&entity, name, std::move(values));
        return entity;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Entity &bad : {with("fov", {0}), with("fov", {180}), with("fov", {-20}), with("fov", {nan}),
                              with("lensradius", {-1}), with("lensradius", {nan}), with("focaldistance", {0}),
                              with("frameaspectratio", {0}), Perspective(Transform::Translate({2e18, 0, 0})),
                              with("screenwindow", {1, 1, 0, 1}), Perspective(Transform::Scale(1, 0, 1)),
                              Perspective(Transform::LookAt({1, 1, 1}, {1, 1, 1}, {0, 1, 0}))})
        EXPECT_THROW(MakeCamera(bad, {10, 10}), Error);
    EXPECT_THROW(MakeCamera(Perspective(), {0, 10}), Error);

    Entity unknown = Perspective();
    unknown.type = "perspektive";
    try {
        MakeCamera(unknown, {10, 10});
        FAIL() << "an unknown camera was taken";
    } catch (const Error &e) {
        EXPECT_NE(std::string(e.what()).find("\"perspective\""), std::string::npos) << e.what();
    }
    // What the others read, and a parameter that is not theirs
    for (const char *name : {"orthographic", "environment"}) {
        Entity other = OfType(name);
        for (const char *p :
             {"lensradius", "focaldistance", "frameaspectratio", "shutteropen", "shutterclose"})
            Set(&other, p, {1});
        FlushWarnings();
        MakeCamera(other, {10, 10});
        EXPECT_EQ(FlushWarnings(), 0u) << name;
        Set(&other, "fov", {30});
        MakeCamera(other, {10, 10});
        EXPECT_EQ(FlushWarnings(), 1u) << name;
    }
}

} // namespace
} // namespace cuticle
