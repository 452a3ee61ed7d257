// Films in files, and renders that go on from them: what a run that is killed leaves behind.
#include "render/film_file.h"

#include "core/error.h"
#include "core/sampling.h"
#include "files/file.h"
#include "files/inputs.h"
#include "message_of.h"
#include "render/job.h"
#include "render/plugins.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <unistd.h>
#include <vector>

namespace cuticle {
namespace {

namespace fs = std::filesystem;

// A sky, a light and hair, over tiles that are not all whole.
constexpr const char *kHairScene = R"(LookAt 0 0 3 0 0 0 0 1 0 Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 40 "integer yresolution" 37
PixelFilter "mitchell" Sampler "sobol" "integer pixelsamples" 24
WorldBegin LightSource "infinite" LightSource "point" "point from" [0 1 2] "rgb I" [40 1 2]
Material "hair" "float eumelanin" .3 Shape "groom" "string kind" "ball" "integer strands" 300
"float width" .03 WorldEnd)";

class FilmFileTest : public testing::Test {
  protected:
    FilmFileTest() : folder_(fs::path(testing::TempDir()) / fmt::format("cuticle_film_{}", ::getpid())) {
        fs::create_directories(folder_);
    }
    ~FilmFileTest() override { fs::remove_all(folder_); }
    std::string Path(const std::string &name) const { return (folder_ / name).string(); }
    // The bytes with the hash that belongs to them: what only a careful forger or a wrong program writes.
    static std::string Sealed(const std::string &bytes) {
        ContentHash hash;
        hash.Add(bytes);
        return bytes + hash.Hex();
    }
    std::string WhyRefused(const std::string &bytes) const {
        WriteFileAtomically(Path("wrong.part"), bytes);
        try {
            ReadFilm(Path("wrong.part"));
        } catch (const Error &e) {
            return e.what();
        }
        return "";
    }

