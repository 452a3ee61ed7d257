#include "scene/scene.h"

#include "core/check.h"
#include "core/error.h"
#include "core/memory_budget.h"
#include "grooms/groom.h"
#include "scene/plugins.h"
#include "scene/shape_makers.h"
#include "shapes/curve.h"
#include "shapes/strand_normals.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cuticle {

namespace {

// The element of a list that the description names by index: the parser has checked it.
template <class List>
auto &At(List &list, int index) {
    const auto i = static_cast<size_t>(index);
    CHECK_LT(i, list.size());
    return list[i];
}

} // namespace

// Turns a description into a Scene; holds what is needed only meanwhile.
class SceneBuilder {
  public:
    SceneBuilder(Scene *scene, SceneDescription *description, const SceneOptions &options)
        : scene_(*scene), description_(*description), options_(options),
          textures_(description->floatTextures, description->spectrumTextures) {}

    void Build() {
        for (const MaterialEntity &entity : description_.materials)
            scene_.materials_.push_back(
                MakeMaterial(entity, textures_, options_.materials, scene_.materials_));
        Shapes world{
            &scene_.world_, std::move(description_.curves), std::move(description_.unevenCurves), {}};
        for (const ShapeEntity &shape : description_.shapes)
            AddShape(shape, &world);
        AddObjects();
        ListCurveGroups();
        Finish(&world);
        for (Shapes &object : objects_)
            Finish(&object);
        PlaceInstances(world);
        MakeLights();
    }

  private:
    const Material *MaterialOf(const ShapeState &state) const {
        return At(scene_.materials_, state.material).get();
    }

    // What belongs to the world, or to one object, until its accelerators are built.
    struct Shapes {
        ShapeGroup *group;
        CurvePool curves;
        std::vector<UnevenCurves> uneven;
        // The uneven curves once they are built, each with its way to this one's coordinates
        std::vector<std::pair<const ShapeGroup *, Transform>> unevenGroups;
    };

    // Adds the solids and strands of each object that is used, once.
    void AddObjects() {
        shapesOf_.assign(description_.objects.size(), SIZE_MAX);
        for (const ObjectUse &use : description_.instances) {
            size_t &shapes = At(shapesOf_, use.object);
            if (shapes != SIZE_MAX)
                continue;
            shapes = objects_.size();
            scene_.objects_.push_back(std::make_unique<ShapeGroup>());
            ObjectDefinition &object = At(description_.objects, use.object);
            objects_.push_back(
                {scene_.objects_.back().get(), std::move(object.curves), std::move(object.unevenCurves), {}});
            for (const ShapeEntity &shape : object.shapes)
                AddShape(shape, &objects_.back());
        }
    }

    // Uneven curves are instances of their own, of the world or of each use of their object.
    void PlaceInstances(const Shapes &world) {
        std::vector<FileLoc> places;
        const auto place = [&](const ShapeGroup *group, const Transform &toWorld) {
            scene_.instances_.Add(toWorld, group->Bound());
            scene_.objectOf_.push_back(group);
        };
        for (const ObjectUse &use : description_.instances) {
            const PlaceScope here(use.loc);
            const Shapes &shapes = objects_[At(shapesOf_, use.object)];
            place(shapes.group, use.instanceToWorld);
            places.push_back(use.loc);
            for (const auto &[group, toObject] : shapes.unevenGroups)
                place(group, use.instanceToWorld * toObject), places.push_back(use.loc);
        }
        for (const auto &[group, toWorld] : world.unevenGroups)
            place(group, toWorld), places.emplace_back();
        RequireRaysWithinReach(places);
        scene_.instances_.Commit();
        description_.objects.clear();
    }

