#include "parser/parser.h"

#include "core/metal_spectra.h"
#include "parser/lexer.h"
#include "parser/plugins.h"
#include "parser/scene_description.h"
#include "parser/spd_file.h"
#include "shapes/curve.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <utility>

namespace cuticle {

namespace {

using std::string_view;

// --- the names -------------------------------------------------------------------------------------------------

bool Contains(std::span<const string_view> names, string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

enum class Directive {
    Accelerator,
    ActiveTransform,
    AreaLightSource,
    AttributeBegin,
    AttributeEnd,
    Camera,
    ConcatTransform,
    CoordinateSystem,
    CoordSysTransform,
    Film,
    Identity,
    Include,
    Integrator,
    LightSource,
    LookAt,
    MakeNamedMaterial,
    MakeNamedMedium,
    Material,
    MediumInterface,
    NamedMaterial,
    ObjectBegin,
    ObjectEnd,
    ObjectInstance,
    PixelFilter,
    ReverseOrientation,
    Rotate,
    Sampler,
    Scale,
    Shape,
    Texture,
    Transform,
    TransformBegin,
    TransformEnd,
    TransformTimes,
    Translate,
    WorldBegin,
    WorldEnd,
};

// In the order of the enumeration.
constexpr std::array<string_view, 37> kDirectives{"Accelerator",
                                                  "ActiveTransform",
                                                  "AreaLightSource",
                                                  "AttributeBegin",
                                                  "AttributeEnd",
                                                  "Camera",
                                                  "ConcatTransform",
                                                  "CoordinateSystem",
                                                  "CoordSysTransform",
                                                  "Film",
                                                  "Identity",
                                                  "Include",
                                                  "Integrator",
                                                  "LightSource",
                                                  "LookAt",
                                                  "MakeNamedMaterial",
                                                  "MakeNamedMedium",
                                                  "Material",
                                                  "MediumInterface",
                                                  "NamedMaterial",
                                                  "ObjectBegin",
                                                  "ObjectEnd",
                                                  "ObjectInstance",
                                                  "PixelFilter",
                                                  "ReverseOrientation",
                                                  "Rotate",
                                                  "Sampler",
                                                  "Scale",
                                                  "Shape",
                                                  "Texture",
                                                  "Transform",
                                                  "TransformBegin",
                                                  "TransformEnd",
                                                  "TransformTimes",
                                                  "Translate",
                                                  "WorldBegin",
                                                  "WorldEnd"};
static_assert(kDirectives[static_cast<size_t>(Directive::WorldEnd)] == "WorldEnd");
static_assert(kDirectives[static_cast<size_t>(Directive::Shape)] == "Shape");

constexpr std::array<string_view, 4> kV4Directives{"Option", "Attribute", "ColorSpace", "Import"};
constexpr std::array<string_view, 5> kV2Directives{"SurfaceIntegrator", "VolumeIntegrator", "Renderer",
                                                   "Volume", "SearchPath"};

bool FindDirective(string_view word, Directive *directive) {
    static const std::unordered_map<string_view, Directive> map = [] {
        std::unordered_map<string_view, Directive> m;
        for (size_t i = 0; i < kDirectives.size(); ++i)
            m[kDirectives[i]] = static_cast<Directive>(i);
        return m;
    }();
    const auto it = map.find(word);
    if (it == map.end())
        return false;
    *directive = it->second;
    return true;
}

// How a parameter's values are spelled; those of one ParamType differ for spectra only.
enum class Spelling { Plain, RGB, XYZ, Blackbody, Samples };
struct ParamTypeName {
    string_view name;
    ParamType type;
    Spelling spelling = Spelling::Plain;
};
constexpr std::array<ParamTypeName, 18> kParamTypes{{
    {"integer", ParamType::Integer},
    {"float", ParamType::Float},
    {"bool", ParamType::Bool},
    {"point", ParamType::Point3},
    {"point2", ParamType::Point2},
    {"point3", ParamType::Point3},
    {"vector", ParamType::Vector3},
    {"vector2", ParamType::Vector2},
    {"vector3", ParamType::Vector3},
    {"normal", ParamType::Normal},
    {"normal3", ParamType::Normal},
    {"string", ParamType::String},
    {"texture", ParamType::Texture},
    {"rgb", ParamType::Spectrum, Spelling::RGB},
    {"color", ParamType::Spectrum, Spelling::RGB},
    {"xyz", ParamType::Spectrum, Spelling::XYZ},
    {"blackbody", ParamType::Spectrum, Spelling::Blackbody},
    {"spectrum", ParamType::Spectrum, Spelling::Samples},
}};

constexpr auto kParamTypeNames = [] {
    std::array<string_view, kParamTypes.size()> names{};
    for (size_t i = 0; i < names.size(); ++i)
        names[i] = kParamTypes[i].name;
    return names;
}();

// --- the state ---------------------------------------------------------------------------------------------------

using NameMap = std::unordered_map<std::string, int>;

// The part that AttributeBegin saves, but for the names (ScopedNames).
struct GraphicsState {
    int material = 0;
    int areaLight = -1;
    bool reverseOrientation = false;
};

// The names that materials and textures have at a place of the file. A block hides names of the blocks around it; at its
// end they come back: only what it changed is kept, so that a block costs nothing, however many names there are.
class ScopedNames {
  public:
    NameMap materials, floatTextures, spectrumTextures;

    void Set(NameMap *map, const std::string &name, int index) {
        const auto [at, isNew] = map->try_emplace(name, index);
        hidden_.push_back({map, name, isNew ? kNone : at->second});
        at->second = index;
    }
    size_t Mark() const { return hidden_.size(); }
    void Restore(size_t mark) {
        for (; hidden_.size() > mark; hidden_.pop_back()) {
            const Hidden &h = hidden_.back();
            if (h.index == kNone)
                h.map->erase(h.name);
            else
                (*h.map)[h.name] = h.index;
        }
    }

  private:
    static constexpr int kNone = -1;
    struct Hidden {
        NameMap *map;
        std::string name;
        int index;
    };
    std::vector<Hidden> hidden_;
};

// The current transformation at the start and the end of the shutter's time.
using TransformPair = std::array<Transform, 2>;
constexpr unsigned kStart = 1, kEnd = 2, kBoth = 3;

struct Block {
    enum class Kind { Attribute, Transform, Object } kind;
    FileLoc loc;
    GraphicsState state; // not of a Transform block
    size_t names;        // ScopedNames::Mark(), likewise
    TransformPair ctm;
    unsigned active;
};

// One Shape "curve" as written. The vectors are used again for the next one.
struct CurveStatement {
    std::vector<double> P, N;
    bool hasN = false, hasWidth = false, hasWidth0 = false, hasWidth1 = false;
    double width = 1, width0 = 1, width1 = 1;
    CurveType type = CurveType::Flat;
    CurveBasis basis = CurveBasis::Bezier;
    int degree = 3;
    int material = 0;
    const char *begin = nullptr; // of the word Shape

    void Clear() {
        P.clear(), N.clear();
        hasN = hasWidth = hasWidth0 = hasWidth1 = false;
        width = width0 = width1 = 1;
        type = CurveType::Flat;
        basis = CurveBasis::Bezier;
        degree = 3;
    }
};

constexpr size_t kMaxIncludeDepth = 64;
constexpr size_t kMaxIncludes = 100000;
constexpr size_t kMaxBlockDepth = 10000;
constexpr size_t kMaxErrors = 1000;
constexpr size_t kMaxParameters = 1000; // of one directive

class Parser {
  public:
    Parser(const PluginTables &plugins, const ParseOptions &options, const std::string &folder);
    SceneDescription Run(std::unique_ptr<TextSource> top);

  private:
    Lexer &lexer() { return *files_.back().lexer; }
    [[noreturn]] void Fail(const char *at, const std::string &message) { lexer().Fail(at, message); }
    [[noreturn]] void Fail(const Token &at, const std::string &message) { lexer().Fail(at.begin, message); }
    FileLoc Loc(const Token &t) { return lexer().Loc(t.begin); }
    const char *Place(const Token &directive, const Param &p);

    void Push(std::unique_ptr<TextSource> source, const std::string &canonical);
    void ParseAll();
    void Resync();
    void Finish(const Token *worldEnd);
    void ParseDirective(const Token &word);

    // Arguments of directives.
    std::string ReadString(const Token &word, const char *what);
    template <size_t N>
    std::array<double, N> ReadNumbers(const Token &word, const char *what, bool brackets = false);
    ParamSet ReadParams(const Token &word);
    void ReadParam(ParamSet *set);
    void ReadNumberArray(std::vector<double> *numbers);
    void ToSpectrum(Param *p, Spelling spelling, const Token &declaration,
                    const std::vector<const char *> &at);
    std::string ReadPluginName(const Token &word, PluginKind kind);
    void CheckPluginName(PluginKind kind, const std::string &name, const char *at);

    // Directives.
    void Include(const Token &word);
    void OptionEntity(const Token &word, PluginKind kind, Entity *entity);
    void RequireWorld(const Token &word);
    void MakeNamedMaterial(const Token &word);
    void NamedMaterial(const Token &word);
    void Texture(const Token &word);
    void Shape(const Token &word);
    void Medium(const Token &word);
    void BeginBlock(const Token &word, Block::Kind kind);
    void EndBlock(const Token &word, Block::Kind kind);
    void ObjectBegin(const Token &word);
    void ObjectInstance(const Token &word);

    // Transformations.
    void Apply(const Token &word, const Transform &t, bool concat);
    const Transform &Current(const FileLoc &loc);

    // Materials.
    int AddMaterial(MaterialEntity material);
    int ShapeMaterial(const std::string &shapeType, const ParamSet &params);
    void ResolveMix(const Token &word, MaterialEntity *material);
    ShapeState CurrentState(int material);

    // Curves.
    bool FastCurve(const char *word);
    void SlowCurve(const ParamSet &params, const Token &word, int material);
    bool EmitCurve(const CurveStatement &c, std::string *error);
    void UpdateCurveTransform();
    uint32_t GroupIndex(const CurveGroup &group, const char *at);
    void MakeRoom(CurvePool *pool);

    struct File {
        std::unique_ptr<Lexer> lexer;
        std::string canonical; // "" for text in memory
        size_t curves = 0;     // Shape "curve" statements met, for the forecast of how many will come
    };

    const PluginTables &plugins_;
    ParseOptions options_;
    std::shared_ptr<const std::string> folder_;
    SceneDescription scene_;
    std::vector<File> files_;
    size_t includes_ = 0;
    // An Include or a .spd file was not there: names may be unknown because of it, which is not said again.
    bool missingFile_ = false;
    bool metMedium_ = false;       // participating media have been warned of
    bool unknownMaterial_ = false; // a NamedMaterial that is not has been warned of
    bool inWorld_ = false, done_ = false;

    GraphicsState state_;
    ScopedNames names_;
    TransformPair ctm_;
    unsigned active_ = kBoth;
    std::unordered_map<std::string, TransformPair> coordinateSystems_;
    std::vector<Block> blocks_;
    NameMap objects_;
    int object_ = -1; // the one being defined
    std::unordered_map<std::string, int> materialByContent_;
    std::unordered_map<std::string, std::array<double, 3>> spectrumFiles_;

    // What curves need of the current transformation, computed when the first one meets it.
    bool curveTransformKnown_ = false, curveIdentity_ = true;
    double curveScale_ = 1;
    std::vector<Point3f> points_;
    std::vector<Normal3f> normals_;
    CurveStatement statement_;
    std::unordered_map<uint64_t, std::vector<uint32_t>> groupsByState_;
    CurveGroup lastGroup_;
    uint32_t lastGroupIndex_ = UINT32_MAX;
};

std::string Quoted(string_view s) {
    std::string quoted(1, '"');
    quoted += s.substr(0, 60);
    return quoted += '"';
}

std::string Describe(const Token &t) {
    switch (t.kind) {
    case Token::Kind::End:
        return "the end of the file";
    case Token::Kind::String:
        return "the string " + Quoted(t.text);
    case Token::Kind::Number:
        return "the number " + std::string(t.text.substr(0, 60));
    default:
        return "\"" + std::string(t.text.substr(0, 60)) + "\"";
    }
}

// ". Did you mean ...?" from the names that a scene has defined, "" where there are none.
template <typename Map>
std::string Suggest(string_view name, std::initializer_list<Map *> maps) {
    std::vector<string_view> known;
    for (Map *map : maps)
        for (const auto &entry : *map)
            known.push_back(entry.first);
    if (known.empty())
        return "";
    std::sort(known.begin(), known.end());
    // A name far from all others is answered with a list, which should stay readable.
    std::string s = Suggestion(name, known.data(), known.size());
    if (s.starts_with("Known") && known.size() > 20)
        s = Suggestion(name, known.data(), 20);
    return ". " + s;
}

std::string NotANumberHint(string_view word) {
    std::string lower(word.substr(0, 16));
    for (char &c : lower)
        c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    return lower == "nan" || lower == "inf" || lower == "infinity"
               ? " (not-a-number and infinity have no place in a scene)"
               : "";
}

Parser::Parser(const PluginTables &plugins, const ParseOptions &options, const std::string &folder)
    : plugins_(plugins), options_(options), folder_(std::make_shared<const std::string>(folder)) {
    const auto standard = [&](Entity *e, const char *type) {
        e->type = type;
        e->params.folder = folder_;
    };
    standard(&scene_.camera, "perspective");
    standard(&scene_.sampler, "halton");
    standard(&scene_.film, "image");
    standard(&scene_.filter, "box");
    standard(&scene_.integrator, "path");
    standard(&scene_.accelerator, "bvh");
    MaterialEntity matte;
    matte.type = "matte";
    matte.params.folder = folder_;
    AddMaterial(std::move(matte));
}

void Parser::Push(std::unique_ptr<TextSource> source, const std::string &canonical) {
    scene_.bytesRead += static_cast<size_t>(source->End() - source->Begin());
    File file;
    file.lexer = std::make_unique<Lexer>(std::move(source)); // may throw, and then nothing is pushed
    file.canonical = canonical;
    files_.push_back(std::move(file));
}

SceneDescription Parser::Run(std::unique_ptr<TextSource> top) {
    scene_.filename = *top->Name();
    std::error_code ec;
    const auto canonical = std::filesystem::weakly_canonical(*top->Name(), ec);
    try {
        Push(std::move(top), ec ? "" : canonical.string());
        ParseAll();
    } catch (const Error &e) {
        if (!options_.collectErrors)
            throw;
        options_.collectErrors->push_back(e.what());
    }
    // Give back what the forecast reserved in excess.
    const auto trim = [](CurvePool *pool) {
        if (pool->segments.capacity() > pool->segments.size() + pool->segments.size() / 16)
            pool->segments.shrink_to_fit();
    };
    trim(&scene_.curves);
    for (ObjectDefinition &o : scene_.objects)
        trim(&o.curves);
    return std::move(scene_);
}

void Parser::ParseAll() {
    while (!done_) {
        try {
            lexer().ReleaseBehind();
            const Token t = lexer().Next();
            if (t.kind == Token::Kind::Word) {
                ParseDirective(t);
            } else if (t.kind == Token::Kind::End) {
                if (files_.size() > 1) {
                    files_.pop_back();
                } else {
                    done_ = true;
                    Finish(nullptr);
                }
            } else if (t.kind == Token::Kind::Number) {
                Fail(t, "expected a directive or a parameter, found " + Describe(t) +
                            ": several values of one parameter need brackets, [ ... ]");
            } else if (t.kind == Token::Kind::String) {
                Fail(t, "expected a directive, found " + Describe(t));
            } else {
                Fail(t, "\"" + std::string(t.text) + "\" stands outside of a parameter");
            }
        } catch (const Error &e) {
            if (!options_.collectErrors)
                throw;
            options_.collectErrors->push_back(e.what());
            if (options_.collectErrors->size() >= kMaxErrors)
                return;
            if (!done_)
                Resync();
        }
    }
}

// After an error: on to the next word that is a directive.
void Parser::Resync() {
    while (true) {
        try {
            const Token &t = lexer().Peek();
            Directive d;
            if (t.kind == Token::Kind::End || (t.kind == Token::Kind::Word && FindDirective(t.text, &d)))
                return;
            lexer().Next();
        } catch (const Error &) { // the lexer has gone past the fault
        }
    }
}

void Parser::Finish(const Token *worldEnd) {
    if (!blocks_.empty()) {
        const Block &b = blocks_.back();
        const std::string name = b.kind == Block::Kind::Attribute   ? "Attribute"
                                 : b.kind == Block::Kind::Transform ? "Transform"
                                                                    : "Object";
        const std::string message = name + "Begin at " + b.loc.ToString() + " has no " + name +
                                    "End before " + (worldEnd ? "WorldEnd" : "the end of the file");
        blocks_.clear();
        if (!missingFile_)
            Fail(worldEnd ? worldEnd->begin : lexer().Source().End(), message);
    }
    if (worldEnd)
        return;
    const char *const end = lexer().Source().End();
    if (!inWorld_) {
        if (!missingFile_)
            Fail(end, "the file ends without a WorldBegin: there is no scene in it");
        return;
    }
    Warning(lexer().Loc(end), "no WorldEnd",
            "the file ends without WorldEnd; it is read as if WorldEnd stood here (pbrt-v4 scenes have none: "
            "if this is one, it must be "
            "converted, for Cuticle reads pbrt-v3)");
}

// --- arguments -----------------------------------------------------------------------------------------------------

std::string Parser::ReadString(const Token &word, const char *what) {
    const Token t = lexer().Peek();
    if (t.kind != Token::Kind::String)
        Fail(t, std::string(word.text) + " needs " + what + " in quotes, found " + Describe(t));
    lexer().Next();
    return lexer().Unescape(t);
}

template <size_t N>
std::array<double, N> Parser::ReadNumbers(const Token &word, const char *what, bool brackets) {
    std::array<double, N> v{};
    const bool open = brackets && lexer().Peek().kind == Token::Kind::Open;
    if (open)
        lexer().Next();
    for (size_t i = 0; i < N; ++i) {
        const Token t = lexer().Peek();
        if (t.kind != Token::Kind::Number)
            Fail(t, std::string(word.text) + " needs " + std::to_string(N) + " numbers (" + what +
                        "), found " + Describe(t) + " after " + std::to_string(i) + NotANumberHint(t.text));
        v[i] = lexer().Next().number;
    }
    if (open) {
        const Token t = lexer().Peek();
        if (t.kind != Token::Kind::Close)
            Fail(t, std::string(word.text) + " needs " + std::to_string(N) +
                        " numbers and then \"]\", found " + Describe(t));
        lexer().Next();
    }
    return v;
}

void Parser::CheckPluginName(PluginKind kind, const std::string &name, const char *at) {
    const PluginTable *table = plugins_.Find(kind);
    if (!table || table->Find(name))
        return;
    const std::vector<string_view> names = table->Names();
    const std::string full = std::string(DirectiveOf(kind)) + " " + Quoted(name);
    if (Contains(table->v4, name))
        Fail(at, full + " is pbrt-v4: this looks like a pbrt-v4 scene, and Cuticle reads pbrt-v3");
    if (Contains(table->v2, name))
        Fail(at, full + " is pbrt-v2: this looks like a pbrt-v2 scene, and Cuticle reads pbrt-v3");
    Fail(at, full + " is not known. " + Suggestion(name, names.data(), names.size()));
}

std::string Parser::ReadPluginName(const Token &word, PluginKind kind) {
    const Token t = lexer().Peek();
    std::string name = ReadString(word, "a type");
    CheckPluginName(kind, name, t.begin);
    return name;
}

// Where a parameter of the directive just read stands in the text.
const char *Parser::Place(const Token &directive, const Param &p) {
    const char *at = directive.begin, *const end = lexer().Source().End();
    for (uint32_t line = Loc(directive).line; line < p.loc.line; ++line)
        at = static_cast<const char *>(std::memchr(at, '\n', static_cast<size_t>(end - at))) + 1;
    while (at > lexer().Source().Begin() && at[-1] != '\n')
        --at;
    return at + p.loc.column - 1;
}

ParamSet Parser::ReadParams(const Token &word) {
    ParamSet set;
    set.loc = Loc(word);
    set.folder = folder_;
    while (lexer().Peek().kind == Token::Kind::String)
        ReadParam(&set);
    return set;
}

// Reads on while numbers follow, which in meshes they do by the million.
void Parser::ReadNumberArray(std::vector<double> *numbers) {
    const char *p = lexer().Cursor(), *const end = lexer().Source().End();
    while (true) {
        const char *q = p;
        while (IsBlank(*q))
            ++q;
        double v = 0;
        const char *after = ScanNumber(q, end, &v);
        if (!after || !(IsBlank(*after) || *after == ']') || !(std::abs(v) <= FLT_MAX))
            break; // whatever it is, the lexer says it
        numbers->push_back(v);
        p = after;
    }
    lexer().SetCursor(p);
}

void Parser::ReadParam(ParamSet *set) {
    const Token declaration = lexer().Next();
    const std::string text = lexer().Unescape(declaration);

    // Split "type name" at any white space, of which there may be some around it too.
    const char *blanks = " \t\r";
    const size_t typeBegin = std::min(text.find_first_not_of(blanks), text.size());
    const size_t typeEnd = std::min(text.find_first_of(blanks, typeBegin), text.size());
    const size_t nameBegin = std::min(text.find_first_not_of(blanks, typeEnd), text.size());
    const size_t nameEnd = std::min(text.find_first_of(blanks, nameBegin), text.size());
    const bool rest = text.find_first_not_of(blanks, nameEnd) != std::string::npos;
    const string_view typeName = string_view(text).substr(typeBegin, typeEnd - typeBegin);
    if (nameBegin == nameEnd || rest)
        Fail(declaration,
             "a parameter is written \"type name\" value, as in \"float fov\" 30; found " + Quoted(text));
    const auto type = std::find_if(kParamTypes.begin(), kParamTypes.end(),
                                   [&](const ParamTypeName &t) { return t.name == typeName; });
    if (type == kParamTypes.end()) {
        // The beginning of a type ("int") says more than its edit distance to the others.
        const auto begun =
            std::find_if(kParamTypeNames.begin(), kParamTypeNames.end(),
                         [&](string_view name) { return typeName.size() > 1 && name.starts_with(typeName); });
        Fail(declaration, "parameter type " + Quoted(typeName) + " is not known. " +
                              (begun != kParamTypeNames.end()
                                   ? Suggestion(*begun, &*begun, 1)
                                   : Suggestion(typeName, kParamTypeNames.data(), kParamTypeNames.size())));
    }

    Param p;
    p.type = type->type;
    p.name = text.substr(nameBegin, nameEnd - nameBegin);
    p.loc = Loc(declaration);

    // Read one value, or any number of them in brackets.
    const std::string full = "\"" + std::string(typeName) + " " + p.name + "\"";
    std::vector<const char *> at; // places of strings, for messages
    bool hasWords = false;
    const auto value = [&](const Token &t) {
        if (t.kind == Token::Kind::Number) {
            p.numbers.push_back(t.number);
        } else if (t.kind == Token::Kind::String) {
            at.push_back(t.begin);
            p.strings.push_back(lexer().Unescape(t));
        } else if (t.kind == Token::Kind::Word && (t.text == "true" || t.text == "false")) {
            hasWords = true;
            at.push_back(t.begin);
            p.strings.emplace_back(t.text);
        } else {
            return false;
        }
        return true;
    };
    if (lexer().Peek().kind == Token::Kind::Open) {
        const Token open = lexer().Next();
        while (true) {
            ReadNumberArray(&p.numbers);
            const Token t = lexer().Peek();
            Directive d;
            if (t.kind == Token::Kind::Close) {
                lexer().Next();
                break;
            }
            if (t.kind == Token::Kind::End || t.kind == Token::Kind::Open ||
                (t.kind == Token::Kind::Word && FindDirective(t.text, &d)))
                Fail(open, "the values of " + full + " have no closing \"]\" before " + Describe(t) + " at " +
                               Loc(t).ToString());
            if (!value(t))
                Fail(t, "expected a value of " + full + ", found " + Describe(t) + NotANumberHint(t.text));
            lexer().Next();
        }
    } else {
        const Token t = lexer().Peek();
        if (!value(t))
            Fail(t, "expected the value of " + full + ", found " + Describe(t) + NotANumberHint(t.text));
        lexer().Next();
    }

    // Check the values against the type.
    const bool wantsStrings =
        p.type == ParamType::String || p.type == ParamType::Texture || p.type == ParamType::Bool;
    if (!p.strings.empty() && !p.numbers.empty())
        Fail(declaration, "the values of " + full + " are strings as well as numbers");
    if (wantsStrings && !p.numbers.empty())
        Fail(declaration,
             full +
                 (p.type == ParamType::Bool ? " takes \"true\" or \"false\"" : " takes a string in quotes") +
                 ", not a number");
    if (!wantsStrings && !p.strings.empty() && (hasWords || type->spelling != Spelling::Samples))
        Fail(at.front(), full + " takes numbers, not " + Quoted(p.strings.front()));
    if (hasWords && p.type != ParamType::Bool)
        Fail(at.front(), full + " takes strings in quotes");
    switch (p.type) {
    case ParamType::Bool:
        for (size_t i = 0; i < p.strings.size(); ++i) {
            if (p.strings[i] != "true" && p.strings[i] != "false")
                Fail(at[i], full + " takes \"true\" or \"false\", not " + Quoted(p.strings[i]));
            p.bools.push_back(p.strings[i] == "true");
        }
        p.strings.clear();
        break;
    case ParamType::Texture: {
        if (p.strings.size() != 1)
            Fail(declaration,
                 full + " takes the name of one texture, not " + std::to_string(p.strings.size()));
        const std::string &name = p.strings[0];
        const auto f = names_.floatTextures.find(name), s = names_.spectrumTextures.find(name);
        p.floatTexture = f == names_.floatTextures.end() ? -1 : f->second;
        p.spectrumTexture = s == names_.spectrumTextures.end() ? -1 : s->second;
        if (p.floatTexture < 0 && p.spectrumTexture < 0 && !missingFile_) {
            Fail(at[0], "no texture " + Quoted(name) + " has been defined here" +
                            Suggest(name, {&names_.floatTextures, &names_.spectrumTextures}));
        }
        break;
    }
    case ParamType::Spectrum:
        ToSpectrum(&p, type->spelling, declaration, at);
        break;
    default:
        break;
    }

    for (Param &other : set->params)
        if (other.name == p.name) {
            Warning(p.loc, "parameter given twice",
                    "parameter \"" + p.name + "\" is given twice; the last one wins");
            other = std::move(p);
            return;
        }
    if (set->params.size() >= kMaxParameters)
        Fail(declaration, "more than " + std::to_string(kMaxParameters) + " parameters of one directive");
    set->params.push_back(std::move(p));
}

// Replaces whatever spelling by triples of linear RGB.
void Parser::ToSpectrum(Param *p, Spelling spelling, const Token &declaration,
                        const std::vector<const char *> &at) {
    const std::vector<double> in = std::move(p->numbers);
    p->numbers.clear();
    const auto add = [&](const Spectrum &s) { p->numbers.insert(p->numbers.end(), {s[0], s[1], s[2]}); };
    const std::string count = std::to_string(in.size());
    switch (spelling) {
    case Spelling::RGB:
    case Spelling::XYZ:
        if (in.empty() || in.size() % 3 != 0)
            Fail(declaration, "\"" + p->name + "\" is a colour of 3 numbers (or several), not of " + count);
        if (spelling == Spelling::RGB)
            p->numbers = in;
        else
            for (size_t i = 0; i < in.size(); i += 3)
                add(XYZToRGB({in[i], in[i + 1], in[i + 2]}));
        break;
    case Spelling::Blackbody:
        if (in.size() == 1)
            Fail(declaration,
                 "\"blackbody " + p->name +
                     "\" takes a temperature in kelvin and a scale; a temperature alone is pbrt-v4, and "
                     "Cuticle reads pbrt-v3");
        if (in.empty() || in.size() % 2 != 0)
            Fail(declaration, "\"blackbody " + p->name +
                                  "\" takes pairs of temperature in kelvin and scale, not " + count +
                                  " numbers");
        for (size_t i = 0; i < in.size(); i += 2) {
            if (!(in[i] > 0))
                Fail(declaration, "the temperature of \"blackbody " + p->name + "\" must be above 0 kelvin");
            add(BlackbodyToRGB(in[i], in[i + 1]));
        }
        break;
    case Spelling::Samples:
        if (p->strings.empty()) {
            if (in.empty() || in.size() % 2 != 0)
                Fail(declaration, "\"spectrum " + p->name +
                                      "\" takes pairs of wavelength in nm and value, not " + count +
                                      " numbers" + (in.size() == 1 ? " (one number alone is pbrt-v4)" : ""));
            std::vector<double> lambda, values;
            for (size_t i = 0; i < in.size(); i += 2) {
                if (!(in[i] > 0))
                    Fail(declaration, "a wavelength of \"spectrum " + p->name + "\" must be above 0 nm");
                lambda.push_back(in[i]);
                values.push_back(in[i + 1]);
            }
            add(SpectrumFromSamples(std::move(lambda), std::move(values)));
        }
        for (size_t i = 0; i < p->strings.size(); ++i) {
            const std::string &name = p->strings[i];
            for (const string_view prefix : {"metal-", "glass-", "stdillum-", "illum-"})
                if (name.starts_with(prefix) && name.find('.') == std::string::npos)
                    Fail(at[i],
                         "the named spectrum " + Quoted(name) +
                             " is pbrt-v4: this looks like a pbrt-v4 scene, and Cuticle reads pbrt-v3");
            const std::string path = ResolveFilename(*folder_, name);
            auto it = spectrumFiles_.find(path);
            if (it == spectrumFiles_.end()) {
                std::error_code ec;
                Spectrum s;
                if (std::filesystem::exists(path, ec)) {
                    const PlaceScope here(lexer().Loc(at[i]));
                    s = ReadSPD(path);
                } else if (auto metal = FindMetalSpectrumByFilename(name)) {
                    Warning(p->loc, "a metal's spectrum file is missing",
                            "the spectrum file \"" + path + "\" is missing; the built-in table (" +
                                std::string(metal->source) + ") is used instead");
                    s = SpectrumFromSamples(std::move(metal->lambda), std::move(metal->values));
                } else {
                    missingFile_ = true;
                    Fail(at[i], "cannot open the spectrum file \"" + path + "\": No such file or directory");
                }
                it = spectrumFiles_.emplace(path, std::array<double, 3>{s[0], s[1], s[2]}).first;
            }
            p->numbers.insert(p->numbers.end(), it->second.begin(), it->second.end());
        }
        p->strings.clear();
        break;
    case Spelling::Plain:
        break;
    }
    for (const double v : p->numbers)
        if (!(std::abs(v) <= FLT_MAX))
            Fail(declaration, "the colour of \"" + p->name + "\" is out of range (largest 3.4e38)");
}

// --- directives ----------------------------------------------------------------------------------------------------

void Parser::ParseDirective(const Token &word) {
    Directive d;
    if (!FindDirective(word.text, &d)) {
        const std::string name = Quoted(word.text);
        if (Contains(kV4Directives, word.text))
            Fail(
                word,
                name +
                    " is a directive of pbrt-v4: this looks like a pbrt-v4 scene, and Cuticle reads pbrt-v3");
        if (Contains(kV2Directives, word.text))
            Fail(
                word,
                name +
                    " is a directive of pbrt-v2: this looks like a pbrt-v2 scene, and Cuticle reads pbrt-v3" +
                    (word.text == "SurfaceIntegrator" ? " (there it is Integrator)" : ""));
        if (!blocks_.empty() || inWorld_ || word.text.size() < 32)
            Fail(word, "directive " + name + " is not known. " +
                           Suggestion(word.text, kDirectives.data(), kDirectives.size()));
        Fail(word, name + " is no directive: this does not look like a scene file");
    }
    switch (d) {
    case Directive::Camera:
        OptionEntity(word, PluginKind::Camera, &scene_.camera);
        break;
    case Directive::Sampler:
        OptionEntity(word, PluginKind::Sampler, &scene_.sampler);
        break;
    case Directive::Film:
        OptionEntity(word, PluginKind::Film, &scene_.film);
        break;
    case Directive::PixelFilter:
        OptionEntity(word, PluginKind::Filter, &scene_.filter);
        break;
    case Directive::Integrator:
        OptionEntity(word, PluginKind::Integrator, &scene_.integrator);
        break;
    case Directive::Accelerator:
        OptionEntity(word, PluginKind::Accelerator, &scene_.accelerator);
        break;
    case Directive::Include:
        Include(word);
        break;
    case Directive::Identity:
        Apply(word, Transform(), false);
        break;
    case Directive::Translate: {
        const auto v = ReadNumbers<3>(word, "x y z");
        Apply(word, Transform::Translate({v[0], v[1], v[2]}), true);
        break;
    }
    case Directive::Scale: {
        const auto v = ReadNumbers<3>(word, "x y z");
        Apply(word, Transform::Scale(v[0], v[1], v[2]), true);
        break;
    }
    case Directive::Rotate: {
        const auto v = ReadNumbers<4>(word, "degrees, axis x y z");
        if (v[1] == 0 && v[2] == 0 && v[3] == 0)
            Fail(word, "Rotate needs an axis that is not 0 0 0");
        Apply(word, Transform::Rotate(v[0], {v[1], v[2], v[3]}), true);
        break;
    }
    case Directive::LookAt: {
        const auto v = ReadNumbers<9>(word, "eye, point looked at, up");
        Apply(word, Transform::LookAt({v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}), true);
        break;
    }
    case Directive::Transform:
    case Directive::ConcatTransform: {
        const auto v = ReadNumbers<16>(word, "a matrix, column after column", true);
        Transform::Matrix m;
        for (size_t i = 0; i < 4; ++i)
            for (size_t j = 0; j < 4; ++j)
                m[i][j] = v[4 * j + i];
        Apply(word, Transform(m), d == Directive::ConcatTransform);
        break;
    }
    case Directive::CoordinateSystem:
        coordinateSystems_[ReadString(word, "a name")] = ctm_;
        break;
    case Directive::CoordSysTransform: {
        const Token t = lexer().Peek();
        const std::string name = ReadString(word, "the name of a coordinate system");
        const auto it = coordinateSystems_.find(name);
        if (it != coordinateSystems_.end()) {
            ctm_ = it->second;
            curveTransformKnown_ = false;
        } else if (!missingFile_) {
            Fail(t, "no coordinate system " + Quoted(name) + " has been named" +
                        Suggest(name, {&coordinateSystems_}));
        }
        break;
    }
    case Directive::ActiveTransform: {
        const Token t = lexer().Next();
        if (t.text == "StartTime")
            active_ = kStart;
        else if (t.text == "EndTime")
            active_ = kEnd;
        else if (t.text == "All")
            active_ = kBoth;
        else
            Fail(t, "ActiveTransform takes StartTime, EndTime or All, not " + Describe(t));
        break;
    }
    case Directive::TransformTimes:
        ReadNumbers<2>(word, "start, end"); // times matter to motion only, which is not rendered
        break;
    case Directive::TransformBegin:
        BeginBlock(word, Block::Kind::Transform);
        break;
    case Directive::TransformEnd:
        EndBlock(word, Block::Kind::Transform);
        break;
    case Directive::AttributeBegin:
        BeginBlock(word, Block::Kind::Attribute);
        break;
    case Directive::AttributeEnd:
        EndBlock(word, Block::Kind::Attribute);
        break;
    case Directive::ObjectBegin:
        ObjectBegin(word);
        break;
    case Directive::ObjectEnd:
        EndBlock(word, Block::Kind::Object);
        break;
    case Directive::ObjectInstance:
        ObjectInstance(word);
        break;
    case Directive::WorldBegin:
        if (inWorld_)
            Fail(word, "a second WorldBegin");
        if (!blocks_.empty())
            Fail(word, "WorldBegin inside the block opened at " + blocks_.back().loc.ToString());
        inWorld_ = true;
        ctm_ = {};
        active_ = kBoth;
        curveTransformKnown_ = false;
        coordinateSystems_["world"] = ctm_;
        break;
    case Directive::WorldEnd: {
        if (!inWorld_)
            Fail(word, "WorldEnd without WorldBegin");
        done_ = true;
        bool more = false;
        try {
            more = lexer().Peek().kind != Token::Kind::End;
        } catch (const Error &) {
            more = true;
        }
        if (more)
            Warning(
                Loc(lexer().Peek()), "text after WorldEnd",
                "what stands after WorldEnd is not read: Cuticle renders one picture of a file, the first");
        Finish(&word);
        break;
    }
    case Directive::MakeNamedMaterial:
        MakeNamedMaterial(word);
        break;
    case Directive::NamedMaterial:
        NamedMaterial(word);
        break;
    case Directive::Material: {
        RequireWorld(word);
        MaterialEntity m;
        m.type = ReadPluginName(word, PluginKind::Material);
        m.params = ReadParams(word);
        ResolveMix(word, &m);
        state_.material = AddMaterial(std::move(m));
        break;
    }
    case Directive::Texture:
        Texture(word);
        break;
    case Directive::LightSource: {
        RequireWorld(word);
        LightEntity light;
        light.type = ReadPluginName(word, PluginKind::Light);
        light.params = ReadParams(word);
        light.ctm = Current(light.params.loc);
        scene_.lights.push_back(std::move(light));
        break;
    }
    case Directive::AreaLightSource: {
        RequireWorld(word);
        Entity light;
        light.type = ReadPluginName(word, PluginKind::AreaLight);
        light.params = ReadParams(word);
        light.ctm = Current(light.params.loc);
        state_.areaLight = static_cast<int>(scene_.areaLights.size());
        scene_.areaLights.push_back(std::move(light));
        break;
    }
    case Directive::Shape:
        Shape(word);
        break;
    case Directive::ReverseOrientation:
        RequireWorld(word);
        state_.reverseOrientation = !state_.reverseOrientation;
        break;
    case Directive::MediumInterface:
    case Directive::MakeNamedMedium:
        Medium(word);
        break;
    }
}

void Parser::RequireWorld(const Token &word) {
    if (!inWorld_)
        Fail(word, std::string(word.text) +
                       " belongs between WorldBegin and WorldEnd, and WorldBegin has not come yet");
}

void Parser::OptionEntity(const Token &word, PluginKind kind, Entity *entity) {
    Entity e;
    e.type = ReadPluginName(word, kind);
    e.params = ReadParams(word);
    if (inWorld_) {
        Warning(e.params.loc, std::string(word.text) + " after WorldBegin",
                std::string(word.text) +
                    " has no effect after WorldBegin; this one is ignored, as by pbrt-v3");
        return;
    }
    e.ctm = Current(e.params.loc);
    if (kind == PluginKind::Camera)
        coordinateSystems_["camera"] = {ctm_[0].Inverse(), ctm_[1].Inverse()};
    *entity = std::move(e);
}

void Parser::Include(const Token &word) {
    const Token t = lexer().Peek();
    const std::string name = ReadString(word, "a file name");
    const FileLoc loc = Loc(t);
    const std::string path = ResolveFilename(*folder_, name);
    if (files_.size() >= kMaxIncludeDepth)
        Fail(t, "Include goes " + std::to_string(kMaxIncludeDepth) + " files deep here, which is too deep");
    if (++includes_ > kMaxIncludes)
        Fail(t, "more than " + std::to_string(kMaxIncludes) + " files are included, which is too many");
    std::error_code ec;
    const std::filesystem::path canonicalPath = std::filesystem::weakly_canonical(path, ec);
    const std::string canonical = ec ? path : canonicalPath.string();
    for (const File &f : files_)
        if (f.canonical == canonical)
            Fail(t,
                 "\"" + path + "\" includes itself" + (&f == &files_.back() ? "" : " by way of other files"));
    std::unique_ptr<TextSource> source;
    try {
        source = TextSource::FromFile(path, loc, lexer().Line(t.begin));
    } catch (const Error &) {
        missingFile_ = true;
        throw;
    }
    Push(std::move(source), canonical);
}

void Parser::BeginBlock(const Token &word, Block::Kind kind) {
    RequireWorld(word);
    if (blocks_.size() >= kMaxBlockDepth)
        Fail(word, "blocks are nested " + std::to_string(kMaxBlockDepth) +
                       " deep here: " + std::string(word.text) + " without its end?");
    blocks_.push_back({kind, Loc(word), state_, names_.Mark(), ctm_, active_});
}

void Parser::EndBlock(const Token &word, Block::Kind kind) {
    RequireWorld(word);
    const std::string begin = std::string(word.text.substr(0, word.text.size() - 3)) + "Begin";
    if (blocks_.empty()) {
        if (missingFile_)
            return;
        Fail(word, std::string(word.text) + " without " + begin);
    }
    if (blocks_.back().kind != kind) {
        static constexpr const char *kBegin[] = {"AttributeBegin", "TransformBegin", "ObjectBegin"};
        Fail(word, std::string(word.text) + " inside the block of " +
                       kBegin[static_cast<size_t>(blocks_.back().kind)] + " at " +
                       blocks_.back().loc.ToString() + ": that must end first");
    }
    Block &b = blocks_.back();
    ctm_ = b.ctm;
    active_ = b.active;
    curveTransformKnown_ = false;
    if (kind != Block::Kind::Transform) {
        state_ = b.state;
        names_.Restore(b.names);
    }
    if (kind == Block::Kind::Object)
        object_ = -1;
    blocks_.pop_back();
}

void Parser::ObjectBegin(const Token &word) {
    RequireWorld(word);
    ObjectDefinition o;
    o.name = ReadString(word, "a name");
    if (object_ >= 0)
        Fail(word, "ObjectBegin inside the definition of object " +
                       Quoted(scene_.objects[static_cast<size_t>(object_)].name) +
                       ", which has no ObjectEnd yet");
    o.loc = Loc(word);
    BeginBlock(word, Block::Kind::Object);
    object_ = static_cast<int>(scene_.objects.size());
    objects_[o.name] = object_;
    scene_.objects.push_back(std::move(o));
}

void Parser::ObjectInstance(const Token &word) {
    RequireWorld(word);
    const Token t = lexer().Peek();
    const std::string name = ReadString(word, "the name of an object");
    if (object_ >= 0)
        Fail(word, "ObjectInstance inside the definition of an object");
    const auto it = objects_.find(name);
    if (it == objects_.end()) {
        if (missingFile_)
            return;
        Fail(t, "no object " + Quoted(name) + " has been defined" + Suggest(name, {&objects_}));
    }
    const FileLoc loc = Loc(word);
    scene_.instances.push_back({it->second, Current(loc), loc});
}

void Parser::MakeNamedMaterial(const Token &word) {
    RequireWorld(word);
    MaterialEntity m;
    m.name = ReadString(word, "a name");
    m.params = ReadParams(word);
    const Param *type = m.params.Find("type");
    if (!type || type->type != ParamType::String || type->strings.size() != 1)
        Fail(word, "MakeNamedMaterial needs a parameter \"string type\" with the type of the material");
    type->used = true;
    m.type = type->strings[0];
    CheckPluginName(PluginKind::Material, m.type, Place(word, *type));
    ResolveMix(word, &m);
    if (names_.materials.count(m.name))
        Warning(m.params.loc, "named material redefined",
                "named material " + Quoted(m.name) + " is defined again");
    const std::string name = m.name;
    const int index = static_cast<int>(scene_.materials.size());
    scene_.materials.push_back(std::move(m));
    names_.Set(&names_.materials, name, index);
}

void Parser::NamedMaterial(const Token &word) {
    RequireWorld(word);
    const Token t = lexer().Peek();
    const std::string name = ReadString(word, "the name of a material");
    const auto it = names_.materials.find(name);
    if (it != names_.materials.end()) {
        state_.material = it->second;
    } else if (!missingFile_) {
        // Scenes that people share do this, and pbrt-v3 renders them; so it is no Error. Only the first is told with
        // the names that it may have meant, which takes time as there are names.
        const bool isFirst = !std::exchange(unknownMaterial_, true);
        Warning(Loc(t), "unknown named material",
                "no material " + Quoted(name) +
                    " has been defined here; the current one stays, as in pbrt-v3" +
                    (isFirst ? Suggest(name, {&names_.materials}) : ""));
    }
}

void Parser::Texture(const Token &word) {
    RequireWorld(word);
    TextureEntity texture;
    texture.name = ReadString(word, "a name");
    const Token t = lexer().Peek();
    const std::string kind = ReadString(word, "\"float\", \"color\" or \"spectrum\"");
    const bool isFloat = kind == "float";
    if (!isFloat && kind != "color" && kind != "spectrum") {
        static constexpr std::array<string_view, 3> kKinds{"float", "color", "spectrum"};
        Fail(t, "texture " + Quoted(texture.name) +
                    ": its class must be \"float\", \"color\" or \"spectrum\", not " + Quoted(kind) + ". " +
                    Suggestion(kind, kKinds.data(), kKinds.size()));
    }
    texture.type = ReadPluginName(word, PluginKind::Texture);
    texture.params = ReadParams(word);
    texture.ctm = Current(texture.params.loc);
    NameMap &map = isFloat ? names_.floatTextures : names_.spectrumTextures;
    auto &list = isFloat ? scene_.floatTextures : scene_.spectrumTextures;
    if (map.count(texture.name))
        Warning(texture.params.loc, "texture redefined",
                "texture " + Quoted(texture.name) + " is defined again");
    names_.Set(&map, texture.name, static_cast<int>(list.size()));
    list.push_back(std::move(texture));
}

void Parser::Medium(const Token &word) {
    if (word.text == "MediumInterface") {
        ReadString(word, "the name of a medium");
        if (lexer().Peek().kind == Token::Kind::String)
            lexer().Next();
    } else {
        ReadString(word, "a name");
        const ParamSet params = ReadParams(word);
        const Param *type = params.Find("type");
        if (type && type->type == ParamType::String && type->strings.size() == 1)
            CheckPluginName(PluginKind::Medium, type->strings[0], Place(word, *type));
    }
    // A medium is made once and named often: one line says it for all.
    if (!metMedium_)
        Warning(Loc(word), "participating media",
                "participating media are not rendered; all space is taken as empty");
    metMedium_ = true;
}

// --- transformations -------------------------------------------------------------------------------------------------

void Parser::Apply(const Token &word, const Transform &t, bool concat) {
    for (unsigned i = 0; i < 2; ++i) {
        if (!(active_ & (1u << i)))
            continue;
        const Transform next = concat ? ctm_[i] * t : t;
        if (t.IsSingular() || next.IsSingular())
            Fail(word, std::string(word.text) + " makes a transformation that cannot be inverted" +
                           (word.text == "Scale" ? " (a factor is 0?)"
                            : word.text == "LookAt"
                                ? " (the eye is the point looked at, or up points along the view?)"
                                : ""));
        ctm_[i] = next;
    }
    curveTransformKnown_ = false;
}

const Transform &Parser::Current(const FileLoc &loc) {
    if (!(ctm_[0] == ctm_[1]))
        Warning(loc, "motion",
                "motion is not rendered; the transformation at the start time is used throughout");
    return ctm_[0];
}

// --- materials -------------------------------------------------------------------------------------------------------

// The content of a material as bytes, equal for equal content.
std::string ContentKey(const MaterialEntity &m) {
    std::string key = m.type;
    const auto raw = [&](const void *data, size_t size) {
        key.append(static_cast<const char *>(data), size);
    };
    for (const Param &p : m.params.params) {
        key += '\0';
        key += p.name;
        key += '\0';
        key += static_cast<char>(p.type);
        const std::array<size_t, 3> counts{p.numbers.size(), p.strings.size(), p.bools.size()};
        raw(counts.data(), sizeof(counts));
        raw(p.numbers.data(), p.numbers.size() * sizeof(double));
        for (const std::string &s : p.strings) {
            key += s;
            key += '\0';
        }
        for (const bool b : p.bools)
            key += b ? '1' : '0';
        raw(&p.floatTexture, sizeof(int));
        raw(&p.spectrumTexture, sizeof(int));
    }
    raw(m.mixed, sizeof(m.mixed));
    return key;
}

int Parser::AddMaterial(MaterialEntity material) {
    const auto [it, isNew] =
        materialByContent_.emplace(ContentKey(material), static_cast<int>(scene_.materials.size()));
    if (isNew)
        scene_.materials.push_back(std::move(material));
    return it->second;
}

void Parser::ResolveMix(const Token &word, MaterialEntity *material) {
    if (material->type != "mix")
        return;
    static constexpr const char *kNames[] = {"namedmaterial1", "namedmaterial2"};
    for (size_t i = 0; i < 2; ++i) {
        const Param *p = material->params.Find(kNames[i], ParamType::String);
        if (!p || p->strings.size() != 1)
            Fail(word, std::string("a material \"mix\" needs \"string ") + kNames[i] + "\"");
        const auto it = names_.materials.find(p->strings[0]);
        if (it != names_.materials.end())
            material->mixed[i] = it->second;
        else if (!missingFile_)
            Fail(Place(word, *p), "no material " + Quoted(p->strings[0]) + " has been defined here" +
                                      Suggest(p->strings[0], {&names_.materials}));
    }
}

// pbrt-v3 looks for a material's parameters among the shape's first. Gives the index of the current material, or of a
// copy that has the shape's values.
int Parser::ShapeMaterial(const std::string &shapeType, const ParamSet &params) {
    const MaterialEntity &current = scene_.materials[static_cast<size_t>(state_.material)];
    const std::span<const string_view> names = MaterialParameters(current.type);
    MaterialEntity copy;
    bool changed = false;
    for (const Param &p : params.params) {
        // The alpha of a mesh is its cut-out mask, whatever the material calls alpha.
        if (!Contains(names, p.name) ||
            (p.name == "alpha" && (shapeType == "trianglemesh" || shapeType == "plymesh")))
            continue;
        if (!changed) {
            copy = current;
            changed = true;
        }
        p.used = true;
        Param mine = p;
        mine.used = false;
        const auto same = std::find_if(copy.params.params.begin(), copy.params.params.end(),
                                       [&](const Param &q) { return q.name == p.name; });
        if (same != copy.params.params.end())
            *same = std::move(mine);
        else
            copy.params.params.push_back(std::move(mine));
    }
    return changed ? AddMaterial(std::move(copy)) : state_.material;
}

ShapeState Parser::CurrentState(int material) {
    return {material, object_ >= 0 ? -1 : state_.areaLight, state_.reverseOrientation};
}

// --- shapes ----------------------------------------------------------------------------------------------------------

void Parser::Shape(const Token &word) {
    RequireWorld(word);
    if (options_.fastCurves && FastCurve(word.begin))
        return;
    const std::string type = ReadPluginName(word, PluginKind::Shape);
    ParamSet params = ReadParams(word);
    const int material = ShapeMaterial(type, params);
    if (object_ >= 0 && state_.areaLight >= 0)
        Warning(params.loc, "area light in an object",
                "an area light on a shape of an object definition is not rendered (nor by pbrt-v3)");
    if (type == "curve") {
        SlowCurve(params, word, material);
        return;
    }
    ShapeEntity shape;
    shape.objectToWorld = Current(params.loc);
    shape.state = CurrentState(material);
    shape.type = type;
    shape.params = std::move(params);
    auto &list = object_ >= 0 ? scene_.objects[static_cast<size_t>(object_)].shapes : scene_.shapes;
    list.push_back(std::move(shape));
}

// Reads a Shape "curve" from behind the word Shape without any allocation, if all of it is written in the ordinary way.
// Otherwise leaves everything as it was and returns false: the general reader takes over, or says what is wrong.
bool Parser::FastCurve(const char *word) {
    const char *p = lexer().Cursor();
    const char *const end = lexer().Source().End();
    const auto skip = [&] {
        while (IsBlank(*p))
            ++p;
    };
    // Takes `literal` if it stands at p. The text ends with a NUL byte, where any comparison stops.
    const auto take = [&](string_view literal) {
        for (size_t i = 0; i < literal.size(); ++i)
            if (p[i] != literal[i])
                return false;
        p += literal.size();
        return true;
    };
    const auto numbers = [&](std::vector<double> *v) {
        const bool bracket = *p == '[';
        p += bracket;
        do {
            skip();
            if (bracket && *p == ']') {
                ++p;
                return true;
            }
            double x;
            const char *after = ScanNumber(p, end, &x);
            if (!after || !(IsBlank(*after) || *after == ']' || *after == '"' || after == end) ||
                !(std::abs(x) <= FLT_MAX))
                return false;
            v->push_back(x);
            p = after;
        } while (bracket);
        return true;
    };
    double one = 0;
    const auto number = [&] {
        const bool bracket = *p == '[';
        p += bracket;
        skip();
        const char *after = ScanNumber(p, end, &one);
        if (!after || !(IsBlank(*after) || *after == ']' || *after == '"' || after == end) ||
            !(std::abs(one) <= FLT_MAX))
            return false;
        p = after;
        if (bracket) {
            skip();
            return take("]");
        }
        return true;
    };
    // One string of a short list, with or without brackets; its index, or -1.
    const auto oneOf = [&](std::initializer_list<string_view> words) {
        const bool bracket = *p == '[';
        p += bracket;
        skip();
        int index = 0;
        for (const string_view w : words) {
            const char *const back = p;
            if (take(w)) {
                if (bracket) {
                    skip();
                    if (!take("]"))
                        return -1;
                }
                return index;
            }
            p = back;
            ++index;
        }
        return -1;
    };

    skip();
    if (!take("\"curve\""))
        return false;
    CurveStatement &c = statement_;
    c.Clear();
    c.material = state_.material;
    c.begin = word;
    unsigned seen = 0;
    const auto first = [&](unsigned bit) { // whether this parameter comes the first time
        const bool isFirst = !(seen & bit);
        seen |= bit;
        return isFirst;
    };
    while (true) {
        skip();
        if (*p != '"')
            break;
        ++p;
        bool ok = false;
        if (take("point P\"") || take("point3 P\"")) {
            skip();
            ok = first(1) && numbers(&c.P);
        } else if (take("float width0\"")) {
            skip();
            ok = first(2) && number();
            c.width0 = one;
            c.hasWidth0 = true;
        } else if (take("float width1\"")) {
            skip();
            ok = first(4) && number();
            c.width1 = one;
            c.hasWidth1 = true;
        } else if (take("float width\"")) {
            skip();
            ok = first(8) && number();
            c.width = one;
            c.hasWidth = true;
        } else if (take("string type\"")) {
            skip();
            const int i = oneOf({"\"flat\"", "\"cylinder\"", "\"ribbon\""});
            ok = first(16) && i >= 0;
            c.type = i == 0 ? CurveType::Flat : i == 1 ? CurveType::Cylinder : CurveType::Ribbon;
        } else if (take("normal N\"")) {
            skip();
            ok = first(32) && numbers(&c.N);
            c.hasN = true;
        } else if (take("string basis\"")) {
            skip();
            const int i = oneOf({"\"bezier\"", "\"bspline\""});
            ok = first(64) && i >= 0;
            c.basis = i == 0 ? CurveBasis::Bezier : CurveBasis::BSpline;
        } else if (take("integer degree\"")) {
            skip();
            ok = first(128) && number() && (one == 2 || one == 3);
            c.degree = one == 2 ? 2 : 3;
        } else if (take("integer splitdepth\"")) {
            skip();
            ok = first(256) && number() && one == std::floor(one) && std::abs(one) < 1e6;
        }
        if (!ok)
            return false;
    }
    // A statement ends where the next directive begins; anything else is for the general reader to judge.
    if (!(p == end || (*p >= 'A' && *p <= 'Z')))
        return false;
    if (c.hasN != (c.type == CurveType::Ribbon) || (object_ >= 0 && state_.areaLight >= 0))
        return false;
    if (!EmitCurve(c, nullptr))
        return false;
    lexer().SetCursor(p);
    return true;
}

// The same from a parameter set, with everything checked and said.
void Parser::SlowCurve(const ParamSet &params, const Token &word, int material) {
    CurveStatement &c = statement_;
    c.Clear();
    c.material = material;
    c.begin = word.begin;
    const auto fail = [&](const char *name, const std::string &message) {
        const Param *p = params.Find(name);
        Fail(p ? Place(word, *p) : word.begin, message);
    };
    const auto typed = [&](const char *name, std::initializer_list<ParamType> types,
                           const char *how) -> const Param * {
        const Param *p = params.Find(name);
        if (!p)
            return nullptr;
        if (std::find(types.begin(), types.end(), p->type) == types.end())
            fail(name, std::string("a curve's \"") + name + "\" is written " + how);
        p->used = true;
        return p;
    };
    const auto number = [&](const char *name, double *v, const char *how) {
        const Param *p = typed(name, {ParamType::Float, ParamType::Integer}, how);
        if (!p)
            return false;
        if (p->numbers.size() != 1)
            fail(name, std::string("a curve's \"") + name + "\" takes one number, not " +
                           std::to_string(p->numbers.size()));
        *v = p->numbers[0];
        return true;
    };
    const auto choice = [&](const char *name, std::initializer_list<string_view> words, const char *how) {
        const Param *p = typed(name, {ParamType::String}, how);
        if (!p)
            return size_t(0);
        const auto it =
            p->strings.size() == 1 ? std::find(words.begin(), words.end(), p->strings[0]) : words.end();
        if (it == words.end())
            fail(name, std::string("a curve's \"") + name + "\" cannot be " +
                           (p->strings.empty() ? "empty" : Quoted(p->strings[0])) + ". " +
                           Suggestion(p->strings.empty() ? "" : string_view(p->strings[0]), words.begin(),
                                      words.size()));
        return static_cast<size_t>(it - words.begin());
    };

    const Param *P = typed("P", {ParamType::Point3}, "\"point P\" [ x y z ... ]");
    if (!P)
        Fail(word, "Shape \"curve\" needs control points, \"point P\" [ x y z ... ]");
    if (P->numbers.size() % 3 != 0)
        fail("P", "a curve's \"point P\" has " + std::to_string(P->numbers.size()) +
                      " numbers, which is no multiple of 3");
    c.P = P->numbers;
    c.hasWidth = number("width", &c.width, "\"float width\" value");
    c.hasWidth0 = number("width0", &c.width0, "\"float width0\" value");
    c.hasWidth1 = number("width1", &c.width1, "\"float width1\" value");
    static constexpr CurveType kTypes[] = {CurveType::Flat, CurveType::Cylinder, CurveType::Ribbon};
    c.type = kTypes[choice("type", {"flat", "cylinder", "ribbon"}, "\"string type\" name")];
    c.basis = choice("basis", {"bezier", "bspline"}, "\"string basis\" name") ? CurveBasis::BSpline
                                                                              : CurveBasis::Bezier;
    double degree = 3, splitDepth = 3;
    number("degree", &degree, "\"integer degree\" 2 or 3");
    if (degree != 2 && degree != 3)
        fail("degree", "a curve's \"degree\" must be 2 or 3");
    c.degree = degree == 2 ? 2 : 3;
    number("splitdepth", &splitDepth,
           "\"integer splitdepth\" value"); // pbrt-v3's accelerator wants it, ours does not
    if (const Param *N = typed("N", {ParamType::Normal}, "\"normal N\" [ x y z ... ]")) {
        if (c.type == CurveType::Ribbon) {
            if (N->numbers.size() % 3 != 0)
                fail("N", "a curve's \"normal N\" has " + std::to_string(N->numbers.size()) +
                              " numbers, which is no multiple of 3");
            c.N = N->numbers;
            c.hasN = true;
        } else {
            Warning(N->loc, "curve normals without ribbon",
                    "\"normal N\" is used for curves of type \"ribbon\" only");
        }
    }
    if (c.type == CurveType::Ribbon && !c.hasN)
        Fail(word, "a curve of type \"ribbon\" needs \"normal N\", one at each end of each segment");
    std::string error;
    if (!EmitCurve(c, &error))
        Fail(word, "Shape \"curve\": " + error);
    params.ReportUnused("Shape \"curve\"");
}

// Looks at the current transformation once for all curves that follow under it.
void Parser::UpdateCurveTransform() {
    curveTransformKnown_ = true;
    const Transform &t = Current(lexer().Loc(lexer().Cursor()));
    curveIdentity_ = t.IsIdentity();
    curveScale_ = std::cbrt(std::abs(t.Determinant()));
    // A similarity has columns of equal length at right angles to one another: A^T A = s^2 I.
    const Transform::Matrix &m = t.M();
    double worst = 0;
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) {
            const double dot = m[0][i] * m[0][j] + m[1][i] * m[1][j] + m[2][i] * m[2][j];
            worst = std::max(worst, std::abs(dot - (i == j ? Sqr(curveScale_) : 0)));
        }
    // Twice the relative difference in length, since lengths are squared here.
    if (worst > 0.002 * Sqr(curveScale_))
        Warning(lexer().Loc(lexer().Cursor()), "curves scaled unevenly",
                "curves stand under a transformation that scales differently along different axes; their "
                "widths are scaled by "
                "the mean factor " +
                    std::to_string(curveScale_));
}

// Puts the curve into the pool as segments; both readers end here. On a refusal the pool is as it was.
bool Parser::EmitCurve(const CurveStatement &c, std::string *error) {
    if (c.P.size() % 3 != 0 || c.N.size() % 3 != 0) {
        if (error)
            *error = "points and normals have three coordinates each";
        return false;
    }
    if (!curveTransformKnown_)
        UpdateCurveTransform();

    // Bring the control points and widths into world space; double until the last step.
    const size_t count = c.P.size() / 3;
    points_.resize(count);
    if (curveIdentity_) {
        for (size_t i = 0; i < count; ++i)
            points_[i] = Point3f(Vector3d(c.P[3 * i], c.P[3 * i + 1], c.P[3 * i + 2]));
    } else {
        const Transform::Matrix &m = ctm_[0].M();
        for (size_t i = 0; i < count; ++i) {
            const double x = c.P[3 * i], y = c.P[3 * i + 1], z = c.P[3 * i + 2];
            const auto row = [&](size_t r) { return m[r][0] * x + m[r][1] * y + m[r][2] * z + m[r][3]; };
            const double w = row(3);
            points_[i] = Point3f(Vector3d(row(0), row(1), row(2)) / w);
        }
    }
    const double w0 = (c.hasWidth0 ? c.width0 : c.hasWidth ? c.width : 1) * curveScale_;
    const double w1 = (c.hasWidth1 ? c.width1 : c.hasWidth ? c.width : 1) * curveScale_;
    for (const Point3f &p : points_)
        if (!IsWithinReach(p)) {
            if (error)
                *error = "a control point is out of range after the transformation (beyond 1e18)";
            return false;
        }

    CurvePool *pool = object_ >= 0 ? &scene_.objects[static_cast<size_t>(object_)].curves : &scene_.curves;
    const uint32_t group = GroupIndex({c.type, CurrentState(c.material), {}}, c.begin);
    MakeRoom(pool);
    ++files_.back().curves;
    if (c.type != CurveType::Ribbon)
        return AppendCurve(points_.data(), count, c.basis, c.degree, static_cast<float>(w0),
                           static_cast<float>(w1), group, &pool->segments, error);
    normals_.resize(c.N.size() / 3);
    for (size_t i = 0; i < normals_.size(); ++i)
        normals_[i] = ctm_[0].Normal(Normal3f(Vector3d(c.N[3 * i], c.N[3 * i + 1], c.N[3 * i + 2])));
    return AppendRibbon(points_.data(), count, c.basis, c.degree, static_cast<float>(w0),
                        static_cast<float>(w1), normals_.data(), normals_.size(), group, &pool->segments,
                        &pool->ribbonNormals, error);
}

uint32_t Parser::GroupIndex(const CurveGroup &group, const char *at) {
    if (lastGroupIndex_ != UINT32_MAX && lastGroup_.type == group.type && lastGroup_.state == group.state)
        return lastGroupIndex_;
    const uint64_t key =
        static_cast<uint64_t>(group.state.material) << 32 | static_cast<uint32_t>(group.state.areaLight);
    std::vector<uint32_t> &candidates = groupsByState_[key];
    uint32_t index = UINT32_MAX;
    for (const uint32_t i : candidates)
        if (scene_.curveGroups[i].type == group.type && scene_.curveGroups[i].state == group.state)
            index = i;
    if (index == UINT32_MAX) {
        index = static_cast<uint32_t>(scene_.curveGroups.size());
        scene_.curveGroups.push_back(group);
        scene_.curveGroups.back().loc = lexer().Loc(at);
        candidates.push_back(index);
    }
    lastGroup_ = group;
    lastGroupIndex_ = index;
    return index;
}

// Grows the pool by what the rest of the file lets expect, rather than by doubling: memory is the limit of large scenes.
void Parser::MakeRoom(CurvePool *pool) {
    std::vector<CurveSegment> &s = pool->segments;
    if (s.size() + 64 <= s.capacity())
        return;
    const File &f = files_.back();
    const double read = static_cast<double>(lexer().Cursor() - lexer().Source().Begin()) + 1;
    const double left = static_cast<double>(lexer().Source().End() - lexer().Cursor());
    const double forecast = 1.02 * static_cast<double>(f.curves) * left / read;
    const double least = static_cast<double>(s.size()) / 4 + 64,
                 most = 8 * static_cast<double>(s.size()) + 1024;
    s.reserve(s.size() + static_cast<size_t>(std::clamp(forecast, least, most)) + 64);
}

} // namespace

std::span<const std::string_view> MaterialParameters(std::string_view materialType) {
    static const std::unordered_map<string_view, std::vector<string_view>> table{
        {"matte", {"Kd", "sigma", "bumpmap"}},
        {"plastic", {"Kd", "Ks", "roughness", "remaproughness", "bumpmap"}},
        {"translucent", {"Kd", "Ks", "reflect", "transmit", "roughness", "remaproughness", "bumpmap"}},
        {"glass", {"Kr", "Kt", "eta", "index", "uroughness", "vroughness", "remaproughness", "bumpmap"}},
        {"mirror", {"Kr", "bumpmap"}},
        {"hair",
         {"sigma_a", "color", "reflectance", "eumelanin", "pheomelanin", "eta", "beta_m", "beta_n", "alpha",
          "model", "Kd", "Ks", "exponent"}},
        {"disney",
         {"color", "metallic", "eta", "roughness", "speculartint", "anisotropic", "sheen", "sheentint",
          "clearcoat", "clearcoatgloss", "spectrans", "scatterdistance", "thin", "flatness", "difftrans",
          "bumpmap"}},
        {"mix", {"amount"}},
        {"metal", {"eta", "k", "roughness", "uroughness", "vroughness", "remaproughness", "bumpmap"}},
        {"substrate", {"Kd", "Ks", "uroughness", "vroughness", "remaproughness", "bumpmap"}},
        {"uber",
         {"Kd", "Ks", "Kr", "Kt", "opacity", "eta", "index", "roughness", "uroughness", "vroughness",
          "remaproughness", "bumpmap"}},
        {"subsurface",
         {"Kr", "Kt", "sigma_a", "sigma_s", "mfp", "g", "scale", "eta", "uroughness", "vroughness",
          "remaproughness", "bumpmap"}},
        {"kdsubsurface",
         {"Kd", "Kr", "Kt", "mfp", "g", "eta", "uroughness", "vroughness", "remaproughness", "bumpmap"}},
        {"fourier", {"bumpmap"}},
    };
    const auto it = table.find(materialType);
    return it == table.end() ? std::span<const string_view>() : std::span<const string_view>(it->second);
}

SceneDescription ParseScene(const PluginTables &plugins, const std::string &filename,
                            const ParseOptions &options) {
    std::unique_ptr<TextSource> source;
    try {
        source = TextSource::FromFile(filename, {});
    } catch (const Error &e) {
        if (!options.collectErrors)
            throw;
        options.collectErrors->push_back(e.what());
        return {};
    }
    const size_t slash = filename.rfind('/');
    return Parser(plugins, options,
                  slash == std::string::npos ? "" : filename.substr(0, std::max<size_t>(slash, 1)))
        .Run(std::move(source));
}

SceneDescription ParseSceneText(const PluginTables &plugins, const std::string &text, const std::string &name,
                                const std::string &folder, const ParseOptions &options) {
    return Parser(plugins, options, folder).Run(TextSource::FromText(text, name));
}

} // namespace cuticle