  private:
    fs::path folder_;
};

// A film of 20 x 17 pixels, so of four tiles, with numbers of all sizes.
enum class Kind { Plain, Variance, Parts };
Film MadeFilm(Kind kind, SampleRange range) {
    const std::string text = "Film \"image\" \"integer xresolution\" 20 \"integer yresolution\" 17 "
                             "\"float scale\" .1 \"string filename\" \"odd \\\\ name\" WorldBegin WorldEnd";
    Film film(ParseSceneText(AllPlugins(), text, "film.pbrt").film,
              {.variance = kind == Kind::Variance, .denoise = kind == Kind::Parts});
    film.Expect({{{"scene", "a\nb\\c=d"}, {"nothing", ""}}}, range);
    RNG rng(static_cast<uint64_t>(range.first));
    for (size_t i = 0; i < film.Tiles(); ++i) {
        FilmTile tile(film, i);
        const int count = i == 2 ? 1 : range.Count(); // an interrupted pass
        for (int y = tile.Min().y; y < tile.Max().y; ++y)
            for (int x = tile.Min().x; x < tile.Max().x; ++x)
                for (int s = 0; s < count; ++s) {
                    const float value = std::pow(10.f, 60 * rng.UniformFloat() - 30);
                    const Spectrum light = x == 3 && s == 0
                                               ? Spectrum(std::numeric_limits<float>::quiet_NaN())
                                               : Spectrum(value, -value, 1);
                    if (kind == Kind::Parts)
                        tile.Add(x, y, light, range.first + s, light * 0.75f);
                    else
                        tile.Add(x, y, light);
                }
        film.Join(tile, count);
    }
    return film;
}

TEST_F(FilmFileTest, FilmsComeBackBitForBit) {
    for (const Kind kind : {Kind::Plain, Kind::Variance, Kind::Parts}) {
        Film film = MadeFilm(kind, {8, 12});
        film.Merge(MadeFilm(kind, {0, 3}));
        WriteFilm(Path("a.part"), film, {12.5, 7, 8});
        const StoredFilm back = ReadFilm(Path("a.part"));
        EXPECT_EQ(back.film.Difference(film), "");
        EXPECT_EQ(back.film.Develop().data, film.Develop().data);
        EXPECT_EQ(back.film.Filename(), film.Filename());
        EXPECT_EQ(back.film.Identity(), film.Identity());
        ASSERT_EQ(back.film.Taken().size(), 2u);
        for (size_t i = 0; i < 2; ++i) {
            EXPECT_EQ(back.film.Taken()[i].range, film.Taken()[i].range);
            EXPECT_EQ(back.film.Taken()[i].done, film.Taken()[i].done);
        }
        EXPECT_EQ(back.film.FewestDone(), 2);
        // Tiles of 16 x 16, 4 x 16, 16 x 1 and 4 x 1 pixels got 7, 7, 2 and 7 samples
        EXPECT_EQ(back.film.SamplesDone(), 256u * 7 + 64 * 7 + 16 * 2 + 4 * 7);
        EXPECT_EQ(back.film.LeftOut(), 17u * 2) << "one sample of each range in the column x = 3";
        EXPECT_EQ(back.tally.seconds, 12.5);
        EXPECT_EQ(back.tally.rays, 7u);
        EXPECT_EQ(back.tally.shadowRays, 8u);
        // What is read can be gone on with
        Film a = film, b = back.film;
        a.Merge(MadeFilm(kind, {20, 24}));
        b.Merge(MadeFilm(kind, {20, 24}));
        EXPECT_EQ(a.Develop().data, b.Develop().data);
        if (kind != Kind::Parts)
            continue;
        // In whatever order, the halves and the direct light are the same
        Film c = MadeFilm(kind, {20, 24});
        c.Merge(MadeFilm(kind, {0, 3})), c.Merge(MadeFilm(kind, {8, 12}));
        for (const Film *other : {&b, &c})
            for (size_t part = 0; part < 2; ++part) {
                EXPECT_EQ(other->DevelopParts()[part].a, a.DevelopParts()[part].a);
                EXPECT_EQ(other->DevelopParts()[part].b, a.DevelopParts()[part].b);
            }
        const auto parts = a.DevelopParts();
        EXPECT_FLOAT_EQ(parts[0].a[0].c[2], 0.75f * 0.1f) << "direct: three quarters of 1, scaled";
        EXPECT_FLOAT_EQ(parts[1].b[0].c[2], 0.25f * 0.1f);
    }
}

TEST_F(FilmFileTest, DamageIsAnErrorAndTakesNoMemory) {
    WriteFilm(Path("a.part"), MadeFilm(Kind::Variance, {0, 4}), {});
    const std::string good = ReadFile(Path("a.part"), "it");
    for (size_t n = 0; n < good.size(); n += 1 + n / 7)
        EXPECT_NE(WhyRefused(good.substr(0, n)), "") << n;
    for (size_t at = 0; at < good.size(); at += 1 + at / 9) {
        std::string wrong = good;
        wrong[at] ^= 1;
        EXPECT_NE(WhyRefused(wrong), "") << at;
    }
    EXPECT_NE(WhyRefused("cuticle film 1\n").find("another version"), std::string::npos);
    EXPECT_NE(WhyRefused("a picture").find("is no film"), std::string::npos);
    // With the right hash, it is what stands there that is judged
    const std::string unsealed = good.substr(0, good.size() - 32);
    const auto with = [&](const std::string &from, const std::string &to) {
        std::string wrong = unsealed;
        return Sealed(wrong.replace(wrong.find(from), from.size(), to));
    };
    EXPECT_EQ(WhyRefused(with("seconds=0", "seconds=9")), "");
    for (const auto &[from, to] : std::vector<std::pair<std::string, std::string>>{
             {"window=0 0 20 17", "window=0 0 16000 16000"},
             {"resolution=20 17", "resolution=2000000000 2000000000"},
             {"window=0 0 20 17", "window=-9 0 20 17"},
             {"window=0 0 20 17", "window=0 0 20"},
             {"window=0 0 20 17", "window=0 0 20 17 1"},
             {"range=0 4", "range=4 0"},
             {"range=0 4", "range=0 3"}, // a tile has got 4
             {"range=0 4", "range=0 99999999999"},
             {"variance=1", "variance=0"},
             {"parts=0", "parts=1"},
             {"seconds=0", "seconds"}})
        EXPECT_NE(WhyRefused(with(from, to)).find("is a damaged film"), std::string::npos) << to;
    // The first counter of the first pixel: more than four samples can add
    std::string wrong = unsealed;
    wrong[unsealed.find("\n\n") + 2 + 4 + 4 + 3 + 7] = 0x10;
    EXPECT_NE(WhyRefused(Sealed(wrong)).find("pixel (0, 0) holds what no samples make"), std::string::npos);
}

// Renders kHairScene; interrupts after so many tiles, and copies the part meanwhile as a kill would leave it.
class ResumeTest : public FilmFileTest {
  protected:
    ResumeTest()
        : description_(ParseSceneText(AllPlugins(), kHairScene, "hair.pbrt")), scene_(&description_, {}) {
        options_.variance = true;
        options_.checkpoints = Checkpoints{.filename = Path("a.part"), .resume = true, .afterStop = true};
    }
    JobResult Run() const { return RunJob(description_, scene_, options_); }
    // What a run without any interruption makes.
    JobResult Whole() const {
        JobOptions options = options_;
        options.checkpoints.reset();
        return RunJob(description_, scene_, options);
    }

