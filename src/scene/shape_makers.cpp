#include "scene/shape_makers.h"

#include "core/error.h"
#include "grooms/groom_file.h"
#include "grooms/groom_params.h"
#include "grooms/head_mesh.h"
#include "grooms/procedural.h"
#include "scene/plugins.h"
#include "shapes/loop_subdivision.h"
#include "shapes/ply.h"

#include <span>
#include <string>
#include <vector>

namespace cuticle {

namespace {

// The file that "filename" names. Error where it is absent.
std::string RequiredFilename(const ParamSet &p) {
    std::string name = p.FindFilename("filename");
    if (name.empty())
        throw Error(p.loc, "this shape needs \"string filename\"").WithPbrtInstead("it is left out");
    return name;
}

// --- meshes -------------------------------------------------------------------------------------------

// The mesh of "P" and "indices" alone.
TriangleMesh PointsAndIndices(const ShapeEntity &shape) {
    const ParamSet &p = shape.params;
    TriangleMesh mesh;
    mesh.p = p.FindPoint3fs("P");
    const std::vector<int> indices = p.FindInts("indices");
    if (indices.empty() || mesh.p.empty())
        throw Error(p.loc, "a {} needs \"integer indices\" and \"point P\"; {} is missing or empty",
                    shape.type, indices.empty() ? "\"indices\"" : "\"P\"")
            .WithPbrtInstead("it is left out");
    for (int i : indices) {
        if (i < 0 || static_cast<size_t>(i) >= mesh.p.size())
            throw Error(p.Find("indices")->loc,
                        "vertex index {} is out of range, for there are {} points, counted from 0", i,
                        mesh.p.size())
                .WithPbrtInstead("the {} is left out", shape.type);
        mesh.indices.push_back(static_cast<uint32_t>(i));
    }
    return mesh;
}

TriangleMesh MakeTriangleMesh(const ShapeEntity &shape) {
    const ParamSet &p = shape.params;
    TriangleMesh mesh = PointsAndIndices(shape);
    mesh.n = p.FindNormals("N");
    for (const char *name : {"uv", "st"})
        if (mesh.uv.empty())
            mesh.uv = p.FindPoint2fs(name);
    if (!mesh.uv.empty() && mesh.uv.size() != mesh.p.size()) {
        const bool tooMany = mesh.uv.size() > mesh.p.size();
        Warning(p.loc, "wrong number of texture coordinates",
                fmt::format("there are {} texture coordinates for {} points; {}, as by pbrt-v3",
                            mesh.uv.size(), mesh.p.size(),
                            tooMany ? "those in excess are ignored" : "they are ignored"));
        mesh.uv.resize(tooMany ? mesh.p.size() : 0);
    }
    if (!mesh.n.empty() && mesh.n.size() != mesh.p.size()) {
        Warning(p.Find("N")->loc, "wrong number of normals",
                fmt::format("there are {} normals for {} points; they are ignored, as by pbrt-v3",
                            mesh.n.size(), mesh.p.size()));
        mesh.n.clear();
    }
    (void)p.Find("S", ParamType::Vector3); // tangents: no material depends on them
    (void)p.Find("faceIndices", ParamType::Integer);
    return mesh;
}

TriangleMesh MakePlyMesh(const ShapeEntity &shape) {
    const std::string name = RequiredFilename(shape.params);
    try {
        return ReadPly(name);
    } catch (const Error &e) {
        throw Error(e).WithPbrtInstead("the shape is left out");
    }
}

TriangleMesh MakeLoopSubdivision(const ShapeEntity &shape) {
    const ParamSet &p = shape.params;
    (void)p.FindString("scheme", "loop"); // pbrt-v3 reads it, and knows no other
    return LoopSubdivide(PointsAndIndices(shape), p.FindInt("nlevels", p.FindInt("levels", 3)));
}

// Makes pbrt-v3's heightfield: nu columns and nv rows of heights over the unit square, two triangles a cell.
TriangleMesh MakeHeightField(const ShapeEntity &shape) {
    const ParamSet &p = shape.params;
    const int nu = p.FindInt("nu", -1), nv = p.FindInt("nv", -1);
    const std::vector<float> z = p.FindFloats("Pz");
    if (nu < 2 || nv < 2 || int64_t{nu} * nv != static_cast<int64_t>(z.size()))
        throw Error(
            p.loc,
            "a heightfield needs \"integer nu\" and \"integer nv\" of at least 2, and nu times nv numbers "
            "\"float Pz\"; there are {} for nu {} and nv {}",
            z.size(), nu, nv);
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

// The head and shoulders that procedural grooms grow on.
TriangleMesh MakeGroomHead(const ShapeEntity &shape) {
    SurfaceMesh head = MakeHeadMesh(shape.params.FindFloat("spacing", 0.3f));
    return {std::move(head.points), std::move(head.normals), {}, std::move(head.indices)};
}

// --- quadrics -----------------------------------------------------------------------------------------

// The parameters that quadrics share, and whether their normals are turned.
struct QuadricParameters {
    explicit QuadricParameters(const ShapeEntity &shape)
        : phiMax(shape.params.FindFloat("phimax", 360)), radius(shape.params.FindFloat("radius", 1)),
          flip(shape.state.reverseOrientation) {}
    float phiMax, radius; // degrees; lengths of the scene
    bool flip;
};

uint32_t AddSphere(const ShapeEntity &shape, SolidSet *solids, uint32_t id) {
    const QuadricParameters q(shape);
    const ParamSet &p = shape.params;
    const float zMin = p.FindFloat("zmin", -q.radius), zMax = p.FindFloat("zmax", q.radius);
    return solids ? solids->AddSphere(shape.objectToWorld, q.radius, zMin, zMax, q.phiMax, id, q.flip) : 0;
}

uint32_t AddDisk(const ShapeEntity &shape, SolidSet *solids, uint32_t id) {
    const QuadricParameters q(shape);
    const float height = shape.params.FindFloat("height", 0),
                inner = shape.params.FindFloat("innerradius", 0);
    return solids ? solids->AddDisk(shape.objectToWorld, height, q.radius, inner, q.phiMax, id, q.flip) : 0;
}

uint32_t AddCylinder(const ShapeEntity &shape, SolidSet *solids, uint32_t id) {
    const QuadricParameters q(shape);
    const float zMin = shape.params.FindFloat("zmin", -1), zMax = shape.params.FindFloat("zmax", 1);
    return solids ? solids->AddCylinder(shape.objectToWorld, q.radius, zMin, zMax, q.phiMax, id, q.flip) : 0;
}

uint32_t AddCone(const ShapeEntity &shape, SolidSet *solids, uint32_t id) {
    const QuadricParameters q(shape);
    const float height = shape.params.FindFloat("height", 1);
    return solids ? solids->AddCone(shape.objectToWorld, q.radius, height, q.phiMax, id, q.flip) : 0;
}

uint32_t AddParaboloid(const ShapeEntity &shape, SolidSet *solids, uint32_t id) {
    const QuadricParameters q(shape);
    const float zMin = shape.params.FindFloat("zmin", 0), zMax = shape.params.FindFloat("zmax", 1);
    return solids ? solids->AddParaboloid(shape.objectToWorld, q.radius, zMin, zMax, q.phiMax, id, q.flip)
                  : 0;
}

uint32_t AddHyperboloid(const ShapeEntity &shape, SolidSet *solids, uint32_t id) {
    const QuadricParameters q(shape); // a "radius" is read and has no effect
    const Point3f p1 = shape.params.FindPoint3f("p1", {0, 0, 0}),
                  p2 = shape.params.FindPoint3f("p2", {1, 1, 1});
    return solids ? solids->AddHyperboloid(shape.objectToWorld, p1, p2, q.phiMax, id, q.flip) : 0;
}

// --- strands ------------------------------------------------------------------------------------------

// Grows Shape "groom", whose parameters are the table that the command line has too.
StrandShape MakeGroomShape(const ParamSet &p, std::optional<size_t>) {
    return {MakeGroom(GroomParamsOf(p)), {}};
}

constexpr int kMaxSegmentsPerStrand = 10000;

// Reads Shape "hairfile": the strands of a file.
StrandShape MakeHairFile(const ParamSet &p, std::optional<size_t> frame) {
    StrandShape made;
    SegmentOptions &options = made.segments;
    made.widthScale = p.FindFloat("widthscale", 1);
    options.segmentsPerStrand = p.FindInt("segments", 0);
    if (options.segmentsPerStrand < 0 || options.segmentsPerStrand > kMaxSegmentsPerStrand)
        throw Error(p.loc, "\"segments\" must be 0 (as the file has them) to {}, not {}",
                    kMaxSegmentsPerStrand, options.segmentsPerStrand);
    const float width = p.FindFloat("width", 0);
    if (p.Find("width") && !(width > 0))
        throw Error(p.loc, "\"width\" must be positive; without it the file's widths are used");
    const int pointsPerStrand = p.FindInt("pointsperstrand", 0);
    if (p.Find("pointsperstrand") && pointsPerStrand < 2)
        throw Error(p.loc, "\"pointsperstrand\" must be at least 2, not {}", pointsPerStrand);
    std::optional<double> time;
    if (p.Find("time"))
        time = static_cast<double>(p.FindFloat("time", 0));
    else if (frame)
        time = static_cast<double>(*frame);
    made.groom = ReadGroomFile(RequiredFilename(p), {width, static_cast<size_t>(pointsPerStrand), time});
    if (const std::string name = p.FindString("spline", ""); !name.empty()) {
        options.spline = StrandSplineByName(name);
        if (!options.spline)
            throw Error(p.loc, "unknown spline \"{}\"", name)
                .WithRemedy(Suggestion(name, kStrandSplines.data(), kStrandSplines.size()));
        if (made.groom.spline == StrandSpline::Bezier)
            throw Error(p.loc, "the file's curves are cubic: \"spline\" is for files of points");
    }
    return made;
}

// --- the table of shapes ------------------------------------------------------------------------------

// Lengths are in the units of the scene, under the current transformation.
constexpr std::string_view kLengths = "lengths of the scene";
constexpr std::string_view kCurveTypes[] = {"flat", "cylinder", "ribbon"};
constexpr std::string_view kCurveBases[] = {"bezier", "bspline"};
constexpr ParamInfo kCurveParams[] = {
    {"P", "point3s", kLengths, "", "control points; each segment shares its last ones with the next"},
    {"width", "float", kLengths, "1", "width of the curve", 0},
    {"width0", "float", kLengths, "width", "width at its start, linear to width1", 0},
    {"width1", "float", kLengths, "width", "width at its end", 0},
    ChoiceParam("type", kCurveTypes,
                "flat curves face the ray, cylinders are shaded round, ribbons have normals"),
    ChoiceParam("basis", kCurveBases, "how control points make the curve"),
    {"degree", "integer", "", "3", "degree of the polynomial", 2, 3},
    {"N", "normals", "", "", "ribbons: the normal at both ends of each segment"},
    {"splitdepth", "integer", "", "3", "for pbrt-v3's accelerator; no effect"},
};
constexpr ParamInfo kPoints{"P", "point3s", kLengths, "", "vertices"};
constexpr ParamInfo kIndices{"indices", "integers", "", "", "three vertices a triangle, counted from 0", 0};
constexpr ParamInfo kFilename{"filename", "string", "", "", "the file, from the folder of the scene"};
constexpr ParamInfo kAlpha{"alpha", "float texture", "", "1", "0: a hole"};
constexpr ParamInfo kShadowAlpha{"shadowalpha", "float texture", "", "1", "0: a hole for shadow rays alone"};
constexpr ParamInfo kTriangleMeshParams[] = {
    kPoints,
    kIndices,
    {"N", "normals", "", "", "shading normals, one a vertex"},
    {"uv", "point2s", "", "", "texture coordinates, one a vertex"},
    {"st", "point2s", "", "", "an older name of uv"},
    {"S", "vector3s", "", "", "tangents; no effect"},
    {"faceIndices", "integers", "", "", "numbers of faces for ptex; no effect"},
    kAlpha,
    kShadowAlpha,
};
constexpr ParamInfo kPlyMeshParams[] = {kFilename, kAlpha, kShadowAlpha};
constexpr ParamInfo kLoopSubdivParams[] = {
    kPoints,
    kIndices,
    {"levels", "integer", "", "3", "times that each triangle is split in four", 0},
    {"nlevels", "integer", "", "levels", "an older name of levels", 0},
    {"scheme", "string", "", "loop", "pbrt-v3 knows no other"},
};
constexpr ParamInfo kHeightFieldParams[] = {
    {"nu", "integer", "", "", "columns", 2},
    {"nv", "integer", "", "", "rows", 2},
    {"Pz", "floats", kLengths, "", "heights over the unit square, row by row"},
};
constexpr ParamInfo kPhiMax{"phimax", "float", "degrees", "360", "sweep about the z axis", 0, 360};
constexpr ParamInfo kRadius{"radius", "float", kLengths, "1", "radius", 0};
constexpr ParamInfo kSphereParams[] = {
    kRadius,
    {"zmin", "float", kLengths, "-radius", "lower end along z"},
    {"zmax", "float", kLengths, "radius", "upper end along z"},
    kPhiMax,
};
constexpr ParamInfo kDiskParams[] = {
    kRadius,
    {"innerradius", "float", kLengths, "0", "radius of the hole", 0},
    {"height", "float", kLengths, "0", "place along z"},
    kPhiMax,
};
constexpr ParamInfo kCylinderParams[] = {
    kRadius,
    {"zmin", "float", kLengths, "-1", "lower end along z"},
    {"zmax", "float", kLengths, "1", "upper end along z"},
    kPhiMax,
};
constexpr ParamInfo kConeParams[] = {
    {"radius", "float", kLengths, "1", "radius at z = 0", 0},
    {"height", "float", kLengths, "1", "place of the apex along z"},
    kPhiMax,
};
constexpr ParamInfo kParaboloidParams[] = {
    {"radius", "float", kLengths, "1", "radius at zmax", 0},
    {"zmin", "float", kLengths, "0", "lower end along z"},
    {"zmax", "float", kLengths, "1", "upper end along z"},
    kPhiMax,
};
constexpr ParamInfo kHyperboloidParams[] = {
    {"p1", "point3", kLengths, "0 0 0", "one end of the segment that sweeps the surface"},
    {"p2", "point3", kLengths, "1 1 1", "its other end"},
    {"radius", "float", kLengths, "1", "is read and has no effect"},
    kPhiMax,
};
constexpr ParamInfo kHairFileParams[] = {
    {"filename", "string", "", "", "a .hair, .tfx, .usda or .ply file, from the folder of the scene"},
    {"pointsperstrand", "integer", "", "100", "points of a .ply file that make a strand", 2},
    {"width", "float", kLengths, "the file's", "diameter of all strands", 0},
    {"widthscale", "float", "", "1", "factor on all widths"},
    {"segments", "integer", "", "0", "curve segments a strand, resampled; 0: as the file has them", 0,
     kMaxSegmentsPerStrand},
    ChoiceParam("spline", kStrandSplines, "how points are joined", "the file's"),
    {"time", "float", "time code", "the frame, or the first",
     "of a .usda file's time samples, the last that is no later; without it, in an animation, the number of "
     "the frame"},
};
constexpr ParamInfo kGroomHeadParams[] = {
    {"spacing", "float", "cm", "0.3", "distance of neighbouring vertices"},
};

// To add a shape: its maker above, a row here. A new kind of maker is another alternative of ShapeMaker,
// which SceneBuilder::AddShape then handles.
const std::vector<PluginRow<ShapeMaker>> &ShapeRows() {
    static const std::vector<PluginRow<ShapeMaker>> rows{
        {{"curve", kCurveParams, "a curve of cubic or quadratic segments: hair"}, {}},
        {{"trianglemesh", kTriangleMeshParams, "a mesh of triangles"}, MakeTriangleMesh},
        {{"plymesh", kPlyMeshParams, "a mesh of triangles from a PLY file"}, MakePlyMesh},
        {{"loopsubdiv", kLoopSubdivParams, "a mesh smoothed by Loop's subdivision (Loop 1987)"},
         MakeLoopSubdivision},
        {{"heightfield", kHeightFieldParams, "heights over the unit square"}, MakeHeightField},
        {{"sphere", kSphereParams, "a sphere about the origin, or a part of it"}, AddSphere},
        {{"disk", kDiskParams, "a disk across the z axis"}, AddDisk},
        {{"cylinder", kCylinderParams, "an open cylinder about the z axis"}, AddCylinder},
        {{"cone", kConeParams, "a cone about the z axis, open at z = 0"}, AddCone},
        {{"paraboloid", kParaboloidParams, "a paraboloid about the z axis"}, AddParaboloid},
        {{"hyperboloid", kHyperboloidParams, "the surface that a segment sweeps about the z axis"},
         AddHyperboloid},
        {{.name = "nurbs", .meaning = "a spline surface", .standIn = "left out of the picture"}, {}},
        {{"hairfile", kHairFileParams, "the strands of a file", {}, true}, MakeHairFile},
        {{"groom", GroomParamRows(), "hair that is grown by a recipe", {}, true}, MakeGroomShape},
        {{"groomhead", kGroomHeadParams, "the head and shoulders that Shape \"groom\" grows on", {}, true},
         MakeGroomHead},
    };
    return rows;
}

} // namespace

const PluginRow<ShapeMaker> *FindShape(std::string_view name) { return FindPluginRow(ShapeRows(), name); }

const PluginTable &ShapePlugins() {
    static const PluginTable table{
        PluginKind::Shape,
        PluginInfos(ShapeRows()),
        {"bilinearmesh"},
        {},
        "curves of every type, basis and degree; objects are stored once, however many instances; alpha and "
        "shadowalpha on meshes"};
    return table;
}

} // namespace cuticle
