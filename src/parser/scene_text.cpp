#include "parser/scene_text.h"

#include <cstring>
#include <filesystem>

namespace cuticle {

namespace {

constexpr size_t kMaxIncludeDepth = 64;
constexpr size_t kMaxIncludes = 100000;
constexpr size_t kMaxQuoted = 60; // bytes of a name or number in a message

} // namespace

const char *SceneText::PlaceOf(const Token &directive, const Param &p) {
    const char *at = directive.begin, *const end = lexer().Source().End();
    for (uint32_t line = Loc(directive).line; line < p.loc.line; ++line)
        at = static_cast<const char *>(std::memchr(at, '\n', static_cast<size_t>(end - at))) + 1;
    while (at > lexer().Source().Begin() && at[-1] != '\n')
        --at;
    return at + p.loc.column - 1;
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
        source = TextSource::FromFile(path, loc, lexer().Line(at.begin));
    } catch (const Error &) {
        missingFile = true;
        throw;
    }
    Push(std::move(source), canonical);
}

bool SceneText::Leave() {
    if (files_.size() <= 1)
        return false;
    files_.back().lexer->Source().CheckUnchanged();
    files_.pop_back();
    return true;
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
