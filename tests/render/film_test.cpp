// Sums that depend on no order, and films that are rendered apart and merged.
#include "render/job.h"

#include "core/error.h"
#include "core/sampling.h"
#include "render/plugins.h"

#include <boost/multiprecision/cpp_dec_float.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>
#include <vector>

namespace cuticle {
namespace {

using Exact = boost::multiprecision::cpp_dec_float_50;

// Log-uniform numbers from 10^-exponents to 10^exponents, of either sign where asked for, and zeros.
std::vector<float> RandomNumbers(size_t count, double exponents, bool negative, RNG *rng) {
    std::vector<float> numbers(count);
    for (float &x : numbers) {
        const double u = rng->UniformFloat();
        x = static_cast<float>(std::pow(10, (2 * static_cast<double>(rng->UniformFloat()) - 1) * exponents));
        x = u < 0.05 ? 0 : negative && u < 0.5 ? -x : x;
    }
    return numbers;
}

// The sum of all numbers by parts of random length, each part summed in a random order, the parts merged two
// by two at random.
template <typename Sums, typename AddOne>
Sums SumOfParts(std::vector<float> numbers, const AddOne &addOne, RNG *rng) {
    const auto below = [&](size_t n) { return static_cast<size_t>(rng->UniformUInt32()) % n; };
    for (size_t i = numbers.size(); i > 1; --i)
        std::swap(numbers[i - 1], numbers[below(i)]);
    std::vector<Sums> parts;
    for (size_t i = 0; i < numbers.size();) {
        parts.emplace_back();
        for (size_t end = std::min(numbers.size(), i + 1 + below(1 + numbers.size() / 3)); i < end; ++i)
            addOne(&parts.back(), numbers[i]);
    }
    while (parts.size() > 1) {
        const size_t at = below(parts.size() - 1);
        parts[at].Add(parts[at + 1]);
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(at) + 1);
    }
    return parts[0];
}

template <size_t Bins, int Cut, typename Number>
void CheckSums(const Number &number) {
    using Sums = BinnedSums<1, Bins, Cut>;
    RNG rng(1);
    for (const double exponents : {3., 10., 30., 38.})
        for (const bool negative : {false, true})
            for (const size_t count : {2, 17, 1000}) {
                const std::vector<float> numbers = RandomNumbers(count, exponents, negative, &rng);
                const auto addOne = [&](Sums *sums, float x) { sums->Add(0, number(x)); };
                const Sums sums = SumOfParts<Sums>(numbers, addOne, &rng);
                Exact exact = 0, largest = 0;
                for (const float x : numbers) {
                    const BinaryNumber b = number(x);
                    const Exact size = ldexp(Exact(b.digits), b.exponent);
                    exact += b.negative ? Exact(-size) : size;
                    largest = max(largest, size);
                }
                // The stated bound: one last digit for each number, and the rounding to double
                const Exact bound =
                    static_cast<double>(count) * ldexp(largest, -39 * (static_cast<int>(Bins) - 1)) +
                    ldexp(abs(exact), -52);
                EXPECT_LE(abs(Exact(sums.Value(0)) - exact), bound) << count << " to 10^" << exponents;
                for (int repeat = 0; repeat < 10; ++repeat)
                    EXPECT_EQ(SumOfParts<Sums>(numbers, addOne, &rng), sums)
                        << count << " to 10^" << exponents;
            }
}

TEST(BinnedSums, DependOnNoOrderAndKeepTheirBound) {
    CheckSums<2, 16>([](float x) { return BinaryNumber::Of(x); });
    CheckSums<3, 32>([](float x) { return BinaryNumber::Of(x).Squared(); });
    CheckSums<2, 16>([](float x) { return BinaryNumber::Of(x * 1e-38f); }); // subnormal numbers among them
}

// Numbers as pictures have them are summed without any error but the last rounding.
TEST(BinnedSums, AreExactInTheRangeOfPictures) {
    RNG rng(2);
    const std::vector<float> numbers = RandomNumbers(1000, 4.8, true, &rng);
    BinnedSums<1, 2, 16> sums;
    Exact exact = 0;
    for (const float x : numbers) {
        sums.Add(0, BinaryNumber::Of(x));
        exact += Exact(x);
    }
    EXPECT_LE(abs(Exact(sums.Value(0)) - exact), ldexp(abs(exact), -52));
    // Opposite numbers cancel to nothing
    for (const float x : numbers)
        sums.Add(0, BinaryNumber::Of(-x));
    EXPECT_EQ(sums.Value(0), 0);
}

// The most that the counters must hold: 2^24 numbers whose digits are all ones.
TEST(BinnedSums, HoldAsManyNumbersAsAPixelMay) {
    const BinaryNumber ones = BinaryNumber::Of(0xffffffp-8f);
    BinnedSums<1, 2, 16> sums;
    BinnedSums<1, 3, 32> squares;
    sums.Add(0, ones);
    squares.Add(0, ones.Squared());
    for (uint32_t n = 1; n < sums.kMaxCount; n *= 2) {
        sums.Add(decltype(sums)(sums));
        squares.Add(decltype(squares)(squares));
    }
    EXPECT_EQ(sums.Value(0), 0xffffffp+16);
    EXPECT_EQ(squares.Value(0), 0xffffffp+8 * 0xffffffp+0);
}

Film MakeFilm(const std::string &parameters, const FilmOptions &options) {
    return Film(
        ParseSceneText(AllPlugins(), "Film \"image\" " + parameters + " WorldBegin WorldEnd", "film.pbrt")
            .film,
        options);
}

// Random samples, in random parts: one picture bit for bit, with its variances, near to what 50 digits say.
TEST(Film, PartsMergeToTheWhole) {
    const std::string size = "\"integer xresolution\" 3 \"integer yresolution\" 2";
    const FilmOptions options{.variance = true};
    constexpr size_t kSamples = 300;
    RNG rng(3);
    std::vector<std::vector<float>> samples(6);
    for (auto &s : samples)
        s = RandomNumbers(kSamples, 30, true, &rng);
    const auto takeRange = [&](size_t first, size_t last) {
        Film film = MakeFilm(size, options);
        film.Expect({{{"scene", "random"}}}, {static_cast<int>(first), static_cast<int>(last)});
        for (size_t pixel = 0; pixel < samples.size(); ++pixel)
            for (size_t s = first; s < last; ++s) {
                const float x = samples[pixel][s];
                EXPECT_TRUE(film.Add(static_cast<int>(pixel % 3), static_cast<int>(pixel / 3),
                                     Spectrum(x, -x, samples[pixel][kSamples - 1 - s])));
            }
        return film;
    };
    const Image whole = takeRange(0, kSamples).Develop();
    ASSERT_EQ(whole.Channels(), 6u);
    for (int repeat = 0; repeat < 20; ++repeat) {
        std::vector<size_t> cuts{0, kSamples};
        while (cuts.size() < 9)
            cuts.push_back(rng.UniformUInt32() % kSamples);
        std::sort(cuts.begin(), cuts.end());
        std::vector<Film> parts;
        for (size_t i = 0; i + 1 < cuts.size(); ++i)
            parts.insert(parts.begin() +
                             static_cast<std::ptrdiff_t>(rng.UniformUInt32() % (parts.size() + 1)),
                         takeRange(cuts[i], cuts[i + 1]));
        while (parts.size() > 1) {
            const size_t at = rng.UniformUInt32() % (parts.size() - 1);
            parts[at].Merge(parts[at + 1]);
            parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(at) + 1);
        }
        EXPECT_EQ(parts[0].MinSamples(), static_cast<int>(kSamples));
        EXPECT_EQ(parts[0].Develop().data, whole.data);
    }
    for (size_t pixel = 0; pixel < samples.size(); ++pixel) {
        Exact sum = 0, squares = 0, largest = 0;
        for (const float x : samples[pixel]) {
            sum += Exact(x);
            squares += Exact(x) * Exact(x);
            largest = max(largest, Exact(abs(Exact(x))));
        }
        const int x = static_cast<int>(pixel % 3), y = static_cast<int>(pixel / 3);
        const Exact n = kSamples, mean = sum / n, variance = (squares / n - mean * mean) / (n - 1);
        const Exact meanError = ldexp(largest, -39) + ldexp(abs(mean), -24);
        EXPECT_LE(abs(Exact(whole.At(x, y, 0)) - mean), meanError);
        EXPECT_EQ(whole.At(x, y, 1), -whole.At(x, y, 0));
        // Variances beyond binary32 are infinite there
        if (variance < Exact(std::numeric_limits<float>::max()))
            EXPECT_LE(abs(Exact(whole.At(x, y, 3)) - variance),
                      (2 * abs(mean) * meanError + ldexp(squares / n, -50)) / (n - 1) + ldexp(variance, -24));
        else
            EXPECT_EQ(whole.At(x, y, 3), std::numeric_limits<float>::infinity());
    }
}

