#include "render/film_file.h"

#include "core/error.h"
#include "files/file.h"
#include "files/inputs.h"

#include <charconv>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <string_view>

namespace cuticle {

namespace {

constexpr std::string_view kMagic = "cuticle film 2\n";
constexpr std::string_view kFactMark = "fact:"; // before the names of an identity's facts
constexpr size_t kHashLetters = 32;

template <typename T>
void PutNumber(T value, std::string *out) {
    auto bits = static_cast<std::make_unsigned_t<T>>(value);
    char bytes[sizeof bits];
    for (char &byte : bytes) {
        byte = static_cast<char>(bits & 0xff);
        bits = static_cast<decltype(bits)>(sizeof bits > 1 ? bits >> 8 : 0);
    }
    out->append(bytes, sizeof bytes);
}

// Takes a number off the front of the bytes, which must hold it.
template <typename T>
T TakeNumber(std::string_view *bytes) {
    std::make_unsigned_t<T> bits = 0;
    for (size_t i = 0; i < sizeof bits; ++i)
        bits = static_cast<decltype(bits)>(
            bits | static_cast<decltype(bits)>(static_cast<unsigned char>((*bytes)[i])) << 8 * i);
    bytes->remove_prefix(sizeof bits);
    return static_cast<T>(bits);
}

template <typename Sums>
void PutSums(const Sums &sums, std::string *out) {
    for (const uint8_t lowest : sums.LowestBins())
        PutNumber(lowest, out);
    for (const auto &channel : sums.AllCounters())
        for (const int64_t counter : channel)
            PutNumber(counter, out);
}

template <typename Sums>
bool TakeSums(uint32_t count, std::string_view *bytes, Sums *sums) {
    auto lowest = sums->LowestBins();
    auto counters = sums->AllCounters();
    for (uint8_t &bin : lowest)
        bin = TakeNumber<uint8_t>(bytes);
    for (auto &channel : counters)
        for (int64_t &counter : channel)
            counter = TakeNumber<int64_t>(bytes);
    return sums->Restore(counters, lowest, count);
}

void PutLine(std::string_view name, std::string_view value, std::string *out) {
    out->append(name).append("=");
    for (const char c : value)
        out->append(c == '\n' ? "\\n" : c == '\\' ? "\\\\" : std::string_view(&c, 1));
    out->append("\n");
}

std::string Unescaped(std::string_view value) {
    std::string text;
    for (size_t i = 0; i < value.size(); ++i)
        text += value[i] != '\\' || i + 1 == value.size() ? value[i] : value[++i] == 'n' ? '\n' : value[i];
    return text;
}

// Reads numbers that stand apart by blanks; false where they are not so many, or something else.
template <typename T>
bool ReadNumbers(const std::string &text, std::initializer_list<T *> values) {
    const char *at = text.data(), *const end = at + text.size();
    for (T *const value : values) {
        while (at < end && *at == ' ')
            ++at;
        const auto [behind, error] = std::from_chars(at, end, *value);
        if (error != std::errc() || behind == at)
            return false;
        at = behind;
    }
    return at == end;
}

} // namespace

// The one that sees a film's inside.
class FilmFile {
  public:
    static std::string Header(const Film &film, const RenderTally &tally);
    static void PutTile(const Film &film, size_t tile, std::string *out);
    static StoredFilm Read(const std::string &filename, std::string_view bytes);

  private:
    explicit FilmFile(const std::string &filename) : filename_(filename) {}
    [[noreturn]] void Refuse(const std::string &why) const { throw Error("\"{}\" {}", filename_, why); }
    void ReadHeader(std::string_view header);
    void ReadShape();
    void ReadTile(size_t tile, std::string_view *bytes);
    size_t BytesOfTiles() const;
    template <typename T>
    void Numbers(const char *name, std::initializer_list<T *> values) {
        if (!ReadNumbers(values_[name], values))
            Refuse(fmt::format("is a damaged film: \"{}\" is not as it must be", name));
    }

