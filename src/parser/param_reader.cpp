#include "parser/param_reader.h"

#include "parser/directives.h"

#include <algorithm>
#include <cfloat>
#include <cmath>

namespace cuticle {

namespace {

constexpr size_t kMaxParameters = 1000; // of one directive

struct ParamTypeName {
    std::string_view name;
    ParamType type;
    SpectrumSpelling spelling = SpectrumSpelling::None;
};

// To add a type of parameters: a row here, and where it is no number or string, its check in CheckValues.
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
    {"rgb", ParamType::Spectrum, SpectrumSpelling::RGB},
    {"color", ParamType::Spectrum, SpectrumSpelling::RGB},
    {"xyz", ParamType::Spectrum, SpectrumSpelling::XYZ},
    {"blackbody", ParamType::Spectrum, SpectrumSpelling::Blackbody},
    {"spectrum", ParamType::Spectrum, SpectrumSpelling::Samples},
}};

constexpr auto kParamTypeNames = [] {
    std::array<std::string_view, kParamTypes.size()> names{};
    for (size_t i = 0; i < names.size(); ++i)
        names[i] = kParamTypes[i].name;
    return names;
}();

std::string SuggestParamType(std::string_view typeName) {
    // The beginning of a type ("int") says more than its edit distance to the others.
    for (const std::string_view &name : kParamTypeNames)
        if (typeName.size() > 1 && name.starts_with(typeName))
            return Suggestion(name, &name, 1);
    return Suggestion(typeName, kParamTypeNames.data(), kParamTypeNames.size());
}

} // namespace

std::string ParamReader::ReadString(const Token &word, std::string_view what) {
    const Token t = text_.Peek();
    if (t.kind != Token::Kind::String)
        text_.Fail(t, "{} needs {} in quotes, found {}", word.text, what, Describe(t));
    text_.Next();
    return text_.Unescape(t);
}

void ParamReader::ReadNumbers(const Token &word, std::string_view what, bool brackets, double *values,
                              size_t count) {
    const bool open = brackets && text_.Peek().kind == Token::Kind::Open;
    if (open)
        text_.Next();
    for (size_t i = 0; i < count; ++i) {
        const Token t = text_.Peek();
        if (t.kind != Token::Kind::Number)
            text_.Fail(t, "{} needs {} numbers ({}), found {} after {}{}", word.text, count, what,
                       Describe(t), i, NotANumberHint(t.text));
        values[i] = text_.Next().number;
    }
    if (open) {
        const Token t = text_.Peek();
        if (t.kind != Token::Kind::Close)
            text_.Fail(t, "{} needs {} numbers and then \"]\", found {}", word.text, count, Describe(t));
        text_.Next();
    }
}

ParamSet ParamReader::ReadParams(const Token &word) {
    ParamSet set;
    text_.BeginParams();
    set.loc = text_.Loc(word);
    set.folder = text_.Folder();
    // Those that are left out count as well: each costs a warning
    for (size_t count = 0; text_.Peek().kind == Token::Kind::String; ++count) {
        if (count == kMaxParameters)
            text_.Fail(text_.Peek(), "more than {} parameters of one directive", kMaxParameters);
        ReadParam(&set);
    }
    return set;
}

void ParamReader::ReadParam(ParamSet *set) {
    Reading r;
    const bool isKnown = ReadDeclaration(&r);
    ReadValues(&r);
    const PlaceScope here(text_.Loc(r.declaration)); // of conversions that know no place
    if (isKnown && CheckValues(&r) && Convert(&r))
        Add(std::move(r), set);
}

