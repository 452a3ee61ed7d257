#include "render/renderer.h"

#include "core/parallel.h"
#include "render/guides.h"

#include <filesystem>

namespace cuticle {

namespace {

ImageAttribute TextAttribute(const std::string &s) {
    ImageAttribute a;
    a.text = s;
    return a;
}
ImageAttribute NumberAttribute(double v) {
    ImageAttribute a;
    a.kind = ImageAttribute::Kind::Number;
    a.number = v;
    return a;
}
// OpenEXR and pbrt multiply row vectors from the left: their matrix is the transpose of ours.
ImageAttribute MatrixAttribute(const Transform &t) {
    ImageAttribute a;
    a.kind = ImageAttribute::Kind::Matrix;
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j)
            a.matrix[4 * i + j] = static_cast<float>(t.M()[j][i]);
    return a;
}

// So many rays look at each pixel for guides, for each of its samples, within bounds. One costs a tenth of a
// sample.
constexpr int kGuideRays = 4, kMinGuideRays = 16, kMaxGuideRays = 64;

// Denoises a film's picture. The means of its samples stay as channels unfiltered.R, .G and .B. Returns what
// was found.
std::string DenoiseImage(const JobResult &job, const Scene &scene, const Filter &filter, uint64_t seed,
                         Image *image) {
    const Film &film = job.film;
    if (film.MinSamples() < 2) // the render was stopped
        return "not denoised, as some pixels have one sample alone";
    const int rays = std::clamp(kGuideRays * std::min(job.spp, kMaxGuideRays), kMinGuideRays, kMaxGuideRays);
    const Guides guides =
        SeeGuides(scene, job.camera, filter, {film.WindowMin(), film.WindowMax(), rays, seed});
    const DenoisedPicture denoised = Denoise({image->width, image->height}, film.DevelopParts(), &guides);
    Image both(image->width, image->height, {"R", "G", "B", "unfiltered.R", "unfiltered.G", "unfiltered.B"});
    both.fullWidth = image->fullWidth, both.fullHeight = image->fullHeight;
    both.cropX = image->cropX, both.cropY = image->cropY;
    for (size_t i = 0; i < denoised.picture.size(); ++i)
        for (size_t c = 0; c < 3; ++c) {
            both.data[6 * i + c] = denoised.picture[i].c[c];
            both.data[6 * i + 3 + c] = image->data[3 * i + c];
        }
    *image = std::move(both);
    return denoised.Words();
}

} // namespace

std::string DefaultOutput(const SceneDescription &description) {
    std::string name = description.film.params.FindString("filename", "");
    if (!name.empty())
        return name;
    std::filesystem::path p = std::filesystem::path(description.filename).filename();
    if (p.extension() == ".gz")
        p.replace_extension();
    return p.replace_extension(".exr").string();
}

Image Render(const SceneDescription &description, const Scene &scene, const RenderOptions &options,
             RenderStats *stats) {
    const JobResult job = RunJob(description, scene, options);
    if (stats) {
        stats->renderSeconds = job.seconds;
        stats->spp = job.samples.Count();
        stats->sppReached = job.SamplesReached();
        stats->width = job.film.Resolution().x;
        stats->height = job.film.Resolution().y;
        stats->threads = job.threads;
        stats->rays = job.rays.rays;
        stats->shadowRays = job.rays.shadowRays;
        stats->learned = job.learned;
        stats->nanSamples = job.nanSamples;
    }
    Image image = job.film.Develop();
    if (job.film.HasParts()) {
        std::string words;
        OnThreads(options.threads, [&] {
            words = DenoiseImage(job, scene, MakeFilter(description.filter), options.seed, &image);
        });
        image.attributes["denoised"] = TextAttribute(words);
        if (stats)
            stats->denoised = words;
    }
    image.attributes["scene"] =
        TextAttribute(std::filesystem::path(description.filename).filename().string());
    image.attributes["version"] = TextAttribute(CUTICLE_VERSION);
    image.attributes["spp"] = NumberAttribute(job.SamplesReached());
    image.attributes["seed"] = NumberAttribute(static_cast<double>(options.seed));
    image.attributes["renderTime"] = NumberAttribute(job.seconds);
    const Transform &worldToCamera = job.camera.WorldToCamera();
    image.attributes["worldToCamera"] = MatrixAttribute(worldToCamera);
    if (job.camera.HasCameraToScreen())
        image.attributes["worldToScreen"] = MatrixAttribute(job.camera.CameraToScreen() * worldToCamera);
    return image;
}

} // namespace cuticle
