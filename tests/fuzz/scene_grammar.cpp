#include "fuzz/scene_grammar.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace cuticle {

namespace {

bool IsNumber(const std::string &token) {
    return !token.empty() && std::string_view("+-.0123456789").find(token[0]) != std::string_view::npos;
}
bool IsString(const std::string &token) { return !token.empty() && token[0] == '"'; }
// "float beta_m": a declaration of a parameter and no plain name
bool IsDeclaration(const std::string &token) {
    return IsString(token) && token.find(' ') != std::string::npos;
}
bool IsPlainString(const std::string &token) { return IsString(token) && !IsDeclaration(token); }
bool IsAny(const std::string &) { return true; }

std::string Quote(std::string_view text) { return fmt::format("\"{}\"", text); }

} // namespace

// --- random choices --------------------

SceneMutator::SceneMutator(const PluginTables &plugins, std::vector<std::string> seedFiles, uint64_t seed)
    : plugins_(plugins), seedFiles_(std::move(seedFiles)), random_(seed) {}

size_t SceneMutator::Below(size_t n) { return n == 0 ? 0 : random_() % n; }

bool SceneMutator::Chance(double probability) {
    return static_cast<double>(random_() >> 11) * 0x1p-53 < probability;
}

std::string SceneMutator::Name() {
    constexpr std::array<const char *, 6> names{"a", "b", "c", "camera", "world", ""};
    return names[Chance(0.9) ? Below(3) : Below(names.size())];
}

std::string SceneMutator::FileName() {
    constexpr std::array<const char *, 6> names{"a.pbrt",     "b.pbrt",   "c.pbrt",
                                                "scene.pbrt", "none.png", "../x"};
    if (!seedFiles_.empty() && Chance(0.7))
        return Pick(seedFiles_);
    return Chance(0.5) ? fmt::format("d{}", Below(4)) : names[Below(names.size())];
}

// --- values of parameters --------------------

double SceneMutator::SaneNumber(const ParamInfo &info) {
    const double u = static_cast<double>(random_() >> 11) * 0x1p-53;
    const bool bounded = std::isfinite(info.low), above = std::isfinite(info.high);
    if (bounded && above && info.high - info.low < 1000)
        return info.low + u * (info.high - info.low);
    if (bounded)
        return info.low - std::log(1 - u);
    return 4 * u - 2;
}

std::string SceneMutator::EdgeNumber(const ParamInfo &info) {
    constexpr std::array<const char *, 34> edges{
        "0",     "-0",         "1",          "-1",         "2",           "3",          "0.5",
        "1e-7",  "1e-20",      "1e-38",      "1e-45",      "-1e-45",      "1e5",        "1e10",
        "1e17",  "1e19",       "1e30",       "-1e30",      "3.4e38",      "1e39",       "-1e39",
        "1e300", "1e999",      "2147483647", "2147483648", "-2147483648", "4294967295", "65536",
        "255",   "0.99999994", "1.0000001",  "16777217",   "1.5",         "-2"};
    if (std::isfinite(info.low) && Chance(0.3))
        return fmt::format("{:.9g}",
                           Chance(0.5) ? info.low : std::nextafter(static_cast<float>(info.low), -1e30f));
    if (std::isfinite(info.high) && Chance(0.3))
        return fmt::format("{:.9g}",
                           Chance(0.5) ? info.high : std::nextafter(static_cast<float>(info.high), 1e30f));
    return edges[Below(edges.size())];
}

std::string SceneMutator::Number(const ParamInfo &info, bool integer) {
    if (Chance(0.04))
        return EdgeNumber(info);
    const double value = SaneNumber(info);
    if (!integer)
        return fmt::format("{:.6g}", value);
    return fmt::format("{}", static_cast<int64_t>(std::isfinite(info.high) && info.high < 1000
                                                      ? std::round(value)
                                                      : std::round(std::fabs(value) * 4)));
}