    // Error at an instance in whose space a ray can begin beyond what geometry may have, and what traces rays
    // bears: rays begin at the camera and in the bounds of the scene.
    // places: of the instances.
    void RequireRaysWithinReach(const std::vector<FileLoc> &places) const {
        Bounds3f origins = scene_.WorldBound();
        const Transform &worldToCamera = description_.camera.ctm;
        if (const Point3f eye = worldToCamera.Inverse().Point(Point3f()); IsWithinReach(eye))
            origins.Extend(eye); // else the camera is refused
        if (origins.IsEmpty())
            return;
        for (size_t i = 0; i < places.size(); ++i) {
            const Bounds3f b = scene_.instances_.ObjectToWorld(static_cast<uint32_t>(i)).Inverse()(origins);
            if (!IsWithinReach(b.pMin) || !IsWithinReach(b.pMax))
                throw Error(
                    places[i],
                    "the instance's transformation is extreme: in the object's coordinates rays of the "
                    "scene reach to {:g}",
                    std::max({std::abs(b.pMin.x), std::abs(b.pMin.y), std::abs(b.pMin.z), std::abs(b.pMax.x),
                              std::abs(b.pMax.y), std::abs(b.pMax.z)}))
                    .WithRemedy("it may be up to 1e18: scale the object's shapes instead");
        }
    }

    // Where pbrt-v3 leaves out a shape that cannot be made, so do we, with a Warning.
    void AddShape(const ShapeEntity &shape, Shapes *shapes) {
        const PlaceScope here(shape.params.loc);
        try {
            MakeShape(shape, shapes);
        } catch (const Error &e) {
            e.GoOnAsPbrt("shape left out");
        }
    }

    void MakeShape(const ShapeEntity &shape, Shapes *shapes) {
        const PluginRow<ShapeMaker> *row = FindShape(shape.type);
        if (!row || shape.type == "curve") {
            const std::vector<std::string_view> names = ShapePlugins().Names();
            throw Error(shape.params.loc, "unknown shape \"{}\"", shape.type)
                .WithRemedy(Suggestion(shape.type, names.data(), names.size()));
        }
        if (const auto *makeStrands = std::get_if<StrandMaker>(&row->make))
            AddStrands(shape, (*makeStrands)(shape.params, description_.frame), shapes);
        else if (std::holds_alternative<std::monostate>(row->make))
            LeaveOut(shape, row->info.standIn);
        else
            AddSolid(shape, *row, shapes->group);
        shape.params.ReportUnused(fmt::format("Shape \"{}\"", shape.type));
    }

    // Warns of a shape that is not rendered.
    static void LeaveOut(const ShapeEntity &shape, std::string_view standIn) {
        for (const Param &param : shape.params.params)
            param.used = true;
        Warning(shape.params.loc, fmt::format("shape \"{}\" is not rendered", shape.type),
                fmt::format("shape \"{}\" is not rendered; it is {}", shape.type, standIn));
    }

    void AddSolid(const ShapeEntity &shape, const PluginRow<ShapeMaker> &row, ShapeGroup *shapes) {
        // Without a material light passes a surface, which is invisible unless it emits
        const bool visible = MaterialOf(shape.state) != nullptr || shape.state.areaLight >= 0;
        const auto id = static_cast<uint32_t>(shapes->solidInfos.size());
        SolidSet *solids = visible ? &shapes->solids : nullptr;
        uint32_t geometry = 0;
        if (const auto *addQuadric = std::get_if<QuadricMaker>(&row.make))
            geometry = (*addQuadric)(shape, solids, id);
        else
            geometry = AddMesh(shape, row, solids, id);
        if (!visible)
            return;
        shapes->solidInfos.push_back({MaterialOf(shape.state), -1});
        if (shape.state.areaLight >= 0 && shapes == &scene_.world_)
            emitters_.push_back({id, geometry, shape.state.areaLight});
    }

