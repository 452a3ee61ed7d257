#include "fuzz/scene_bundle.h"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

namespace cuticle {

namespace {

bool IsBlankByte(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

std::string Quote(std::string_view text) { return fmt::format("\"{}\"", text); }

// The next token of a text from *at on, or "" at its end. Comments are passed over; a string that does not
// end on its line ends with it.
std::string_view NextToken(std::string_view text, size_t *at) {
    size_t i = *at;
    while (i < text.size() && (IsBlankByte(text[i]) || text[i] == '#'))
        if (text[i++] == '#')
            while (i < text.size() && text[i] != '\n')
                ++i;
    const size_t begin = i;
    if (i < text.size() && text[i] == '"') {
        ++i;
        while (i < text.size() && text[i] != '"' && text[i] != '\n')
            i += text[i] == '\\' && i + 1 < text.size() && text[i + 1] != '\n' ? 2 : 1;
        i += i < text.size() && text[i] == '"';
    } else if (i < text.size() && (text[i] == '[' || text[i] == ']')) {
        ++i;
    } else {
        while (i < text.size() && !IsBlankByte(text[i]) &&
               std::string_view("\"[]#").find(text[i]) == std::string_view::npos)
            ++i;
    }
    i = std::min(i, text.size());
    *at = i;
    return text.substr(begin, i - begin);
}

std::vector<SceneStatement> ReadStatements(std::string_view text) {
    std::vector<SceneStatement> statements;
    size_t at = 0;
    for (std::string_view t; !(t = NextToken(text, &at)).empty();) {
        const std::string token(t);
        const bool word = std::string_view("\"[]+-.0123456789").find(token[0]) == std::string_view::npos;
        // A list of names without quotes belongs to nothing: each is a statement of its own
        if (word || statements.empty())
            statements.emplace_back().word = token;
        else
            statements.back().tokens.push_back(token);
    }
    return statements;
}

void WriteStatements(const std::vector<SceneStatement> &statements, std::string *to) {
    for (const SceneStatement &s : statements) {
        *to += s.word;
        for (const std::string &t : s.tokens)
            *to += ' ' + t;
        *to += '\n';
    }
}

int64_t ToInteger(std::string_view text) {
    int64_t value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
}

// The line behind "#file ".
SceneFile ReadHeader(std::string_view line) {
    SceneFile file;
    std::vector<std::string_view> words;
    for (size_t at = 0; at < line.size();) {
        while (at < line.size() && IsBlankByte(line[at]))
            ++at;
        const size_t begin = at;
        while (at < line.size() && !IsBlankByte(line[at]))
            ++at;
        if (at > begin)
            words.push_back(line.substr(begin, at - begin));
    }
    // Only plain names: a fuzzer writes nothing outside of its folder
    if (!words.empty() && words[0].find('/') == std::string_view::npos && words[0][0] != '.')
        file.name = words[0].substr(0, 40);
    for (size_t i = 1; i < words.size(); ++i) {
        if (words[i] == "packed")
            file.packed = true;
        else if (words[i] == "seed" && i + 1 < words.size() &&
                 words[i + 1].find('/') == std::string_view::npos)
            file.seed = words[++i];
        else if (words[i] == "damage" && i + 3 < words.size()) {
            FileDamage d;
            d.offset = static_cast<uint32_t>(ToInteger(words[i + 1]));
            d.size = static_cast<uint32_t>(ToInteger(words[i + 2]) & 15);
            d.value = ToInteger(words[i + 3]);
            file.damage.push_back(d);
            i += 3;
        }
    }
    return file;
}

std::string Gzip(const std::string &bytes) {
    z_stream z{};
    if (deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return bytes;
    std::string packed(deflateBound(&z, bytes.size()) + 32, '\0');
    std::string copy = bytes;
    z.next_in = reinterpret_cast<Bytef *>(copy.data()), z.avail_in = static_cast<uInt>(copy.size());
    z.next_out = reinterpret_cast<Bytef *>(packed.data()), z.avail_out = static_cast<uInt>(packed.size());
    deflate(&z, Z_FINISH);
    packed.resize(z.total_out);
    deflateEnd(&z);
    return packed;
}

void Spoil(const FileDamage &damage, std::string *bytes) {
    if (bytes->empty())
        return;
    const size_t offset = damage.offset % bytes->size();
    if (damage.size == 0) {
        bytes->resize(offset);
        return;
    }
    auto value = static_cast<uint64_t>(damage.value);
    for (size_t i = offset; i < std::min<size_t>(bytes->size(), offset + damage.size); ++i, value >>= 8)
        (*bytes)[i] = static_cast<char>(value & 255);
}

bool Flatten(const SceneBundle &bundle, const SceneFile &file, size_t depth, std::string *text) {
    if (depth > 6 || !file.seed.empty() || !file.damage.empty() || text->size() > (1u << 20))
        return false;
    for (const SceneStatement &s : file.statements) {
        if (s.word != "Include") {
            WriteStatements({s}, text);
            continue;
        }
        if (s.tokens.size() != 1)
            return false;
        const auto found = std::find_if(bundle.files.begin(), bundle.files.end(),
                                        [&](const SceneFile &f) { return Quote(f.name) == s.tokens[0]; });
        if (found == bundle.files.end() || !Flatten(bundle, *found, depth + 1, text))
            return false;
    }
    return true;
}

} // namespace

SceneBundle ReadBundle(std::string_view text) {
    SceneBundle bundle;
    bundle.files.emplace_back().name = "scene.pbrt";
    constexpr std::string_view mark = "\n#file ";
    for (size_t at = 0; at != std::string_view::npos;) {
        const size_t next = text.find(mark, at);
        bundle.files.back().statements =
            ReadStatements(text.substr(at, next == std::string_view::npos ? next : next - at));
        if (next == std::string_view::npos || bundle.files.size() >= 8)
            break;
        const size_t header = next + mark.size();
        const size_t end = std::min(text.find('\n', header), text.size());
        bundle.files.push_back(ReadHeader(text.substr(header, end - header)));
        // an empty name stands for a file that cannot be named; it is given one that nobody uses
        if (bundle.files.back().name.empty())
            bundle.files.back().name = fmt::format("file{}", bundle.files.size());
        at = end;
    }
    return bundle;
}

std::string WriteBundle(const SceneBundle &bundle) {
    std::string text;
    for (size_t i = 0; i < bundle.files.size(); ++i) {
        const SceneFile &f = bundle.files[i];
        if (i > 0) {
            text += fmt::format("\n#file {}", f.name);
            if (!f.seed.empty())
                text += " seed " + f.seed;
            if (f.packed)
                text += " packed";
            for (const FileDamage &d : f.damage)
                text += fmt::format(" damage {} {} {}", d.offset, d.size, d.value);
            text += '\n';
        }
        WriteStatements(f.statements, &text);
    }
    return text;
}

std::string FileBytes(const SceneFile &file, const std::string &seeds) {
    std::string bytes;
    if (file.seed.empty()) {
        WriteStatements(file.statements, &bytes);
    } else {
        std::ifstream stream(seeds + "/" + file.seed, std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(stream), {});
    }
    if (file.packed)
        bytes = Gzip(bytes);
    for (const FileDamage &d : file.damage)
        Spoil(d, &bytes);
    return bytes;
}

bool FlattenIncludes(const SceneBundle &bundle, std::string *text) {
    text->clear();
    return Flatten(bundle, bundle.files[0], 0, text);
}

} // namespace cuticle