void SceneMutator::Numbers(const ParamInfo &info, bool integer, size_t count, Tokens *to) {
    to->emplace_back("[");
    for (size_t i = 0; i < count; ++i)
        to->push_back(Number(info, integer));
    to->emplace_back("]");
}

void SceneMutator::SpectrumParam(const ParamInfo &info, Tokens *to) {
    const std::string name(info.name);
    switch (Below(8)) {
    case 0:
        to->push_back(Quote("blackbody " + name));
        to->insert(to->end(), {"[", fmt::format("{}", 1000 + Below(9000)), Number(info, false), "]"});
        return;
    case 1:
        to->push_back(Quote("xyz " + name));
        return Numbers(info, false, 3, to);
    case 2:
        to->push_back(Quote("spectrum " + name));
        if (Chance(0.4)) {
            to->push_back(Quote("spectrum.spd"));
            return;
        }
        to->emplace_back("[");
        for (size_t i = 0; i < 1 + Below(4); ++i)
            to->insert(to->end(), {fmt::format("{}", 400 + 100 * i), Number(info, false)});
        to->emplace_back("]");
        return;
    case 3:
        to->push_back(Quote("float " + name)); // of the wrong type
        return Numbers(info, false, 1, to);
    default:
        to->push_back(Quote((Chance(0.8) ? "rgb " : "color ") + name));
        return Numbers(info, false, 3, to);
    }
}

void SceneMutator::Param(const ParamInfo &info, std::string_view plugin, Tokens *to) {
    const std::string name(info.name);
    std::string type(info.type);
    if (type == "texture name" || (type.find("texture") != std::string::npos && Chance(0.25))) {
        to->insert(to->end(), {Quote("texture " + name), Quote(Name())});
        return;
    }
    if (type.starts_with("spectrum") || (type.starts_with("float or spectrum") && Chance(0.5)))
        return SpectrumParam(info, to);
    type = type.substr(0, type.find(' '));
    if (type == "string") {
        const bool file = name.find("file") != std::string::npos || name.find("map") != std::string::npos;
        to->push_back(Quote("string " + name));
        to->push_back(Quote(!info.choices.empty() && Chance(0.95)
                                ? std::string(info.choices[Below(info.choices.size())])
                            : file ? FileName()
                                   : Name()));
        return;
    }
    if (type == "bool") {
        to->insert(to->end(), {Quote("bool " + name), Quote(Chance(0.5) ? "true" : "false")});
        return;
    }
    const bool several = type.ends_with("s");
    if (several)
        type.pop_back();
    const bool integer = type == "integer";
    size_t count = several ? vertices_ : 1;
    if (name == "cropwindow" || name == "screenwindow")
        count = 4;
    if (plugin == "curve" && name == "N")
        count = (vertices_ - 1) / 3 + 1;
    const size_t parts = type.ends_with("2") ? 2 : integer || type == "float" ? 1 : 3;
    to->push_back(Quote(type + " " + name));
    if (name == "indices") { // triangles of those vertices
        ParamInfo index = info;
        index.low = 0, index.high = static_cast<double>(vertices_ - 1);
        return Numbers(index, true, 3 * (1 + Below(4)), to);
    }
    Numbers(info, integer, Chance(0.97) ? count * parts : Below(20), to);
}

