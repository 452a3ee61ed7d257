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
#include <sstream>

namespace cuticle {

namespace {} // namespace

namespace {

// z the normal, x along dp/du as far as that is across it.
Frame ShadingFrame(const Vector3f &dpdu, const Vector3f &ns) {
    Vector3f x = dpdu - ns * Dot(ns, dpdu), y;
    if (x.LengthSquared() > 0)
        x = Normalize(x);
    else
        CoordinateSystem(ns, &x, &y);
    return {x, Cross(ns, x), ns};
}

} // namespace

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
            AddShape(shape, &scene_.world_, &curves);
        std::vector<CurvePool> objectCurves = AddObjects();
        NameCurveGroups();
        FinishPart(std::move(curves), &scene_.world_);
        for (size_t i = 0; i < objectCurves.size(); ++i)
            FinishPart(std::move(objectCurves[i]), scene_.objects_[i].get());
        PlaceInstances();
        MakeLights();
    }

  private:
    const Material *MaterialOf(const ShapeState &state) const {
        return scene_.materials_[static_cast<size_t>(state.material)].get();
    }

    // The objects that are used, each once, in their own coordinates.
    std::vector<CurvePool> AddObjects() {
        std::vector<CurvePool> curves;
        partOf_.resize(description_.objects.size());
        for (const ObjectUse &use : description_.instances) {
            auto &part = partOf_[static_cast<size_t>(use.object)];
            if (part)
                continue;
            ObjectDefinition &object = description_.objects[static_cast<size_t>(use.object)];
            scene_.objects_.push_back(std::make_unique<Part>());
            part = scene_.objects_.back().get();
            curves.push_back(std::move(object.curves));
            for (const ShapeEntity &shape : object.shapes)
                AddShape(shape, part, &curves.back());
        }
        return curves;
    }

    void PlaceInstances() {
        for (const ObjectUse &use : description_.instances) {
            const PlaceScope here(use.loc);
            const Part *part = partOf_[static_cast<size_t>(use.object)];
            scene_.instances_.Add(use.instanceToWorld, part->Bound());
            scene_.objectOf_.push_back(part);
        }
        scene_.instances_.Commit();
        description_.objects.clear();
    }

    void AddShape(const ShapeEntity &shape, Part *part, CurvePool *curves) {
        AddShapeUnchecked(shape, part, curves);
        shape.params.ReportUnused("Shape \"" + shape.type + "\"");
    }

    void AddShapeUnchecked(const ShapeEntity &shape, Part *part, CurvePool *curves) {
        const ParamSet &p = shape.params;
        const PlaceScope here(p.loc);
        if (shape.type == "hairfile" || shape.type == "groom")
            return AddGroom(shape, curves);
        const PluginInfo *plugin = ShapePlugins().Find(shape.type);
        if (plugin && !plugin->standIn.empty()) {
            for (const Param &param : p.params)
                param.used = true;
            return Warning(
                p.loc, "shape \"" + shape.type + "\" is not rendered",
                fmt::format("shape \"{}\" is not rendered; it is {}", shape.type, plugin->standIn));
        }
        // Without a material light passes a surface: it is no surface, unless it emits
        const bool visible = MaterialOf(shape.state) != nullptr || shape.state.areaLight >= 0;
        const uint32_t id = static_cast<uint32_t>(part->solidInfos.size());
        const bool flip = shape.state.reverseOrientation;
        const uint32_t geometry = AddSolid(shape, part, id, flip, visible);
        if (!visible)
            return;
        part->solidInfos.push_back({MaterialOf(shape.state), -1});
        if (shape.state.areaLight >= 0 && part == &scene_.world_)
            emitters_.push_back({id, geometry, shape.state.areaLight});
    }

    // Where the mesh is: an alpha of exactly 0 is a hole, as in pbrt-v3; "shadowalpha" makes holes for shadow rays alone.
    SolidSet::MeshAlpha AlphaOf(const ParamSet &p) const {
        if (!p.Find("alpha") && !p.Find("shadowalpha"))
            return {};
        return [alpha = textures_.GetFloatTexture(p, "alpha", 1),
                shadowAlpha = textures_.GetFloatTexture(p, "shadowalpha", 1)](
                   const Point3f &point, const Point2f &uv, bool shadow) {
            const TexturePoint at{point, uv};
            return alpha->Evaluate(at) != 0 && (!shadow || shadowAlpha->Evaluate(at) != 0);
        };
    }

    uint32_t AddSolid(const ShapeEntity &shape, Part *part, uint32_t id, bool flip, bool visible) {
        const ParamSet &p = shape.params;
        const Transform &toWorld = shape.objectToWorld;
        SolidSet &solids = part->solids;
        if (std::optional<TriangleMesh> mesh = MakeMesh(shape)) {
            for (Point3f &v : mesh->p)
                v = toWorld.Point(v);
            for (Normal3f &n : mesh->n)
                n = Normalize(toWorld.Normal(n));
            SolidSet::MeshAlpha alpha =
                shape.type == "trianglemesh" || shape.type == "plymesh" ? AlphaOf(p) : nullptr;
            return visible ? solids.AddMesh(std::move(*mesh), id, flip ^ toWorld.SwapsHandedness(),
                                            std::move(alpha))
                           : 0;
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
        const std::vector<std::string_view> names = ShapePlugins().Names();
        throw Error(p.loc, "unknown shape \"" + shape.type + "\". " +
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
        constexpr int kMaxPerStrand = 10000;
        if (options->segmentsPerStrand < 0 || options->segmentsPerStrand > kMaxPerStrand)
            throw Error(p.loc, "\"segments\" must be 0 (as the file has them) to " +
                                   std::to_string(kMaxPerStrand) + ", not " +
                                   std::to_string(options->segmentsPerStrand));
        const float width = p.FindFloat("width", 0);
        if (p.Find("width") && !(width > 0))
            throw Error(p.loc, "\"width\" must be positive; without it the file's widths are used");
        Groom groom = ReadGroomFile(Filename(p), width);
        if (const std::string name = p.FindString("spline", ""); !name.empty()) {
            options->spline = StrandSplineByName(name);
            if (!options->spline)
                throw Error(p.loc, "unknown spline \"" + name + "\". " +
                                       Suggestion(name, kStrandSplines.data(), kStrandSplines.size()));
            if (groom.spline == StrandSpline::Bezier)
                throw Error(p.loc, "the file's curves are cubic: \"spline\" is for files of points");
        }
        return groom;
    }

    // Strands from a file or a recipe become curve segments of one group.
    void AddGroom(const ShapeEntity &shape, CurvePool *curves) {
        const Transform &toWorld = shape.objectToWorld;
        auto widthScale = static_cast<float>(std::cbrt(std::abs(toWorld.Determinant())));
        SegmentOptions options;
        const Groom groom = shape.type == "hairfile" ? ReadHairFileShape(shape.params, &options, &widthScale)
                                                     : GrowGroom(shape.params);
        if (!MaterialOf(shape.state))
            return;
        const auto group = static_cast<uint32_t>(description_.curveGroups.size());
        description_.curveGroups.push_back({CurveType::Flat, shape.state, shape.params.loc});
        GroupColors *colors = groom.hasColor ? &scene_.strandColors_[group] : nullptr;
        std::vector<CurveSegment> &segments = curves->segments;
        const size_t needed = segments.size() + ExpectedSegments(groom, options);
        CheckSegmentCount(needed);
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
                if (segment.cp[i] = toWorld.Point(piece.cp[i]); !IsWithinReach(segment.cp[i]))
                    throw Error(shape.params.loc, "a strand is out of range after the transformation: its "
                                                  "coordinates are beyond 1e18 or not finite");
            for (size_t i = 0; i < 2; ++i)
                segment.width[i] = piece.width[i] * widthScale;
            segment.group = group;
            segments.push_back(segment);
            if (!groom.pointColors.empty())
                colors->colors.push_back(
                    {groom.Color(strand, piece.at[0]), groom.Color(strand, piece.at[1])});
        });
    }

    // What all parts' curves share: the groups' types and materials.
    void NameCurveGroups() {
        for (const CurveGroup &group : description_.curveGroups) {
            curveTypes_.push_back(group.type);
            scene_.curveMaterials_.push_back(MaterialOf(group.state));
            const Material *material = scene_.curveMaterials_.back();
            anyHidden_ |= !material;
            wantsStrandNormals_ |= material && material->WantsStrandNormals();
            if (material && material->Bumped())
                Warning("bump maps on curves are not rendered",
                        "bump maps on curves are not rendered; the curves stay smooth");
            if (group.state.areaLight >= 0)
                Warning(description_.areaLights[static_cast<size_t>(group.state.areaLight)].params.loc,
                        "curves do not emit",
                        "area lights on curves are not rendered; the curve does not emit");
        }
        WarnOfAbsentStrandColors();
    }

    // No box can part curves that are wider than all of them together, and every ray would try every curve. A few are
    // a jest and are drawn; more are a mistaken number, and a picture that takes for ever.
    void RefuseGiantWidths(const std::vector<CurveSegment> &segments) const {
        constexpr size_t kMaxGiants = 1000;
        Bounds3f bounds;
        for (const CurveSegment &s : segments)
            for (const Point3f &p : s.cp)
                if (IsFinite(p))
                    bounds.Extend(p);
        const Vector3f d = bounds.Diagonal();
        const float extent = std::max({d.x, d.y, d.z});
        const CurveSegment *giant = nullptr;
        size_t giants = 0;
        for (const CurveSegment &s : segments)
            if (std::max(s.width[0], s.width[1]) > extent) {
                giant = giant ? giant : &s;
                ++giants;
            }
        if (giants <= kMaxGiants)
            return;
        std::ostringstream says;
        says << giants << " curve segments are wider (" << std::max(giant->width[0], giant->width[1])
             << ") than the box round all curves (" << extent
             << "): give their \"width\" or \"widthscale\" in the units of the scene";
        throw Error(description_.curveGroups[giant->group].loc, says.str());
    }

    void FinishPart(CurvePool curves, Part *part) {
        RefuseGiantWidths(curves.segments);
        part->solids.Commit();
        part->haveSolids = part->solids.Geometries() > 0;
        // Ribbon normals and strand colours go by the segments' numbers, which must stay then
        if (anyHidden_ && curves.ribbonNormals.empty() && scene_.strandColors_.empty())
            std::erase_if(curves.segments,
                          [&](const CurveSegment &s) { return !scene_.curveMaterials_[s.group]; });
        if (wantsStrandNormals_)
            part->strandNormals = MakeStrandNormals(curves.segments);
        part->haveCurves = !curves.segments.empty();
        if (!part->haveCurves)
            return;
        if (options_.binaryCurves) {
            part->binaryCurves.emplace(std::move(curves.segments), curveTypes_, curves.ribbonNormals);
            return;
        }
        part->curves = CurveSet(std::move(curves.segments), curveTypes_, curves.ribbonNormals);
        if (const size_t dropped = part->curves.DroppedSegments())
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
            scene_.world_.solidInfos[shape].light = static_cast<int>(scene_.lights_.size());
            scene_.lights_.push_back(MakeAreaLight(description_.areaLights[static_cast<size_t>(areaLight)],
                                                   &scene_.world_.solids, geometry));
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
    std::vector<Part *> partOf_; // by object; null: never used
    std::vector<CurveType> curveTypes_;
    bool anyHidden_ = false, wantsStrandNormals_ = false;
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

bool Scene::Part::Intersect(Ray ray, const CurveOrigin *origin, Hit *hit) const {
    const bool hitSolid = haveSolids && solids.Intersect(ray, &hit->solid);
    if (hitSolid)
        ray.tMax = hit->solid.t;
    hit->isCurve = haveCurves && (binaryCurves ? binaryCurves->Intersect(ray, origin, &hit->curve)
                                               : curves.Intersect(ray, origin, &hit->curve));
    return hitSolid || hit->isCurve;
}

bool Scene::Part::Occluded(const Ray &ray, const CurveOrigin *origin) const {
    return (haveSolids && solids.Occluded(ray)) ||
           (haveCurves &&
            (binaryCurves ? binaryCurves->Occluded(ray, origin) : curves.Occluded(ray, origin)));
}

Bounds3f Scene::Part::Bound() const {
    Bounds3f b = solids.WorldBound();
    if (haveCurves)
        b.Extend(binaryCurves ? binaryCurves->WorldBound() : curves.WorldBound());
    return b;
}
size_t Scene::Part::Curves() const {
    return binaryCurves ? binaryCurves->SegmentCount() : curves.SegmentCount();
}
size_t Scene::Part::MemoryBytes() const {
    return solids.MemoryBytes() + (binaryCurves ? binaryCurves->MemoryBytes() : curves.MemoryBytes()) +
           strandNormals.size() * sizeof(Vector3f);
}

// Fills si in the coordinates of the part and of the ray, which are the same.
void Scene::Describe(const Part &part, const Ray &ray, const Part::Hit &hit, SurfaceInteraction *si) const {
    si->t = hit.T();
    si->isCurve = hit.isCurve;
    si->strandColors = nullptr;
    si->strandNormal = {};
    if (hit.isCurve) {
        const CurveHit &curve = hit.curve;
        const CurveSurface s =
            part.binaryCurves ? part.binaryCurves->Surface(ray, curve) : part.curves.Surface(ray, curve);
        const CurveSegment &segment = part.Segment(curve.segment);
        si->p = s.p;
        si->pError = {s.pError, s.pError, s.pError};
        si->n = s.n;
        si->uv = s.uv;
        si->shading = {s.tangent, Cross(s.n, s.tangent), s.n};
        si->material = curveMaterials_[segment.group];
        si->light = -1;
        si->curveOrigin = {curve.segment, curve.u};
        si->strandColors = strandColors_.empty() ? nullptr : StrandColorsOf(segment.group, curve.segment);
        if (!part.strandNormals.empty())
            si->strandNormal = StrandNormal(segment, part.strandNormals[curve.segment], curve.u, s.tangent);
        return;
    }
    const SolidHit solid = part.solids.Describe(hit.solid);
    si->p = solid.p;
    si->pError = solid.pError;
    si->n = solid.n;
    si->uv = solid.uv;
    si->dpdu = solid.dpdu;
    si->dpdv = solid.dpdv;
    si->shading = ShadingFrame(solid.dpdu, solid.ns);
    si->material = part.solidInfos[solid.shapeId].material;
    si->light = part.solidInfos[solid.shapeId].light;
    si->geometryId = solid.geometryId;
    si->primId = solid.primId;
}

namespace {

// What rounding to single precision, on the way into the object and out of it, adds to the error of a point, and what the
// transformation makes of the error that it had.
Vector3f ErrorInWorld(const Transform &toWorld, const Point3f &object, const Vector3f &error,
                      const Point3f &world) {
    const auto &m = toWorld.M();
    Vector3f e;
    for (int row = 0; row < 3; ++row) {
        double sum = 0;
        for (int c = 0; c < 3; ++c)
            sum += std::abs(m[static_cast<size_t>(row)][static_cast<size_t>(c)]) *
                   (static_cast<double>(error[c]) + 0x1p-23 * static_cast<double>(std::abs(object[c])));
        e[row] = static_cast<float>(sum + 0x1p-23 * static_cast<double>(std::abs(world[row])));
    }
    return e;
}

// Takes what was found in an object to the world. Of a curve the tangent stays exact and the normal is made
// perpendicular to it. A mirror turns left and right across a fiber.
void ToWorld(const Transform &toWorld, SurfaceInteraction *si) {
    const Point3f object = si->p;
    si->p = toWorld.Point(object);
    si->pError = ErrorInWorld(toWorld, object, si->pError, si->p);
    si->n = Normalize(toWorld.Normal(si->n));
    si->dpdu = toWorld.Vector(si->dpdu);
    si->dpdv = toWorld.Vector(si->dpdv);
    if (!si->isCurve) {
        si->shading = ShadingFrame(si->dpdu, Normalize(toWorld.Normal(si->shading.z)));
        return;
    }
    const Vector3f tangent = Normalize(toWorld.Vector(si->shading.x));
    const auto across = [&](const Vector3f &v) { return Normalize(v - tangent * Dot(v, tangent)); };
    si->n = across(si->n);
    si->shading = {tangent, Cross(si->n, tangent), si->n};
    if (si->strandNormal.LengthSquared() > 0)
        si->strandNormal = across(toWorld.Vector(si->strandNormal));
    if (toWorld.SwapsHandedness())
        si->uv.y = 1 - si->uv.y;
}

} // namespace

// A ray on its way through the instances, and the nearest that it met so far.
struct Scene::InstanceQuery {
    const Scene &scene;
    const SceneRay &ray;
    Part::Hit hit = {};
    Ray objectRay = {};
    int instance = -1;

    const CurveOrigin *Origin(uint32_t i) const {
        return ray.fromCurve && ray.instance == static_cast<int>(i) ? &ray.origin : nullptr;
    }
};

float Scene::IntersectInstance(void *query, uint32_t instance, const Ray &ray) {
    auto &q = *static_cast<InstanceQuery *>(query);
    Part::Hit hit;
    if (!q.scene.objectOf_[instance]->Intersect(ray, q.Origin(instance), &hit))
        return -1;
    q.hit = hit, q.objectRay = ray, q.instance = static_cast<int>(instance);
    return hit.T();
}

float Scene::OccludedInstance(void *query, uint32_t instance, const Ray &ray) {
    const auto &q = *static_cast<InstanceQuery *>(query);
    return q.scene.objectOf_[instance]->Occluded(ray, q.Origin(instance)) ? 0.f : -1.f;
}

bool Scene::Intersect(const SceneRay &sceneRay, SurfaceInteraction *si) const {
    Ray ray = sceneRay.ray;
    Part::Hit hit;
    const CurveOrigin *origin = sceneRay.fromCurve && sceneRay.instance < 0 ? &sceneRay.origin : nullptr;
    const bool hitWorld = world_.Intersect(ray, origin, &hit);
    si->instance = -1;
    if (instances_.Size() > 0) {
        if (hitWorld)
            ray.tMax = hit.T();
        InstanceQuery query{*this, sceneRay};
        if (instances_.Intersect(ray, IntersectInstance, &query)) {
            const auto instance = static_cast<uint32_t>(query.instance);
            Describe(*objectOf_[instance], query.objectRay, query.hit, si);
            ToWorld(instances_.ObjectToWorld(instance), si);
            si->instance = query.instance;
            si->wo = -sceneRay.ray.d;
            return true;
        }
    }
    if (!hitWorld)
        return false;
    Describe(world_, sceneRay.ray, hit, si);
    si->wo = -sceneRay.ray.d;
    return true;
}

bool Scene::Occluded(const SceneRay &ray) const {
    if (world_.Occluded(ray.ray, ray.fromCurve && ray.instance < 0 ? &ray.origin : nullptr))
        return true;
    if (instances_.Size() == 0)
        return false;
    InstanceQuery query{*this, ray};
    return instances_.Occluded(ray.ray, OccludedInstance, &query);
}

SceneRay Scene::SpawnRay(const SurfaceInteraction &si, const Vector3f &w) const {
    SceneRay ray;
    ray.ray.d = w;
    ray.fromCurve = si.isCurve;
    ray.origin = si.curveOrigin;
    ray.instance = si.instance;
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
    Bounds3f b = world_.Bound();
    b.Extend(instances_.WorldBound());
    return b;
}

size_t Scene::Curves() const {
    size_t n = world_.Curves();
    for (const auto &object : objects_)
        n += object->Curves();
    return n;
}
size_t Scene::Instances() const { return instances_.Size(); }
size_t Scene::MemoryBytes() const {
    size_t n = world_.MemoryBytes() + instances_.MemoryBytes() + objectOf_.size() * sizeof(void *);
    for (const auto &object : objects_)
        n += object->MemoryBytes();
    return n;
}
const char *Scene::Isa() const { return world_.binaryCurves ? "scalar" : world_.curves.Isa(); }

} // namespace cuticle
