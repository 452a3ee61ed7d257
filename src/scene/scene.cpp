#include "scene/scene.h"

#include "core/error.h"
#include "grooms/groom.h"
#include "grooms/groom_file.h"
#include "grooms/head_shape.h"
#include "grooms/procedural.h"
#include "scene/plugins.h"
#include "shapes/loop_subdivision.h"
#include "shapes/ply.h"
#include "shapes/strand_normals.h"

#include <algorithm>

namespace cuticle {

namespace {} // namespace

// What is needed only while the scene is made.
class Scene::Builder {
  public:
    Builder(Scene *scene, SceneDescription *description, const SceneOptions &options)
        : scene_(*scene), description_(*description), options_(options),
          textures_(description->floatTextures, description->spectrumTextures) {}

    void Build() {
        for (const MaterialEntity &entity : description_.materials)
            scene_.materials_.push_back(
                MakeMaterial(entity, textures_, options_.materials, scene_.materials_));
        CurvePool curves = std::move(description_.curves);
        for (const ShapeEntity &shape : description_.shapes)
            AddShape(shape, shape.objectToWorld, &curves);
        for (const ObjectUse &use : description_.instances)
            AddInstance(use, &curves);
        for (const ShapeEntity &shape : description_.shapes)
            shape.params.ReportUnused("Shape \"" + shape.type + "\"");
        description_.objects.clear();
        FinishCurves(std::move(curves));
        scene_.solids_.Commit();
        scene_.haveSolids_ = scene_.solids_.Geometries() > 0;
        MakeLights();
    }

  private:
    const Material *MaterialOf(const ShapeState &state) const {
        return scene_.materials_[static_cast<size_t>(state.material)].get();
    }

    void AddInstance(const ObjectUse &use, CurvePool *curves) {
        const ObjectDefinition &object = description_.objects[static_cast<size_t>(use.object)];
        for (const ShapeEntity &shape : object.shapes)
            AddShape(shape, use.instanceToWorld * shape.objectToWorld, curves);
        // This version copies what it instances; widths follow the mean scale, as for curves outside instances
        const float scale = static_cast<float>(std::cbrt(std::abs(use.instanceToWorld.Determinant())));
        const size_t first = curves->segments.size();
        for (CurveSegment segment : object.curves.segments) {
            for (Point3f &p : segment.cp)
                p = use.instanceToWorld.Point(p);
            for (float &w : segment.width)
                w *= scale;
            curves->segments.push_back(segment);
        }
        for (const auto &[index, ribbon] : object.curves.ribbonNormals) {
            RibbonNormals n;
            for (size_t i = 0; i < 2; ++i)
                n.n[i] = Normalize(use.instanceToWorld.Normal(ribbon.n[i]));
            curves->ribbonNormals[static_cast<uint32_t>(first + index)] = n;
        }
    }

    void AddShape(const ShapeEntity &shape, const Transform &toWorld, CurvePool *curves) {
        const ParamSet &p = shape.params;
        const PlaceScope here(p.loc);
        for (const char *name : {"alpha", "shadowalpha"})
            if (const Param *alpha = p.Find(name)) {
                alpha->used = true;
                Warning(p.loc, "alpha masks are not rendered",
                        "\"" + std::string(name) + "\" is not rendered; the shape is opaque everywhere");
            }
        if (shape.type == "hairfile" || shape.type == "groom")
            return AddGroom(shape, toWorld, curves);
        if (const std::string standIn(StandInOf(PluginKind::Shape, shape.type)); !standIn.empty()) {
            for (const Param &param : p.params)
                param.used = true;
            return Warning(p.loc, "shape \"" + shape.type + "\" is not rendered",
                           "shape \"" + shape.type + "\" is not rendered; it is " + standIn);
        }
        // Without a material light passes a surface: it is no surface, unless it emits
        const bool visible = MaterialOf(shape.state) != nullptr || shape.state.areaLight >= 0;
        const uint32_t id = static_cast<uint32_t>(scene_.solidInfos_.size());
        const bool flip = shape.state.reverseOrientation;
        const uint32_t geometry = AddSolid(shape, toWorld, id, flip, visible);
        if (!visible)
            return;
        scene_.solidInfos_.push_back({MaterialOf(shape.state), -1});
        if (shape.state.areaLight >= 0)
            emitters_.push_back({id, geometry, shape.state.areaLight});
    }