void SceneMutator::Params(const PluginInfo &plugin, Tokens *to) {
    vertices_ = Chance(0.7) ? 4 : 7;
    // What would be legitimate and take long stays small, so that inputs are many
    const auto small = [&](const char *declaration, size_t value) {
        to->insert(to->end(), {Quote(declaration), fmt::format("{}", value)});
    };
    if (plugin.name == "groom")
        small("integer strands", 1 + Below(100)), small("integer segments", 1 + Below(8));
    if (plugin.name == "groomhead")
        small("float spacing", 2 + Below(5));
    if (plugin.name == "hair")
        small("integer samples", 1 + Below(30));
    for (const ParamInfo &info : plugin.params) {
        const bool needed = info.name == "P" || info.name == "indices" || info.name == "filename" ||
                            info.name == "mapname" || info.name == "nu" || info.name == "nv" ||
                            info.name == "Pz";
        if (info.name == "strands" || info.name == "samples" || info.name == "spacing" ||
            (info.name == "segments" && plugin.name == "groom"))
            continue;
        if (Chance(needed ? 0.97 : std::min(0.4, 4.0 / static_cast<double>(plugin.params.size()))))
            Param(info, plugin.name, to);
    }
}

void SceneMutator::Values(std::initializer_list<double> sane, double spread, Tokens *to) {
    const ParamInfo any{};
    for (const double v : sane)
        to->push_back(Chance(0.02) ? EdgeNumber(any)
                                   : fmt::format("{:.6g}", v + spread * (SaneNumber(any) / 2)));
}

// --- statements --------------------

SceneStatement SceneMutator::PluginStatement(PluginKind kind) {
    SceneStatement s;
    s.word = DirectiveOf(kind);
    const PluginTable *table = plugins_.Find(kind);
    if (!table || table->rows.empty())
        return s;
    const PluginInfo &plugin = Pick(table->rows);
    if (kind == PluginKind::Texture)
        s.tokens.insert(s.tokens.end(), {Quote(Name()), Quote(Chance(0.5) ? "float" : "spectrum")});
    s.tokens.push_back(Quote(plugin.name));
    if (kind == PluginKind::Material && Chance(0.2)) {
        s.word = "MakeNamedMaterial";
        s.tokens = {Quote(Name()), Quote("string type"), Quote(plugin.name)};
    }
    Params(plugin, &s.tokens);
    return s;
}

SceneStatement SceneMutator::TransformStatement() {
    SceneStatement s;
    switch (Below(6)) {
    case 0:
        s.word = "Translate";
        Values({0, 0, 0}, 0.5, &s.tokens);
        break;
    case 1:
        s.word = "Scale";
        Values({1, 1, 1}, 0.5, &s.tokens);
        break;
    case 2:
        s.word = "Rotate";
        Values({0, 0, 1, 0}, 90, &s.tokens);
        break;
    case 3:
        s.word = "LookAt";
        Values({0, 0, 3, 0, 0, 0, 0, 1, 0}, 0.2, &s.tokens);
        break;
    case 4:
        s.word = Chance(0.3) ? "Transform" : "ConcatTransform";
        s.tokens.emplace_back("[");
        Values({1, 0, 0}, 0.2, &s.tokens);
        s.tokens.emplace_back("0");
        Values({0, 1, 0}, 0.2, &s.tokens);
        s.tokens.emplace_back("0");
        Values({0, 0, 1}, 0.2, &s.tokens);
        s.tokens.emplace_back("0");
        Values({0, 0, 0}, 0.2, &s.tokens);
        s.tokens.insert(s.tokens.end(), {Chance(0.95) ? "1" : "0.5", "]"});
        break;
    default:
        s.word = "Identity";
    }
    return s;
}

SceneStatement SceneMutator::NameStatement() {
    constexpr std::array<const char *, 6> words{"NamedMaterial",     "ObjectInstance", "CoordinateSystem",
                                                "CoordSysTransform", "Include",        "MediumInterface"};
    SceneStatement s;
    s.word = words[Below(words.size())];
    s.tokens.push_back(Quote(s.word == "Include" ? fmt::format("{}.pbrt", Name()) : Name()));
    if (s.word == "MediumInterface")
        s.tokens.push_back(Quote(Name()));
    return s;
}

