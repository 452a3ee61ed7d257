#include "grooms/groom_file.h"

#include "core/error.h"
#include "core/memory_budget.h"
#include "files/file.h"
#include "grooms/hair_file.h"
#include "grooms/ply_strands.h"
#include "grooms/tfx_file.h"
#include "grooms/usd_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sys/stat.h>

namespace cuticle {

namespace {

[[noreturn]] void Refuse(const std::string &name, const std::string &what) {
    throw Error(FileLoc{std::make_shared<const std::string>(name)}, what);
}

using StrandParser = Groom (*)(std::string_view bytes, const std::string &name, const GroomFileOptions &);
// The parser of a format that has no use for the options.
template <Groom (*parse)(std::string_view, const std::string &)>
Groom Parse(std::string_view bytes, const std::string &name, const GroomFileOptions &) {
    return parse(bytes, name);
}

// A format of files with strands. To add a format of grooms: a pair of files with its Parse function, a row
// in kFormats, its beginning in the message of ParserFor; the help texts of cli/groom.cpp and the README name
// all.
struct StrandFormat {
    std::string_view ending;
    bool (*begins)(std::string_view bytes); // whether a file of this format can begin so
    StrandParser parse;
};

constexpr StrandFormat kFormats[] = {
    {".hair", [](std::string_view b) { return b.starts_with("HAIR"); }, Parse<ParseHairFile>},
    {".tfx", IsTfxFile, Parse<ParseTfxFile>},
    {".usda", [](std::string_view b) { return b.starts_with("#usda"); },
     [](std::string_view b, const std::string &name, const GroomFileOptions &options) {
         return ParseUsdFileAt(b, name, options.time);
     }},
    {".ply", [](std::string_view b) { return b.starts_with("ply"); },
     [](std::string_view b, const std::string &name, const GroomFileOptions &options) {
         return ParsePlyStrands(b, name, options.pointsPerStrand);
     }},
};

StrandParser ParserFor(std::string_view beginning, const std::string &filename) {
    for (const StrandFormat &f : kFormats)
        if (f.begins(beginning))
            return f.parse;
    if (beginning.starts_with("PXR-USDC") || beginning.starts_with("PK\3\4"))
        Refuse(filename, "this is USD in its binary form; USD's own usdcat writes it as text: "
                         "usdcat FILE -o FILE.usda");
    // The parser of what the name promises says what is wrong with the beginning; the rest, maybe huge, stays
    // unread.
    for (const StrandFormat &f : kFormats)
        if (filename.ends_with(f.ending))
            f.parse(beginning, filename, {});
    Refuse(filename,
           "this is none of the files with strands that can be read: .hair (begins with the letters "
           "HAIR), .tfx (with the number 4 as a float), .usda (with #usda), .ply (with ply)");
}

double MeanLength(const Groom &groom) {
    double sum = 0;
    for (size_t i = 0; i < groom.StrandCount(); ++i)
        for (uint32_t k = groom.strandOffsets[i]; k + 1 < groom.strandOffsets[i + 1]; ++k)
            sum += (Vector3d(groom.points[k + 1]) - Vector3d(groom.points[k])).Length();
    return sum / static_cast<double>(std::max<size_t>(1, groom.StrandCount()));
}

} // namespace

Groom ReadGroomFile(const std::string &filename, const GroomFileOptions &options) {
    const float width = options.width;
    const std::string path = AllowedPath(filename);
    struct stat status {};
    if (stat(path.c_str(), &status) != 0)
        Refuse(filename, std::string("cannot read: ") + std::strerror(errno));
    if (!S_ISREG(status.st_mode))
        Refuse(filename, "cannot read: not a regular file");
    const File noted(OpenPlainFile(filename, "the file of strands"));
    std::ifstream in(path, std::ios::binary);
    if (!in)
        Refuse(filename, std::string("cannot read: ") + std::strerror(errno));
    // Look at the first bytes before the rest is read: a wrong file may be huge.
    std::string bytes(256, '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<size_t>(in.gcount()));
    const StrandParser parse = ParserFor(bytes, filename);
    const auto size = static_cast<uint64_t>(status.st_size);
    // The longest .hair file that its 32-bit counts can describe; read no more, whatever the system says.
    constexpr uint64_t kMaxLength = 128 + 0xffffffffull * (2 + 12 + 4 + 4 + 12);
    if (size > kMaxLength)
        Refuse(filename, "too long for a file of strands");
    ClaimMemory(fmt::format("the file of strands \"{}\"", filename), 2 * size); // and what is read from it
    bytes.resize(size);
    in.clear();
    in.seekg(0);
    in.read(bytes.data(), static_cast<std::streamsize>(size));
    bytes.resize(static_cast<size_t>(in.gcount()));

    Groom groom = parse(bytes, filename, options);
    const bool none = groom.pointWidths.empty() && groom.strandWidths.empty() && groom.width == 0;
    if (width > 0 || none) {
        std::vector<float>().swap(groom.pointWidths); // `= {}` would keep its memory
        std::vector<std::array<float, 2>>().swap(groom.strandWidths);
        groom.width = width;
    }
    if (none && !(width > 0)) {
        groom.width = static_cast<float>(MeanLength(groom) / 500);
        Warning(
            "strands without widths",
            fmt::format("{}: the file gives its strands no width; {:f} is used, 1/500 of their mean length. "
                        "\"float width\" (--width) sets another",
                        filename, groom.width));
    }
    return groom;
}

} // namespace cuticle