    // Makes a mesh, and adds it in world space unless solids is null.
    uint32_t AddMesh(const ShapeEntity &shape, const PluginRow<ShapeMaker> &row, SolidSet *solids,
                     uint32_t id) const {
        const Transform &toWorld = shape.objectToWorld;
        TriangleMesh mesh = std::get<MeshMaker>(row.make)(shape);
        // Embree's tree took 60 to 110 bytes a triangle
        ClaimMemory(fmt::format("a mesh of {} triangles", mesh.indices.size() / 3),
                    mesh.p.size() * sizeof(Point3f) + mesh.n.size() * sizeof(Normal3f) +
                        mesh.uv.size() * sizeof(Point2f) + mesh.indices.size() / 3 * (12 + 110));
        for (Point3f &v : mesh.p)
            v = toWorld.Point(v);
        for (Normal3f &n : mesh.n)
            n = Normalize(toWorld.Normal(n));
        SolidSet::MeshAlpha alpha = row.info.FindParam("alpha") ? AlphaOf(shape.params) : nullptr;
        const bool flip = shape.state.reverseOrientation ^ toWorld.SwapsHandedness();
        return solids ? solids->AddMesh(std::move(mesh), id, flip, std::move(alpha)) : 0;
    }

    // Tells where a mesh has holes: an alpha of exactly 0, as in pbrt-v3; "shadowalpha" makes holes for
    // shadow rays alone. Null where the shape has no such parameter.
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

    void AddStrands(const ShapeEntity &shape, const StrandShape &strands, Shapes *shapes) {
        if (!MaterialOf(shape.state))
            return;
        ForEachPlacement(strands.groom, [&](const StrandRange &range, const Transform *toGroom) {
            const Transform toWorld = toGroom ? shape.objectToWorld * *toGroom : shape.objectToWorld;
            if (!toWorld.ScalesUnevenly())
                return AddStrands(shape, strands, range, toWorld, &shapes->curves);
            shapes->uneven.push_back({toWorld, {}});
            AddStrands(shape, strands, range, Transform(), &shapes->uneven.back().curves);
        });
    }

    // Turns strands into curve segments of a group of their own.
    void AddStrands(const ShapeEntity &shape, const StrandShape &strands, const StrandRange &range,
                    const Transform &toPool, CurvePool *curves) {
        const Groom &groom = strands.groom;
        const float widthScale =
            static_cast<float>(std::cbrt(std::abs(toPool.Determinant()))) * strands.widthScale;
        const auto group = static_cast<uint32_t>(description_.curveGroups.size());
        description_.curveGroups.push_back({CurveType::Flat, shape.state, shape.params.loc,
                                            shape.state.reverseOrientation != toPool.SwapsHandedness()});
        CurveList &segments = curves->segments;
        const size_t added = ExpectedSegments(groom, range, strands.segments),
                     needed = segments.size() + added;
        CheckSegmentCount(needed);
        segments.reserve(needed);
        Scene::StrandColorRun *colors = groom.hasColor ? &scene_.strandColors_[group] : nullptr;
        if (colors) {
            colors->firstSegment = static_cast<uint32_t>(segments.size());
            if (groom.pointColors.empty())
                colors->colors.push_back({groom.color, groom.color});
            else
                colors->colors.reserve(added);
        }
        ForEachSegment(groom, range, strands.segments, [&](const BezierSegment &piece, size_t strand) {
            CurveSegment segment;
            for (size_t i = 0; i < 4; ++i)
                if (segment.cp[i] = toPool.Point(piece.cp[i]); !IsWithinReach(segment.cp[i]))
                    throw Error(shape.params.loc, "a strand is out of range after the transformation: its "
                                                  "coordinates are beyond 1e18 or not finite");
            for (size_t i = 0; i < 2; ++i)
                segment.width[i] = piece.width[i] * widthScale;
            segment.group = group;
            segment.part = StrandPart::Of(piece.index, piece.count);
            segments.push_back(segment);
            if (!groom.pointColors.empty())
                colors->colors.push_back(
                    {groom.Color(strand, piece.at[0]), groom.Color(strand, piece.at[1])});
        });
    }

    // Collects the types and materials of all curve groups.
    void ListCurveGroups() {
        for (const CurveGroup &group : description_.curveGroups) {
            curveTypes_.push_back(group.type);
            scene_.curveMaterials_.push_back(MaterialOf(group.state));
            scene_.curveFlipped_.push_back(group.flipped);
            const Material *material = scene_.curveMaterials_.back();
            anyHidden_ |= !material;
            wantsStrandNormals_ |= material && material->WantsStrandNormals();
            if (material && material->Bumped())
                Warning("bump maps on curves are not rendered",
                        "bump maps on curves are not rendered; the curves stay smooth");
            if (group.state.areaLight >= 0)
                Warning(At(description_.areaLights, group.state.areaLight).params.loc, "curves do not emit",
                        "area lights on curves are not rendered; the curve does not emit");
        }
        WarnOfAbsentStrandColors();
        scene_.strandRoots_ = AsksForStrandRoots();
    }

