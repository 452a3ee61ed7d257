#include "render/film.h"

#include "core/check.h"
#include "core/error.h"
#include "core/memory_budget.h"
#include "render/plugins.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace cuticle {

namespace {

constexpr ParamInfo kImageParams[] = {
    {"filename", "string", "", "the scene's name with .exr", "the picture's file, .exr or .png"},
    {"xresolution", "integer", "pixels", "1280", "width of the whole picture", 1},
    {"yresolution", "integer", "pixels", "720", "height of the whole picture", 1},
    {"cropwindow", "float", "", "0 1 0 1", "the part that is rendered: x0 x1 y0 y1, fractions of the picture",
     0, 1},
    {"scale", "float", "", "1", "a factor on the picture, above 0", 0, 1e12},
    {"maxsampleluminance", "float", "", "infinity", "brighter samples are darkened to it; above 0", 0},
    {"denoise", "bool", "", "false",
     "ours: the picture is smoothed where its samples show that it gets better by it (--denoise)"},
    {"diagonal", "float", "mm", "35", "of the film, for Camera \"realistic\""},
};

// To add a film: a row here, its class, and a table of makers in place of Film's constructor.
const PluginInfo kFilms[] = {{"image", kImageParams, "a picture of R, G and B"}};

} // namespace

const PluginTable &FilmPlugins() {
    static const PluginTable table{
        PluginKind::Film, {std::begin(kFilms), std::end(kFilms)}, {"rgb", "gbuffer", "spectral"}};
    return table;
}

// The scene's wish counts where the caller has none of his own, and does not ask for variances.
static bool WantsDenoising(const Entity &entity, const FilmOptions &options) {
    return options.denoise.value_or(!options.variance && entity.params.FindBool("denoise", false));
}

Film::Film(const Entity &entity, const FilmOptions &options) {
    ReadParams(entity, options);
    entity.params.ReportUnused("Film \"image\"");
    const bool denoise = WantsDenoising(entity, options);
    if (denoise && options.variance)
        throw Error(entity.params.loc, "a denoised picture has no variance of its pixels: they share samples")
            .WithRemedy("ask for one of the two");
    MakePixels(options.variance, denoise);
}

Point2i Film::WindowSizeOf(const Entity &entity, const FilmOptions &options) {
    Film film;
    film.ReadParams(entity, options);
    return film.WindowSize();
}

void Film::ReadParams(const Entity &entity, const FilmOptions &options) {
    const ParamSet &p = entity.params;
    if (entity.type != "image")
        throw Error(p.loc, "unknown film \"{}\"", entity.type)
            .WithRemedy(Suggestion(entity.type, &kFilms[0].name, 1));
    filename_ = p.FindString("filename", "");
    resolution_ = {p.FindInt("xresolution", 1280), p.FindInt("yresolution", 720)};
    if (const int n = options.Divisor(); n > 1)
        resolution_ = {std::max(1, resolution_.x / n), std::max(1, resolution_.y / n)};
    if (resolution_.x <= 0 || resolution_.y <= 0 || int64_t{resolution_.x} * resolution_.y > kMaxPixels)
        throw Error(p.loc, "a film of {} x {} pixels cannot be made", resolution_.x, resolution_.y)
            .WithRemedy("xresolution and yresolution must be positive, at most 2^28 pixels together");
    std::array<float, 4> crop{0, 1, 0, 1};
    const std::vector<float> given = p.FindFloats("cropwindow");
    if (given.size() == 4)
        std::copy(given.begin(), given.end(), crop.begin());
    else if (!given.empty())
        Warning(
            p.Find("cropwindow")->loc, "wrong number of values",
            fmt::format("\"cropwindow\" takes 4 numbers (x0 x1 y0 y1), not {}; it is ignored, as by pbrt-v3",
                        given.size()));
    SetWindow(p, options.crop.value_or(crop));
    scale_ = p.FindFloat("scale", 1);
    // A picture is held in binary32, and so are the samples that the scale multiplies
    if (!(scale_ > 0 && scale_ <= 1e12))
        throw Error(p.loc, "the film's \"scale\" must be above 0 and at most 1e12");
    maxLuminance_ = p.FindFloat("maxsampleluminance", Infinity);
    if (!(maxLuminance_ > 0))
        throw Error(p.loc, "the film's \"maxsampleluminance\" must be above 0");
    (void)p.FindBool("denoise", false);
    (void)p.FindFloat("diagonal", 35); // of the film in mm: only pbrt-v3's realistic camera uses it
}