SceneStatement SceneMutator::Statement() {
    constexpr std::array<PluginKind, 8> options{
        PluginKind::Camera,     PluginKind::Sampler,     PluginKind::Film,   PluginKind::Filter,
        PluginKind::Integrator, PluginKind::Accelerator, PluginKind::Medium, PluginKind::Light};
    const size_t choice = Below(100);
    if (choice < 35)
        return PluginStatement(PluginKind::Shape);
    if (choice < 50)
        return PluginStatement(PluginKind::Material);
    if (choice < 60)
        return PluginStatement(PluginKind::Texture);
    if (choice < 68)
        return PluginStatement(PluginKind::Light);
    if (choice < 72)
        return PluginStatement(PluginKind::AreaLight);
    if (choice < 85)
        return TransformStatement();
    if (choice < 92)
        return NameStatement();
    if (choice < 96)
        return PluginStatement(options[Below(options.size())]);
    constexpr std::array<const char *, 10> words{
        "ReverseOrientation", "AttributeBegin", "AttributeEnd", "WorldBegin", "WorldEnd",
        "TransformBegin",     "TransformEnd",   "ObjectEnd",    "Wordl",      "TransformTimes 0 1"};
    return {words[Below(words.size())], {}};
}

std::vector<SceneStatement> SceneMutator::Block() {
    std::vector<SceneStatement> block;
    const size_t kind = Below(3);
    if (kind == 0)
        block.push_back({"AttributeBegin", {}});
    else if (kind == 1)
        block.push_back({"TransformBegin", {}});
    else
        block.push_back({"ObjectBegin", {Quote(Name())}});
    for (size_t i = Below(4); i-- > 0;)
        block.push_back(Statement());
    block.push_back({kind == 0 ? "AttributeEnd" : kind == 1 ? "TransformEnd" : "ObjectEnd", {}});
    return block;
}

SceneBundle SceneMutator::NewScene() {
    SceneBundle bundle = ReadBundle("LookAt 0 0 3 0 0 0 0 1 0\n");
    std::vector<SceneStatement> &all = bundle.files[0].statements;
    for (const PluginKind kind : {PluginKind::Camera, PluginKind::Sampler, PluginKind::Film,
                                  PluginKind::Filter, PluginKind::Integrator})
        if (Chance(0.5))
            all.push_back(PluginStatement(kind));
    all.push_back({"WorldBegin", {}});
    all.push_back(PluginStatement(PluginKind::Light));
    for (size_t i = 1 + Below(5); i-- > 0;) {
        if (Chance(0.2)) {
            const std::vector<SceneStatement> block = Block();
            all.insert(all.end(), block.begin(), block.end());
        } else {
            all.push_back(
                PluginStatement(std::array{PluginKind::Texture, PluginKind::Material, PluginKind::Material,
                                           PluginKind::AreaLight, PluginKind::Light}[Below(5)]));
        }
        all.push_back(PluginStatement(PluginKind::Shape));
    }
    all.push_back({"WorldEnd", {}});
    if (Chance(0.3))
        MoveToInclude(&bundle);
    return bundle;
}

// --- changes --------------------

// Null where there is none.
SceneStatement *SceneMutator::AnyStatement(SceneBundle *bundle) {
    SceneFile &file = Chance(0.7) ? bundle->files[0] : Pick(bundle->files);
    return file.statements.empty() ? nullptr : &Pick(file.statements);
}

// A statement and the place of its token; a null statement where none fits.
std::pair<SceneStatement *, size_t> SceneMutator::AnyToken(SceneBundle *bundle,
                                                           bool (*fits)(const std::string &)) {
    SceneStatement *const statement = AnyStatement(bundle);
    std::vector<size_t> found;
    for (size_t i = 0; statement && i < statement->tokens.size(); ++i)
        if (fits(statement->tokens[i]))
            found.push_back(i);
    if (found.empty())
        return {nullptr, 0};
    return {statement, Pick(found)};
}

