#include "parser/scene_text.h"

#include <filesystem>

namespace cuticle {

namespace {

constexpr size_t kMaxIncludeDepth = 64;
constexpr size_t kMaxIncludes = 100000;
constexpr size_t kMaxQuoted = 60; // bytes of a name or number in a message

} // namespace

Token SceneText::Next() {
    Peek(); // which goes on to the file that holds it
    return lexer().Next();
}

const Token &SceneText::Peek() {
    while (lexer().Peek().kind == Token::Kind::End && IsIncluded()) {
        lexer().Source().CheckUnchanged();
        ended_.push_back(std::move(files_.back()));
        files_.pop_back();
    }
    return lexer().Peek();
}

void SceneText::BeginDirective() {
    ended_.clear();
    lexer().ReleaseBehind();
}

Lexer &SceneText::LexerOf(const char *at) {
    for (const std::vector<File> *files : {&files_, &ended_})
        for (auto file = files->rbegin(); file != files->rend(); ++file)
            if (file->lexer->Holds(at))
                return *file->lexer;
    return lexer();
}

const char *SceneText::PlaceOf(const Token &directive, const Param &p) {
    for (auto place = paramPlaces_.rbegin(); place != paramPlaces_.rend(); ++place)
        if (place->first == p.name)
            return place->second;
    return directive.begin;
}

void SceneText::Push(std::unique_ptr<TextSource> source, const std::string &canonical) {
    bytesRead_ += static_cast<size_t>(source->End() - source->Begin());
    File file;
    file.lexer = std::make_unique<Lexer>(std::move(source)); // may throw, and then nothing is pushed
    file.canonical = canonical;
    files_.push_back(std::move(file));
}

void SceneText::Open(std::unique_ptr<TextSource> source) {
    std::error_code ec;
    const auto canonical = std::filesystem::weakly_canonical(*source->Name(), ec);
    Push(std::move(source), ec ? "" : canonical.string());
}

void SceneText::Include(const std::string &name, const Token &at) {
    const FileLoc loc = Loc(at);
    const std::string path = ResolveFilename(*folder_, name);
    if (files_.size() >= kMaxIncludeDepth)
        Fail(at, "Include goes {} files deep here, which is too deep", kMaxIncludeDepth);
    if (++includes_ > kMaxIncludes)
        Fail(at, "more than {} files are included, which is too many", kMaxIncludes);
    std::error_code ec;
    const std::filesystem::path canonicalPath = std::filesystem::weakly_canonical(path, ec);
    const std::string canonical = ec ? path : canonicalPath.string();
    for (const File &f : files_)
        if (f.canonical == canonical)
            Fail(at, "\"{}\" includes itself{}", path, &f == &files_.back() ? "" : " by way of other files");
    std::unique_ptr<TextSource> source;
    try {
        source = TextSource::FromFile(path, loc, LexerOf(at.begin).Line(at.begin));
    } catch (const Error &e) {
        missingFile = true;
        return e.GoOnAsPbrt("missing file of an Include");
    }
    Push(std::move(source), canonical);
}

void SceneText::CheckUnchanged() const {
    for (const File &file : files_)
        file.lexer->Source().CheckUnchanged();
}

std::string Quoted(std::string_view s) { return fmt::format("\"{}\"", s.substr(0, kMaxQuoted)); }

std::string Describe(const Token &t) {
    switch (t.kind) {
    case Token::Kind::End:
        return "the end of the file";
    case Token::Kind::String:
        return "the string " + Quoted(t.text);
    case Token::Kind::Number:
        return fmt::format("the number {}", t.text.substr(0, kMaxQuoted));
    default:
        return Quoted(t.text);
    }
}

std::string_view NotANumberHint(std::string_view word) {
    std::string lower(word.substr(0, 16));
    for (char &c : lower)
        c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    return lower == "nan" || lower == "inf" || lower == "infinity"
               ? " (not-a-number and infinity have no place in a scene)"
               : "";
}

} // namespace cuticle