    uint32_t AddSolid(const ShapeEntity &shape, const Transform &toWorld, uint32_t id, bool flip,
                      bool visible) {
        const ParamSet &p = shape.params;
        SolidSet &solids = scene_.solids_;
        if (std::optional<TriangleMesh> mesh = MakeMesh(shape)) {
            for (Point3f &v : mesh->p)
                v = toWorld.Point(v);
            for (Normal3f &n : mesh->n)
                n = Normalize(toWorld.Normal(n));
            return visible ? solids.AddMesh(std::move(*mesh), id, flip ^ toWorld.SwapsHandedness()) : 0;
        }
        const float phiMax = p.FindFloat("phimax", 360), radius = p.FindFloat("radius", 1);
        if (shape.type == "sphere") {
            const float zMin = p.FindFloat("zmin", -radius), zMax = p.FindFloat("zmax", radius);
            return visible ? solids.AddSphere(toWorld, radius, zMin, zMax, phiMax, id, flip) : 0;
        }
        if (shape.type == "disk") {
            const float height = p.FindFloat("height", 0), inner = p.FindFloat("innerradius", 0);
            return visible ? solids.AddDisk(toWorld, height, radius, inner, phiMax, id, flip) : 0;
        }
        if (shape.type == "cylinder") {
            const float zMin = p.FindFloat("zmin", -1), zMax = p.FindFloat("zmax", 1);
            return visible ? solids.AddCylinder(toWorld, radius, zMin, zMax, phiMax, id, flip) : 0;
        }
        if (shape.type == "cone") {
            const float height = p.FindFloat("height", 1);
            return visible ? solids.AddCone(toWorld, radius, height, phiMax, id, flip) : 0;
        }
        if (shape.type == "paraboloid") {
            const float zMin = p.FindFloat("zmin", 0), zMax = p.FindFloat("zmax", 1);
            return visible ? solids.AddParaboloid(toWorld, radius, zMin, zMax, phiMax, id, flip) : 0;
        }
        if (shape.type == "hyperboloid") {
            const Point3f p1 = p.FindPoint3f("p1", {0, 0, 0}), p2 = p.FindPoint3f("p2", {1, 1, 1});
            return visible ? solids.AddHyperboloid(toWorld, p1, p2, phiMax, id, flip) : 0;
        }
        const std::vector<std::string_view> names = PluginNames(PluginKind::Shape);
        throw Error(p.loc, "unknown shape \"" + shape.type + "\"." +
                               Suggestion(shape.type, names.data(), names.size()));
    }

    static std::string Filename(const ParamSet &p) {
        std::string name = p.FindFilename("filename");
        if (name.empty())
            throw Error(p.loc, "this shape needs \"string filename\"");
        return name;
    }

    // The head and shoulders that procedural grooms grow on.
    static TriangleMesh HeadOf(const ParamSet &p) {
        HeadMesh head = MakeHeadMesh(p.FindFloat("spacing", 0.3f));
        return {std::move(head.points), std::move(head.normals), {}, std::move(head.indices)};
    }

    // What the shapes that are meshes say, in their own coordinates; nothing for the others.
    static std::optional<TriangleMesh> MakeMesh(const ShapeEntity &shape) {
        const ParamSet &p = shape.params;
        if (shape.type == "trianglemesh")
            return MeshOf(p);
        if (shape.type == "plymesh")
            return ReadPly(Filename(p));
        if (shape.type == "groomhead")
            return HeadOf(p);
        if (shape.type == "heightfield")
            return HeightFieldOf(p);
        if (shape.type == "loopsubdiv") {
            (void)p.FindString("scheme", "loop"); // pbrt-v3 reads it, and knows no other
            return LoopSubdivide(PointsAndIndices(p, shape.type),
                                 p.FindInt("nlevels", p.FindInt("levels", 3)));
        }
        return {};
    }

