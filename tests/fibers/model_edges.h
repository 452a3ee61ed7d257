// Inputs at the edges of what models take, random ones between them, and what must hold of every answer: for
// the law "ends" of model_laws.h and for the endurance run of endurance.cpp.
#pragma once

#include "core/sampling.h"
#include "fibers/models.h"
#include "sampler_ends.h"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <string>

namespace cuticle::edges {

// A query is what one answer of a model depends on beside its parameters.
struct Query {
    float h;
    Vector3f wo, wi;
    std::array<float, 4> u;
};

// Numbers that begin and end the range of offsets.
inline constexpr float kEndsOfH[] = {-1, -OneMinusEpsilon, -0x1p-30f, 0, 0x1p-24f, OneMinusEpsilon, 1};

// The choices of one random number.
class Chooser {
  public:
    explicit Chooser(uint64_t seed) : rng_(MixBits(seed)) {}
    float Uniform() { return rng_.UniformFloat(); }
    float Between(float low, float high) { return low + (high - low) * Uniform(); }
    bool OneIn(uint32_t n) { return rng_.UniformUInt32() % n == 0; }
    uint32_t Below(uint32_t n) { return rng_.UniformUInt32() % n; }
    template <typename T, size_t n>
    T Of(const T (&values)[n]) {
        return values[Below(static_cast<uint32_t>(n))];
    }
    // Evenly over the magnitudes between two numbers above 0.
    float Magnitude(float low, float high) { return low * std::exp(Uniform() * std::log(high / low)); }

