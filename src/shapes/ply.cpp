#include "shapes/ply.h"

#include "core/error.h"
#include "files/file.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <memory>
#include <optional>

namespace cuticle {

namespace {

// Hands out bytes one after another, from a file (gzip or not) or from memory, through one buffer.
class PlySource {
  public:
    PlySource(std::string_view bytes, std::string name)
        : name_(std::move(name)), at_(bytes.data()), end_(at_ + bytes.size()) {}
    explicit PlySource(const std::string &filename)
        : name_(filename), file_(std::make_unique<InputFile>(filename, "the PLY file")), buffer_(1 << 18) {}

    // Returns the next byte, or -1 at the end.
    int Peek() { return at_ != end_ || Refill() ? static_cast<unsigned char>(*at_) : -1; }
    int Get() {
        const int c = Peek();
        if (c >= 0)
            ++at_;
        return c;
    }
    // Reads n bytes; false if fewer are left.
    bool Read(void *to, size_t n) {
        auto *out = static_cast<char *>(to);
        while (n > 0) {
            if (at_ == end_ && !Refill())
                return false;
            const size_t part = std::min(n, static_cast<size_t>(end_ - at_));
            std::memcpy(out, at_, part);
            at_ += part, out += part, n -= part;
        }
        return true;
    }
    // Throws Error("<name>: <what>").
    template <typename... Args>
    [[noreturn]] void Fail(fmt::format_string<Args...> what, Args &&...args) const {
        throw Error("{}: {}", name_, fmt::vformat(what, fmt::make_format_args(args...)));
    }
    const std::string &Name() const { return name_; }

  private:
    bool Refill() {
        if (!file_)
            return false;
        try {
            at_ = buffer_.data();
            end_ = at_ + file_->Read(buffer_.data(), buffer_.size());
        } catch (const Error &e) {
            Fail("{}", e.Message());
        }
        return at_ != end_;
    }

    std::string name_;
    std::unique_ptr<InputFile> file_; // none: all bytes are in memory
    std::vector<char> buffer_;
    const char *at_ = nullptr, *end_ = nullptr;
};

enum class PlyType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };
enum class PlyFormat { Ascii, LittleEndian, BigEndian };

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

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::Float32;
    std::optional<PlyType> countType; // of a list
    int target = -1;                  // vertex: 0..2 position, 3..5 normal, 6..7 uv; face: 0 the corner list
};
struct PlyElement {
    std::string name;
    uint64_t count = 0;
    std::vector<PlyProperty> properties;
};
struct PlyHeader {
    PlyFormat format = PlyFormat::Ascii;
    std::vector<PlyElement> elements;
};

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