void SceneMutator::Insert(SceneBundle *bundle) {
    std::vector<SceneStatement> &all = (Chance(0.8) ? bundle->files[0] : Pick(bundle->files)).statements;
    const std::vector<SceneStatement> added =
        Chance(0.3) ? Block() : std::vector<SceneStatement>{Statement()};
    all.insert(all.begin() + static_cast<std::ptrdiff_t>(Below(all.size() + 1)), added.begin(), added.end());
}

void SceneMutator::Remove(SceneBundle *bundle) {
    SceneFile &file = Pick(bundle->files);
    if (file.statements.empty())
        return;
    const size_t first = Below(file.statements.size());
    const size_t last = Chance(0.8) ? first + 1 : first + 1 + Below(file.statements.size() - first);
    file.statements.erase(file.statements.begin() + static_cast<std::ptrdiff_t>(first),
                          file.statements.begin() + static_cast<std::ptrdiff_t>(last));
}

void SceneMutator::Repeat(SceneBundle *bundle) {
    std::vector<SceneStatement> &all = Pick(bundle->files).statements;
    if (all.empty() || all.size() > 400)
        return;
    const SceneStatement one = Pick(all);
    const size_t times = Chance(0.8) ? 1 : 1 + Below(60);
    all.insert(all.begin() + static_cast<std::ptrdiff_t>(Below(all.size() + 1)), times, one);
}

void SceneMutator::Swap(SceneBundle *bundle) {
    SceneStatement *const a = AnyStatement(bundle), *const b = AnyStatement(bundle);
    if (a && b && a != b)
        std::swap(*a, *b);
}

// Blocks around a range of statements; now and then one that is never closed.
void SceneMutator::Nest(SceneBundle *bundle) {
    std::vector<SceneStatement> &all = Pick(bundle->files).statements;
    if (all.empty() || all.size() > 400)
        return;
    const size_t first = Below(all.size()), count = 1 + Below(all.size() - first);
    const size_t depth = Chance(0.9) ? 1 : 1 + Below(150);
    const size_t kind = Below(3);
    const SceneStatement begin = kind == 0   ? SceneStatement{"AttributeBegin", {}}
                                 : kind == 1 ? SceneStatement{"TransformBegin", {}}
                                             : SceneStatement{"ObjectBegin", {Quote(Name())}};
    const SceneStatement end{kind == 0 ? "AttributeEnd" : kind == 1 ? "TransformEnd" : "ObjectEnd", {}};
    if (!Chance(0.05))
        all.insert(all.begin() + static_cast<std::ptrdiff_t>(first + count), depth, end);
    all.insert(all.begin() + static_cast<std::ptrdiff_t>(first), depth, begin);
}

void SceneMutator::ChangeNumber(SceneBundle *bundle) {
    const auto [s, i] = AnyToken(bundle, IsNumber);
    if (!s)
        return;
    // What the table says of the parameter gives its edges
    ParamInfo info{};
    for (size_t k = i; k-- > 0;)
        if (IsDeclaration(s->tokens[k])) {
            const std::string declaration = s->tokens[k].substr(1, s->tokens[k].size() - 2);
            const std::string name = declaration.substr(declaration.rfind(' ') + 1);
            for (size_t kind = 0; kind < kPluginKinds; ++kind)
                if (const PluginTable *t = plugins_.Find(static_cast<PluginKind>(kind)))
                    for (const PluginInfo &row : t->rows)
                        if (const ParamInfo *found = row.FindParam(name); found && Chance(0.5))
                            info = *found;
            break;
        }
    s->tokens[i] = Chance(0.5) ? EdgeNumber(info) : Number(info, Chance(0.3));
}

void SceneMutator::ChangeCount(SceneBundle *bundle) {
    const auto [s, i] = AnyToken(bundle, IsNumber);
    if (!s)
        return;
    const auto at = s->tokens.begin() + static_cast<std::ptrdiff_t>(i);
    if (Chance(0.4))
        s->tokens.erase(at);
    else
        s->tokens.insert(at, Chance(0.7) ? 1 : 3 * (1 + Below(40)), std::string(*at));
}

