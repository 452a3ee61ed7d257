#include "files/ply_file.h"

namespace cuticle {

namespace {

struct PlyTypeName {
    std::string_view name;
    PlyType type;
};
constexpr PlyTypeName kTypes[] = {
    {"char", PlyType::Int8},      {"int8", PlyType::Int8},       {"uchar", PlyType::UInt8},
    {"uint8", PlyType::UInt8},    {"short", PlyType::Int16},     {"int16", PlyType::Int16},
    {"ushort", PlyType::UInt16},  {"uint16", PlyType::UInt16},   {"int", PlyType::Int32},
    {"int32", PlyType::Int32},    {"uint", PlyType::UInt32},     {"uint32", PlyType::UInt32},
    {"float", PlyType::Float32},  {"float32", PlyType::Float32}, {"double", PlyType::Float64},
    {"float64", PlyType::Float64}};

std::string ReadLine(PlySource &source) {
    std::string line;
    for (int c; (c = source.Get()) != '\n';) {
        if (c < 0)
            source.Fail("ends inside the PLY header");
        if (line.size() == 4096)
            source.Fail("a line of more than 4096 characters in the PLY header");
        line += static_cast<char>(c);
    }
    if (!line.empty() && line.back() == '\r')
        line.pop_back();
    return line;
}

std::vector<std::string_view> Words(std::string_view line) {
    std::vector<std::string_view> words;
    for (size_t i = 0; i < line.size();) {
        const size_t begin = line.find_first_not_of(" \t", i);
        if (begin == std::string_view::npos)
            break;
        const size_t end = std::min(line.find_first_of(" \t", begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        i = end;
    }
    return words;
}

PlyType ParseType(const PlySource &source, std::string_view word) {
    for (const PlyTypeName &t : kTypes)
        if (t.name == word)
            return t.type;
    source.Fail("\"{}\" is no PLY type", word);
}

} // namespace

PlyHeader ReadPlyHeader(PlySource &source) {
    if (ReadLine(source) != "ply")
        source.Fail("is not a PLY file (its first line is not \"ply\")");
    PlyHeader header;
    bool formatSeen = false;
    while (true) {
        const std::string line = ReadLine(source);
        const std::vector<std::string_view> words = Words(line);
        if (words.empty() || words[0] == "comment" || words[0] == "obj_info")
            continue;
        if (words[0] == "end_header") {
            if (!formatSeen)
                source.Fail("its PLY header has no format line");
            return header;
        }
        if (words[0] == "format" && words.size() == 3) {
            formatSeen = true;
            if (words[1] == "ascii")
                header.format = PlyFormat::Ascii;
            else if (words[1] == "binary_little_endian")
                header.format = PlyFormat::LittleEndian;
            else if (words[1] == "binary_big_endian")
                header.format = PlyFormat::BigEndian;
            else
                source.Fail("unknown PLY format \"{}\"", words[1]);
        } else if (words[0] == "element" && words.size() == 3) {
            PlyElement element{std::string(words[1]), 0, {}};
            const char *end = words[2].data() + words[2].size();
            if (const auto r = std::from_chars(words[2].data(), end, element.count);
                r.ec != std::errc() || r.ptr != end)
                source.Fail("\"{}\" is no count of elements", words[2]);
            if (header.elements.size() == 1000)
                source.Fail("more than 1000 kinds of elements");
            header.elements.push_back(std::move(element));
        } else if (words[0] == "property" &&
                   (words.size() == 3 || (words.size() == 5 && words[1] == "list"))) {
            if (header.elements.empty())
                source.Fail("a PLY property before the first element");
            PlyProperty property;
            property.name = words.back();
            property.type = ParseType(source, words[words.size() - 2]);
            if (words.size() == 5) {
                property.countType = ParseType(source, words[2]);
                if (*property.countType >= PlyType::Float32)
                    source.Fail("property {}: the length of a list cannot be a float", property.name);
            }
            std::vector<PlyProperty> &properties = header.elements.back().properties;
            if (properties.size() == 1000)
                source.Fail("element {} has more than 1000 properties", header.elements.back().name);
            properties.push_back(std::move(property));
        } else {
            source.Fail("the PLY header line \"{}\" makes no sense", line.substr(0, 80));
        }
    }
}

void SkipPlyElement(PlyValues &values, const PlyElement &element) {
    for (uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
        values.SetPlace(&element, i);
        for (const PlyProperty &property : element.properties)
            for (uint64_t n = property.countType ? values.ReadCount(property) : 1; n > 0; --n)
                values.Read(property.type);
    }
}

} // namespace cuticle
