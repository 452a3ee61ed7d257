// Relative error of renderings against the seconds that they take, by integrator, sampler, model of a fiber and samples.
#include "core/error.h"
#include "fibers/tabulated.h"
#include "figures/charts/charts.h"
#include "figures/charts/cost.h"
#include "images/compare.h"
#include "materials/hair_models.h"
#include "render/film.h"
#include "render/plugins.h"
#include "render/renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <spawn.h>
#include <sys/wait.h>

extern char **environ;

namespace cuticle {

namespace {

double SecondsSince(std::chrono::steady_clock::time_point from) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
}

// One way to render; empty: as the scene says.
struct Way {
    std::string name, integrator, sampler, model;
    int color;
    PlotDash dash;
};

struct Rendering {
    Image image;
    double seconds; // from the scene's file to the picture
};

// A scene that is read and built for one way to render it. Quick pictures are a quarter of the resolution each way.
class ReadyScene {
  public:
    ReadyScene(const std::string &file, const Way &way, bool quarter)
        : from_(std::chrono::steady_clock::now()), description_(ParseScene(AllPlugins(), file)),
          scene_(&description_, {.materials = {.hairModel = way.model}}) {
        if (!way.sampler.empty())
            description_.sampler.type = way.sampler;
        if (!way.integrator.empty())
            options_.integrator = way.integrator;
        options_.quick = quarter;
        seconds_ = SecondsSince(from_);
    }
    double Seconds() const { return seconds_; } // that this took
    // seconds: of the rendering alone.
    Rendering Picture(int spp, uint64_t seed) const {
        const auto from = std::chrono::steady_clock::now();
        RenderOptions options = options_;
        options.seed = seed;
        options.spp = options.quick ? 4 * spp : spp; // quick takes a quarter of the samples
        RenderStats stats;
        WarningLog warnings; // printed once a picture
        const WarningScope scope(&warnings);
        Image image = Render(description_, scene_, options, &stats);
        return {std::move(image), SecondsSince(from)};
    }

  private:
    std::chrono::steady_clock::time_point from_;
    SceneDescription description_;
    Scene scene_;
    RenderOptions options_;
    double seconds_ = 0;
};

// A word for sh that stands for itself.
std::string ShellWord(const std::string &text) {
    std::string word = "'";
    for (const char c : text)
        word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return word + "'";
}

// A temporary folder, removed with all that is in it.
class TemporaryFolder {
  public:
    TemporaryFolder() : path_((std::filesystem::temp_directory_path() / "cuticle-peer-XXXXXX").string()) {
        if (mkdtemp(path_.data()) == nullptr)
            throw Error("cannot make a temporary folder " + path_);
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder &) = delete;
    TemporaryFolder &operator=(const TemporaryFolder &) = delete;
    const std::string &Path() const { return path_; }

  private:
    std::string path_;
};

// Runs a command and waits for it; "" if it exits with status 0, else what became of it.
std::string RunByShell(std::string command) {
    std::string shell = "sh", option = "-c";
    char *const words[] = {shell.data(), option.data(), command.data(), nullptr};
    pid_t child = 0;
    int status = 0;
    if (posix_spawnp(&child, "sh", nullptr, nullptr, words, environ) != 0 ||
        waitpid(child, &status, 0) != child)
        return "cannot be run";
    if (WIFSIGNALED(status))
        return "was ended by signal " + std::to_string(WTERMSIG(status));
    return WEXITSTATUS(status) == 0 ? "" : "ended with status " + std::to_string(WEXITSTATUS(status));
}

std::string PixelsOf(int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height) + " pixels";
}

