// The choice of a light: how often each kind is sampled, and which one of a kind.
#pragma once

#include "scene/light.h"

#include <array>
#include <vector>

namespace cuticle {

// How often a light of each kind (LightKind) is sampled at a hit. The shares are 0 or more and make at most 1
// together; for the rest no light is sampled, and only paths that run into lights by themselves find them.
using LightShares = std::array<float, 3>;

// Chooses one light of some at random. Infinite and distant ones: nine times in ten by power (CIE Y), else
// evenly among those that are not black, since power says little about the light that reaches a point. Local
// ones: down a binary tree, at each node by bounds of the light that may come from its children, which know
// power, distance, the side that lights shine to and the side that the receiver shows (Conty Estevez and
// Kulla, "Importance sampling of many lights with adaptive tree splitting", 2018, without the splitting).
class LightSampler {
  public:
    LightSampler() = default;
    // The lights must outlive the sampler. None of them need shine.
    explicit LightSampler(const std::vector<const Light *> &lights);

    bool Has(LightKind kind) const { return powerShares_[static_cast<size_t>(kind)] > 0; }
    // Shares by power and number, for whoever knows no better.
    const LightShares &SharesByPower() const { return powerShares_; }

    // A place where light is to arrive. n: the normal of a surface that is lit from both its sides, of unit
    // length; zero for a fiber, which is lit from all around.
    struct Receiver {
        Point3f p;
        Vector3f n;
    };
    // Chooses an index into lights, with its probability; -1 where none was chosen, or none can light this
    // point. u in [0,1).
    int Sample(const LightShares &shares, const Receiver &receiver, float u, float *probability) const;
    // The same among the lights of one kind.
    int SampleKind(LightKind kind, const Receiver &receiver, float u, float *probability) const;
    // The probability with which Sample chooses a light, to a rounding error.
    float Probability(const LightShares &shares, const Receiver &receiver, size_t light) const {
        DCHECK_LT(light, lights_.size());
        const float share = shares[static_cast<size_t>(lights_[light].kind)];
        return share > 0 ? share * ProbabilityOfKind(receiver, light) : 0;
    }
    // The probability with which SampleKind chooses a light among those of its kind.
    float ProbabilityOfKind(const Receiver &receiver, size_t light) const;

  private:
    // Cosines and sines of an EmissionBound; a leaf of the tree is one light.
    struct Node {
        Bounds3f box;
        float power = 0;
        Vector3f axis;
        float cosNormals = -1, sinNormals = 0, cosSpread = 0;
        bool twoSided = false;
        uint32_t right = 0; // the left child is the next node; 0: a leaf
        uint32_t light = 0; // of a leaf
    };
    struct Leaf {
        uint32_t light;
        float power;
        EmissionBound bound;
        Point3f center;
    };
    struct Entry {
        LightKind kind = LightKind::Local;
        float probability = 0; // among its kind; of a local light only whether it is lit
        uint64_t path = 0;     // of a local light: bit k is set where it lies right of the node of depth k
    };
    // Lights of a kind that is chosen alike everywhere.
    struct Discrete {
        std::vector<uint32_t> lights;
        std::vector<float> cdf; // cdf[i]: the sum over lights before i
    };

    void MakeDiscrete(LightKind kind, const std::vector<double> &power);
    uint32_t Build(Leaf *begin, Leaf *end, uint64_t path, int depth);
    static Leaf *Split(Leaf *begin, Leaf *end, const EmissionBound &all);
    static Node MakeNode(const EmissionBound &bound, float power);
    static float Importance(const Node &node, const Receiver &receiver);
    static float LeftShare(const Node *left, const Node *right, const Receiver &receiver);

    LightShares powerShares_{};
    std::array<Discrete, 2> discrete_; // infinite, distant
    std::vector<Entry> lights_;
    std::vector<Node> nodes_; // empty: no local light is lit
};

} // namespace cuticle
