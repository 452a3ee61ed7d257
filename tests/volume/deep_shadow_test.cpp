// Laws of deep shadows: the stated error of the compression, the places of a map, and shares that are known.
#include "volume/deep_shadow.h"

#include "core/sampling.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cuticle {
namespace {

// Steps at random depths, some at one depth, some large.
std::vector<VisibilityPoint> RandomSteps(RNG &rng, int count) {
    std::vector<VisibilityPoint> steps;
    float depth = rng.UniformFloat(), share = 1;
    for (int i = 0; i < count; ++i) {
        share *= rng.UniformFloat() < 0.1f ? 0.6f : 1 - 0.05f * rng.UniformFloat();
        steps.push_back({depth, rng.UniformFloat() < 0.02f ? (share = 0) : share});
        depth += rng.UniformFloat() < 0.2f ? 2 * rng.UniformFloat() : 0.05f * rng.UniformFloat() + 1e-4f;
    }
    return steps;
}
float StepsAt(const std::vector<VisibilityPoint> &steps, float depth) {
    float share = 1;
    for (const VisibilityPoint &s : steps)
        if (s.depth <= depth)
            share = s.share;
    return share;
}

TEST(DeepShadow, CompressionKeepsItsErrorEverywhere) {
    RNG rng(1);
    size_t before = 0, after = 0;
    for (const float error : {0.f, 0.003f, 0.02f, 0.1f})
        for (int n = 0; n < 200; ++n) {
            const auto steps = RandomSteps(rng, 1 + static_cast<int>(60 * rng.UniformFloat()));
            const auto pieces = CompressVisibility(steps, error);
            float last = 1;
            for (size_t i = 0; i < pieces.size(); ++i) {
                ASSERT_LE(pieces[i].share, last + 1e-6f) << "light never grows";
                ASSERT_TRUE(i == 0 || pieces[i].depth >= pieces[i - 1].depth);
                last = pieces[i].share;
            }
            // Just before and just behind every step, and between
            for (const VisibilityPoint &s : steps)
                for (const float depth :
                     {std::nextafter(s.depth, 0.f), s.depth, s.depth + 1e-5f, s.depth + 0.01f})
                    ASSERT_NEAR(VisibilityAt(pieces, depth), StepsAt(steps, depth), error + 2e-5f)
                        << error << " " << n;
            ASSERT_EQ(VisibilityAt(pieces, -1), 1);
            if (error == 0.02f)
                before += 2 * steps.size(), after += pieces.size();
        }
    printf("[ compression to 0.02: %zu corners become %zu ]\n", before, after);
    EXPECT_LT(3 * after, before);
}

TEST(DeepShadow, NothingInTheWayIsAllOfTheLight) {
    EXPECT_TRUE(CompressVisibility({}, 0.01f).empty());
    EXPECT_EQ(VisibilityAt({}, 5), 1);
}

TEST(DeepShadow, PlacesOfTheMapAreThoseOfItsRays) {
    const Bounds3f bounds{{-1, 2, 3}, {2, 4, 9}};
    RNG rng(2);
    for (const LightRays &rays :
         {LightRays::Parallel(Normalize(Vector3f{1, -2, 0.5f}), bounds), LightRays::From({0.5f, 3, -20})})
        for (int n = 0; n < 500; ++n) {
            const Point2f u{rng.UniformFloat(), rng.UniformFloat()};
            const Ray ray = rays.At(u);
            EXPECT_NEAR(ray.d.Length(), 1, 1e-6f);
            const float t = 0.1f + 10 * rng.UniformFloat();
            float depth;
            const Point2f place = rays.PlaceOf(ray(t), &depth);
            EXPECT_NEAR(depth, t, 1e-4f);
            EXPECT_NEAR(place.x, u.x, 2e-4f);
            EXPECT_NEAR(place.y, u.y, 2e-4f);
        }
    // All of the bounds lie on a map of parallel rays
    const LightRays rays = LightRays::Parallel(Normalize(Vector3f{1, -2, 0.5f}), bounds);
    for (int corner = 0; corner < 8; ++corner) {
        float depth;
        const Point2f u = rays.PlaceOf({corner & 1 ? bounds.pMax.x : bounds.pMin.x,
                                        corner & 2 ? bounds.pMax.y : bounds.pMin.y,
                                        corner & 4 ? bounds.pMax.z : bounds.pMin.z},
                                       &depth);
        EXPECT_TRUE(u.x >= 0 && u.x <= 1 && u.y >= 0 && u.y <= 1 && depth >= 0);
    }
}

// Layers that all rays cross at the depths 1, 2, 3, ...: n of them leave (1 - opacity)^n, and a wall nothing.
TEST(DeepShadow, LayersTakeTheirShares) {
    DeepShadowSettings settings;
    settings.side = 8, settings.opacity = 0.3f, settings.error = 0.001f;
    const LightRays rays = LightRays::Parallel({0, 0, -1}, {{-1, -1, -10}, {1, 1, 10}});
    const DeepShadowMap map(rays, settings, [](const Ray &, const std::function<void(float)> &crossing) {
        for (int i = 1; i <= 9; ++i)
            crossing(static_cast<float>(i));
        return 9.5f;
    });
    for (int n = 0; n < 9; ++n) {
        // Depth counts from the map, which stands before the bounds
        const Point3f p = rays.origin + rays.frame.z * (static_cast<float>(n) + 0.5f) +
                          (rays.frame.x + rays.frame.y) * (rays.width / 2);
        EXPECT_NEAR(map.Share(p, 0), std::pow(0.7f, static_cast<float>(n)), 0.0011f) << n;
    }
    EXPECT_NEAR(map.Share(rays.origin + rays.frame.z * 9.6f, 0), 0, 0.0011f);
    EXPECT_GT(map.Steps(), 64u * 9);
}

} // namespace
} // namespace cuticle
