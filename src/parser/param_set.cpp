#include "parser/param_set.h"

#include "parser/lexer.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

namespace cuticle {

namespace {

thread_local ParamRecorder *recorder = nullptr;

// The word before the name in the file; Spectrum by the spelling that is asked for most.
const char *TypeName(ParamType type) {
    switch (type) {
    case ParamType::Bool:
        return "bool";
    case ParamType::Integer:
        return "integer";
    case ParamType::Float:
        return "float";
    case ParamType::Point2:
        return "point2";
    case ParamType::Vector2:
        return "vector2";
    case ParamType::Point3:
        return "point";
    case ParamType::Vector3:
        return "vector";
    case ParamType::Normal:
        return "normal";
    case ParamType::Spectrum:
        return "rgb";
    case ParamType::String:
        return "string";
    case ParamType::Texture:
        return "texture";
    }
    return "";
}

template <typename... Args>
[[noreturn]] void Fail(const Param &p, fmt::format_string<Args...> format, Args &&...args) {
    throw Error(p.loc, fmt::vformat(format, fmt::make_format_args(args...)))
        .WithSourceLine(SourceLine(p.loc));
}

// Warns of what pbrt-v3 passes over: the parameter does not count, or not all of it.
template <typename... Args>
void Complain(const Param &p, const std::string &kind, fmt::format_string<Args...> format, Args &&...args) {
    p.used = true;
    Warning(p.loc, kind, fmt::vformat(format, fmt::make_format_args(args...)));
}

// Finds the parameter of that name, which must be of one of the types; null when there is none. The message
// recommends the first type.
const Param *Require(const ParamSet &set, std::string_view name, std::initializer_list<ParamType> types) {
    const Param *p = set.Find(name);
    if (!p)
        return nullptr;
    if (std::find(types.begin(), types.end(), p->type) == types.end()) {
        Complain(*p, "parameter of another type",
                 "\"{0}\" is given as {1}; it must be \"{2} {0}\", and is ignored, as by pbrt-v3", p->name,
                 TypeName(p->type), TypeName(*types.begin()));
        return nullptr;
    }
    p->used = true;
    return p;
}

// False for any other number of values than `count`.
bool HasCount(const Param &p, size_t given, size_t count, const char *what) {
    if (given != count)
        Complain(p, "wrong number of values", "\"{}\" must have {}, not {} {}; it is ignored, as by pbrt-v3",
                 p.name, what, given, given == 1 ? "value" : "values");
    return given == count;
}

// How many whole groups of `size` numbers there are.
size_t WholeGroups(const Param &p, size_t size) {
    if (p.numbers.size() % size != 0)
        Complain(
            p, "numbers in excess",
            "\"{}\" has {} numbers, which is no multiple of {}; those in excess are ignored, as by pbrt-v3",
            p.name, p.numbers.size(), size);
    return p.numbers.size() / size;
}

int ToInt(const Param &p, double v) {
    if (!(v >= std::numeric_limits<int>::min() && v <= std::numeric_limits<int>::max()))
        Fail(p, "\"{}\" is {:g}, which is out of range (an integer has 32 bits)", p.name, v);
    if (v != std::trunc(v))
        Complain(p, "integer with a fraction",
                 "\"{}\" is {:g}, and must be a whole number; {:g} is taken, as by "
                 "pbrt-v3",
                 p.name, v, std::trunc(v));
    return static_cast<int>(v);
}

Point3f Triple(const std::vector<double> &v, size_t i) {
    return Point3f(Vector3d(v[3 * i], v[3 * i + 1], v[3 * i + 2]));
}

std::vector<Point3f> Triples(const Param *p) {
    std::vector<Point3f> r;
    if (!p)
        return r;
    const size_t count = WholeGroups(*p, 3);
    r.reserve(count);
    for (size_t i = 0; i < count; ++i)
        r.push_back(Triple(p->numbers, i));
    return r;
}

} // namespace

std::string ResolveFilename(const std::string &folder, const std::string &name) {
    if (name.empty() || name[0] == '/' || folder.empty())
        return name;
    return folder.back() == '/' ? folder + name : folder + "/" + name;
}

const Param *ParamSet::Find(std::string_view name) const {
    if (recorder)
        recorder->asked_[loc.line].emplace(name);
    for (const Param &p : params)
        if (p.name == name)
            return &p;
    return nullptr;
}

const Param *ParamSet::Find(std::string_view name, ParamType type) const {
    const Param *p = Find(name);
    if (!p || p->type != type)
        return nullptr;
    p->used = true;
    return p;
}

ParamRecorder::ParamRecorder() : outer_(std::exchange(recorder, this)) {}

ParamRecorder::~ParamRecorder() { recorder = outer_; }

const std::set<std::string, std::less<>> &ParamRecorder::AskedOn(uint32_t line) const {
    static const std::set<std::string, std::less<>> kNone;
    const auto it = asked_.find(line);
    return it == asked_.end() ? kNone : it->second;
}

bool ParamSet::FindBool(std::string_view name, bool defaultValue) const {
    const Param *p = Require(*this, name, {ParamType::Bool});
    if (!p || !HasCount(*p, p->bools.size(), 1, "one value"))
        return defaultValue;
    return p->bools[0];
}

int ParamSet::FindInt(std::string_view name, int defaultValue) const {
    const Param *p = Require(*this, name, {ParamType::Integer});
    if (!p || !HasCount(*p, p->numbers.size(), 1, "one value"))
        return defaultValue;
    return ToInt(*p, p->numbers[0]);
}

float ParamSet::FindFloat(std::string_view name, float defaultValue) const {
    const Param *p = Require(*this, name, {ParamType::Float, ParamType::Integer});
    if (!p || !HasCount(*p, p->numbers.size(), 1, "one value"))
        return defaultValue;
    return static_cast<float>(p->numbers[0]);
}

std::string ParamSet::FindString(std::string_view name, const std::string &defaultValue) const {
    const Param *p = Require(*this, name, {ParamType::String});
    if (!p || !HasCount(*p, p->strings.size(), 1, "one value"))
        return defaultValue;
    return p->strings[0];
}

Spectrum ParamSet::FindSpectrum(std::string_view name, const Spectrum &defaultValue) const {
    const Param *p = Require(*this, name, {ParamType::Spectrum});
    if (!p || !HasCount(*p, p->numbers.size() / 3, 1, "one colour"))
        return defaultValue;
    const Point3f c = Triple(p->numbers, 0);
    return {c.x, c.y, c.z};
}

Point3f ParamSet::FindPoint3f(std::string_view name, const Point3f &defaultValue) const {
    const Param *p = Require(*this, name, {ParamType::Point3});
    if (!p || !HasCount(*p, p->numbers.size(), 3, "three numbers"))
        return defaultValue;
    return Triple(p->numbers, 0);
}

Vector3f ParamSet::FindVector3f(std::string_view name, const Vector3f &defaultValue) const {
    const Param *p = Require(*this, name, {ParamType::Vector3});
    if (!p || !HasCount(*p, p->numbers.size(), 3, "three numbers"))
        return defaultValue;
    return Triple(p->numbers, 0);
}

std::vector<float> ParamSet::FindFloats(std::string_view name) const {
    const Param *p = Require(*this, name, {ParamType::Float, ParamType::Integer});
    std::vector<float> r;
    if (p) {
        r.reserve(p->numbers.size());
        for (const double v : p->numbers)
            r.push_back(static_cast<float>(v));
    }
    return r;
}

std::vector<int> ParamSet::FindInts(std::string_view name) const {
    const Param *p = Require(*this, name, {ParamType::Integer});
    std::vector<int> r;
    if (p) {
        r.reserve(p->numbers.size());
        for (const double v : p->numbers)
            r.push_back(ToInt(*p, v));
    }
    return r;
}

std::vector<Point2f> ParamSet::FindPoint2fs(std::string_view name) const {
    const Param *p =
        Require(*this, name, {ParamType::Point2, ParamType::Vector2, ParamType::Float, ParamType::Integer});
    std::vector<Point2f> r;
    if (!p)
        return r;
    const size_t count = WholeGroups(*p, 2);
    r.reserve(count);
    for (size_t i = 0; i < 2 * count; i += 2)
        r.emplace_back(static_cast<float>(p->numbers[i]), static_cast<float>(p->numbers[i + 1]));
    return r;
}

std::vector<Point3f> ParamSet::FindPoint3fs(std::string_view name) const {
    return Triples(Require(*this, name, {ParamType::Point3, ParamType::Vector3}));
}

std::vector<Normal3f> ParamSet::FindNormals(std::string_view name) const {
    return Triples(Require(*this, name, {ParamType::Normal}));
}

std::string ParamSet::FindFilename(std::string_view name) const {
    return ResolveFilename(folder ? *folder : "", FindString(name, ""));
}

void ParamSet::ReportUnused(const std::string &what) const {
    for (const Param &p : params)
        if (!p.used)
            Warning(p.loc, fmt::format("unused parameter \"{}\" of {}", p.name, what),
                    fmt::format("{} has no use for parameter \"{}\"", what, p.name));
}

} // namespace cuticle