// Splits "type name" at any white space, of which there may be some around it too. False for what is none.
bool ParamReader::ReadDeclaration(Reading *r) {
    r->declaration = text_.Next();
    const std::string text = text_.Unescape(r->declaration);
    r->full = Quoted(text);
    const char *blanks = " \t\r";
    const size_t typeBegin = std::min(text.find_first_not_of(blanks), text.size());
    const size_t typeEnd = std::min(text.find_first_of(blanks, typeBegin), text.size());
    const size_t nameBegin = std::min(text.find_first_not_of(blanks, typeEnd), text.size());
    const size_t nameEnd = std::min(text.find_first_of(blanks, nameBegin), text.size());
    const bool rest = text.find_first_not_of(blanks, nameEnd) != std::string::npos;
    const std::string_view typeName = std::string_view(text).substr(typeBegin, typeEnd - typeBegin);
    if (nameBegin == nameEnd || rest)
        text_.Complain(r->declaration, "parameter that is no \"type name\"",
                       "a parameter is written \"type name\" value, as in \"float fov\" 30; found {}, and "
                       "{}, as by pbrt-v3",
                       Quoted(text), rest ? "the first two words count" : "it is ignored");
    if (nameBegin == nameEnd)
        return false;
    const auto type = std::find_if(kParamTypes.begin(), kParamTypes.end(),
                                   [&](const ParamTypeName &t) { return t.name == typeName; });
    if (type == kParamTypes.end()) {
        text_.Complain(r->declaration, "unknown parameter type",
                       "parameter type {} is not known, and {} is ignored, as by pbrt-v3. {}",
                       Quoted(typeName), r->full, SuggestParamType(typeName));
        return false;
    }
    r->spelling = type->spelling;
    r->param.type = type->type;
    r->param.name = text.substr(nameBegin, nameEnd - nameBegin);
    r->param.loc = text_.Loc(r->declaration);
    r->full = fmt::format("\"{} {}\"", typeName, r->param.name);
    return true;
}

// Reads one value, or any number of them in brackets.
void ParamReader::ReadValues(Reading *r) {
    if (text_.Peek().kind == Token::Kind::Open)
        return ReadBracketedValues(r);
    const Token t = text_.Peek();
    if (!TakeValue(t, r))
        text_.Fail(t, "expected the value of {}, found {}{}", r->full, Describe(t), NotANumberHint(t.text));
    text_.Next();
}

void ParamReader::ReadBracketedValues(Reading *r) {
    const Token open = text_.Next();
    while (true) {
        ReadNumberArray(&r->param.numbers);
        const Token t = text_.Peek();
        Directive d;
        if (t.kind == Token::Kind::Close) {
            text_.Next();
            return;
        }
        if (t.kind == Token::Kind::End || t.kind == Token::Kind::Open ||
            (t.kind == Token::Kind::Word && FindDirective(t.text, &d)))
            text_.Fail(open, "the values of {} have no closing \"]\" before {} at {}", r->full, Describe(t),
                       text_.Loc(t).ToString());
        if (!TakeValue(t, r))
            text_.Fail(t, "expected a value of {}, found {}{}", r->full, Describe(t), NotANumberHint(t.text));
        text_.Next();
    }
}

// False for a token that is no value.
bool ParamReader::TakeValue(const Token &t, Reading *r) {
    Param &p = r->param;
    if (t.kind == Token::Kind::Number) {
        p.numbers.push_back(t.number);
    } else if (t.kind == Token::Kind::String) {
        r->places.push_back(t.begin);
        p.strings.push_back(text_.Unescape(t));
    } else if (t.kind == Token::Kind::Word && (t.text == "true" || t.text == "false")) {
        r->hasWords = true;
        r->places.push_back(t.begin);
        p.strings.emplace_back(t.text);
    } else {
        return false;
    }
    return true;
}

// Reads on while numbers follow, which in meshes they do by the million.
void ParamReader::ReadNumberArray(std::vector<double> *numbers) {
    Lexer &lexer = text_.lexer();
    const char *p = lexer.Cursor(), *const end = lexer.Source().End();
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
    lexer.SetCursor(p);
}

