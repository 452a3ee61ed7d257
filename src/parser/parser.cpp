#include "parser/curve_reader.h"
#include "parser/directives.h"
#include "parser/graphics_state.h"
#include "parser/lexer.h"
#include "parser/material_list.h"
#include "parser/param_reader.h"
#include "parser/plugins.h"
#include "parser/scene_description.h"
#include "parser/scene_text.h"

#include <algorithm>
#include <array>
#include <utility>

namespace cuticle {

namespace {

constexpr size_t kMaxErrors = 1000;

// The loop over directives, and each directive.
class SceneParser {
  public:
    SceneParser(const PluginTables &plugins, const ParseOptions &options, const std::string &folder);
    SceneDescription Run(std::unique_ptr<TextSource> top);

  private:
    void ParseAll();
    void ParseNext();
    void SkipToDirective();
    void Finish(const Token *worldEnd);
    void ParseDirective(const Token &word);

    // isKnown: null for a kind of which all unknown names are Errors.
    std::string ReadPluginName(const Token &word, PluginKind kind, bool *isKnown = nullptr);
    bool CheckPluginName(PluginKind kind, const std::string &name, const char *at);

    void Include(const Token &word);
    void OptionEntity(const Token &word, PluginKind kind, Entity *entity);
    void Rotate(const Token &word);
    void LookAt(const Token &word);
    void Matrix(const Token &word, bool concat);
    void CoordSysTransform(const Token &word);
    void ActiveTransform();
    void WorldEnd(const Token &word);
    void Material(const Token &word);
    void MakeNamedMaterial(const Token &word);
    void NamedMaterial(const Token &word);
    void Texture(const Token &word);
    void LightSource(const Token &word);
    void AreaLightSource(const Token &word);
    void Shape(const Token &word);
    void Medium(const Token &word);
    void ObjectBegin(const Token &word);
    void ObjectInstance(const Token &word);