PlyHeader ReadHeader(PlySource &source) {
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

// Reads values one after another, in any of the three formats.
class PlyValueReader {
  public:
    PlyValueReader(PlySource &source, PlyFormat format) : source_(source), format_(format) {}

    double Read(PlyType type) {
        if (format_ == PlyFormat::Ascii)
            return ReadText();
        switch (type) {
        case PlyType::Int8:
            return ReadBinary<int8_t, uint8_t>();
        case PlyType::UInt8:
            return ReadBinary<uint8_t, uint8_t>();
        case PlyType::Int16:
            return ReadBinary<int16_t, uint16_t>();
        case PlyType::UInt16:
            return ReadBinary<uint16_t, uint16_t>();
        case PlyType::Int32:
            return ReadBinary<int32_t, uint32_t>();
        case PlyType::UInt32:
            return ReadBinary<uint32_t, uint32_t>();
        case PlyType::Float32:
            return ReadBinary<float, uint32_t>();
        case PlyType::Float64:
            break;
        }
        return ReadBinary<double, uint64_t>();
    }
    // Reads the length of a list.
    uint64_t ReadCount(const PlyProperty &property) {
        const double v = Read(*property.countType);
        if (!(v >= 0 && v <= 4294967295.0 && v == std::floor(v)))
            source_.Fail("property {}: a list of length {:f}", property.name, v);
        return static_cast<uint64_t>(v);
    }
    void SetPlace(const PlyElement *element, uint64_t index) { element_ = element, index_ = index; }

  private:
    [[noreturn]] void FailTruncated() const {
        source_.Fail("ends at {} {} of {}", element_->name, index_, element_->count);
    }
    template <typename T, typename Bits>
    T ReadBinary() {
        unsigned char bytes[sizeof(Bits)];
        if (!source_.Read(bytes, sizeof bytes))
            FailTruncated();
        Bits bits = 0;
        for (size_t i = 0; i < sizeof bytes; ++i) {
            const size_t place = format_ == PlyFormat::LittleEndian ? i : sizeof bytes - 1 - i;
            bits = static_cast<Bits>(bits | static_cast<Bits>(static_cast<Bits>(bytes[i]) << (8 * place)));
        }
        return std::bit_cast<T>(bits);
    }
    double ReadText() {
        int c;
        while ((c = source_.Get()) == ' ' || (c >= '\t' && c <= '\r')) {
        }
        if (c < 0)
            FailTruncated();
        char word[64];
        size_t n = 0;
        for (; c > ' '; c = source_.Get()) {
            if (n == sizeof word)
                source_.Fail("a number of more than 64 characters at {} {}", element_->name, index_);
            word[n++] = static_cast<char>(c);
        }
        double v = 0;
        const std::string_view text(word, n);
        const bool plus = text.starts_with('+'), minus = text.starts_with('-');
        const auto r = std::from_chars(word + plus, word + n, v);
        if (r.ec == std::errc::result_out_of_range) // v is left alone: too near to 0, or too far
            return text.find("e-") != text.npos || text.find("E-") != text.npos ? 0
                   : minus                                                      ? -HUGE_VAL
                                                                                : HUGE_VAL;
        if (r.ec != std::errc() || r.ptr != word + n)
            source_.Fail("\"{}\" where a number belongs, at {} {}", text, element_->name, index_);
        return v;
    }

    PlySource &source_;
    PlyFormat format_;
    const PlyElement *element_ = nullptr;
    uint64_t index_ = 0;
};

// Limits what is reserved on a header's word alone.
size_t CautiousReserve(uint64_t count) { return static_cast<size_t>(std::min<uint64_t>(count, 1 << 20)); }

void ReadVertices(PlyValueReader &values, PlyElement &element, const PlySource &source, TriangleMesh *mesh) {
    constexpr std::string_view kTargets[][5] = {{"x"},
                                                {"y"},
                                                {"z"},
                                                {"nx"},
                                                {"ny"},
                                                {"nz"},
                                                {"u", "s", "texture_u", "texture_s"},
                                                {"v", "t", "texture_v", "texture_t"}};
    bool has[8] = {};
    for (PlyProperty &property : element.properties)
        for (size_t k = 0; k < 8; ++k)
            for (const std::string_view name : kTargets[k])
                if (!has[k] && !property.countType && property.name == name)
                    property.target = static_cast<int>(k), has[k] = true;
    if (!(has[0] && has[1] && has[2]))
        source.Fail("its vertices lack x, y or z");
    if (element.count > 0xfffffffeull)
        source.Fail("{} vertices: more than 4294967294", element.count);
    const bool hasN = has[3] && has[4] && has[5], hasUV = has[6] && has[7];
    mesh->p.reserve(CautiousReserve(element.count));
    uint64_t notFinite = 0;
    for (uint64_t i = 0; i < element.count; ++i) {
        values.SetPlace(&element, i);
        float v[8] = {};
        for (const PlyProperty &property : element.properties) {
            const uint64_t length = property.countType ? values.ReadCount(property) : 1;
            for (uint64_t k = 0; k < length; ++k) {
                const double value = values.Read(property.type);
                if (property.target >= 0)
                    v[property.target] = static_cast<float>(value);
            }
        }
        // Triangles of a point that is not finite are dropped where they are made into a shape
        bool finite = true;
        for (size_t k = 3; k < 8; ++k)
            if (!std::isfinite(v[k]))
                v[k] = 0, finite = false;
        notFinite += !finite;
        mesh->p.push_back({v[0], v[1], v[2]});
        if (hasN)
            mesh->n.push_back({v[3], v[4], v[5]});
        if (hasUV)
            mesh->uv.push_back({v[6], v[7]});
    }
    if (notFinite > 0)
        Warning(
            "PLY values out of range",
            fmt::format("{}: the normals or texture coordinates of {} vertices are not finite, and set to 0",
                        source.Name(), notFinite));
}

void ReadFaces(PlyValueReader &values, PlyElement &element, const PlySource &source, TriangleMesh *mesh) {
    bool hasCorners = false;
    for (PlyProperty &property : element.properties)
        if (!hasCorners && property.countType &&
            (property.name == "vertex_indices" || property.name == "vertex_index"))
            property.target = 0, hasCorners = true;
    if (!hasCorners)
        source.Fail("its faces lack a list vertex_indices");
    mesh->indices.reserve(mesh->indices.size() + 3 * CautiousReserve(element.count));
    uint64_t dropped = 0;
    for (uint64_t i = 0; i < element.count; ++i) {
        values.SetPlace(&element, i);
        for (const PlyProperty &property : element.properties) {
            const uint64_t length = property.countType ? values.ReadCount(property) : 1;
            uint32_t first = 0, previous = 0;
            for (uint64_t k = 0; k < length; ++k) {
                const double value = values.Read(property.type);
                if (property.target < 0)
                    continue;
                if (!(value >= 0 && value <= 4294967294.0 && value == std::floor(value)))
                    source.Fail("face {} has the vertex index {:f}", i, value);
                const auto index = static_cast<uint32_t>(value);
                if (k == 0)
                    first = index;
                else if (k == 1)
                    ;
                else if (k == 2)
                    mesh->indices.insert(mesh->indices.end(), {first, previous, index});
                else // pbrt-v3's order for the second half of a quad: the new corner first
                    mesh->indices.insert(mesh->indices.end(), {index, first, previous});
                previous = index;
            }
            dropped += property.target >= 0 && length < 3;
        }
    }
    if (dropped > 0)
        Warning("PLY faces dropped", fmt::format("{}: {} of {} faces have fewer than three corners",
                                                 source.Name(), dropped, element.count));
}

TriangleMesh ReadFrom(PlySource &source) {
    PlyHeader header = ReadHeader(source);
    PlyValueReader values(source, header.format);
    TriangleMesh mesh;
    bool vertices = false, faces = false;
    for (PlyElement &element : header.elements) {
        if (element.name == "vertex" && !vertices) {
            ReadVertices(values, element, source, &mesh);
            vertices = true;
        } else if (element.name == "face" && !faces) {
            ReadFaces(values, element, source, &mesh);
            faces = true;
        } else if (!(vertices && faces)) {
            if (element.properties.empty())
                continue;
            for (uint64_t i = 0; i < element.count; ++i) {
                values.SetPlace(&element, i);
                for (const PlyProperty &property : element.properties)
                    for (uint64_t n = property.countType ? values.ReadCount(property) : 1; n > 0; --n)
                        values.Read(property.type);
            }
        }
    }
    if (!vertices || mesh.p.empty())
        source.Fail("holds no vertices");
    if (!faces || mesh.indices.empty())
        source.Fail("holds no faces");
    for (const uint32_t index : mesh.indices)
        if (index >= mesh.p.size())
            source.Fail("a face has the vertex index {}, but there are {} vertices", index, mesh.p.size());
    return mesh;
}

} // namespace

TriangleMesh ReadPly(const std::string &filename) {
    PlySource source(filename);
    return ReadFrom(source);
}

TriangleMesh ReadPlyBytes(std::string_view bytes, const std::string &name) {
    PlySource source(bytes, name);
    return ReadFrom(source);
}

} // namespace cuticle