    // pbrt-v3's: nu columns and nv rows of heights over the unit square, two triangles a cell.
    static TriangleMesh HeightFieldOf(const ParamSet &p) {
        const int nu = p.FindInt("nu", -1), nv = p.FindInt("nv", -1);
        const std::vector<float> z = p.FindFloats("Pz");
        const int64_t expected = int64_t{nu} * nv;
        if (nu < 2 || nv < 2 || expected != static_cast<int64_t>(z.size()))
            throw Error(
                p.loc, "a heightfield needs \"integer nu\" and \"integer nv\" of at least 2, and nu times nv "
                       "numbers \"float Pz\"; there are " +
                           std::to_string(z.size()) + " for nu " + std::to_string(nu) + " and nv " +
                           std::to_string(nv));
        TriangleMesh mesh;
        for (int y = 0; y < nv; ++y)
            for (int x = 0; x < nu; ++x) {
                const Point2f uv{static_cast<float>(x) / static_cast<float>(nu - 1),
                                 static_cast<float>(y) / static_cast<float>(nv - 1)};
                mesh.p.push_back({uv.x, uv.y, z[mesh.p.size()]});
                mesh.uv.push_back(uv);
            }
        const auto width = static_cast<uint32_t>(nu);
        for (uint32_t y = 0; y + 1 < static_cast<uint32_t>(nv); ++y)
            for (uint32_t x = 0; x + 1 < width; ++x) {
                const uint32_t a = y * width + x, b = a + 1, c = b + width, d = a + width;
                mesh.indices.insert(mesh.indices.end(), {a, b, c, a, c, d});
            }
        return mesh;
    }

    static TriangleMesh PointsAndIndices(const ParamSet &p, const std::string &shape) {
        TriangleMesh mesh;
        mesh.p = p.FindPoint3fs("P");
        const std::vector<int> indices = p.FindInts("indices");
        if (indices.empty() || mesh.p.empty())
            throw Error(p.loc, "a " + shape + " needs \"integer indices\" and \"point P\"; " +
                                   (indices.empty() ? "\"indices\"" : "\"P\"") + " is missing or empty");
        for (int i : indices) {
            if (i < 0 || static_cast<size_t>(i) >= mesh.p.size())
                throw Error(p.loc, "vertex index " + std::to_string(i) + " is out of range; there are " +
                                       std::to_string(mesh.p.size()) + " points, counted from 0");
            mesh.indices.push_back(static_cast<uint32_t>(i));
        }
        return mesh;
    }

    static TriangleMesh MeshOf(const ParamSet &p) {
        TriangleMesh mesh = PointsAndIndices(p, "trianglemesh");
        mesh.n = p.FindNormals("N");
        for (const char *name : {"uv", "st"})
            if (mesh.uv.empty())
                mesh.uv = p.FindPoint2fs(name);
        if (!mesh.uv.empty() && mesh.uv.size() != mesh.p.size()) {
            Warning(p.loc, "wrong number of texture coordinates",
                    "there are " + std::to_string(mesh.uv.size()) + " texture coordinates for " +
                        std::to_string(mesh.p.size()) + " points; they are ignored");
            mesh.uv.clear();
        }
        if (!mesh.n.empty() && mesh.n.size() != mesh.p.size())
            throw Error(p.loc, "there are " + std::to_string(mesh.n.size()) + " normals for " +
                                   std::to_string(mesh.p.size()) + " points; give one for each");
        (void)p.Find("S", ParamType::Vector3); // tangents: nothing that we render turns by them
        (void)p.Find("faceIndices", ParamType::Integer);
        return mesh;
    }

    // Shape "groom": the parameters are the same table as the command line's.
    static Groom GrowGroom(const ParamSet &p) {
        const std::string kind = p.FindString("kind", "head");
        GroomParams params = MakeGroomParams(kind, p.FindString("style", ""));
        for (const GroomParamInfo &info : GroomParamTable())
            if (const Param *given = p.Find(info.name); given && GroomReads(kind, info))
                SetGroomParam(&params, info.name,
                              std::holds_alternative<int GroomParams::*>(info.member)
                                  ? static_cast<double>(p.FindInt(info.name, 0))
                                  : static_cast<double>(p.FindFloat(info.name, 0)));
        for (const GroomColorInfo &info : GroomColorTable())
            if (p.Find(info.name))
                SetGroomColor(&params, info.name, p.FindSpectrum(info.name, Spectrum(0)));
        return MakeGroom(params);
    }