// Runs the other renderer on the scene and reads its picture. Throws Error, with the command, if it fails or leaves no
// picture of the size that the scene asks for.
Rendering RenderPeer(const Peer &peer, const std::string &file) {
    const TemporaryFolder folder;
    const std::string out = folder.Path() + "/picture.exr";
    std::string command = peer.command;
    for (const auto &[mark, text] :
         {std::pair("{scene}", std::filesystem::absolute(file).string()), std::pair("{out}", out)})
        for (size_t at = 0; (at = command.find(mark, at)) != std::string::npos;) {
            const std::string word = ShellWord(text);
            command.replace(at, std::string(mark).size(), word);
            at += word.size();
        }
    const auto refused = [&](const std::string &what) {
        return Error("the peer " + peer.name + " " + what + "; its command: " + command);
    };
    const auto from = std::chrono::steady_clock::now();
    if (const std::string failure = RunByShell(command); !failure.empty())
        throw refused(failure);
    const double seconds = SecondsSince(from);
    if (!std::filesystem::exists(out))
        throw refused("wrote no picture to {out}, an .exr file");
    Image image;
    try {
        image = ReadImage(out);
    } catch (const Error &e) {
        throw refused("wrote a picture that cannot be read (" + e.Message() + ")");
    }
    const Point2i asked = Film(ParseScene(AllPlugins(), file).film, {}).Resolution();
    if (image.width != asked.x || image.height != asked.y)
        throw refused("made a picture of " + PixelsOf(image.width, image.height) + ", the scene asks for " +
                      PixelsOf(asked.x, asked.y));
    return {std::move(image), seconds};
}

// Makes a logarithmic axis reach a little beyond these numbers.
void Stretch(PlotAxis *axis, const std::vector<double> &values) {
    for (const double v : values)
        if (v > 0 && std::isfinite(v)) {
            axis->min = std::min(axis->min.value_or(v / 1.2), v / 1.2);
            axis->max = std::max(axis->max.value_or(v * 1.2), v * 1.2);
        }
}

} // namespace