    const PluginTables &plugins_;
    ParseOptions options_;
    SceneDescription scene_;
    SceneText text_;
    GraphicsState state_;
    ParamReader params_;
    MaterialList materials_;
    CurveReader curves_;
    NameMap objects_;
    bool metMedium_ = false; // participating media have been warned of
    bool done_ = false;
};

SceneParser::SceneParser(const PluginTables &plugins, const ParseOptions &options, const std::string &folder)
    : plugins_(plugins), options_(options), text_(folder, options.frame), state_(&text_),
      params_(&text_, &state_.names),
      materials_(&text_, &state_, plugins.Find(PluginKind::Material), &scene_.materials),
      curves_(&text_, &state_, &scene_) {
    scene_.frame = options.frame;
    const auto standard = [&](Entity *e, const char *type) {
        e->type = type;
        e->params.folder = text_.Folder();
    };
    standard(&scene_.camera, "perspective");
    standard(&scene_.sampler, "halton");
    standard(&scene_.film, "image");
    standard(&scene_.filter, "box");
    standard(&scene_.integrator, "path");
    standard(&scene_.accelerator, "bvh");
    MaterialEntity matte;
    matte.type = "matte";
    matte.params.folder = text_.Folder();
    materials_.Add(std::move(matte));
}

SceneDescription SceneParser::Run(std::unique_ptr<TextSource> top) {
    scene_.filename = *top->Name();
    try {
        text_.Open(std::move(top));
        ParseAll();
        text_.CheckUnchanged();
    } catch (const Error &e) {
        if (!options_.collectErrors) {
            text_.CheckUnchanged(); // a better reason
            throw;
        }
        options_.collectErrors->push_back(e.what());
    }
    curves_.Finish();
    scene_.bytesRead = text_.BytesRead();
    return std::move(scene_);
}

void SceneParser::ParseAll() {
    while (!done_) {
        try {
            ParseNext();
        } catch (const Error &e) {
            if (!options_.collectErrors)
                throw;
            options_.collectErrors->push_back(e.what());
            if (options_.collectErrors->size() >= kMaxErrors)
                return;
            if (!done_)
                SkipToDirective();
        }
    }
}

void SceneParser::ParseNext() {
    text_.BeginDirective();
    const Token t = text_.Next();
    switch (t.kind) {
    case Token::Kind::Word:
        ParseDirective(t);
        break;
    case Token::Kind::End:
        done_ = true;
        Finish(nullptr);
        break;
    case Token::Kind::Number:
        text_.Fail(t,
                   "expected a directive or a parameter, found {}: several values of one parameter need "
                   "brackets, [ ... ]",
                   Describe(t));
    case Token::Kind::String:
        text_.Fail(t, "expected a directive, found {}", Describe(t));
    default:
        text_.Fail(t, "\"{}\" stands outside of a parameter", t.text);
    }
}

// After an error: on to the next word that is a directive.
void SceneParser::SkipToDirective() {
    while (true) {
        try {
            const Token &t = text_.Peek();
            Directive d;
            if (t.kind == Token::Kind::End || (t.kind == Token::Kind::Word && FindDirective(t.text, &d)))
                return;
            text_.Next();
        } catch (const Error &) { // the lexer has gone past the fault
        }
    }
}

// At WorldEnd, or where it is null at the end of the file.
void SceneParser::Finish(const Token *worldEnd) {
    const char *const end = text_.lexer().Source().End();
    const std::string unclosed = state_.CloseBlocks(worldEnd ? "WorldEnd" : "the end of the file");
    if (!unclosed.empty() && !text_.missingFile)
        text_.Complain(worldEnd ? worldEnd->begin : end, "block without end",
                       "{}; it ends here, as in pbrt-v3", unclosed);
    if (worldEnd)
        return;
    if (!state_.InWorld())
        text_.Fail(end, "the file ends without a WorldBegin: there is no scene in it");
    Warning(text_.Loc(end), "no WorldEnd",
            "the file ends without WorldEnd; it is read as if WorldEnd stood here (pbrt-v4 scenes have none: "
            "if this is one, it must be converted, for Cuticle reads pbrt-v3)");
}

// --- names of plug-ins
// ---------------------------------------------------------------------------------------------

// Says what pbrt-v3 does about a name that it does not know, in words; "" where it makes no picture then.
std::string_view InsteadOfUnknown(PluginKind kind) {
    switch (kind) {
    case PluginKind::Accelerator:
        return "a \"bvh\" takes its place";
    case PluginKind::Material:
        return "\"matte\" takes its place";
    case PluginKind::Shape:
    case PluginKind::Light:
    case PluginKind::Texture:
    case PluginKind::Medium:
        return "it is left out";
    case PluginKind::AreaLight:
        return "shapes after it do not emit";
    case PluginKind::Camera:
    case PluginKind::Sampler:
    case PluginKind::Film:
    case PluginKind::Filter:
    case PluginKind::Integrator:
        return "";
    }
    return "";
}

// False for a name that is not known, of a kind where pbrt-v3 goes on.
bool SceneParser::CheckPluginName(PluginKind kind, const std::string &name, const char *at) {
    const PluginTable *table = plugins_.Find(kind);
    if (!table || table->Find(name))
        return true;
    const auto isIn = [&](const std::vector<std::string_view> &names) {
        return std::find(names.begin(), names.end(), name) != names.end();
    };
    const std::string full = fmt::format("{} {}", DirectiveOf(kind), Quoted(name));
    for (const int version : {4, 2})
        if (isIn(version == 4 ? table->v4 : table->v2))
            text_.Fail(at, "{0} is pbrt-v{1}: this looks like a pbrt-v{1} scene, and Cuticle reads pbrt-v3",
                       full, version);
    const std::vector<std::string_view> names = table->Names();
    const std::string suggestion = Suggestion(name, names.data(), names.size());
    const std::string_view instead = InsteadOfUnknown(kind);
    if (instead.empty())
        text_.Fail(at, "{} is not known. {}", full, suggestion);
    text_.Complain(at, fmt::format("unknown {}", DirectiveOf(kind)), "{} is not known; {}, as by pbrt-v3. {}",
                   full, instead, suggestion);
    return false;
}

std::string SceneParser::ReadPluginName(const Token &word, PluginKind kind, bool *isKnown) {
    const Token t = text_.Peek();
    std::string name = params_.ReadString(word, "a type");
    const bool known = CheckPluginName(kind, name, t.begin);
    if (isKnown)
        *isKnown = known;
    return name;
}

// --- directives
// ----------------------------------------------------------------------------------------------------

// Long because: it is the table of directives, a case for each.
void SceneParser::ParseDirective(const Token &word) {
    Directive d;
    if (!FindDirective(word.text, &d))
        text_.Fail(word, UnknownDirectiveMessage(word.text, state_.InBlock() || state_.InWorld()));
    switch (d) {
    case Directive::Camera:
        return OptionEntity(word, PluginKind::Camera, &scene_.camera);
    case Directive::Sampler:
        return OptionEntity(word, PluginKind::Sampler, &scene_.sampler);
    case Directive::Film:
        return OptionEntity(word, PluginKind::Film, &scene_.film);
    case Directive::PixelFilter:
        return OptionEntity(word, PluginKind::Filter, &scene_.filter);
    case Directive::Integrator:
        return OptionEntity(word, PluginKind::Integrator, &scene_.integrator);
    case Directive::Accelerator:
        return OptionEntity(word, PluginKind::Accelerator, &scene_.accelerator);
    case Directive::Include:
        return Include(word);
    case Directive::Identity:
        return state_.Apply(word, Transform(), false);
    case Directive::Translate: {
        const auto v = params_.ReadNumbers<3>(word, "x y z");
        return state_.Apply(word, Transform::Translate({v[0], v[1], v[2]}), true);
    }
    case Directive::Scale: {
        const auto v = params_.ReadNumbers<3>(word, "x y z");
        return state_.Apply(word, Transform::Scale(v[0], v[1], v[2]), true);
    }
    case Directive::Rotate:
        return Rotate(word);
    case Directive::LookAt:
        return LookAt(word);
    case Directive::Transform:
        return Matrix(word, false);
    case Directive::ConcatTransform:
        return Matrix(word, true);
    case Directive::CoordinateSystem:
        return state_.NameSpace(params_.ReadString(word, "a name"));
    case Directive::CoordSysTransform:
        return CoordSysTransform(word);
    case Directive::ActiveTransform:
        return ActiveTransform();
    case Directive::TransformTimes:
        params_.ReadNumbers<2>(word, "start, end"); // times matter to motion only, which is not rendered
        return;
    case Directive::TransformBegin:
        state_.BeginBlock(word, BlockKind::Transform);
        return;
    case Directive::TransformEnd:
        return state_.EndBlock(word, BlockKind::Transform);
    case Directive::AttributeBegin:
        state_.BeginBlock(word, BlockKind::Attribute);
        return;
    case Directive::AttributeEnd:
        return state_.EndBlock(word, BlockKind::Attribute);
    case Directive::ObjectBegin:
        return ObjectBegin(word);
    case Directive::ObjectEnd:
        return state_.EndBlock(word, BlockKind::Object);
    case Directive::ObjectInstance:
        return ObjectInstance(word);
    case Directive::WorldBegin:
        return state_.BeginWorld(word);
    case Directive::WorldEnd:
        return WorldEnd(word);
    case Directive::MakeNamedMaterial:
        return MakeNamedMaterial(word);
    case Directive::NamedMaterial:
        return NamedMaterial(word);
    case Directive::Material:
        return Material(word);
    case Directive::Texture:
        return Texture(word);
    case Directive::LightSource:
        return LightSource(word);
    case Directive::AreaLightSource:
        return AreaLightSource(word);
    case Directive::Shape:
        return Shape(word);
    case Directive::ReverseOrientation:
        if (state_.RequireWorld(word))
            state_.attributes.reverseOrientation = !state_.attributes.reverseOrientation;
        return;
    case Directive::MediumInterface:
    case Directive::MakeNamedMedium:
        return Medium(word);
    }
}

void SceneParser::OptionEntity(const Token &word, PluginKind kind, Entity *entity) {
    Entity e;
    bool isKnown = true;
    e.type = ReadPluginName(word, kind, &isKnown);
    if (!isKnown && kind == PluginKind::Accelerator)
        e.type = "bvh";
    e.params = params_.ReadParams(word);
    if (state_.InWorld()) {
        Warning(
            e.params.loc, fmt::format("{} after WorldBegin", word.text),
            fmt::format("{} has no effect after WorldBegin; this one is ignored, as by pbrt-v3", word.text));
        return;
    }
    e.ctm =
        kind == PluginKind::Camera ? state_.Current(e.params.loc) : state_.CurrentOfDirections(e.params.loc);
    if (kind == PluginKind::Camera)
        state_.NameCameraSpace();
    *entity = std::move(e);
}

void SceneParser::Include(const Token &word) {
    const Token t = text_.Peek();
    text_.Include(params_.ReadString(word, "a file name"), t);
}

void SceneParser::Rotate(const Token &word) {
    const auto v = params_.ReadNumbers<4>(word, "degrees, axis x y z");
    if (v[1] == 0 && v[2] == 0 && v[3] == 0)
        text_.Fail(word, "Rotate needs an axis that is not 0 0 0");
    state_.Apply(word, Transform::Rotate(v[0], {v[1], v[2], v[3]}), true);
}

void SceneParser::LookAt(const Token &word) {
    const auto v = params_.ReadNumbers<9>(word, "eye, point looked at, up");
    const Vector3d eye(v[0], v[1], v[2]), look(v[3], v[4], v[5]), up(v[6], v[7], v[8]);
    const Transform t = Transform::LookAt(eye, look, up);
    if (t.IsSingular() && !(eye == look) && up.LengthSquared() > 0)
        return text_.Complain(word, "LookAt along up",
                              "LookAt: up points along the view; it changes nothing, as in pbrt-v3");
    state_.Apply(word, t, true);
}

void SceneParser::Matrix(const Token &word, bool concat) {
    const auto v = params_.ReadNumbers<16>(word, "a matrix, column after column", true);
    Transform::Matrix m;
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j)
            m[i][j] = v[4 * j + i];
    if (const double m33 = m[3][3]; m33 != 0)
        for (auto &row : m) // points are divided by the last element
            for (double &element : row)
                element /= m33;
    state_.NoteProjective(word, m);
    state_.Apply(word, Transform(m), concat);
}

void SceneParser::CoordSysTransform(const Token &word) {
    const Token t = text_.Peek();
    state_.UseSpace(params_.ReadString(word, "the name of a coordinate system"), t);
}

void SceneParser::ActiveTransform() {
    const Token t = text_.Next();
    if (t.text == "StartTime")
        state_.SetActive(GraphicsState::kStart);
    else if (t.text == "EndTime")
        state_.SetActive(GraphicsState::kEnd);
    else if (t.text == "All")
        state_.SetActive(GraphicsState::kBoth);
    else
        text_.Fail(t, "ActiveTransform takes StartTime, EndTime or All, not {}", Describe(t));
}

void SceneParser::WorldEnd(const Token &word) {
    if (!state_.InWorld())
        text_.Fail(word, "WorldEnd without WorldBegin");
    done_ = true;
    bool more = false;
    try {
        more = text_.Peek().kind != Token::Kind::End;
    } catch (const Error &) {
        more = true;
    }
    if (more)
        Warning(text_.Loc(text_.Peek()), "text after WorldEnd",
                "what stands after WorldEnd is not read: Cuticle renders one picture of a file, the first");
    Finish(&word);
}

void SceneParser::Material(const Token &word) {
    MaterialEntity m;
    bool isKnown = true;
    m.type = ReadPluginName(word, PluginKind::Material, &isKnown);
    if (!isKnown)
        m.type = "matte";
    m.params = params_.ReadParams(word);
    if (!state_.RequireWorld(word))
        return;
    materials_.ResolveMix(word, &m);
    state_.attributes.material = materials_.Add(std::move(m));
}

void SceneParser::MakeNamedMaterial(const Token &word) {
    MaterialEntity m;
    m.name = params_.ReadString(word, "a name");
    m.params = params_.ReadParams(word);
    if (!state_.RequireWorld(word))
        return;
    const Param *type = m.params.Find("type");
    if (!type || type->type != ParamType::String || type->strings.size() != 1) {
        text_.Complain(word, "named material without a type",
                       "MakeNamedMaterial needs a parameter \"string type\" with the type of the material; "
                       "without it, it is none and light passes it, as in pbrt-v3");
    } else {
        type->used = true;
        m.type = type->strings[0];
        if (!CheckPluginName(PluginKind::Material, m.type, text_.PlaceOf(word, *type)))
            m.type = "matte";
    }
    materials_.ResolveMix(word, &m);
    materials_.AddNamed(std::move(m));
}

void SceneParser::NamedMaterial(const Token &word) {
    const Token t = text_.Peek();
    const std::string name = params_.ReadString(word, "the name of a material");
    if (state_.RequireWorld(word))
        materials_.Choose(name, t);
}

void SceneParser::Texture(const Token &word) {
    TextureEntity texture;
    texture.name = params_.ReadString(word, "a name");
    const Token t = text_.Peek();
    const std::string kind = params_.ReadString(word, "\"float\", \"color\" or \"spectrum\"");
    const bool isFloat = kind == "float";
    bool isKnown = true;
    texture.type = ReadPluginName(word, PluginKind::Texture, &isKnown);
    texture.params = params_.ReadParams(word);
    if (!state_.RequireWorld(word) || !isKnown)
        return;
    if (!isFloat && kind != "color" && kind != "spectrum") {
        static constexpr std::array<std::string_view, 3> kKinds{"float", "color", "spectrum"};
        return text_.Complain(
            t, "unknown class of a texture",
            "texture {}: its class must be \"float\", \"color\" or \"spectrum\", not {}; it "
            "is left out, as by pbrt-v3. {}",
            Quoted(texture.name), Quoted(kind), Suggestion(kind, kKinds.data(), kKinds.size()));
    }
    texture.ctm = state_.Current(texture.params.loc);
    NameMap &map = isFloat ? state_.names.floatTextures : state_.names.spectrumTextures;
    std::vector<TextureEntity> &list = isFloat ? scene_.floatTextures : scene_.spectrumTextures;
    if (map.count(texture.name))
        Warning(texture.params.loc, "texture redefined",
                fmt::format("texture {} is defined again", Quoted(texture.name)));
    state_.names.Set(&map, texture.name, static_cast<int>(list.size()));
    list.push_back(std::move(texture));
}

void SceneParser::LightSource(const Token &word) {
    LightEntity light;
    bool isKnown = true;
    light.type = ReadPluginName(word, PluginKind::Light, &isKnown);
    light.params = params_.ReadParams(word);
    if (!state_.RequireWorld(word) || !isKnown)
        return;
    const PluginTable *table = plugins_.Find(PluginKind::Light);
    const PluginInfo *row = table ? table->Find(light.type) : nullptr;
    light.ctm = row && row->directional ? state_.CurrentOfDirections(light.params.loc)
                                        : state_.Current(light.params.loc);
    scene_.lights.push_back(std::move(light));
}

void SceneParser::AreaLightSource(const Token &word) {
    Entity light;
    bool isKnown = true;
    light.type = ReadPluginName(word, PluginKind::AreaLight, &isKnown);
    light.params = params_.ReadParams(word);
    if (!state_.RequireWorld(word))
        return;
    if (!isKnown) {
        state_.attributes.areaLight = -1;
        return;
    }
    light.ctm = state_.Current(light.params.loc);
    state_.attributes.areaLight = static_cast<int>(scene_.areaLights.size());
    scene_.areaLights.push_back(std::move(light));
}

void SceneParser::Shape(const Token &word) {
    const bool inWorld = state_.RequireWorld(word);
    if (inWorld && options_.fastCurves && curves_.TryFast(word.begin))
        return;
    bool isKnown = true;
    const std::string type = ReadPluginName(word, PluginKind::Shape, &isKnown);
    ParamSet params = params_.ReadParams(word);
    if (!inWorld || !isKnown)
        return;
    const PluginTable *shapes = plugins_.Find(PluginKind::Shape);
    const int material = materials_.OfShape(shapes ? shapes->Find(type) : nullptr, params);
    if (state_.InObject() && state_.attributes.areaLight >= 0)
        Warning(params.loc, "area light in an object",
                "an area light on a shape of an object definition is not rendered (nor by pbrt-v3)");
    if (type == "curve") {
        try {
            curves_.Read(params, word, material);
        } catch (const Error &e) {
            e.GoOnAsPbrt("curve left out");
        }
        return;
    }
    ShapeEntity shape;
    shape.objectToWorld = state_.Current(params.loc);
    shape.state = state_.StateOfShape(material);
    shape.type = type;
    shape.params = std::move(params);
    auto &list =
        state_.InObject() ? scene_.objects[static_cast<size_t>(state_.object)].shapes : scene_.shapes;
    list.push_back(std::move(shape));
}

void SceneParser::Medium(const Token &word) {
    if (word.text == "MediumInterface") {
        params_.ReadString(word, "the name of a medium");
        if (text_.Peek().kind == Token::Kind::String)
            text_.Next();
    } else {
        params_.ReadString(word, "a name");
        const ParamSet params = params_.ReadParams(word);
        const Param *type = params.Find("type");
        if (type && type->type == ParamType::String && type->strings.size() == 1)
            CheckPluginName(PluginKind::Medium, type->strings[0], text_.PlaceOf(word, *type));
    }
    // A medium is made once and named often: one line says it for all.
    if (!std::exchange(metMedium_, true))
        Warning(text_.Loc(word), "participating media",
                "participating media are not rendered; all space is taken as empty");
}

void SceneParser::ObjectBegin(const Token &word) {
    ObjectDefinition o;
    o.name = params_.ReadString(word, "a name");
    o.loc = text_.Loc(word);
    if (state_.InObject())
        text_.Complain(
            word, "object in an object",
            "ObjectBegin inside the definition of object {}, which has no ObjectEnd yet; shapes go "
            "to the new one, and behind its ObjectEnd to the scene, as in pbrt-v3",
            Quoted(scene_.objects[static_cast<size_t>(state_.object)].name));
    if (!state_.BeginBlock(word, BlockKind::Object))
        return;
    state_.object = static_cast<int>(scene_.objects.size());
    objects_[o.name] = state_.object;
    scene_.objects.push_back(std::move(o));
}

void SceneParser::ObjectInstance(const Token &word) {
    const Token t = text_.Peek();
    const std::string name = params_.ReadString(word, "the name of an object");
    if (!state_.RequireWorld(word))
        return;
    if (state_.InObject())
        return text_.Complain(
            word, "instance in an object",
            "ObjectInstance inside the definition of an object; it is ignored, as by pbrt-v3");
    const auto it = objects_.find(name);
    if (it == objects_.end()) {
        if (!text_.missingFile)
            text_.Complain(t, "unknown object",
                           "no object {} has been defined; the instance is left out, as by pbrt-v3{}",
                           Quoted(name), text_.SuggestOnce("unknown object", name, {&objects_}));
        return;
    }
    const FileLoc loc = text_.Loc(word);
    scene_.instances.push_back({it->second, state_.Current(loc), loc});
}

} // namespace

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
    const std::string folder =
        slash == std::string::npos ? "" : filename.substr(0, std::max<size_t>(slash, 1));
    return SceneParser(plugins, options, folder).Run(std::move(source));
}

SceneDescription ParseSceneText(const PluginTables &plugins, const std::string &text, const std::string &name,
                                const std::string &folder, const ParseOptions &options) {
    return SceneParser(plugins, options, folder).Run(TextSource::FromText(text, name));
}

} // namespace cuticle