    // The strands of a file, and how its curves are to be made.
    static Groom ReadHairFileShape(const ParamSet &p, SegmentOptions *options, float *widthScale) {
        *widthScale *= p.FindFloat("widthscale", 1);
        options->segmentsPerStrand = p.FindInt("segments", 0);
        constexpr int kMostSegments = 10000;
        if (options->segmentsPerStrand < 0 || options->segmentsPerStrand > kMostSegments)
            throw Error(p.loc, "\"segments\" must be 0 (as the file has them) to " +
                                   std::to_string(kMostSegments) + ", not " +
                                   std::to_string(options->segmentsPerStrand));
        const float width = p.FindFloat("width", 0);
        if (p.Find("width") && !(width > 0))
            throw Error(p.loc, "\"width\" must be positive; without it the file's widths are used");
        Groom groom = ReadGroomFile(Filename(p), width);
        if (const std::string name = p.FindString("spline", ""); !name.empty()) {
            options->spline = StrandSplineByName(name);
            if (!options->spline)
                throw Error(p.loc, "unknown spline \"" + name + "\"." +
                                       Suggestion(name, kStrandSplines.data(), kStrandSplines.size()));
            if (groom.spline == StrandSpline::Bezier)
                throw Error(p.loc, "the file's curves are cubic: \"spline\" is for files of points");
        }
        return groom;
    }

    // Strands from a file or a recipe become curve segments of one group.
    void AddGroom(const ShapeEntity &shape, const Transform &toWorld, CurvePool *curves) {
        auto widthScale = static_cast<float>(std::cbrt(std::abs(toWorld.Determinant())));
        SegmentOptions options;
        const Groom groom = shape.type == "hairfile" ? ReadHairFileShape(shape.params, &options, &widthScale)
                                                     : GrowGroom(shape.params);
        if (!MaterialOf(shape.state))
            return;
        const auto group = static_cast<uint32_t>(description_.curveGroups.size());
        description_.curveGroups.push_back({CurveType::Flat, shape.state});
        GroupColors *colors = groom.hasColor ? &scene_.strandColors_[group] : nullptr;
        std::vector<CurveSegment> &segments = curves->segments;
        const size_t needed = segments.size() + ExpectedSegments(groom, options);
        if (needed > segments.capacity()) // exact for one groom, geometric for many
            segments.reserve(std::max(needed, segments.size() + segments.size() / 2));
        if (colors) {
            colors->firstSegment = static_cast<uint32_t>(segments.size());
            if (groom.pointColors.empty())
                colors->colors.push_back({groom.color, groom.color});
            else
                colors->colors.reserve(ExpectedSegments(groom, options));
        }
        ForEachSegment(groom, options, [&](const BezierSegment &piece, size_t strand) {
            CurveSegment segment;
            for (size_t i = 0; i < 4; ++i)
                segment.cp[i] = toWorld.Point(piece.cp[i]);
            for (size_t i = 0; i < 2; ++i)
                segment.width[i] = piece.width[i] * widthScale;
            segment.group = group;
            segments.push_back(segment);
            if (!groom.pointColors.empty())
                colors->colors.push_back(
                    {groom.Color(strand, piece.at[0]), groom.Color(strand, piece.at[1])});
        });
    }

