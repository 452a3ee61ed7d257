#include "parser/statements.h"

#include "parser/manual.h"
#include "parser/param_reader.h"
#include "parser/scene_text.h"

#include <cmath>
#include <filesystem>

namespace cuticle {

namespace {

// How a type of a ParamInfo is written in a file, and how many numbers one value has (0: it has none).
struct ValueTypeRow {
    std::string_view name;
    ParamType type;
    size_t numbers;
};
// To add one: a row; its values arrive in Param::numbers or strings.
constexpr ValueTypeRow kValueTypes[] = {
    {"float", ParamType::Float, 1},      {"integer", ParamType::Integer, 1},
    {"bool", ParamType::Bool, 0},        {"string", ParamType::String, 0},
    {"point3", ParamType::Point3, 3},    {"vector3", ParamType::Vector3, 3},
    {"spectrum", ParamType::Spectrum, 3}};

const ValueTypeRow &ValueTypeOf(std::string_view name) {
    for (const ValueTypeRow &row : kValueTypes)
        if (name == row.name || (name.ends_with('s') && name.substr(0, name.size() - 1) == row.name))
            return row;
    throw Error("a table asks for values of type \"{}\", which statements have not", name);
}

void CheckNumbers(const Param &p, const ParamInfo &info) {
    // Bounds that are no binary32 numbers include the nearest one
    const auto rounded = [](double v) { return static_cast<double>(static_cast<float>(v)); };
    for (const double v : p.numbers) {
        if (!std::isfinite(v))
            throw Error(p.loc, "\"{}\" holds a number that is not finite", p.name);
        if (rounded(v) < rounded(info.low) || rounded(v) > rounded(info.high))
            throw Error(p.loc, "\"{}\" is {}", p.name, v).WithRemedy("it must be {}", RangeInWords(info));
    }
}

// Holds a parameter to its row.
void CheckParam(const Param &p, const ParamInfo &info) {
    const ValueTypeRow &type = ValueTypeOf(info.type);
    const bool asFloat = p.type == ParamType::Integer && type.type == ParamType::Float;
    if (p.type != type.type && !asFloat)
        throw Error(p.loc, "\"{}\" is of another type", p.name)
            .WithRemedy("write \"{} {}\"", type.name == "spectrum" ? "rgb" : type.name, p.name);
    const size_t values = type.type == ParamType::Bool     ? p.bools.size()
                          : type.type == ParamType::String ? p.strings.size()
                                                           : p.numbers.size() / type.numbers;
    const bool wholeValues = type.numbers == 0 || p.numbers.size() % type.numbers == 0;
    if (values == 0 || !wholeValues || (values > 1 && type.name == info.type))
        throw Error(p.loc, "\"{}\" has {} values", p.name, type.numbers > 1 ? p.numbers.size() : values)
            .WithRemedy("it takes {}{}", type.numbers > 1 ? "three numbers" : "one",
                        type.name == info.type ? "" : " or more of them");
    CheckNumbers(p, info);
    for (const std::string &s : p.strings)
        if (!info.choices.empty() &&
            std::find(info.choices.begin(), info.choices.end(), s) == info.choices.end())
            throw Error(p.loc, "\"{}\" is \"{}\"", p.name, s)
                .WithRemedy(Suggestion(s, info.choices.data(), info.choices.size()));
}

class StatementReader {
  public:
    StatementReader(std::span<const StatementKind> kinds, const std::string &folder)
        : kinds_(kinds), text_(folder), params_(&text_, &names_) {}

    std::vector<Statement> Read(std::unique_ptr<TextSource> source) {
        std::vector<Statement> statements;
        text_.Open(std::move(source));
        while (true) {
            text_.BeginDirective();
            const Token word = text_.Next();
            if (word.kind == Token::Kind::End)
                break;
            if (word.kind != Token::Kind::Word)
                text_.Fail(word, "expected a directive, found {}", Describe(word));
            statements.push_back(ReadStatement(word));
            const StatementKind *kind = statements.back().kind;
            for (size_t i = 0; !kind->many && i + 1 < statements.size(); ++i)
                if (statements[i].kind == kind)
                    text_.Fail(word, "{} stands here a second time; one is enough", kind->directive);
        }
        text_.CheckUnchanged();
        return statements;
    }

  private:
    Statement ReadStatement(const Token &word) {
        const StatementKind *kind = nullptr;
        std::vector<std::string_view> words, names;
        for (const StatementKind &k : kinds_) {
            words.push_back(k.directive);
            if (k.directive == word.text)
                kind = &k;
        }
        if (kind == nullptr)
            text_.Fail(word, "{} is no directive here. {}", Describe(word),
                       Suggestion(word.text, words.data(), words.size()));
        const Token at = text_.Peek();
        const std::string name = params_.ReadString(word, "a name");
        const PluginInfo *row = nullptr;
        for (const PluginInfo &r : kind->rows) {
            names.push_back(r.name);
            if (r.name == name)
                row = &r;
        }
        if (row == nullptr)
            text_.Fail(at, "{} {} is not known. {}", kind->directive, Quoted(name),
                       Suggestion(name, names.data(), names.size()));
        Statement statement{kind, row, params_.ReadParams(word)};
        names.clear();
        for (const ParamInfo &info : row->params)
            names.push_back(info.name);
        for (const Param &p : statement.params.params) {
            const ParamInfo *info = row->FindParam(p.name);
            if (info == nullptr)
                throw Error(p.loc, "{} \"{}\" has no parameter {}", kind->directive, name, Quoted(p.name))
                    .WithRemedy(Suggestion(p.name, names.data(), names.size()));
            CheckParam(p, *info);
        }
        return statement;
    }

    std::span<const StatementKind> kinds_;
    SceneText text_;
    ScopedNames names_;
    ParamReader params_;
};

} // namespace

std::vector<Statement> ReadStatements(std::span<const StatementKind> kinds, const std::string &filename) {
    const std::filesystem::path folder = std::filesystem::path(filename).parent_path();
    return StatementReader(kinds, folder.string()).Read(TextSource::FromFile(filename, {}));
}
std::vector<Statement> ParseStatements(std::span<const StatementKind> kinds, const std::string &text,
                                       const std::string &name, const std::string &folder) {
    return StatementReader(kinds, folder).Read(TextSource::FromText(text, name));
}

std::string StatementManual(std::span<const StatementKind> kinds) {
    std::string text;
    for (const StatementKind &kind : kinds)
        for (const PluginInfo &row : kind.rows)
            text += (text.empty() ? "" : "\n") + PluginManual(kind.directive, row);
    return text;
}

} // namespace cuticle