TEST(Film, RefusesToMergeWhatIsNotOnePicture) {
    const RenderIdentity render{{{"scene", "a"}, {"seed", "1"}}};
    const auto film = [&](int width, const FilmOptions &options, const RenderIdentity &identity,
                          SampleRange samples, const std::string &more = "") {
        Film f = MakeFilm("\"integer xresolution\" " + std::to_string(width) + " \"integer yresolution\" 4 " +
                              more,
                          options);
        f.Expect(identity, samples);
        return f;
    };
    Film good = film(4, {}, render, {0, 8});
    for (int x = 0; x < 4; ++x)
        for (int y = 0; y < 4; ++y)
            good.Add(x, y, Spectrum(1));
    const auto before = good.Develop().data;
    const std::array<float, 4> half{0, 0.5f, 0, 1};
    const Film wrong[] = {film(8, {}, render, {8, 16}),
                          film(4, {.crop = half}, render, {8, 16}),
                          film(4, {.variance = true}, render, {8, 16}),
                          film(4, {}, {{{"scene", "b"}, {"seed", "1"}}}, {8, 16}),
                          film(4, {}, {{{"scene", "a"}, {"seed", "2"}}}, {8, 16}),
                          film(4, {}, {{{"scene", "a"}}}, {8, 16}),
                          film(4, {}, {{{"scene", "a"}, {"seed", "1"}, {"more", "x"}}}, {8, 16}),
                          film(4, {}, render, {8, 16}, "\"float scale\" 2"),
                          film(4, {}, render, {8, 16}, "\"float maxsampleluminance\" 2"),
                          film(4, {}, render, {7, 16})};
    for (const Film &other : wrong)
        EXPECT_THROW(good.Merge(other), Error) << &other - wrong;
    EXPECT_EQ(good.Develop().data, before);
    good.Merge(film(4, {}, render, {8, 16}));
    EXPECT_THROW(good.Merge(film(4, {}, render, {15, 16})), Error);
}