    void FinishCurves(CurvePool curves) {
        std::vector<CurveType> types;
        bool anyHidden = false;
        for (const CurveGroup &group : description_.curveGroups) {
            types.push_back(group.type);
            scene_.curveMaterials_.push_back(MaterialOf(group.state));
            const Material *material = scene_.curveMaterials_.back();
            anyHidden |= !material;
            if (material && material->Bumped())
                Warning("bump maps on curves are not rendered",
                        "bump maps on curves are not rendered; the curves stay smooth");
            if (group.state.areaLight >= 0)
                Warning(description_.areaLights[static_cast<size_t>(group.state.areaLight)].params.loc,
                        "curves do not emit",
                        "area lights on curves are not rendered; the curve does not emit");
        }
        WarnOfAbsentStrandColors();
        // Ribbon normals and strand colours go by the segments' numbers, which must stay then
        if (anyHidden && curves.ribbonNormals.empty() && scene_.strandColors_.empty())
            std::erase_if(curves.segments,
                          [&](const CurveSegment &s) { return !scene_.curveMaterials_[s.group]; });
        if (std::any_of(scene_.curveMaterials_.begin(), scene_.curveMaterials_.end(),
                        [](const Material *m) { return m && m->WantsStrandNormals(); }))
            scene_.strandNormals_ = MakeStrandNormals(curves.segments);
        scene_.haveCurves_ = !curves.segments.empty();
        if (!scene_.haveCurves_)
            return;
        if (options_.binaryCurves) {
            scene_.binaryCurves_.emplace(std::move(curves.segments), std::move(types),
                                         std::move(curves.ribbonNormals));
            return;
        }
        scene_.curves_ =
            CurveSet(std::move(curves.segments), std::move(types), std::move(curves.ribbonNormals));
        if (const size_t dropped = scene_.curves_.DroppedSegments())
            Warning("curves that cannot be met", std::to_string(dropped) +
                                                     " curve segments have points that are not finite, or "
                                                     "no width, and are left out of the picture");
    }

    void WarnOfAbsentStrandColors() const {
        if (!scene_.strandColors_.empty())
            return;
        for (const auto *textures : {&description_.floatTextures, &description_.spectrumTextures})
            for (const TextureEntity &texture : *textures)
                if (texture.type == "strandcolor")
                    Warning(texture.params.loc, "no strand has colours",
                            "no strand of this scene has colours of its own, which Shape \"hairfile\" and "
                            "\"groom\" can give; the texture's \"default\" is used everywhere");
    }

    void MakeLights() {
        const Bounds3f bound = scene_.WorldBound();
        for (const LightEntity &entity : description_.lights) {
            auto light = MakeLight(entity, bound);
            if (light->IsInfinite())
                scene_.infiniteLights_.push_back(static_cast<int>(scene_.lights_.size()));
            scene_.lights_.push_back(std::move(light));
            entity.params.ReportUnused("LightSource \"" + entity.type + "\"");
        }
        for (const auto &[shape, geometry, areaLight] : emitters_) {
            scene_.solidInfos_[shape].light = static_cast<int>(scene_.lights_.size());
            scene_.lights_.push_back(MakeAreaLight(description_.areaLights[static_cast<size_t>(areaLight)],
                                                   &scene_.solids_, geometry));
        }
        for (const Entity &entity : description_.areaLights)
            entity.params.ReportUnused("AreaLightSource \"" + entity.type + "\"");
        std::vector<const Light *> pointers;
        for (const auto &light : scene_.lights_)
            pointers.push_back(light.get());
        scene_.lightSampler_ = LightSampler(pointers);
        if (pointers.empty())
            Warning("no lights", "the scene has no lights: the picture will be black");
    }