void SceneMutator::ChangeString(SceneBundle *bundle) {
    const auto [s, i] = AnyToken(bundle, IsPlainString);
    if (!s)
        return;
    switch (Below(5)) {
    case 0:
        s->tokens[i] = Quote(FileName());
        break;
    case 1: { // the name of any plug-in
        const PluginTable *table = plugins_.Find(static_cast<PluginKind>(Below(kPluginKinds)));
        if (table && !table->rows.empty())
            s->tokens[i] = Quote(Pick(table->rows).name);
        break;
    }
    case 2: { // a choice of some parameter of some plug-in
        const PluginTable *table = plugins_.Find(static_cast<PluginKind>(Below(kPluginKinds)));
        if (!table || table->rows.empty())
            break;
        const PluginInfo &plugin = Pick(table->rows);
        if (plugin.params.empty())
            break;
        const ParamInfo &info = plugin.params[Below(plugin.params.size())];
        if (!info.choices.empty())
            s->tokens[i] = Quote(info.choices[Below(info.choices.size())]);
        break;
    }
    case 3: {
        constexpr std::array<const char *, 6> odd{"",
                                                  " ",
                                                  "\\n\\t",
                                                  "\\\"",
                                                  "\xff\xfe",
                                                  "\xe2\x80\xae"
                                                  "abc"};
        s->tokens[i] = Quote(Chance(0.9) ? odd[Below(odd.size())] : std::string(1 + Below(600), 'x').c_str());
        break;
    }
    default:
        s->tokens[i] = Quote(Name());
    }
}

void SceneMutator::ChangeDeclaration(SceneBundle *bundle) {
    constexpr std::array<const char *, 16> types{
        "float", "integer",  "bool", "string",    "point", "point2",  "vector", "normal",
        "rgb",   "spectrum", "xyz",  "blackbody", "color", "texture", "point3", "flaot"};
    const auto [s, i] = AnyToken(bundle, IsDeclaration);
    if (!s)
        return;
    const std::string old = s->tokens[i].substr(1, s->tokens[i].size() - 2);
    s->tokens[i] = Quote(fmt::format("{} {}", types[Below(types.size())], old.substr(old.rfind(' ') + 1)));
}

void SceneMutator::AddParam(SceneBundle *bundle) {
    SceneStatement *const s = AnyStatement(bundle);
    if (!s || s->tokens.empty())
        return;
    for (size_t kind = 0; kind < kPluginKinds; ++kind)
        if (const PluginTable *table = plugins_.Find(static_cast<PluginKind>(kind)))
            for (const PluginInfo &row : table->rows)
                if (!row.params.empty() &&
                    std::find(s->tokens.begin(), s->tokens.end(), Quote(row.name)) != s->tokens.end()) {
                    vertices_ = Chance(0.7) ? 4 : 7;
                    return Param(row.params[Below(row.params.size())], row.name, &s->tokens);
                }
}

void SceneMutator::RemoveToken(SceneBundle *bundle) {
    const auto [s, i] = AnyToken(bundle, IsAny);
    if (s)
        s->tokens.erase(s->tokens.begin() + static_cast<std::ptrdiff_t>(i));
}

// Statements, or the end of one of them, become a file of their own, packed now and then.
void SceneMutator::MoveToInclude(SceneBundle *bundle) {
    if (bundle->files.size() >= 6)
        return;
    SceneFile added;
    added.name = fmt::format("{}.pbrt", Name());
    added.packed = Chance(0.3);
    SceneFile &from = Pick(bundle->files);
    if (from.statements.empty() || !from.seed.empty() || added.name == ".pbrt")
        return;
    if (std::any_of(bundle->files.begin(), bundle->files.end(),
                    [&](const SceneFile &f) { return f.name == added.name; }))
        return;
    const size_t first = Below(from.statements.size()), count = Below(from.statements.size() - first + 1);
    const auto begin = from.statements.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(count);
    added.statements.assign(begin, end);
    from.statements.erase(begin, end);
    from.statements.insert(from.statements.begin() + static_cast<std::ptrdiff_t>(first),
                           SceneStatement{"Include", {Quote(added.name)}});
    bundle->files.push_back(std::move(added));
}