void Film::MakePixels(bool variance, bool parts) {
    const Point2i size = WindowSize();
    pixels_.resize(static_cast<size_t>(size.x) * static_cast<size_t>(size.y));
    if (variance)
        squares_.resize(pixels_.size());
    if (parts)
        parts_.resize(pixels_.size());
}

void ClaimFilm(const Entity &entity, const FilmOptions &options) {
    const ParamSet &p = entity.params;
    const Point2i size{p.FindInt("xresolution", 1280), p.FindInt("yresolution", 720)};
    double pixels = double{1} * std::max(size.x, 0) * std::max(size.y, 0) /
                    (double{1} * options.Divisor() * options.Divisor());
    std::array<float, 4> crop{0, 1, 0, 1};
    if (const std::vector<float> given = p.FindFloats("cropwindow"); given.size() == 4)
        std::copy(given.begin(), given.end(), crop.begin());
    if (options.crop)
        crop = *options.crop;
    for (size_t i = 0; i < 4; i += 2)
        pixels *= std::abs(std::clamp(crop[i + 1], 0.f, 1.f) - std::clamp(crop[i], 0.f, 1.f));
    const bool denoise = WantsDenoising(entity, options);
    const double each = 56 + (options.variance ? 80 : 0) + (denoise ? 160 : 0);
    ClaimMemory(fmt::format("the film of {} x {} pixels{}", size.x, size.y,
                            options.variance ? " with variance"
                            : denoise        ? " to be denoised"
                                             : ""),
                static_cast<uint64_t>(std::min(pixels * each, 1e18)), p.loc);
}

size_t Film::Tiles() const {
    const auto along = [](int pixels) { return static_cast<size_t>((pixels + kFilmTile - 1) / kFilmTile); };
    return along(WindowSize().x) * along(WindowSize().y);
}

std::pair<Point2i, Point2i> Film::TileWindow(size_t tile) const {
    const int across = (WindowSize().x + kFilmTile - 1) / kFilmTile, number = static_cast<int>(tile);
    const Point2i min{min_.x + number % across * kFilmTile, min_.y + number / across * kFilmTile};
    return {min, {std::min(min.x + kFilmTile, max_.x), std::min(min.y + kFilmTile, max_.y)}};
}

// Finds the window of a crop in fractions of the picture, x0 x1 y0 y1. Throws Error where it holds no pixel.
void Film::SetWindow(const ParamSet &params, std::array<float, 4> crop) {
    for (size_t i = 0; i < 4; i += 2) {
        if (!std::isfinite(crop[i]) || !std::isfinite(crop[i + 1]))
            throw Error(params.loc, "the crop window holds a number that is not finite");
        if (crop[i] > crop[i + 1])
            std::swap(crop[i], crop[i + 1]);
        crop[i] = std::clamp(crop[i], 0.f, 1.f);
        crop[i + 1] = std::clamp(crop[i + 1], 0.f, 1.f);
    }
    // As pbrt-v3: a pixel belongs to the window that its lower corner lies in, so that adjoining windows tile
    const auto pixel = [](int resolution, float fraction) {
        return static_cast<int>(std::ceil(static_cast<float>(resolution) * fraction));
    };
    min_ = {pixel(resolution_.x, crop[0]), pixel(resolution_.y, crop[2])};
    max_ = {pixel(resolution_.x, crop[1]), pixel(resolution_.y, crop[3])};
    if (min_.x >= max_.x || min_.y >= max_.y)
        throw Error(params.loc, "the crop window holds no pixel")
            .WithRemedy("give x0 < x1 and y0 < y1 between 0 and 1");
}

std::string RenderIdentity::Difference(const RenderIdentity &other) const {
    const auto valueOf = [](const RenderIdentity &identity, const std::string &name) {
        for (const auto &[n, value] : identity.facts)
            if (n == name)
                return value.empty() ? std::string("none") : value;
        return std::string("not known");
    };
    for (const RenderIdentity *identity : {this, &other})
        for (const auto &[name, ignored] : identity->facts)
            if (const std::string mine = valueOf(*this, name), its = valueOf(other, name); mine != its)
                return fmt::format("the {} is {}, not {}", name, its, mine);
    return "";
}

void Film::Expect(const RenderIdentity &render, const SampleRange &samples) {
    render_ = render;
    taken_ = {{samples, std::vector<uint32_t>(Tiles(), 0)}};
}