    struct Emitter {
        uint32_t shape, geometry;
        int areaLight;
    };
    Scene &scene_;
    SceneDescription &description_;
    const SceneOptions &options_;
    TextureTable textures_;
    std::vector<Emitter> emitters_;
};

Scene::Scene(SceneDescription *description, const SceneOptions &options) {
    Builder(this, description, options).Build();
}

const StrandColors *Scene::StrandColorsOf(uint32_t group, uint32_t segment) const {
    const auto found = strandColors_.find(group);
    if (found == strandColors_.end())
        return nullptr;
    const GroupColors &g = found->second;
    return &g.colors[g.colors.size() == 1 ? 0 : segment - g.firstSegment];
}

bool Scene::Intersect(const SceneRay &sceneRay, SurfaceInteraction *si) const {
    Ray ray = sceneRay.ray;
    SolidHit solid;
    const bool hitSolid = haveSolids_ && solids_.Intersect(ray, &solid);
    if (hitSolid)
        ray.tMax = solid.t;
    CurveHit curve;
    const CurveOrigin *origin = sceneRay.fromCurve ? &sceneRay.origin : nullptr;
    bool hitCurve = false;
    if (haveCurves_)
        hitCurve = binaryCurves_ ? binaryCurves_->Intersect(ray, origin, &curve)
                                 : curves_.Intersect(ray, origin, &curve);
    si->wo = -ray.d;
    if (hitCurve) {
        const CurveSurface s =
            binaryCurves_ ? binaryCurves_->Surface(ray, curve) : curves_.Surface(ray, curve);
        const CurveSegment &segment =
            binaryCurves_ ? binaryCurves_->Segment(curve.segment) : curves_.Segment(curve.segment);
        const uint32_t group = segment.group;
        si->t = curve.t;
        si->p = s.p;
        si->pError = {s.pError, s.pError, s.pError};
        si->n = s.n;
        si->uv = s.uv;
        si->shading = {s.tangent, Cross(s.n, s.tangent), s.n};
        si->material = curveMaterials_[group];
        si->light = -1;
        si->isCurve = true;
        si->curveOrigin = {curve.segment, curve.u};
        si->strandColors = strandColors_.empty() ? nullptr : StrandColorsOf(group, curve.segment);
        if (!strandNormals_.empty())
            si->strandNormal = StrandNormal(segment, strandNormals_[curve.segment], curve.u, s.tangent);
        return true;
    }
    if (!hitSolid)
        return false;
    si->t = solid.t;
    si->p = solid.p;
    si->pError = solid.pError;
    si->n = solid.n;
    si->uv = solid.uv;
    si->dpdu = solid.dpdu;
    si->dpdv = solid.dpdv;
    Vector3f x = solid.dpdu - solid.ns * Dot(solid.ns, solid.dpdu), y;
    if (x.LengthSquared() > 0)
        x = Normalize(x);
    else
        CoordinateSystem(solid.ns, &x, &y);
    si->shading = {x, Cross(solid.ns, x), solid.ns};
    si->material = solidInfos_[solid.shapeId].material;
    si->light = solidInfos_[solid.shapeId].light;
    si->isCurve = false;
    si->strandColors = nullptr;
    si->strandNormal = {};
    si->geometryId = solid.geometryId;
    si->primId = solid.primId;
    return true;
}

bool Scene::Occluded(const SceneRay &ray) const {
    if (haveSolids_ && solids_.Occluded(ray.ray))
        return true;
    if (!haveCurves_)
        return false;
    const CurveOrigin *origin = ray.fromCurve ? &ray.origin : nullptr;
    return binaryCurves_ ? binaryCurves_->Occluded(ray.ray, origin) : curves_.Occluded(ray.ray, origin);
}

SceneRay Scene::SpawnRay(const SurfaceInteraction &si, const Vector3f &w) const {
    SceneRay ray;
    ray.ray.d = w;
    ray.fromCurve = si.isCurve;
    ray.origin = si.curveOrigin;
    ray.ray.o = si.isCurve ? si.p : OffsetRayOrigin(si.p, si.pError, si.n, w);
    return ray;
}

float Scene::AreaLightPdf(const Point3f &ref, const SurfaceInteraction &si) const {
    SolidHit hit;
    hit.t = si.t;
    hit.p = si.p;
    hit.pError = si.pError;
    hit.n = si.n;
    hit.ns = si.shading.z;
    hit.uv = si.uv;
    hit.geometryId = si.geometryId;
    hit.primId = si.primId;
    return AreaLightAt(si.light).Pdf_Li(ref, hit);
}

Bounds3f Scene::WorldBound() const {
    Bounds3f b = solids_.WorldBound();
    if (haveCurves_)
        b.Extend(binaryCurves_ ? binaryCurves_->WorldBound() : curves_.WorldBound());
    return b;
}

size_t Scene::Curves() const {
    return binaryCurves_ ? binaryCurves_->SegmentCount() : curves_.SegmentCount();
}
size_t Scene::MemoryBytes() const {
    return solids_.MemoryBytes() + (binaryCurves_ ? binaryCurves_->MemoryBytes() : curves_.MemoryBytes()) +
           strandNormals_.size() * sizeof(Vector3f);
}
const char *Scene::Isa() const { return binaryCurves_ ? "scalar" : curves_.Isa(); }

} // namespace cuticle