// Strings, numbers and true or false each belong to certain types.
bool ParamReader::CheckValues(Reading *r) {
    const Param &p = r->param;
    const bool wantsStrings =
        p.type == ParamType::String || p.type == ParamType::Texture || p.type == ParamType::Bool;
    if (!p.strings.empty() && !p.numbers.empty())
        text_.Fail(r->declaration, "the values of {} are strings as well as numbers", r->full);
    if (r->hasWords && p.type != ParamType::Bool)
        text_.Fail(r->places.front(), "{} takes {}, not {}", r->full,
                   wantsStrings ? "strings in quotes" : "numbers", Quoted(p.strings.front()));
    const bool isNumber = wantsStrings && !p.numbers.empty();
    if (isNumber || (wantsStrings && p.strings.empty()))
        text_.Complain(r->declaration, "value of another type than its parameter's",
                       "{} takes {}, not {}; it is ignored, as by pbrt-v3", r->full,
                       p.type == ParamType::Bool ? "\"true\" or \"false\"" : "a string in quotes",
                       isNumber ? fmt::format("{:g}", p.numbers.front()) : "nothing");
    if (wantsStrings)
        return !p.strings.empty();
    if (p.strings.empty() || r->spelling == SpectrumSpelling::Samples)
        return true;
    text_.Complain(r->places.front(), "value of another type than its parameter's",
                   "{} takes numbers, not {}; it is ignored, as by pbrt-v3", r->full,
                   Quoted(p.strings.front()));
    return false;
}

bool ParamReader::Convert(Reading *r) {
    switch (r->param.type) {
    case ParamType::Bool:
        return ReadBools(r);
    case ParamType::Texture:
        return BindTexture(r);
    case ParamType::Spectrum:
        return ToSpectrum(r);
    default:
        return true;
    }
}

bool ParamReader::ReadBools(Reading *r) {
    Param &p = r->param;
    for (size_t i = 0; i < p.strings.size(); ++i) {
        if (p.strings[i] != "true" && p.strings[i] != "false")
            text_.Complain(r->places[i], "neither true nor false",
                           "{} takes \"true\" or \"false\", not {}, which counts as false, as in pbrt-v3",
                           r->full, Quoted(p.strings[i]));
        p.bools.push_back(p.strings[i] == "true");
    }
    p.strings.clear();
    return true;
}

// A texture is bound where it is named: a later one of the same name does not change it.
bool ParamReader::BindTexture(Reading *r) {
    Param &p = r->param;
    if (p.strings.size() != 1) {
        text_.Complain(r->declaration, "names of several textures",
                       "{} takes the name of one texture, not {}; it is ignored, as by pbrt-v3", r->full,
                       p.strings.size());
        return false;
    }
    const std::string &name = p.strings[0];
    const auto indexIn = [&](const NameMap &map) {
        const auto it = map.find(name);
        return it == map.end() ? -1 : it->second;
    };
    p.floatTexture = indexIn(names_.floatTextures);
    p.spectrumTexture = indexIn(names_.spectrumTextures);
    if (p.floatTexture >= 0 || p.spectrumTexture >= 0)
        return true;
    if (!text_.missingFile)
        text_.Complain(
            r->places[0], "undefined texture",
            "no texture {} has been defined here, and {} is left at its default, as in pbrt-v3{}",
            Quoted(name), r->full,
            text_.SuggestOnce("undefined texture", name, {&names_.floatTextures, &names_.spectrumTextures}));
    return false;
}

void ParamReader::Add(Reading &&r, ParamSet *set) {
    Param &p = r.param;
    text_.NoteParam(p.name, r.declaration.begin);
    for (Param &other : set->params)
        if (other.name == p.name) {
            Warning(p.loc, "parameter given twice",
                    fmt::format("parameter \"{}\" is given twice; the last one wins", p.name));
            other = std::move(p);
            return;
        }
    set->params.push_back(std::move(p));
}

} // namespace cuticle
