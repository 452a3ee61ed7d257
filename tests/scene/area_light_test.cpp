// Area lights: irradiances known in closed form, and densities of the samples.
#include "core/sampling.h"
#include "materials/material.h"
#include "sampler_ends.h"
#include "scene/plugins.h"
#include "scene/scene.h"
#include "warnings.h"

#include <gtest/gtest.h>

#include <fstream>
#include <unistd.h>

namespace cuticle {
namespace {

std::unique_ptr<DiffuseAreaLight> AreaLight(const SolidSet *solids, uint32_t id, bool twoSided = false) {
    Entity entity;
    entity.type = "diffuse";
    Param radiance;
    radiance.type = ParamType::Spectrum;
    radiance.name = "L";
    radiance.numbers = {2, 2, 2};
    entity.params.params.push_back(radiance);
    if (twoSided) {
        Param p;
        p.type = ParamType::Bool;
        p.name = "twosided";
        p.bools = {true};
        entity.params.params.push_back(p);
    }
    return MakeAreaLight(entity, solids, id);
}

// Irradiance at ref on a plane of normal n, by samples on a grid. Every sample's way must be free up to its
// distance, since there is nothing but the emitter.
double Irradiance(const Light &light, const SolidSet &solids, const Point3f &ref, const Normal3f &n,
                  int *shadowed) {
    constexpr int kGrid = 300;
    double sum = 0;
    for (int i = 0; i < kGrid; ++i)
        for (int j = 0; j < kGrid; ++j) {
            LightSample s;
            const Point2f u{(static_cast<float>(i) + 0.5f) / kGrid, (static_cast<float>(j) + 0.5f) / kGrid};
            if (!light.Sample_Li(ref, u, &s))
                continue;
            *shadowed += solids.Occluded({ref, s.wi, 0, s.distance});
            sum += static_cast<double>(s.L[0] * std::max(0.f, Dot(s.wi, n)) / s.pdf);
        }
    return sum / (kGrid * kGrid);
}

// Irradiances in closed form, L = 2: a disk over a point of its axis, pi L r^2 / (r^2 + d^2); a sphere, pi L
// r^2 / d^2; a rectangle of two triangles by Lambert's formula.
TEST(AreaLight, IrradianceIsTheClosedForm) {
    int shadowed = 0;
    {
        SolidSet set;
        const uint32_t id = set.AddDisk(Transform::Translate({0, 0, 3}), 0, 1.5f, 0, 360, 0, true);
        set.Commit();
        const auto light = AreaLight(&set, id);
        EXPECT_NEAR(Irradiance(*light, set, {0, 0, 0}, {0, 0, 1}, &shadowed), 2 * kPi<double> * 2.25 / 11.25,
                    1e-4);
        EXPECT_EQ(Irradiance(*light, set, {0, 0, 6}, {0, 0, -1}, &shadowed), 0) << "behind";
        EXPECT_NEAR(light->Power()[0], 2 * Pi * Pi * 2.25f, 1e-3);
        EXPECT_NEAR(Irradiance(*AreaLight(&set, id, true), set, {0, 0, 6}, {0, 0, -1}, &shadowed),
                    2 * kPi<double> * 2.25 / 11.25, 1e-4);
    }
    for (const float d : {1.001f, 1.5f, 10.f, 1e4f}) {
        SolidSet set;
        const uint32_t id = set.AddSphere(Transform::Translate({0, 5, 0}) * Transform::Scale(2, 2, 2), 0.5f,
                                          -1, 1, 360, 0, false);
        set.Commit();
        const auto light = AreaLight(&set, id);
        const double expected = 2 * kPi<double> / Sqr(static_cast<double>(d));
        EXPECT_NEAR(Irradiance(*light, set, {0, 5 - d, 0}, {0, 1, 0}, &shadowed) / expected, 1, 2e-4)
            << "distance " << d;
    }
    {
        SolidSet set;
        TriangleMesh mesh;
        mesh.p = {{0, 0, 2}, {3, 0, 2}, {3, 1, 2}, {0, 1, 2}};
        mesh.indices = {0, 2, 1, 0, 3, 2};
        const uint32_t id = set.AddMesh(mesh, 0, false);
        set.Commit();
        const auto light = AreaLight(&set, id);
        const Point3f ref(0.5f, -0.5f, 0);
        const Normal3f n = Normalize(Normal3f(0.1f, 0.3f, 1));
        double edges = 0;
        for (size_t i = 0; i < 4; ++i) {
            const Vector3d a = Normalize(Vector3d(mesh.p[i] - ref)),
                           b = Normalize(Vector3d(mesh.p[(i + 1) % 4] - ref));
            edges += std::acos(Dot(a, b)) * Dot(Normalize(Cross(a, b)), Vector3d(n));
        }
        EXPECT_NEAR(Irradiance(*light, set, ref, n, &shadowed) / std::abs(edges), 1,
                    2e-4); // L / 2 = 1 times the sum
    }
    EXPECT_EQ(shadowed, 0) << "of 9 x 90000 shadow rays";
}

// A ray that meets the light by chance has the density that the light's own sampling has there.
TEST(AreaLight, PdfOfAHitIsTheSamplesPdf) {
    SolidSet set;
    const uint32_t id = set.AddCylinder(Transform::Rotate(30, {1, 1, 0}), 0.5f, -1, 1, 300, 0, false);
    set.Commit();
    const auto light = AreaLight(&set, id, true);
    RNG rng(3);
    int tried = 0;
    for (int i = 0; i < 5000; ++i) {
        const Point3f ref = UniformSampleSphere({rng.UniformFloat(), rng.UniformFloat()}) * 4.f;
        LightSample s;
        if (!light->Sample_Li(ref, {rng.UniformFloat(), rng.UniformFloat()}, &s))
            continue;
        SolidHit hit;
        // Points of the far side of the tube are seen through the near one: only those in plain view.
        if (!set.Intersect({ref, s.wi, 0, s.distance * 1.01f}, &hit) || hit.t < s.distance * 0.999f ||
            AbsDot(hit.n, s.wi) < 0.05f)
            continue;
        ++tried;
        EXPECT_NEAR(light->Pdf_Li(ref, hit) / s.pdf, 1, 1e-3);
        EXPECT_EQ(light->L(hit.n, -s.wi), s.L);
    }
    EXPECT_GT(tried, 1500);
}

// The least that a shape needs to be made; none for those of hair, which do not emit.
std::optional<std::string> Needed(std::string_view name, const std::string &mesh) {
    if (name == "curve" || name == "hairfile" || name == "groom")
        return {};
    if (name == "trianglemesh" || name == "loopsubdiv")
        return "\"point P\" [0 0 0 2 0 0 0 1 0 0 0 .3] \"integer indices\" [0 1 2 0 3 1 0 2 3 1 3 2] ";
    if (name == "plymesh")
        return "\"string filename\" \"" + mesh + "\" ";
    if (name == "heightfield")
        return "\"integer nu\" 3 \"integer nv\" 2 \"float Pz\" [0 .2 0 .1 0 .3] ";
    if (name == "hyperboloid")
        return "\"point p1\" [1 -1 -1] \"point p2\" [1 1 1] ";
    return "";
}

// Places from which a shape about the origin is seen: around it, in it, on its axis, in the planes of its
// rims, on its surface, and from far and near.
const Point3f kPlaces[] = {{0, 0, 0},    {0, 0, 3},          {0, 0, -3},        {0.3f, 0.2f, 0},  {4, 0, 0},
                           {1, 0, 0},    {0, 0, 1},          {0, 0, 1e-6f},     {-2, 3, 0.5f},    {0, 5, 1},
                           {1e6f, 0, 0}, {0, 1e-20f, 1e12f}, {1.000001f, 0, 0}, {0.999999f, 0, 0}};

// At the ends of the square a light on any shape of the table answers with a unit direction, a finite density
// above 0, a distance that is not negative, and its radiance; where the ray meets the point that was sampled,
// the hit's density is the sample's. Parts of shapes, sheared ones and both sides too.
TEST(AreaLight, SamplesHoldAtTheEnds) {
    const PluginTables plugins{&MaterialPlugins(), &TexturePlugins(), &ShapePlugins(), &LightPlugins(),
                               &AreaLightPlugins()};
    const std::string mesh = testing::TempDir() + "area_light_" + std::to_string(getpid()) + ".ply";
    std::ofstream(mesh)
        << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
           "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    int emitters = 0, met = 0, tried = 0;
    for (const PluginInfo &row : ShapePlugins().rows) {
        const std::optional<std::string> needed = Needed(row.name, mesh);
        if (!needed || !row.standIn.empty())
            continue;
        ++emitters;
        for (const char *part : {"", "\"float phimax\" 200 "})
            for (const char *transform : {"", "Rotate 30 1 2 3 Scale 2 -.3 1 ", "Scale 1e-4 1e-4 1e-4 "}) {
                if (*part && !row.FindParam("phimax"))
                    continue;
                SceneDescription d =
                    ParseSceneText(plugins,
                                   fmt::format("WorldBegin AreaLightSource \"diffuse\" \"rgb L\" [1 2 0] "
                                               "\"bool twosided\" \"true\"\n"
                                               "{}\nShape \"{}\" {}{}\nWorldEnd",
                                               transform, row.name, *needed, part),
                                   "test.pbrt", ".");
                const Scene scene(&d, {});
                ASSERT_EQ(scene.LightCount(), 1) << row.name;
                const Light &light = scene.LightAt(0);
                for (const Point3f &ref : kPlaces)
                    ForEachEnd([&](const Point2f &u) {
                        LightSample s;
                        if (!light.Sample_Li(ref, u, &s))
                            return;
                        const std::string at = fmt::format("{} {}{} from {} {} {}, u {} {}", row.name,
                                                           transform, part, ref.x, ref.y, ref.z, u.x, u.y);
                        ASSERT_EQ(FaultOf(s.L, s.pdf), "") << at;
                        ASSERT_TRUE(s.pdf > 0 && s.distance >= 0 && s.distance < Infinity) << at;
                        ASSERT_TRUE(IsUnit(s.wi)) << at << ", length " << s.wi.Length();
                        ASSERT_EQ(s.L, Spectrum(1, 2, 0)) << at;
                        // At an end of u a ray may meet the triangle next door, which is seen under another
                        // angle; at a grazing angle its place is rounding; and from far away or over a thin
                        // shape another side of it lies as far (within 2e-5).
                        const auto inner = [](float x) { return x == 0.618f || x == 0.75f; };
                        if (*transform || ref.Length() > 10 ||
                            (!row.FindParam("phimax") && !(inner(u.x) && inner(u.y))))
                            return;
                        ++tried;
                        SurfaceInteraction si;
                        if (!scene.Intersect({{ref, s.wi, 0.99998f * s.distance}, {}, false, -1}, &si) ||
                            si.t > 1.00002f * s.distance || AbsDot(si.n, s.wi) < 0.1f)
                            return;
                        ++met;
                        ASSERT_NEAR(scene.AreaLightPdf(ref, si) / s.pdf, 1, 2e-3f) << at;
                    });
            }
    }
    std::remove(mesh.c_str());
    FlushWarnings();
    EXPECT_GE(emitters, 10);
    EXPECT_GT(met, tried / 2);
    std::printf("%d shapes, %d of %d samples met again\n", emitters, met, tried);
}

} // namespace
} // namespace cuticle
