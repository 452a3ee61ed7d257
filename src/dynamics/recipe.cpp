#include "dynamics/recipe.h"

#include "core/error.h"
#include "dynamics/pose_file.h"
#include "grooms/groom_file.h"
#include "grooms/groom_params.h"
#include "grooms/procedural.h"
#include "parser/statements.h"

#include <cmath>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

namespace cuticle {

namespace {

constexpr double kMaxFrames = 100000;

constexpr ParamInfo kHairFileParams[] = {
    {"filename", "string", "", "", "a .hair, .tfx, .usda or .ply file of strands, in cm"},
    {"width", "float", "cm", "the file's", "diameter of all strands", 0},
    {"pointsperstrand", "integer", "", "100", "points of a .ply file that make a strand", 2, 1e6},
    {"time", "float", "time code", "the first", "of a .usda file's time samples, the last that is no later"},
};
constexpr std::string_view kMethods[] = {"rods", "springs"};
constexpr ParamInfo kStrandsParams[] = {
    ChoiceParam(
        "method", kMethods,
        "elastic rods of constant length, or the paper's springs in explicit steps, which stretch and let "
        "straight hair hang like a chain"),
    {"springsteps", "integer", "", "200",
     "small steps of springs in a step; the more, the stiffer they may be", 1, 100000},
    {"seconds", "float", "s", "2", "how long", 0, 1e5},
    {"fps", "float", "1/s", "24", "frames a second", 1, 1000},
    {"substeps", "integer", "", "0", "steps of a frame; 0: so many that none is longer than 1/60 s", 0, 1000},
    {"keys", "integer", "", "2500", "key hairs that are simulated; the others follow them", 1, 1e6},
    {"points", "integer", "", "32", "points of a key hair", 3, 1000},
    {"bending", "float", "cm^4/s^2", "5e6",
     "bending stiffness over mass a length; a single hair of 80 um has 1.2e5, a key hair stands for a lock",
     1, 1e12},
    {"twist", "float", "", "0.75", "stiffness against twist over that against bending", 1e-3, 100},
    {"stretch", "float", "cm^2/s^2", "3e10", "Young's modulus over density, before lengths are mended", 1e6,
     1e14},
    {"damping", "float", "s", "0.005", "time in which a bend without inertia would relax", 0, 100},
    {"drag", "float", "1/s", "3", "by which the air slows hair down", 0, 1e6},
    {"friction", "float", "", "0.3", "Coulomb's coefficient against obstacles", 0, 100},
    {"clearance", "float", "cm", "0.03", "distance kept from obstacles; less where a point rests nearer", 0,
     10},
    {"gravity", "vector3", "cm/s^2", "0 -981 0", "acceleration by weight", -1e6, 1e6},
    {"balanced", "bool", "", "true", "the groom carries its weight at the start; false: it sags from there"},
};
constexpr ParamInfo kSphereParams[] = {
    {"center", "point3", "cm", "0 0 0", "its centre", -1e6, 1e6},
    {"radius", "float", "cm", "1", "its radius", 1e-3, 1e6},
};
constexpr ParamInfo kEllipsoidParams[] = {
    {"center", "point3", "cm", "0 0 0", "its centre", -1e6, 1e6},
    {"radii", "vector3", "cm", "1 1 1", "its semi-axes along x, y and z", 1e-3, 1e6},
};
constexpr ParamInfo kCapsuleParams[] = {
    {"from", "point3", "cm", "0 0 0", "one end of its axis", -1e6, 1e6},
    {"to", "point3", "cm", "0 0 0", "the other end", -1e6, 1e6},
    {"radius", "float", "cm", "1", "its radius", 1e-3, 1e6},
};
constexpr ParamInfo kKeysParams[] = {
    {"time", "floats", "s", "", "times of the keys, growing from 0", 0, 1e5},
    {"turn", "vector3s", "degrees", "none",
     "a turn for each time: its direction is the axis, its length the angle; the first is 0 0 0", -36000,
     36000},
    {"shift", "vector3s", "cm", "none", "a shift for each time; the first is 0 0 0", -1e6, 1e6},
    {"pivot", "point3", "cm", "0 -12 -3", "point that the head turns about: the neck", -1e6, 1e6},
};
constexpr std::string_view kUpAxes[] = {"y", "z"};
constexpr ParamInfo kPosesParams[] = {
    {"filename", "string", "", "",
     "a .usda file in which an Xform has time samples, or a table with a line for each frame: its number, a "
     "place x y z, and a turn: a vector (degrees) whose direction is the axis, or a quaternion w x y z"},
    {"prim", "string", "", "the first that moves", "the Xform of a .usda file, by its name or path"},
    {"fps", "float", "1/s", "24, or the .usda file's timeCodesPerSecond", "frames of the file a second", 1e-3,
     1e5},
    {"start", "float", "", "the first", "the file's frame at which the hair is groomed and time begins", -1e6,
     1e6},
    {"unit", "float", "cm", "1, or the .usda file's metersPerUnit", "length of a unit of the file", 1e-6,
     1e6},
    ChoiceParam("up", kUpAxes, "axis of a table that is up: of z, (x, y, z) is turned to (x, z, -y)"),
};
constexpr ParamInfo kGridParams[] = {
    {"drag", "float", "1/s", "20", "by which hair is drawn to the velocity of the hair around it", 0, 1e6},
    {"cell", "float", "cm", "1.5", "side of a cell", 0.01, 1e4},
    {"passes", "integer", "", "2", "times that velocities are smoothed on the grid", 0, 1000},
    {"flip", "float", "", "0",
     "share of the target that is a hair's own velocity and what smoothing changes (FLIP), not the smoothed "
     "velocity (PIC)",
     0, 1},
};
constexpr std::string_view kKernels[] = {"smooth", "tent"};
constexpr ParamInfo kDensityParams[] = {
    {"filename", "string", "", "", "a file of strands in the wanted shape"},
    {"time", "float", "time code", "the first", "of a .usda file's time samples, the last that is no later"},
    {"factor", "float", "cm^2/s^2", "3e4",
     "strength of the pull: acceleration is the factor times equation 3's", 0, 1e12},
    {"cells", "floats", "cm", "6 3 1.5",
     "sides of cells, coarse to fine, each for an equal share of the time", 0.25, 1e3},
    ChoiceParam("kernel", kKernels, "how points make a density: a quadratic B-spline, or the paper's tent"),
};
constexpr ParamInfo kWindParams[] = {
    {"velocity", "vector3", "cm/s", "0 0 0", "its mean velocity", -1e5, 1e5},
    {"gust", "float", "", "0.5", "strength of gusts against the mean", 0, 10},
    {"gustlength", "float", "cm", "15", "distance from gust to gust", 0.1, 1e6},
};

// To add one: a row of parameters above, a row or a directive here, and what it does in MakeRecipe.
std::vector<StatementKind> MakeStatementKinds() {
    return {
        {"Hair",
         {{"groom", GroomParamRows(), "hair that is grown by a recipe, as Shape \"groom\" in a scene"},
          {"hairfile", kHairFileParams, "the strands of a file"}}},
        {"Simulation", {{"strands", kStrandsParams, "key hairs and how they are stepped"}}},
        {"Obstacle",
         {{"head", {}, "the head and shoulders of our grooms"},
          {"sphere", kSphereParams, "a ball"},
          {"ellipsoid", kEllipsoidParams, "an ellipsoid"},
          {"capsule", kCapsuleParams, "a cylinder with round ends"}},
         true},
        {"Motion",
         {{"keys", kKeysParams, "the head, and obstacles with it, move by keys on a smooth way"},
          {"poses", kPosesParams,
           "the head, and obstacles with it, move as a file says; hair is groomed on the head where it "
           "stands "
           "at the first pose"}}},
        {"HairToHair", {{"grid", kGridParams, "hair holds hair: velocities are smoothed on a grid"}}},
        {"Target", {{"density", kDensityParams, "hair is drawn to where a target's density is"}}},
        {"Wind",
         {{"steady", kWindParams, "a wind with gusts that travel with it; drag says how it takes hold"}}},
    };
}
std::span<const StatementKind> RecipeKinds() {
    static const std::vector<StatementKind> kinds = MakeStatementKinds();
    return kinds;
}

// Parameters in double: a statement's reader has checked type and range.
double NumberOf(const ParamSet &p, std::string_view name, double defaultValue) {
    const Param *param = p.Find(name);
    return param != nullptr ? param->numbers[0] : defaultValue;
}
Vector3d VectorOf(const ParamSet &p, std::string_view name, const Vector3d &defaultValue) {
    const Param *param = p.Find(name);
    return param != nullptr ? Vector3d{param->numbers[0], param->numbers[1], param->numbers[2]}
                            : defaultValue;
}
size_t CountOf(const ParamSet &p, std::string_view name, size_t defaultValue) {
    return static_cast<size_t>(NumberOf(p, name, static_cast<double>(defaultValue)));
}

Groom MakeRecipeHair(const Statement &s) {
    const PlaceScope place(s.params.loc);
    if (s.row->name == "groom")
        return MakeGroom(GroomParamsOf(s.params));
    const std::string filename = s.params.FindFilename("filename");
    if (filename.empty())
        throw Error("this hair needs \"string filename\"");
    std::optional<double> time;
    if (const Param *given = s.params.Find("time"))
        time = given->numbers[0];
    return ReadGroomFile(filename, {static_cast<float>(NumberOf(s.params, "width", 0)),
                                    CountOf(s.params, "pointsperstrand", 0), time});
}

std::unique_ptr<Obstacle> MakeRecipeObstacle(const Statement &s) {
    const ParamSet &p = s.params;
    if (s.row->name == "sphere")
        return MakeSphere(VectorOf(p, "center", {}), NumberOf(p, "radius", 1));
    if (s.row->name == "ellipsoid")
        return MakeEllipsoid(VectorOf(p, "center", {}), VectorOf(p, "radii", {1, 1, 1}));
    if (s.row->name == "capsule")
        return MakeCapsule(VectorOf(p, "from", {}), VectorOf(p, "to", {}), NumberOf(p, "radius", 1));
    return MakeHead();
}

HeadMotion MakeMotion(const ParamSet &p) {
    const Param *times = p.Find("time");
    if (times == nullptr)
        throw Error(p.loc, "this motion needs \"float time\", the times of its keys");
    std::vector<HeadMotion::Key> keys;
    for (const double t : times->numbers) {
        if (!(keys.empty() ? t == 0 : t > keys.back().time))
            throw Error(times->loc, "\"time\" holds {} after {}", t, keys.empty() ? 0 : keys.back().time)
                .WithRemedy("times must begin with 0 and grow");
        keys.push_back({t, {}, {}});
    }
    for (const auto &[name, value, factor] : {std::tuple{"turn", &HeadMotion::Key::turn, kPi<double> / 180},
                                              {"shift", &HeadMotion::Key::shift, 1.}}) {
        const Param *param = p.Find(name);
        if (param == nullptr)
            continue;
        if (param->numbers.size() != 3 * keys.size())
            throw Error(param->loc, "\"{}\" has {} vectors for {} times", name, param->numbers.size() / 3,
                        keys.size());
        for (size_t k = 0; k < keys.size(); ++k) {
            const double *v = &param->numbers[3 * k];
            keys[k].*value = Vector3d{v[0], v[1], v[2]} * factor;
        }
        if (!(keys[0].*value == Vector3d{}))
            throw Error(param->loc, "\"{}\" does not begin with 0 0 0", name)
                .WithRemedy("hair is groomed on the head where it stands at time 0");
    }
    return {std::move(keys), VectorOf(p, "pivot", {0, -12, -3})};
}

HeadMotion MakePoses(const ParamSet &p) {
    const PlaceScope place(p.loc);
    const std::string filename = p.FindFilename("filename");
    if (filename.empty())
        throw Error("this motion needs \"string filename\"");
    const auto given = [&](std::string_view name) {
        const Param *param = p.Find(name);
        return param != nullptr ? std::optional(param->numbers[0]) : std::nullopt;
    };
    return HeadMotion(ReadPoseFile(filename, {p.FindString("prim", ""), given("fps"), given("start"),
                                              given("unit"), p.FindString("up", "y") == "z"}));
}

void ReadStrands(const ParamSet &p, SimulationRecipe *recipe) {
    SimulationSettings &s = recipe->settings;
    StrandPhysics &physics = s.physics;
    physics.method = p.FindString("method", "rods") == "springs" ? StrandMethod::Springs : StrandMethod::Rods;
    physics.springSteps = CountOf(p, "springsteps", physics.springSteps);
    recipe->seconds = NumberOf(p, "seconds", recipe->seconds);
    s.framesPerSecond = NumberOf(p, "fps", s.framesPerSecond);
    s.substeps = CountOf(p, "substeps", s.substeps);
    s.keyHairs = CountOf(p, "keys", s.keyHairs);
    s.points = CountOf(p, "points", s.points);
    physics.bending = NumberOf(p, "bending", physics.bending);
    physics.twist = NumberOf(p, "twist", 0.75) * physics.bending;
    physics.stretch = NumberOf(p, "stretch", physics.stretch);
    physics.damping = NumberOf(p, "damping", physics.damping);
    physics.friction = NumberOf(p, "friction", physics.friction);
    physics.clearance = NumberOf(p, "clearance", physics.clearance);
    s.drag = NumberOf(p, "drag", s.drag);
    s.gravity = VectorOf(p, "gravity", s.gravity);
    s.balanced = p.FindBool("balanced", s.balanced);
    if (recipe->seconds * s.framesPerSecond > kMaxFrames)
        throw Error(p.loc, "{} seconds of {} frames each are more than {} frames", recipe->seconds,
                    s.framesPerSecond, kMaxFrames);
}

// The target's key hairs are those of the groom where it has the same strands.
void ReadTarget(const Statement &s, SimulationRecipe *recipe) {
    const PlaceScope place(s.params.loc);
    HairDirection &d = recipe->settings.direction;
    const std::string filename = s.params.FindFilename("filename");
    if (filename.empty())
        throw Error("this target needs \"string filename\"");
    std::optional<double> time;
    if (const Param *given = s.params.Find("time"))
        time = given->numbers[0];
    const Groom groom = PointsOnCurves(WithoutPlacements(ReadGroomFile(filename, {.time = time}), filename));
    const bool same = groom.StrandCount() == recipe->groom.StrandCount();
    const std::vector<uint32_t> keys =
        ChooseKeyHairs(same ? recipe->groom : groom, recipe->settings.keyHairs);
    d.points = ResampleKeyHairs(groom, keys, recipe->settings.points);
    if (d.points.empty())
        throw Error("{}: there is no strand of two points in the target", filename);
    d.factor = NumberOf(s.params, "factor", d.factor);
    if (const Param *cells = s.params.Find("cells"))
        d.cells = cells->numbers;
    d.seconds = recipe->seconds;
    d.kernel =
        s.params.FindString("kernel", "smooth") == "tent" ? DensityKernel::Tent : DensityKernel::Smooth;
}

SimulationRecipe MakeRecipe(const std::vector<Statement> &statements, const std::string &name) {
    SimulationRecipe recipe;
    std::vector<std::unique_ptr<Obstacle>> bodies;
    const Statement *hair = nullptr, *target = nullptr;
    for (const Statement &s : statements) {
        const std::string_view directive = s.kind->directive;
        if (directive == "Hair")
            hair = &s;
        else if (directive == "Simulation")
            ReadStrands(s.params, &recipe);
        else if (directive == "Obstacle")
            bodies.push_back(MakeRecipeObstacle(s));
        else if (directive == "Motion")
            recipe.settings.motion = s.row->name == "poses" ? MakePoses(s.params) : MakeMotion(s.params);
        else if (directive == "HairToHair")
            recipe.settings.coupling = {NumberOf(s.params, "drag", 20), NumberOf(s.params, "cell", 1.5),
                                        CountOf(s.params, "passes", 2), NumberOf(s.params, "flip", 0)};
        else if (directive == "Target")
            target = &s;
        else if (directive == "Wind")
            recipe.settings.wind = {VectorOf(s.params, "velocity", {}), NumberOf(s.params, "gust", 0.5),
                                    NumberOf(s.params, "gustlength", 15)};
    }
    if (hair == nullptr)
        throw Error("{}: there is no Hair in this recipe", name)
            .WithRemedy("give it Hair \"groom\" or Hair \"hairfile\"");
    recipe.groom = MakeRecipeHair(*hair);
    if (target != nullptr)
        ReadTarget(*target, &recipe);
    recipe.obstacle = MakeUnion(std::move(bodies));
    return recipe;
}

} // namespace

size_t SimulationRecipe::FrameCount() const {
    return 1 + static_cast<size_t>(std::floor(seconds * settings.framesPerSecond + 1e-6));
}

SimulationRecipe ReadSimulationRecipe(const std::string &filename) {
    return MakeRecipe(ReadStatements(RecipeKinds(), filename), filename);
}
SimulationRecipe ParseSimulationRecipe(const std::string &text, const std::string &name,
                                       const std::string &folder) {
    return MakeRecipe(ParseStatements(RecipeKinds(), text, name, folder), name);
}
std::string SimulationManual() { return StatementManual(RecipeKinds()); }

} // namespace cuticle