int Film::FewestDone() const {
    uint32_t fewest = std::numeric_limits<uint32_t>::max();
    for (size_t tile = 0; tile < Tiles(); ++tile) {
        uint32_t done = 0;
        for (const FilmRange &taken : taken_)
            done += taken.done[tile];
        fewest = std::min(fewest, done);
    }
    return static_cast<int>(fewest);
}

uint64_t Film::SamplesDone() const {
    uint64_t samples = 0;
    for (const FilmRange &taken : taken_)
        for (size_t tile = 0; tile < taken.done.size(); ++tile) {
            const auto [min, max] = TileWindow(tile);
            samples += static_cast<uint64_t>((max.x - min.x) * (max.y - min.y)) * taken.done[tile];
        }
    return samples;
}

uint64_t Film::LeftOut() const {
    uint64_t held = 0;
    for (const Pixel &pixel : pixels_)
        held += pixel.n;
    return SamplesDone() - std::min(held, SamplesDone());
}

// The factor by which the film's "maxsampleluminance" lets a sample in.
float Film::Darkening(const Spectrum &radiance) const {
    const float luminance = radiance.y();
    return luminance > maxLuminance_ ? maxLuminance_ / luminance : 1;
}

// squares: null where no variance is kept.
void Film::Add(const Spectrum &radiance, Pixel *pixel, Squares *squares) {
    for (size_t c = 0; c < 3; ++c) {
        const BinaryNumber v = BinaryNumber::Of(radiance.c[c]);
        pixel->sums.Add(c, v);
        if (squares)
            squares->Add(c, v.Squared());
    }
    ++pixel->n;
}

bool Film::Add(int x, int y, const Spectrum &radiance) {
    if (!radiance.IsFinite())
        return false;
    const size_t i = IndexOf(x, y);
    Add(radiance * Darkening(radiance), &pixels_[i], HasVariance() ? &squares_[i] : nullptr);
    return true;
}

FilmTile::FilmTile(const Film &film, size_t tile) : film_(film), number_(tile) {
    std::tie(min_, max_) = film.TileWindow(tile);
    pixels_.resize(static_cast<size_t>((max_.x - min_.x) * (max_.y - min_.y)));
    if (film.HasVariance())
        squares_.resize(pixels_.size());
    if (film.HasParts())
        parts_.resize(pixels_.size());
}

bool FilmTile::Add(int x, int y, const Spectrum &radiance) {
    DCHECK(parts_.empty());
    if (!radiance.IsFinite())
        return false;
    const size_t i = IndexOf(x, y);
    Film::Add(radiance * film_.Darkening(radiance), &pixels_[i], squares_.empty() ? nullptr : &squares_[i]);
    return true;
}

bool FilmTile::Add(int x, int y, const Spectrum &radiance, int sample, const Spectrum &direct) {
    if (!radiance.IsFinite() || !direct.IsFinite())
        return false;
    const size_t i = IndexOf(x, y);
    const float factor = film_.Darkening(radiance);
    Film::Add(radiance * factor, &pixels_[i], nullptr);
    const bool isEven = sample % 2 == 0;
    Film::Parts &parts = parts_[i];
    for (size_t c = 0; c < 3; ++c) {
        if (isEven)
            parts.sums.Add(c, BinaryNumber::Of(radiance.c[c] * factor));
        parts.sums.Add(c + (isEven ? 3 : 6), BinaryNumber::Of(direct.c[c] * factor));
    }
    parts.even += isEven ? 1 : 0;
    return true;
}

void Film::Join(const FilmTile &tile, int count) {
    size_t from = 0;
    for (int y = tile.min_.y; y < tile.max_.y; ++y)
        for (int x = tile.min_.x; x < tile.max_.x; ++x, ++from) {
            const size_t to = IndexOf(x, y);
            pixels_[to].sums.Add(tile.pixels_[from].sums);
            pixels_[to].n += tile.pixels_[from].n;
            if (HasVariance())
                squares_[to].Add(tile.squares_[from]);
            if (HasParts()) {
                parts_[to].sums.Add(tile.parts_[from].sums);
                parts_[to].even += tile.parts_[from].even;
            }
        }
    taken_.back().done[tile.number_] += static_cast<uint32_t>(count);
}