// A copy of a seed file with a wrong byte, number or end, and a parameter that names it; or damage to a
// packed include.
void SceneMutator::DamageFile(SceneBundle *bundle) {
    FileDamage damage;
    damage.offset = static_cast<uint32_t>(Chance(0.6) ? Below(128) : Below(4000));
    damage.size = static_cast<uint32_t>(std::array<size_t, 5>{0, 1, 2, 4, 8}[Below(5)]);
    damage.value = std::array<int64_t, 10>{0,          1,
                                           2,          0x7f,
                                           0xff,       0x7fffffff,
                                           -1,         0x80000000,
                                           0x7f800000, static_cast<int64_t>(random_())}[Below(10)];
    SceneFile *file = bundle->files.size() > 1 && Chance(0.6)
                          ? &bundle->files[1 + Below(bundle->files.size() - 1)]
                          : nullptr;
    if (!file && !seedFiles_.empty() && bundle->files.size() < 6) {
        SceneFile copy;
        copy.seed = Pick(seedFiles_);
        copy.name = fmt::format("d{}{}", Below(4), copy.seed.substr(copy.seed.rfind('.')));
        copy.packed = Chance(0.3);
        for (SceneFile &f : bundle->files)
            for (SceneStatement &s : f.statements)
                for (std::string &t : s.tokens)
                    if (t == Quote(copy.seed) && Chance(0.7))
                        t = Quote(copy.name);
        bundle->files.push_back(std::move(copy));
        file = &bundle->files.back();
    }
    if (file && file->damage.size() < 6)
        file->damage.push_back(damage);
}

struct SceneMutator::ChangeRow {
    size_t weight;
    Change change;
};

// To add one: its function, and here how often it is chosen.
void SceneMutator::Mutate(SceneBundle *bundle) {
    static constexpr ChangeRow rows[] = {
        {14, &SceneMutator::Insert},
        {8, &SceneMutator::Remove},
        {4, &SceneMutator::Repeat},
        {4, &SceneMutator::Swap},
        {5, &SceneMutator::Nest},
        {26, &SceneMutator::ChangeNumber},
        {8, &SceneMutator::ChangeCount},
        {8, &SceneMutator::ChangeString},
        {5, &SceneMutator::ChangeDeclaration},
        {12, &SceneMutator::AddParam},
        {3, &SceneMutator::RemoveToken},
        {3, &SceneMutator::MoveToInclude},
        {4, &SceneMutator::DamageFile},
    };
    size_t total = 0;
    for (const ChangeRow &row : rows)
        total += row.weight;
    for (size_t n = 1 + Below(5); n-- > 0;) {
        size_t at = Below(total);
        const ChangeRow *row = rows;
        while (at >= row->weight)
            at -= row++->weight;
        (this->*row->change)(bundle);
    }
}

void SceneMutator::Splice(SceneBundle *bundle, const SceneBundle &other) {
    const std::vector<SceneStatement> &from = other.files[0].statements;
    std::vector<SceneStatement> &to = bundle->files[0].statements;
    if (from.empty() || to.size() > 400)
        return;
    const size_t first = Below(from.size()), count = 1 + Below(std::min<size_t>(10, from.size() - first));
    const auto begin = from.begin() + static_cast<std::ptrdiff_t>(first);
    to.insert(to.begin() + static_cast<std::ptrdiff_t>(Below(to.size() + 1)), begin,
              begin + static_cast<std::ptrdiff_t>(count));
}

} // namespace cuticle