FigureData RenderChart(const FigureOptions &options) {
    // Other renderers make whole pictures; among ourselves small ones show the same, sooner. Our models stay among
    // themselves: each has a reference of its own.
    const bool quarter = options.peers.empty(), withModels = quarter && !options.quick;
    std::vector<Way> ways = {
        {"path", "path", "", "", 0, PlotDash::Solid},
        {"path, random sampler", "path", "random", "", 5, PlotDash::Dashed},
        {"directlighting", "directlighting", "", "", 1, PlotDash::Solid},
    };
    const int modelColors[] = {2, 3, 4, 6, 7};
    size_t models = 0;
    for (const std::string_view model : HairModelNames())
        if (model != "chiang" && withModels)
            ways.push_back({"path, " + std::string(model), "path", "", std::string(model),
                            modelColors[models++ % 5], PlotDash::DashDot});
    const std::vector<std::string> scenes = options.quick ? std::vector<std::string>{"curve-types"}
                                                          : std::vector<std::string>{"head-wavy", "fur-ball"};
    const std::vector<int> samples =
        options.quick ? std::vector<int>{1, 2, 4} : std::vector<int>{1, 2, 4, 8, 16};
    const int referenceSamples = 16 * samples.back(), rounds = options.quick ? 1 : 2;

    FigureData data{
        Table({"scene", "way", "spp", "relative_MSE", "seconds", "seconds_before_rendering"}), {}, "", {}};
    data.plot.width = 900, data.plot.height = 420;
    const auto fileOf = [&](const std::string &scene) { return options.scenes + "/" + scene + ".pbrt"; };
    // First of all, since they may fail. Each runs once.
    std::vector<Rendering> peerPictures;
    for (const std::string &scene : scenes)
        for (const Peer &peer : options.peers)
            peerPictures.push_back(RenderPeer(peer, fileOf(scene)));
    auto peerPicture = peerPictures.cbegin();
    for (const std::string &scene : scenes) {
        const std::string file = fileOf(scene);
        // Each model's own picture is its reference; integrators and samplers are held against path's.
        std::vector<Image> references;
        const size_t n = samples.size();
        std::vector<double> setUp(ways.size(), std::numeric_limits<double>::infinity()),
            rendering(ways.size() * n, std::numeric_limits<double>::infinity()), error(ways.size() * n);
        for (int round = 0; round < rounds; ++round)
            for (size_t w = 0; w < ways.size(); ++w) {
                FiberTable::Cached({}, 1); // a table held for the next scene is let go: each pays for its own
                const ReadyScene ready(file, ways[w], quarter);
                setUp[w] = std::min(setUp[w], ready.Seconds());
                if (round == 0) {
                    const bool own = references.empty() || !ways[w].model.empty();
                    references.push_back(own ? ready.Picture(referenceSamples, 1).image : references[0]);
                }
                for (size_t k = 0; k < n; ++k) {
                    const Rendering r = ready.Picture(samples[k], 0);
                    rendering[w * n + k] = std::min(rendering[w * n + k], r.seconds);
                    error[w * n + k] = Compare(r.image, references[w]).relativeMSE;
                }
            }

        PlotPanel panel;
        panel.title = scene;
        panel.right = 0.6;
        panel.x = {.label = "seconds", .log = true};
        panel.y = {.label = "relative MSE", .log = true};
        std::vector<CostPoint> points;
        for (size_t w = 0; w < ways.size(); ++w) {
            PlotSeries line;
            line.label = ways[w].name;
            line.style = PlotStyle::LinePoints;
            line.color = line.marker = ways[w].color;
            line.marker %= 7;
            line.dash = ways[w].dash;
            for (size_t k = 0; k < n; ++k) {
                const double s = setUp[w] + rendering[w * n + k], e = error[w * n + k];
                data.table.Add({scene, ways[w].name, static_cast<double>(samples[k]), e, s, setUp[w]});
                line.x.push_back(s), line.y.push_back(e);
                if (ways[w].model.empty())
                    points.push_back({ways[w].name, s, e, ways[w].color});
            }
            panel.series.push_back(line);
        }
        for (const Peer &peer : options.peers) {
            const Rendering &r = *peerPicture++;
            const Comparison comparison = Compare(r.image, references[0]);
            const double e = comparison.relativeMSE;
            if (comparison.badPixels > 0)
                data.note += PlainText(peer.name) + " has " + std::to_string(comparison.badPixels) + " of " +
                             scene + "'s pixels that are no numbers, which are left out. ";
            data.table.Add({scene, peer.name, NAN, e, r.seconds, NAN});
            PlotSeries point;
            point.label = PlainText(peer.name);
            point.style = PlotStyle::Points;
            point.x = {r.seconds}, point.y = {e};
            points.push_back({peer.name, r.seconds, e, 0});
            panel.series.push_back(point);
        }
        panel.series.push_back(ParetoSteps(points, 0, std::numeric_limits<double>::infinity()));
        for (const PlotSeries &series : panel.series) {
            Stretch(&panel.x, series.x);
            Stretch(&panel.y, series.y);
        }
        data.plot.panels.push_back(panel);

        // The error of independent samples falls as 1 / spp: the slope of the logarithms, by the ends.
        const double decades = std::log(static_cast<double>(samples.back()) / samples.front());
        data.checks.push_back({scene + ": with random samples the exponent of the error in spp is",
                               std::log(error[2 * n - 1] / error[n]) / decades, -1.3, -0.7});
        data.checks.push_back({scene + ": the scene's sampler has, of the random one's error,",
                               error[n - 1] / error[2 * n - 1], 0, 1.1});
        data.checks.push_back(
            {scene + ": direct light alone differs at most samples by more than path does, times",
             error[3 * n - 1] / error[n - 1], 1, std::numeric_limits<double>::infinity()});
    }
    data.note += Printed("References: path at %.0f samples, another seed; each model against its own. ",
                         referenceSamples) +
                 "The front is that of the scene's own model. Least times of " + std::to_string(rounds) +
                 (rounds == 1 ? " run." : " runs in turn.") +
                 (quarter ? " Pictures of a quarter of the scene's resolution each way." : "");
    return data;
}

} // namespace cuticle