    SceneDescription description_;
    Scene scene_;
    JobOptions options_;
};

struct StopAfter : ProgressSink {
    explicit StopAfter(int tiles) : left(tiles) {}
    void Report(uint64_t, uint64_t) override {
        if (--left <= 0)
            stop = true;
    }
    int left;
    std::atomic<bool> stop = false;
};

TEST_F(ResumeTest, StoppedRunsEndInTheSameBits) {
    const JobResult whole = Whole();
    RNG rng(5);
    int runs = 0;
    for (bool complete = false; !complete; ++runs) {
        ASSERT_LT(runs, 100);
        StopAfter stop(static_cast<int>(1 + rng.UniformUInt32() % 12));
        options_.progress = &stop;
        options_.interrupted = &stop.stop;
        options_.threads = 1 + static_cast<size_t>(runs) % 2;
        const JobResult job = Run();
        complete = job.complete;
        if (complete) {
            EXPECT_EQ(job.film.Develop().data, whole.film.Develop().data);
            EXPECT_EQ(job.rays.rays, whole.rays.rays);
            EXPECT_EQ(job.rays.shadowRays, whole.rays.shadowRays);
            EXPECT_EQ(job.SamplesReached(), 24);
        } else {
            // What an interrupted run claims is what every pixel has got
            EXPECT_EQ(job.SamplesReached(), job.film.MinSamples());
        }
    }
    EXPECT_GT(runs, 4); // 9 tiles, and at least 6 passes
}

TEST_F(ResumeTest, WhatAKillLeavesIsWhole) {
    const JobResult whole = Whole();
    struct Copy : ProgressSink {
        Copy(std::string f, std::string t, int n) : from(std::move(f)), to(std::move(t)), left(n) {}
        void Report(uint64_t, uint64_t) override {
            // The first part may be under way still when so many tiles are done
            if (--left <= 0 && !copied && fs::exists(from))
                copied = fs::copy_file(from, to, fs::copy_options::overwrite_existing);
        }
        std::string from, to;
        int left;
        bool copied = false;
    };
    for (const int tiles : {2, 5, 11, 23, 40}) {
        fs::remove(Path("a.part"));
        // With no time between two parts one is written after almost every tile, while the other thread goes
        // on
        options_.checkpoints->seconds = 1e-9;
        options_.threads = 2;
        size_t written = 0;
        options_.checkpoints->written = &written;
        Copy copy(Path("a.part"), Path("killed.part"), tiles);
        options_.progress = &copy;
        EXPECT_TRUE(Run().complete);
        EXPECT_GE(written, 2u); // how many more is a matter of the machine
        fs::rename(Path("killed.part"), Path("a.part"));
        EXPECT_LT(ReadFilm(Path("a.part")).film.FewestDone(), 24);
        options_.progress = nullptr;
        EXPECT_EQ(Run().film.Develop().data, whole.film.Develop().data) << tiles;
    }
}

TEST_F(ResumeTest, AnotherRenderIsRefused) {
    StopAfter stop(12);
    options_.progress = &stop;
    options_.interrupted = &stop.stop;
    options_.facts = {{"option --hair-model", "marschner"}};
    EXPECT_FALSE(Run().complete);
    const std::string before = ReadFile(Path("a.part"), "it");
    const JobOptions good = options_;
    const auto refused = [&](const std::string &why) {
        const std::string message = MessageOf([&] { Run(); });
        EXPECT_NE(message.find("a.part\" is a part of another render"), std::string::npos) << message;
        EXPECT_NE(message.find(why), std::string::npos) << message;
        options_ = good;
    };
    options_.seed = 7;
    refused("the seed is 0, not 7");
    options_.spp = 25;
    refused("the number of samples per pixel is 24, not 25");
    options_.integrator = "whitted";
    refused("the integrator is path, not whitted");
    options_.facts[0].second = "";
    refused("the option --hair-model is marschner, not none");
    options_.variance = false;
    refused("40 x 37 pixels");
    options_.film.crop = {0, 0.5f, 0, 1};
    refused("window (0, 0) to (20, 37)");
    options_.quick = true;
    options_.spp = 24;
    refused("40 x 37 pixels");
    options_.samples = SampleRange{0, 23};
    refused("it holds other samples");
    EXPECT_EQ(ReadFile(Path("a.part"), "it"), before);

    // Without the wish to go on, what was rendered is not thrown away
    options_.checkpoints->resume = false;
    EXPECT_NE(MessageOf([&] { Run(); }).find("holds 1 of 24 samples per pixel of this render already"),
              std::string::npos);
    // A part of something else is in nobody's way
    options_.seed = 7;
    options_.interrupted = nullptr;
    struct Sink : WarningSink {
        void Warn(const FileLoc &, const std::string &, const std::string &message) override {
            said += message;
        }
        std::string said;
    } sink;
    options_.warnings = &sink;
    EXPECT_TRUE(Run().complete);
    EXPECT_NE(sink.said.find("is a part of another render (the seed is 0, not 7)"), std::string::npos);
}

// A part that cannot be written is one warning and costs nothing.
TEST_F(ResumeTest, ThePartMayFail) {
    options_.checkpoints->filename = Path("no folder/a.part");
    options_.checkpoints->seconds = 1e-9;
    struct Sink : WarningSink {
        void Warn(const FileLoc &, const std::string &kind, const std::string &) override {
            EXPECT_EQ(kind, "part that cannot be written");
            said = true;
        }
        std::atomic<bool> said = false;
    } sink;
    options_.warnings = &sink;
    const JobResult job = Run();
    EXPECT_TRUE(job.complete);
    EXPECT_TRUE(sink.said);
    EXPECT_EQ(job.film.Develop().data, Whole().film.Develop().data);
}

} // namespace
} // namespace cuticle