    // Error where many curves are wider than all of them together: no box separates such curves, and every
    // ray would try every curve. Up to 1000 such curves are drawn; more is a unit error.
    void RefuseGiantWidths(const CurveList &segments) const {
        constexpr size_t kMaxGiants = 1000;
        Bounds3f bounds;
        for (const CurveSegment &s : segments)
            for (const Point3f &p : s.cp)
                if (IsFinite(p))
                    bounds.Extend(p);
        const Vector3f d = bounds.Diagonal();
        const float extent = std::max({d.x, d.y, d.z});
        std::optional<CurveSegment> giant;
        size_t giants = 0;
        for (const CurveSegment &s : segments)
            if (std::max(s.width[0], s.width[1]) > extent) {
                giant = giant ? giant : s;
                ++giants;
            }
        if (giants <= kMaxGiants)
            return;
        CHECK_LT(giant->group, description_.curveGroups.size());
        throw Error(description_.curveGroups[giant->group].loc,
                    "{} curve segments are wider ({:g}) than the box round all curves ({:g}): give their "
                    "\"width\" or "
                    "\"widthscale\" in the units of the scene",
                    giants, std::max(giant->width[0], giant->width[1]), extent);
    }

    void Finish(Shapes *shapes) {
        FinishShapes(std::move(shapes->curves), shapes->group);
        for (UnevenCurves &uneven : shapes->uneven) {
            if (uneven.curves.segments.empty())
                continue;
            CHECK_LT(uneven.curves.segments[0].group, description_.curveGroups.size());
            const PlaceScope here(description_.curveGroups[uneven.curves.segments[0].group].loc);
            scene_.objects_.push_back(std::make_unique<ShapeGroup>());
            FinishShapes(std::move(uneven.curves), scene_.objects_.back().get());
            shapes->unevenGroups.emplace_back(scene_.objects_.back().get(), uneven.toParent);
        }
    }

    // Returns the segments that have a material.
    CurveList WithoutHidden(const CurveList &segments) const {
        CurveList seen;
        for (const CurveSegment &s : segments)
            if (scene_.curveMaterials_[s.group])
                seen.push_back(s);
        return seen;
    }

    // Builds the accelerators of a group whose shapes are complete.
    void FinishShapes(CurvePool curves, ShapeGroup *shapes) {
        RefuseGiantWidths(curves.segments);
        shapes->solids.Commit();
        shapes->haveSolids = shapes->solids.Geometries() > 0;
        // Ribbon normals and strand colours are by segment number, so segments must keep theirs
        if (anyHidden_ && curves.ribbonNormals.empty() && scene_.strandColors_.empty())
            curves.segments = WithoutHidden(curves.segments);
        if (wantsStrandNormals_)
            shapes->strandNormals = MakeStrandNormals(curves.segments);
        shapes->haveCurves = !curves.segments.empty();
        if (!shapes->haveCurves)
            return;
        ClaimCurves(curves);
        if (options_.binaryCurves) {
            shapes->binaryCurves.emplace(curves.segments, curveTypes_, curves.ribbonNormals);
            return;
        }
        shapes->curves = CurveSet(std::move(curves.segments), curveTypes_, curves.ribbonNormals);
        if (shapes->curves.DroppedSegments() > 0)
            WarnOfDropped(shapes->curves);
    }

    // Claims what a curve set takes while it is built: for each segment its points, a reference of 32 bytes,
    // two numbers of pieces, and 50 bytes of the tree, which were measured.
    void ClaimCurves(const CurvePool &curves) const {
        const size_t n = curves.segments.size(), points = curves.segments.MemoryBytes();
        CHECK_LT(curves.segments[0].group, description_.curveGroups.size());
        ClaimMemory(fmt::format("{} curve segments and their tree", n),
                    n * (32 + 8 + 50) + points - std::min(points, curves.claimed),
                    description_.curveGroups[curves.segments[0].group].loc);
    }