    const std::string &filename_;
    std::map<std::string, std::string> values_; // of the header's lines, but the facts and ranges
    std::vector<std::string> ranges_;
    StoredFilm stored_{Film(), {}};
};

std::string FilmFile::Header(const Film &film, const RenderTally &tally) {
    std::string out(kMagic);
    const auto put = [&](std::string_view name, const auto &...values) {
        std::string text;
        ((text += (text.empty() ? "" : " ") + fmt::format("{}", values)), ...);
        PutLine(name, text, &out);
    };
    put("resolution", film.resolution_.x, film.resolution_.y);
    put("window", film.min_.x, film.min_.y, film.max_.x, film.max_.y);
    put("scale", film.scale_);
    put("maxsampleluminance", film.maxLuminance_);
    put("variance", film.HasVariance() ? 1 : 0);
    put("parts", film.HasParts() ? 1 : 0);
    put("filename", film.filename_);
    for (const FilmRange &taken : film.taken_)
        put("range", taken.range.first, taken.range.last);
    put("seconds", tally.seconds);
    put("rays", tally.rays, tally.shadowRays);
    for (const auto &[name, value] : film.render_.facts)
        PutLine(std::string(kFactMark) + name, value, &out);
    return out + "\n";
}

void FilmFile::PutTile(const Film &film, size_t tile, std::string *out) {
    const auto [min, max] = film.TileWindow(tile);
    for (const FilmRange &taken : film.taken_)
        PutNumber(taken.done[tile], out);
    for (int y = min.y; y < max.y; ++y)
        for (int x = min.x; x < max.x; ++x) {
            const size_t i = film.IndexOf(x, y);
            PutNumber(film.pixels_[i].n, out);
            PutSums(film.pixels_[i].sums, out);
            if (film.HasVariance())
                PutSums(film.squares_[i], out);
            if (film.HasParts()) {
                PutNumber(film.parts_[i].even, out);
                PutSums(film.parts_[i].sums, out);
            }
        }
}

void FilmFile::ReadHeader(std::string_view header) {
    while (!header.empty()) {
        const std::string_view line = header.substr(0, header.find('\n'));
        header.remove_prefix(line.size() + 1);
        const size_t equals = line.find('=');
        if (equals == std::string_view::npos)
            Refuse("is a damaged film: a line of its header has no \"=\"");
        const std::string name(line.substr(0, equals)), value = Unescaped(line.substr(equals + 1));
        if (name.starts_with(kFactMark))
            stored_.film.render_.facts.emplace_back(name.substr(kFactMark.size()), value);
        else if (name == "range")
            ranges_.push_back(value);
        else
            values_[name] = value;
    }
}

// Makes the film of the header, with no pixel yet.
void FilmFile::ReadShape() {
    Film &film = stored_.film;
    int variance = 0, parts = 0;
    Numbers("resolution", {&film.resolution_.x, &film.resolution_.y});
    Numbers("window", {&film.min_.x, &film.min_.y, &film.max_.x, &film.max_.y});
    Numbers("scale", {&film.scale_});
    Numbers("maxsampleluminance", {&film.maxLuminance_});
    Numbers("variance", {&variance});
    Numbers("parts", {&parts});
    Numbers("seconds", {&stored_.tally.seconds});
    Numbers("rays", {&stored_.tally.rays, &stored_.tally.shadowRays});
    film.filename_ = values_["filename"];
    const Point2i size = film.resolution_, min = film.min_, max = film.max_;
    if (size.x < 1 || size.y < 1 || int64_t{size.x} * size.y > Film::kMaxPixels || min.x < 0 || min.y < 0 ||
        min.x >= max.x || min.y >= max.y || max.x > size.x || max.y > size.y)
        Refuse("is a damaged film: its window does not lie in its picture");
    for (const std::string &text : ranges_) {
        SampleRange range;
        if (!ReadNumbers(text, {&range.first, &range.last}) || range.first < 0 || range.first >= range.last)
            Refuse("is a damaged film: its ranges of samples are none");
        film.taken_.push_back({range, {}});
    }
    if (variance) // these say so to BytesOfTiles, until there is room
        film.squares_.resize(1);
    if (parts)
        film.parts_.resize(1);
}

// The bytes that all tiles take in the file.
size_t FilmFile::BytesOfTiles() const {
    const Film &film = stored_.film;
    const Point2i size = film.WindowSize();
    const size_t pixel =
        4 + 3 + 6 * 8 + (film.HasVariance() ? 3 + 9 * 8 : 0) + (film.HasParts() ? 4 + 9 + 18 * 8 : 0);
    return static_cast<size_t>(size.x) * static_cast<size_t>(size.y) * pixel +
           film.Tiles() * film.taken_.size() * 4;
}

void FilmFile::ReadTile(size_t tile, std::string_view *bytes) {
    Film &film = stored_.film;
    const auto [min, max] = film.TileWindow(tile);
    uint64_t done = 0;
    for (FilmRange &taken : film.taken_) {
        taken.done[tile] = TakeNumber<uint32_t>(bytes);
        done += taken.done[tile];
        if (taken.done[tile] > static_cast<uint32_t>(taken.range.Count()))
            Refuse("is a damaged film: a tile has more samples than were asked for");
    }
    for (int y = min.y; y < max.y; ++y)
        for (int x = min.x; x < max.x; ++x) {
            const size_t i = film.IndexOf(x, y);
            Film::Pixel &pixel = film.pixels_[i];
            pixel.n = TakeNumber<uint32_t>(bytes);
            bool good = TakeSums(pixel.n, bytes, &pixel.sums) &&
                        (!film.HasVariance() || TakeSums(pixel.n, bytes, &film.squares_[i]));
            if (film.HasParts()) {
                Film::Parts &parts = film.parts_[i];
                parts.even = TakeNumber<uint32_t>(bytes);
                good = good && parts.even <= pixel.n && TakeSums(pixel.n, bytes, &parts.sums);
            }
            if (!good || pixel.n > done)
                Refuse(fmt::format("is a damaged film: pixel ({}, {}) holds what no samples make", x, y));
        }
}

StoredFilm FilmFile::Read(const std::string &filename, std::string_view bytes) {
    FilmFile file(filename);
    if (!bytes.starts_with(kMagic))
        file.Refuse(bytes.starts_with("cuticle film ")
                        ? "is a film in a format of another version of this program"
                        : "is no film that `cuticle render` has written");
    const size_t end = bytes.find("\n\n");
    if (bytes.size() < kHashLetters || end == std::string_view::npos)
        file.Refuse("is a damaged film: it ends too early");
    const std::string_view hashed = bytes.substr(0, bytes.size() - kHashLetters);
    ContentHash hash;
    hash.Add(hashed);
    if (hash.Hex() != bytes.substr(hashed.size()))
        file.Refuse("is a damaged film: its bytes are not those that were written");
    file.ReadHeader(bytes.substr(kMagic.size(), end + 1 - kMagic.size()));
    file.ReadShape();
    bytes = hashed.substr(end + 2);
    if (bytes.size() != file.BytesOfTiles())
        file.Refuse(fmt::format("is a damaged film: {} bytes of pixels where its header asks for {}",
                                bytes.size(), file.BytesOfTiles()));
    Film &film = file.stored_.film;
    film.MakePixels(film.HasVariance(), film.HasParts());
    for (FilmRange &taken : film.taken_)
        taken.done.resize(film.Tiles());
    for (size_t tile = 0; tile < film.Tiles(); ++tile)
        file.ReadTile(tile, &bytes);
    return std::move(file.stored_);
}

void WriteFilm(const std::string &filename, const Film &film, const RenderTally &tally,
               const std::function<std::unique_lock<std::mutex>(size_t tile)> &lockTile) {
    OutputFile file(filename);
    ContentHash hash;
    const auto write = [&](const std::string &bytes) {
        hash.Add(bytes);
        file.Write(bytes);
    };
    write(FilmFile::Header(film, tally));
    std::string bytes;
    for (size_t tile = 0; tile < film.Tiles(); ++tile) {
        {
            const std::unique_lock<std::mutex> lock =
                lockTile ? lockTile(tile) : std::unique_lock<std::mutex>();
            FilmFile::PutTile(film, tile, &bytes);
        }
        if (bytes.size() > (size_t{1} << 20) || tile + 1 == film.Tiles()) {
            write(bytes);
            bytes.clear();
        }
    }
    file.Write(hash.Hex());
    file.Commit(true);
}

StoredFilm ReadFilm(const std::string &filename) {
    const InputScope unnoted(nullptr); // it is written to again
    return FilmFile::Read(filename, ReadFile(filename, "the film"));
}

} // namespace cuticle
