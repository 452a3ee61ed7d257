#include "scene/light_sampler.h"

#include "core/sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cuticle {

namespace {

constexpr double kEven = 0.1; // of the choice by power: this part is even
constexpr int kMaxDepth = 62; // of the tree: paths to lights are bits of a word

// Power as a number: the channels' mean joins in, so that a light whose luminance rounds to nothing is still
// a light. 0 for what is not finite.
double PowerOf(const Light &light) {
    const Spectrum p = light.Power();
    const double y = 0.9 * double{p.y()} + 0.1 * double{p[0] + p[1] + p[2]} / 3;
    return y > 0 && y < HUGE_VAL ? y : 0;
}

// The angle that two cones of directions with these half angles, and axes that lie `between` apart, are held
// by: half the width of both together.
double HalfAngleOfBoth(double a, double b, double between) {
    return std::min((a + b + between) / 2, double{Pi});
}

// Makes a bound that holds two.
EmissionBound Merge(const EmissionBound &a, const EmissionBound &b) {
    EmissionBound all = a;
    all.box.Extend(b.box);
    all.spread = std::max(a.spread, b.spread);
    all.twoSided = a.twoSided || b.twoSided;
    const bool aIsWide = a.normals >= b.normals;
    const EmissionBound &wide = aIsWide ? a : b, &narrow = aIsWide ? b : a;
    const Vector3d w(wide.axis), n(narrow.axis);
    const double between = std::acos(std::clamp(Dot(w, n), -1., 1.));
    if (std::min(between + double{narrow.normals}, double{Pi}) <= double{wide.normals}) {
        all.axis = wide.axis, all.normals = wide.normals;
        return all;
    }
    const double half = HalfAngleOfBoth(double{wide.normals}, double{narrow.normals}, between);
    const Vector3d across = n - w * Dot(w, n); // toward the narrow one
    all.axis = wide.axis, all.normals = Pi;
    if (half >= double{Pi} || !(across.LengthSquared() > 1e-12))
        return all;
    const double turn = half - double{wide.normals};
    all.axis = Vector3f(Normalize(w * std::cos(turn) + Normalize(across) * std::sin(turn)));
    all.normals = std::min(Pi, static_cast<float>(half) + 1e-4f); // what acos and rounding leave open
    return all;
}

// The solid angle that lights of this bound shine into, each direction of it weighed by the cosine beyond the
// normals (Conty Estevez and Kulla 2018, equation 1).
double EmissionMeasure(const EmissionBound &bound) {
    const double o = double{bound.normals}, e = std::min(o + double{bound.spread}, double{Pi});
    const double sides = bound.twoSided ? 2 : 1;
    return sides * (2 * kPi<double> * (1 - std::cos(o)) +
                    kPi<double> / 2 *
                        (2 * e * std::sin(o) - std::cos(o - 2 * e) - 2 * o * std::sin(o) + std::cos(o)));
}

// Estimates what it costs to hold lights in one node: their power, spread over places and directions.
double SplitCost(const EmissionBound &bound, double power) {
    return power > 0 ? power * double{bound.box.Diagonal().LengthSquared()} * EmissionMeasure(bound) : 0;
}

// The cosine and the sine of a - b for angles within [0, pi], of 0 where b is larger.
struct CosSin {
    float cos, sin;
};
CosSin Minus(CosSin a, CosSin b) {
    if (a.cos >= b.cos)
        return {1, 0};
    return {a.cos * b.cos + a.sin * b.sin, a.sin * b.cos - a.cos * b.sin};
}
float SinOf(float cosine) { return std::sqrt(std::max(0.f, 1 - Sqr(cosine))); }

} // namespace

LightSampler::LightSampler(const std::vector<const Light *> &lights) : lights_(lights.size()) {
    std::array<std::vector<double>, 3> power; // of the lights of a kind, in their order
    std::vector<Leaf> leaves;
    std::array<double, 3> sum{}, lit{};
    for (size_t i = 0; i < lights.size(); ++i) {
        const Light &light = *lights[i];
        const auto kind = static_cast<size_t>(light.Kind());
        lights_[i].kind = light.Kind();
        const double p = PowerOf(light);
        sum[kind] += p;
        lit[kind] += p > 0;
        if (light.Kind() != LightKind::Local) {
            discrete_[kind].lights.push_back(static_cast<uint32_t>(i));
            power[kind].push_back(p);
        } else if (p > 0) {
            EmissionBound bound = light.Bound();
            if (bound.box.IsEmpty())
                continue;
            leaves.push_back({static_cast<uint32_t>(i), static_cast<float>(p), bound, bound.box.Center()});
            lights_[i].probability = 1;
        }
    }
    MakeDiscrete(LightKind::Infinite, power[0]);
    MakeDiscrete(LightKind::Distant, power[1]);
    if (!leaves.empty()) {
        nodes_.reserve(2 * leaves.size() - 1);
        Build(leaves.data(), leaves.data() + leaves.size(), 0, 0);
    }
    const double allPower = sum[0] + sum[1] + sum[2], allLit = lit[0] + lit[1] + lit[2];
    for (size_t kind = 0; kind < 3; ++kind)
        if (lit[kind] > 0)
            powerShares_[kind] =
                static_cast<float>((1 - kEven) * sum[kind] / allPower + kEven * lit[kind] / allLit);
}