    // Says why segments are left out of the picture, and where one of them stands.
    void WarnOfDropped(const CurveSet &curves) const {
        struct Kind {
            const char *name, *what;
            size_t count = 0;
            uint32_t group = 0;
        } kinds[] = {
            {"curves of length zero", "of length zero: all their points are one"},
            {"curves without width", "without width"},
            {"curves out of range", "out of range: a point or width of theirs is beyond 1e18 or not finite"}};
        for (uint32_t i = 0; i < curves.SegmentCount(); ++i) {
            const CurveSegment s = curves.Segment(i);
            if (IsUsable(s))
                continue;
            const bool isPoint = s.cp[0] == s.cp[1] && s.cp[0] == s.cp[2] && s.cp[0] == s.cp[3];
            const float width = std::max(s.width[0], s.width[1]);
            Kind &kind = kinds[isPoint ? 0 : width <= 0 ? 1 : 2];
            if (kind.count++ == 0)
                kind.group = s.group;
        }
        for (const Kind &kind : kinds)
            if (kind.count > 0)
                Warning(At(description_.curveGroups, static_cast<int>(kind.group)).loc, kind.name,
                        fmt::format("{} curve segments are {}; they are left out of the picture", kind.count,
                                    kind.what));
    }

    bool AsksForStrandRoots() const {
        for (const auto *textures : {&description_.floatTextures, &description_.spectrumTextures})
            for (const TextureEntity &texture : *textures)
                if (texture.type == "strandroot")
                    return true;
        return false;
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
            entity.params.ReportUnused(fmt::format("LightSource \"{}\"", entity.type));
        }
        for (const auto &[shape, geometry, areaLight] : emitters_) {
            scene_.world_.solidInfos[shape].light = static_cast<int>(scene_.lights_.size());
            scene_.lights_.push_back(
                MakeAreaLight(At(description_.areaLights, areaLight), &scene_.world_.solids, geometry));
        }
        ReportUnusedOfAreaLights();
        std::vector<const Light *> pointers;
        for (const auto &light : scene_.lights_)
            pointers.push_back(light.get());
        scene_.lightSampler_ = LightSampler(pointers);
        if (pointers.empty())
            Warning("no lights", "the scene has no lights: the picture will be black");
    }

    // Of an area light that no shape made, because none stands under it that may, nobody asked the
    // parameters.
    void ReportUnusedOfAreaLights() const {
        std::vector<bool> isMade(description_.areaLights.size());
        for (const Emitter &emitter : emitters_)
            isMade[static_cast<size_t>(emitter.areaLight)] = true;
        for (size_t i = 0; i < isMade.size(); ++i) {
            const Entity &entity = description_.areaLights[i];
            const PluginInfo *row = AreaLightPlugins().Find(entity.type);
            for (const Param &param : entity.params.params)
                if (!isMade[i] && row && row->FindParam(param.name))
                    param.used = true;
            entity.params.ReportUnused(fmt::format("AreaLightSource \"{}\"", entity.type));
        }
    }

    // A solid that emits, until its light is made.
    struct Emitter {
        uint32_t shape, geometry;
        int areaLight;
    };
    Scene &scene_;
    SceneDescription &description_;
    const SceneOptions &options_;
    TextureTable textures_;
    std::vector<Shapes> objects_;  // those that are used
    std::vector<size_t> shapesOf_; // by object, its index there; SIZE_MAX: it is never used
    std::vector<CurveType> curveTypes_;
    bool anyHidden_ = false, wantsStrandNormals_ = false;
    std::vector<Emitter> emitters_;
};

Scene::Scene(SceneDescription *description, const SceneOptions &options) {
    pbrtV3Offset_ = options.materials.compatPbrtV3;
    SceneBuilder(this, description, options).Build();
}

} // namespace cuticle