  private:
    RNG rng_;
};

// A unit vector: any; along an axis; close to one, by any power of ten; of a cosine that vanishes.
inline Vector3f EdgeDirection(Chooser &c) {
    const Vector3f any = UniformSampleSphere({c.Uniform(), c.Uniform()});
    switch (c.Below(8)) {
    case 0: {
        Vector3f axis(0, 0, 0);
        axis[static_cast<int>(c.Below(3))] = c.OneIn(2) ? 1.f : -1.f;
        return axis;
    }
    case 1:
        return Normalize(Vector3f(std::copysign(1.f, any.x), any.y * c.Magnitude(1e-30f, 1), any.z));
    case 2: {
        const float off = c.Magnitude(1e-38f, 1);
        return Normalize(Vector3f(std::copysign(1.f, any.x), off * any.y, off * any.z));
    }
    case 3:
        return Normalize(Vector3f(any.x * c.Magnitude(1e-30f, 1), any.y, any.z * c.Magnitude(1e-30f, 1)));
    default:
        return any;
    }
}
inline Query EdgeQuery(Chooser &c) {
    Query q;
    q.h = c.OneIn(4) ? c.Of(kEndsOfH) : c.Between(-1, 1);
    q.wo = EdgeDirection(c);
    q.wi = EdgeDirection(c);
    if (c.OneIn(4)) // the mirror direction, and all that lies near it
        q.wi = Vector3f(-q.wo.x, q.wo.y, c.OneIn(2) ? q.wo.z : -q.wo.z);
    for (float &u : q.u)
        u = c.OneIn(6) ? c.Of(kEndsOfU) : c.Uniform();
    return q;
}

// The common parameters of Material "hair", over all of the range that a scene may give them.
inline FiberInputs EdgeInputs(Chooser &c, const FiberModel &model) {
    FiberInputs at;
    const auto roughness = [&c] {
        constexpr float kEnds[] = {0, 1e-6f, 1e-3f, 0.01f, 1};
        return c.OneIn(4) ? c.Of(kEnds) : c.Uniform();
    };
    at.betaM = roughness(), at.betaN = roughness();
    const auto lowest = static_cast<float>(model.minEta);
    const float etas[] = {std::max(1.f, lowest), std::max(1.0001f, lowest), 3};
    at.eta = c.OneIn(4) ? c.Of(etas) : c.Between(std::max(1.f, lowest), 3);
    const bool grey = c.OneIn(2);
    for (float &s : at.sigmaA) {
        constexpr float kEnds[] = {0, 1e-30f, 1e6f, 1e18f, 1e38f};
        s = c.OneIn(5) ? c.Of(kEnds) : c.Magnitude(1e-3f, 30);
        if (grey)
            s = at.sigmaA[0];
    }
    constexpr float kTilts[] = {0, 90, -90, 180, 1e6f, 3.4e38f, -3.4e38f};
    at.alpha = c.OneIn(5) ? c.Of(kTilts) : c.Between(-10, 10);
    at.axis = c.OneIn(2) ? 0 : c.Between(-4, 4);
    at.pbrtV3 = c.OneIn(8);
    return at;
}

// A value of a model's own parameter, from its row: a choice, or a number of its range, often at an end.
inline OwnValue EdgeValue(Chooser &c, const ParamInfo &p) {
    if (p.type == "bool")
        return {p.name, c.OneIn(2)};
    if (p.type == "string" && p.choices.empty()) { // names with blanks between; some are refused
        constexpr std::string_view kOrders[] = {"R", "TT", "TRT", "R TRT", "R TT TRT", "TT TRT rest", "rest"};
        return {p.name, c.Of(kOrders)};
    }
    if (p.type == "string")
        return {p.name, p.choices[c.Below(static_cast<uint32_t>(p.choices.size()))]};
    const bool bounded = std::isfinite(p.low) && std::isfinite(p.high);
    const auto low = static_cast<float>(p.low), high = static_cast<float>(p.high);
    const auto number = [&]() -> float {
        if (!bounded && p.unit != "degrees" && c.OneIn(2))
            return c.Uniform();
        if (!bounded)
            return c.OneIn(8) ? c.Of({-1e6f, -180.f, -90.f, 0.f, 90.f, 1e6f}) : c.Between(-30, 30);
        if (c.OneIn(6))
            return c.OneIn(2) ? low : high;
        if (high <= 100)
            return c.Between(low, high);
        return std::max(low, c.Magnitude(0.3f, std::min(high, 60.f)));
    };
    if (p.type == "integer" && !p.defaultValue.empty() && high > 1000) // what costs time: few rays
        return {p.name, static_cast<int>(low) + static_cast<int>(c.Below(30))};
    if (p.type == "integer")
        return {p.name,
                static_cast<int>(low) + static_cast<int>(c.Below(static_cast<uint32_t>(high - low) + 1))};
    if (p.type == "spectrum texture")
        return {p.name, std::array{number(), number(), number()}};
    return {p.name, number()};
}
// Some of a model's own parameters, each given one time in three.
inline std::vector<OwnValue> EdgeOwn(Chooser &c, const FiberModel &model) {
    std::vector<OwnValue> own;
    for (const ParamInfo &p : model.params)
        if (c.OneIn(3) || (model.inCells && p.name == "samples")) // a table of the usual rays takes seconds
            own.push_back(EdgeValue(c, p));
    return own;
}

// Asks a model for a value and for a sample, and says what is wrong. Every number is finite and none is
// negative; a sample's direction is of unit length, and the model has value and density there.
inline std::string FaultAt(const FiberBxDF &fiber, const Query &q) {
    float pdf = 0;
    Spectrum f = fiber.FPdf(q.wo, q.wi, &pdf);
    if (std::string fault = FaultOf(f, pdf); !fault.empty())
        return "f: " + fault;
    Vector3f wi;
    f = fiber.Sample_f(q.wo, &wi, q.u, &pdf);
    if (std::string fault = FaultOf(f, pdf); !fault.empty())
        return "Sample_f: " + fault;
    if (pdf == 0)
        return f.IsBlack() ? "" : "Sample_f: no density, and a value";
    if (!(std::abs(wi.Length() - 1) < 1e-4f))
        return fmt::format("Sample_f: a direction of length {}", wi.Length());
    f = fiber.FPdf(q.wo, wi, &pdf);
    if (std::string fault = FaultOf(f, pdf); !fault.empty())
        return "f at the sample: " + fault;
    return {};
}

inline std::string Hex(float x) { return fmt::format("{:a}f", x); }
inline std::string Hex(const Vector3f &v) {
    return fmt::format("{{{}, {}, {}}}", Hex(v.x), Hex(v.y), Hex(v.z));
}
// The inputs as text of C++, to the last bit, for a test of their own.
inline std::string Text(const FiberInputs &at) {
    return fmt::format(
        "at.eta = {}, at.sigmaA = {{{}, {}, {}}}, at.betaM = {}, at.betaN = {}, at.alpha = {}, "
        "at.axis = {}, at.pbrtV3 = {};",
        Hex(at.eta), Hex(at.sigmaA[0]), Hex(at.sigmaA[1]), Hex(at.sigmaA[2]), Hex(at.betaM), Hex(at.betaN),
        Hex(at.alpha), Hex(at.axis), at.pbrtV3);
}
inline std::string Text(const std::vector<OwnValue> &own) {
    struct Value {
        std::string operator()(float x) const { return Hex(x); }
        std::string operator()(int x) const { return fmt::format("{}", x); }
        std::string operator()(bool x) const { return x ? "true" : "false"; }
        std::string operator()(std::string_view x) const { return fmt::format("\"{}\"", x); }
        std::string operator()(const std::array<float, 3> &x) const {
            return fmt::format("std::array{{{}, {}, {}}}", Hex(x[0]), Hex(x[1]), Hex(x[2]));
        }
    };
    std::string text = "{";
    for (const OwnValue &o : own)
        text += fmt::format("{}{{\"{}\", {}}}", text.size() > 1 ? ", " : "", o.name,
                            std::visit(Value(), o.value));
    return text + "}";
}
inline std::string Text(const Query &q) {
    return fmt::format("{{{}, {}, {}, {{{}, {}, {}, {}}}}}", Hex(q.h), Hex(q.wo), Hex(q.wi), Hex(q.u[0]),
                       Hex(q.u[1]), Hex(q.u[2]), Hex(q.u[3]));
}

} // namespace cuticle::edges