void LightSampler::MakeDiscrete(LightKind kind, const std::vector<double> &power) {
    Discrete &d = discrete_[static_cast<size_t>(kind)];
    double total = 0, lit = 0;
    for (const double p : power)
        total += p, lit += p > 0;
    d.cdf.assign(power.size() + 1, 0.f);
    double sum = 0;
    for (size_t i = 0; i < power.size(); ++i) {
        if (power[i] > 0)
            sum += (1 - kEven) * power[i] / total + kEven / lit;
        d.cdf[i + 1] = static_cast<float>(sum);
    }
    if (lit == 0)
        return;
    const float last = d.cdf.back(); // the last light that is lit takes what rounding left
    for (size_t i = power.size(); d.cdf[i] == last; --i)
        d.cdf[i] = 1;
    for (size_t i = 0; i < power.size(); ++i)
        lights_[d.lights[i]].probability = d.cdf[i + 1] - d.cdf[i];
}

LightSampler::Node LightSampler::MakeNode(const EmissionBound &bound, float power) {
    Node node;
    node.box = bound.box;
    node.power = power;
    node.axis = bound.axis;
    node.cosNormals = std::cos(bound.normals);
    node.sinNormals = std::sin(bound.normals);
    node.cosSpread = std::cos(bound.spread);
    node.twoSided = bound.twoSided;
    return node;
}

// Finds where to divide lights, at least two: by the least cost over the three axes in bins.
LightSampler::Leaf *LightSampler::Split(Leaf *begin, Leaf *end, const EmissionBound &all) {
    constexpr size_t kBins = 12;
    Bounds3f centers;
    for (const Leaf *leaf = begin; leaf != end; ++leaf)
        centers.Extend(leaf->center);
    const Vector3f size = centers.Diagonal(), whole = all.box.Diagonal();
    double best = std::numeric_limits<double>::infinity();
    int bestAxis = -1;
    size_t bestBin = 0;
    const auto binOf = [&](const Leaf &leaf, int axis) {
        const float x = (leaf.center[axis] - centers.pMin[axis]) / size[axis];
        return std::min(static_cast<size_t>(x * kBins), kBins - 1);
    };
    for (int axis = 0; axis < 3; ++axis) {
        if (!(size[axis] > 0))
            continue;
        struct Bin {
            EmissionBound bound;
            double power = 0;
            void Add(const EmissionBound &b, double p) {
                bound = power > 0 ? Merge(bound, b) : b;
                power += p;
            }
        };
        std::array<Bin, kBins> bins, fromRight;
        for (const Leaf *leaf = begin; leaf != end; ++leaf)
            bins[binOf(*leaf, axis)].Add(leaf->bound, double{leaf->power});
        Bin right;
        for (size_t i = kBins; i-- > 1;) {
            if (bins[i].power > 0)
                right.Add(bins[i].bound, bins[i].power);
            fromRight[i] = right;
        }
        Bin left;
        // A division across the long side is favoured, as thin boxes make poor bounds.
        const double regular = double{std::max({whole.x, whole.y, whole.z})} / double{whole[axis]};
        for (size_t i = 0; i + 1 < kBins; ++i) {
            if (bins[i].power > 0)
                left.Add(bins[i].bound, bins[i].power);
            const Bin &other = fromRight[i + 1];
            const double cost =
                regular * (SplitCost(left.bound, left.power) + SplitCost(other.bound, other.power));
            if (left.power > 0 && other.power > 0 && cost < best)
                best = cost, bestAxis = axis, bestBin = i;
        }
    }
    if (bestAxis < 0)
        return begin + (end - begin) / 2; // all at one place
    return std::partition(begin, end, [&](const Leaf &leaf) { return binOf(leaf, bestAxis) <= bestBin; });
}

uint32_t LightSampler::Build(Leaf *begin, Leaf *end, uint64_t path, int depth) {
    EmissionBound bound = begin->bound;
    double power = 0;
    for (const Leaf *leaf = begin; leaf != end; ++leaf) {
        bound = Merge(bound, leaf->bound);
        power += double{leaf->power};
    }
    const auto index = static_cast<uint32_t>(nodes_.size());
    nodes_.push_back(MakeNode(bound, static_cast<float>(power)));
    if (end - begin == 1) {
        nodes_[index].light = begin->light;
        lights_[begin->light].path = path;
        return index;
    }
    // Halves are the last resort against trees too deep for their paths: 2^31 lights are 31 halves.
    Leaf *middle = depth < kMaxDepth - 32 ? Split(begin, end, bound) : begin + (end - begin) / 2;
    Build(begin, middle, path, depth + 1);
    const uint32_t right = Build(middle, end, path | uint64_t{1} << depth, depth + 1);
    nodes_[index].right = right;
    return index;
}