std::string Film::Difference(const Film &other) const {
    const auto shape = [](const Film &f) {
        return fmt::format("{} x {} pixels, window ({}, {}) to ({}, {}){}{}", f.resolution_.x,
                           f.resolution_.y, f.min_.x, f.min_.y, f.max_.x, f.max_.y,
                           f.HasVariance() ? ", with variance" : "", f.HasParts() ? ", to be denoised" : "");
    };
    if (shape(*this) != shape(other))
        return fmt::format("it has {}, not {}", shape(other), shape(*this));
    if (scale_ != other.scale_)
        return fmt::format("the film's scale is {}, not {}", other.scale_, scale_);
    if (maxLuminance_ != other.maxLuminance_)
        return fmt::format("the film's maxsampleluminance is {}, not {}", other.maxLuminance_, maxLuminance_);
    return render_.Difference(other.render_);
}

void Film::Merge(const Film &other) {
    if (const std::string difference = Difference(other); !difference.empty())
        throw Error("films of different renders cannot be merged: of one of them {}", difference);
    for (const FilmRange &a : taken_)
        for (const FilmRange &b : other.taken_)
            if (std::max(a.range.first, b.range.first) < std::min(a.range.last, b.range.last))
                throw Error("films that share samples cannot be merged: both hold sample {} of each pixel",
                            std::max(a.range.first, b.range.first));
    taken_.insert(taken_.end(), other.taken_.begin(), other.taken_.end());
    for (size_t i = 0; i < pixels_.size(); ++i) {
        pixels_[i].sums.Add(other.pixels_[i].sums);
        pixels_[i].n += other.pixels_[i].n;
        if (HasVariance())
            squares_[i].Add(other.squares_[i]);
        if (HasParts()) {
            parts_[i].sums.Add(other.parts_[i].sums);
            parts_[i].even += other.parts_[i].even;
        }
    }
}

Image Film::Develop() const {
    std::vector<std::string> channels{"R", "G", "B"};
    if (HasVariance())
        channels.insert(channels.end(), {"variance.R", "variance.G", "variance.B"});
    Image image(max_.x - min_.x, max_.y - min_.y, channels);
    image.fullWidth = resolution_.x;
    image.fullHeight = resolution_.y;
    image.cropX = min_.x;
    image.cropY = min_.y;
    size_t out = 0;
    for (size_t i = 0; i < pixels_.size(); ++i) {
        const double n = pixels_[i].n;
        std::array<double, 3> mean{};
        for (size_t c = 0; c < 3; ++c) {
            mean[c] = n > 0 ? pixels_[i].sums.Value(c) / n : 0;
            image.data[out++] = static_cast<float>(scale_ * mean[c]);
        }
        if (!HasVariance())
            continue;
        for (size_t c = 0; c < 3; ++c) {
            // One sample tells nothing of the spread: infinite variance, so that no test trusts it
            const double v = n > 1 ? std::max(0.0, squares_[i].Value(c) / n - mean[c] * mean[c]) / (n - 1)
                                   : std::numeric_limits<double>::infinity();
            image.data[out++] = static_cast<float>(scale_ * scale_ * v);
        }
    }
    return image;
}

std::array<PartHalves, 2> Film::DevelopParts() const {
    CHECK(HasParts());
    std::array<PartHalves, 2> parts;
    for (PartHalves &part : parts)
        part.a.resize(pixels_.size()), part.b.resize(pixels_.size());
    for (size_t i = 0; i < pixels_.size(); ++i) {
        const Parts &p = parts_[i];
        const double counts[2] = {double(p.even), double(pixels_[i].n - p.even)};
        for (size_t c = 0; c < 3; ++c) {
            const double even = p.sums.Value(c);
            const double all[2] = {even, pixels_[i].sums.Value(c) - even};
            const double direct[2] = {p.sums.Value(c + 3), p.sums.Value(c + 6)};
            for (size_t half = 0; half < 2; ++half) {
                const size_t from = counts[half] > 0 ? half : 1 - half;
                const double factor = counts[from] > 0 ? scale_ / counts[from] : 0;
                (half ? parts[0].b : parts[0].a)[i].c[c] = static_cast<float>(factor * direct[from]);
                (half ? parts[1].b : parts[1].a)[i].c[c] =
                    static_cast<float>(factor * (all[from] - direct[from]));
            }
        }
    }
    return parts;
}

int Film::MinSamples() const {
    uint32_t n = std::numeric_limits<uint32_t>::max();
    for (const Pixel &pixel : pixels_)
        n = std::min(n, pixel.n);
    return static_cast<int>(n);
}

} // namespace cuticle
