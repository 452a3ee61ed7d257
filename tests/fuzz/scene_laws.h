// These laws hold for every scene text, whoever made it: the fuzz targets of scenes share them.
#pragma once

#include "fuzz/fuzz.h"

#include "core/parallel.h"
#include "fibers/hair_lanes.h"
#include "parser/scene_description.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace cuticle {

using SceneReader = std::function<SceneDescription(const ParseOptions &)>;

// Reads one scene in all ways and requires that they agree: the short cut for curves with the general reader,
// and a list of errors with the first error thrown. Returns what was read, and how many errors it has.
inline SceneDescription ReadInAllWays(const SceneReader &read, size_t *errorCount = nullptr) {
    const auto parse = [&](bool fastCurves, std::vector<std::string> *errors) {
        SceneDescription scene;
        ParseOptions options;
        options.collectErrors = errors;
        options.fastCurves = fastCurves;
        Accepts([&] { scene = read(options); });
        return scene;
    };
    std::vector<std::string> fastErrors, slowErrors;
    SceneDescription fast = parse(true, &fastErrors);
    const SceneDescription slow = parse(false, &slowErrors);
    Require(fastErrors == slowErrors);
    const CurveList &a = fast.curves.segments, &b = slow.curves.segments;
    Require(a.size() == b.size());
    for (size_t i = 0; i < a.size(); ++i)
        for (size_t k = 0; k < 4; ++k)
            Require(a[i].cp[k] == b[i].cp[k] && IsFinite(a[i].cp[k]));
    const bool threw = !Accepts([&] { read({}); });
    Require(threw == !fastErrors.empty());
    if (errorCount)
        *errorCount = fastErrors.size();
    return fast;
}

// Whether a scene is legitimate and takes long: recipes of many strands, surfaces divided often, many
// objects, fibers simulated with many rays, paths without end.
inline bool TakesLong(const SceneDescription &scene) {
    const auto isLong = [](const ShapeEntity &s) {
        if (s.type == "groom")
            return s.params.FindInt("strands", 30000) > 200 || s.params.FindInt("segments", 0) > 16;
        if (s.type == "groomhead")
            return s.params.FindFloat("spacing", 0.3f) < 1;
        return s.type == "loopsubdiv" && s.params.FindInt("nlevels", s.params.FindInt("levels", 3)) > 5;
    };
    bool found = std::any_of(scene.shapes.begin(), scene.shapes.end(), isLong);
    for (const ObjectDefinition &o : scene.objects)
        found |= std::any_of(o.shapes.begin(), o.shapes.end(), isLong);
    for (const MaterialEntity &m : scene.materials)
        found |= m.type == "hair" && m.params.FindInt("samples", 16384) > 64 &&
                 m.params.FindString("model", "") == "tabulated";
    for (const LightEntity &l : scene.lights)
        found |= l.params.FindInt("nsamples", l.params.FindInt("samples", 1)) > 64;
    for (const Entity &l : scene.areaLights)
        found |= l.params.FindInt("nsamples", l.params.FindInt("samples", 1)) > 64;
    return found || scene.instances.size() > 1000 || scene.integrator.params.FindInt("maxdepth", 5) > 100;
}

// Renders 4 x 4 pixels in the middle of the film, unless the scene takes long. Whatever the parser lets pass,
// no sample may be NaN or infinite.
inline void RenderMiddle(SceneDescription *scene) {
    static const ThreadLimit oneThread(1);
    const auto window = [](int resolution, float *crop) {
        const auto n = static_cast<float>(std::max(1, resolution));
        crop[0] = std::max(0.f, 0.5f - 2 / n), crop[1] = std::min(1.f, 0.5f + 2 / n);
    };
    RenderStats stats;
    Accepts([&] {
        if (TakesLong(*scene))
            return;
        RenderOptions options;
        options.spp = 2;
        options.threads = 1;
        options.film.crop.emplace();
        window(scene->film.params.FindInt("xresolution", 1280), &(*options.film.crop)[0]);
        window(scene->film.params.FindInt("yresolution", 720), &(*options.film.crop)[2]);
        const Scene made(scene, {});
        Render(*scene, made, options, &stats);
    });
    Require(stats.nanSamples == 0);
}

} // namespace cuticle