// Ranges of one render, taken by jobs of their own and merged in every order, are the render itself.
TEST(Job, RangesMergeToTheWhole) {
    SceneDescription description =
        ParseSceneText(AllPlugins(), R"(LookAt 0 0 3 0 0 0 0 1 0 Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 33 "integer yresolution" 20
PixelFilter "mitchell" Sampler "sobol" "integer pixelsamples" 64
WorldBegin LightSource "infinite" LightSource "point" "point from" [0 1 2] "rgb I" [40 1 2]
Material "hair" "float eumelanin" .3 Shape "groom" "string kind" "ball" "integer strands" 300
"float width" .03 WorldEnd)",
                       "hair.pbrt");
    const Scene scene(&description, SceneOptions());
    const auto take = [&](int first, int last, int threads) {
        JobOptions options;
        options.samples = SampleRange{first, last};
        options.variance = true;
        options.threads = threads;
        return RunJob(description, scene, options).film;
    };
    const Film whole = take(0, 64, 2);
    const Film parts[] = {take(0, 8, 1), take(8, 32, 2), take(32, 64, 1)};
    std::array<size_t, 3> order{0, 1, 2};
    do {
        Film merged = parts[order[0]];
        merged.Merge(parts[order[1]]);
        merged.Merge(parts[order[2]]);
        EXPECT_EQ(merged.Develop().data, whole.Develop().data);
        Film last = parts[order[1]];
        last.Merge(parts[order[2]]);
        merged = parts[order[0]];
        merged.Merge(last);
        EXPECT_EQ(merged.Develop().data, whole.Develop().data);
    } while (std::next_permutation(order.begin(), order.end()));
}

} // namespace
} // namespace cuticle