// Bounds what the lights of a node may send to a receiver, up to a factor that all nodes share (Conty Estevez
// and Kulla 2018, equation 3). 0 only where no light of it arrives.
float LightSampler::Importance(const Node &node, const Receiver &receiver) {
    const Vector3f way = receiver.p - node.box.Center(); // toward the receiver
    const float d2 = way.LengthSquared(), r2 = node.box.Diagonal().LengthSquared() / 4;
    // Amid lights, a quarter of r2: with all of it, near lamps of many are found too seldom, and a sample of
    // 4,096 lamps in a cube has 15 times the variance (7.6 and .49; by power 41).
    const float farness = std::max({d2, r2 / 4, std::numeric_limits<float>::min()});
    if (!(d2 > r2)) // amid the lights nothing is known of directions
        return node.power / farness;
    const Vector3f w = way / std::sqrt(d2);
    const CosSin seen = {std::sqrt(1 - r2 / d2),
                         std::sqrt(r2 / d2)}; // half the angle that the box is seen under
    float cosAxis = Dot(node.axis, w);
    if (node.twoSided)
        cosAxis = std::abs(cosAxis);
    const CosSin beyond = Minus(Minus({cosAxis, SinOf(cosAxis)}, {node.cosNormals, node.sinNormals}), seen);
    if (beyond.cos < node.cosSpread - 1e-4f)
        return 0;
    float importance = node.power * std::max(beyond.cos, 1e-4f) / farness;
    if (receiver.n.LengthSquared() > 0) {
        // The shading normal may be turned far from this one, toward a light at its horizon.
        constexpr float kMinCosine = 0.2f;
        const float cosReceiver = std::min(1.f, AbsDot(receiver.n, w));
        importance *= std::max(Minus({cosReceiver, SinOf(cosReceiver)}, seen).cos, kMinCosine);
    }
    return importance;
}

// The probability of the left of two children; below 0 where neither can light the receiver.
float LightSampler::LeftShare(const Node *left, const Node *right, const Receiver &receiver) {
    const float a = Importance(*left, receiver), b = Importance(*right, receiver);
    if (!(a + b > 0))
        return -1;
    return a + b < Infinity ? a / (a + b) : 0.5f;
}

int LightSampler::SampleKind(LightKind kind, const Receiver &receiver, float u, float *probability) const {
    u = std::clamp(u, 0.f, OneMinusEpsilon);
    if (kind != LightKind::Local) {
        const Discrete &d = discrete_[static_cast<size_t>(kind)];
        if (d.cdf.empty() || d.cdf.back() == 0)
            return -1;
        const auto i =
            static_cast<size_t>(std::upper_bound(d.cdf.begin(), d.cdf.end(), u) - d.cdf.begin()) - 1;
        *probability = d.cdf[i + 1] - d.cdf[i];
        return static_cast<int>(d.lights[i]);
    }
    if (nodes_.empty())
        return -1;
    *probability = 1;
    size_t at = 0;
    while (nodes_[at].right != 0) {
        const float left = LeftShare(&nodes_[at + 1], &nodes_[nodes_[at].right], receiver);
        if (left < 0)
            return -1;
        if (u < left) {
            u = std::min(u / left, OneMinusEpsilon);
            *probability *= left;
            ++at;
        } else {
            u = std::clamp((u - left) / (1 - left), 0.f, OneMinusEpsilon);
            *probability *= 1 - left;
            at = nodes_[at].right;
        }
    }
    return static_cast<int>(nodes_[at].light);
}

int LightSampler::Sample(const LightShares &shares, const Receiver &receiver, float u,
                         float *probability) const {
    float before = 0;
    for (size_t kind = 0; kind < shares.size(); ++kind) {
        const float share = shares[kind];
        if (share > 0 && u < before + share) {
            const int light =
                SampleKind(static_cast<LightKind>(kind), receiver, (u - before) / share, probability);
            *probability *= share;
            return light;
        }
        before += share;
    }
    return -1;
}

float LightSampler::ProbabilityOfKind(const Receiver &receiver, size_t light) const {
    DCHECK_LT(light, lights_.size());
    const Entry &entry = lights_[light];
    if (entry.kind != LightKind::Local || entry.probability == 0)
        return entry.probability;
    float probability = 1;
    uint64_t path = entry.path;
    for (size_t at = 0; nodes_[at].right != 0; path >>= 1) {
        const float left = LeftShare(&nodes_[at + 1], &nodes_[nodes_[at].right], receiver);
        if (left < 0)
            return 0;
        const bool isRight = path & 1;
        probability *= isRight ? 1 - left : left;
        at = isRight ? nodes_[at].right : at + 1;
    }
    return probability;
}

} // namespace cuticle
