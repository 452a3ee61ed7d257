//> Define the head
#include "grooms/head_shape.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

namespace {

// --- clay

//> Measure the distance to an ellipsoid
// First-order distance to an ellipsoid: the implicit function over its gradient's length.
float Ellipsoid(const Point3f &p, const Point3f &c, const Vector3f &r) {
    const Vector3f q = p - c;
    const Vector3f a{q.x / r.x, q.y / r.y, q.z / r.z};
    const Vector3f b{a.x / r.x, a.y / r.y, a.z / r.z};
    const float k = a.Length(), g = b.Length();
    if (!(g > 0))
        return -std::min(r.x, std::min(r.y, r.z));
    return k * (k - 1) / g;
}
//<

//> Measure the distance to a string of clay
// Capsule whose radius goes from ra at a to rb at b.
float Capsule(const Point3f &p, const Point3f &a, const Point3f &b, float ra, float rb) {
    const Vector3f ab = b - a, ap = p - a;
    const float t = std::clamp(Dot(ap, ab) / ab.LengthSquared(), 0.f, 1.f);
    return (ap - ab * t).Length() - Lerp(t, ra, rb);
}

// One knot of a string of clay.
struct Knot {
    Point3f p;
    float r;
};
template <size_t n>
float Chain(const Point3f &p, const std::array<Knot, n> &knots) {
    float d = Infinity;
    for (size_t i = 0; i + 1 < n; ++i)
        d = std::min(d, Capsule(p, knots[i].p, knots[i + 1].p, knots[i].r, knots[i + 1].r));
    return d;
}
//<

//> Join and carve with rounded edges
// Union that rounds the crease over a width of k (a quadratic blend).
float Join(float a, float b, float k) {
    const float h = std::max(k - std::abs(a - b), 0.f) / k;
    return std::min(a, b) - h * h * k * 0.25f;
}
float Carve(float a, float b, float k) { return -Join(-a, b, k); }
//<

//> Leave out what is too far off to matter
// Says whether clay within r of c, blended over k, could change the distance d at p.
bool Touches(const Point3f &p, const Point3f &c, float r, float d, float k) {
    return (p - c).LengthSquared() < Sqr(r + k + std::abs(d));
}
//<

//> Turn an ear's axes
// Turns a plane's coordinates by an angle that is given by its cosine and sine.
void Turn(float cosine, float sine, float *a, float *b) {
    const float x = *a;
    *a = cosine * x - sine * *b;
    *b = sine * x + cosine * *b;
}
//<

// --- the bust, on the side of +x (it is the same on both)

//> Model the skull
float Skull(const Point3f &p) {
    float d = Ellipsoid(p, {0, 3.1f, -0.9f}, {7.3f, 8.4f, 9.3f});        // cranium
    d = Join(d, Ellipsoid(p, {0, 4.6f, 1.8f}, {6.2f, 6.0f, 6.9f}), 3.f); // forehead
    if (!Touches(p, {0, -4.f, 3.f}, 7.6f, d, 2.6f))
        return d;
    d = Join(d, Ellipsoid(p, {0, -2.4f, 2.4f}, {5.7f, 7.2f, 6.0f}), 2.5f);               // face
    d = Join(d, Capsule(p, {4.3f, -5.0f, 0.9f}, {1.0f, -8.6f, 6.2f}, 1.2f, 1.2f), 2.2f); // jaw
    d = Join(d, Ellipsoid(p, {0, -8.9f, 6.8f}, {1.55f, 1.4f, 1.6f}), 1.6f);              // chin
    d = Join(d, Ellipsoid(p, {3.9f, -2.2f, 4.9f}, {2.1f, 1.8f, 2.0f}), 2.6f);            // cheekbone
    return Join(d, Ellipsoid(p, {0, -8.3f, 3.4f}, {2.8f, 1.5f, 4.f}), 2.f);              // under the chin
}
//<

//> Model an eye
float Eye(const Point3f &p, float d) {
    d = Carve(d, Ellipsoid(p, {3.0f, 0.35f, 9.4f}, {1.9f, 1.15f, 1.75f}), 1.3f);  // socket
    d = Join(d, Ellipsoid(p, {3.15f, 0.2f, 6.85f}, {1.45f, 1.14f, 1.27f}), 0.4f); // closed lids
    // The line where the lids meet, and the upper one's edge over it
    static constexpr std::array<Knot, 5> line{{{{1.75f, -0.1f, 7.75f}, 0.05f},
                                               {{2.3f, -0.38f, 8.0f}, 0.07f},
                                               {{3.1f, -0.52f, 8.12f}, 0.08f},
                                               {{3.9f, -0.4f, 7.85f}, 0.08f},
                                               {{4.6f, -0.05f, 7.2f}, 0.06f}}};
    d = Join(d, Chain(p - Vector3f{0, 0.1f, -0.04f}, line), 0.25f);
    return Carve(d, Chain(p + Vector3f{0, 0.1f, -0.04f}, line), 0.2f);
}
//<

//> Model the nose
float Nose(const Point3f &p, float d) {
    static constexpr std::array<Knot, 3> bridge{
        {{{0, 2.2f, 7.95f}, 0.6f}, {{0, 0.3f, 8.35f}, 0.52f}, {{0, -2.8f, 9.85f}, 0.66f}}};
    d = Join(d, Ellipsoid(p, {0, -2.5f, 8.5f}, {1.45f, 2.0f, 1.15f}), 1.f);
    d = Join(d, Chain(p, bridge), 1.0f);
    d = Join(d, Ellipsoid(p, {0, -3.15f, 10.05f}, {0.82f, 0.72f, 0.85f}), 0.5f);         // tip
    d = Join(d, Ellipsoid(p, {0.98f, -3.45f, 9.2f}, {0.6f, 0.58f, 0.85f}), 0.45f);       // wing
    return Carve(d, Ellipsoid(p, {0.55f, -4.15f, 9.55f}, {0.27f, 0.22f, 0.42f}), 0.25f); // nostril
}
//<

//> Model the mouth
float Mouth(const Point3f &p, float d) {
    d = Join(d, Ellipsoid(p, {0, -6.1f, 6.4f}, {2.9f, 2.5f, 2.6f}), 1.6f);              // muzzle
    d = Carve(d, Capsule(p, {0, -4.5f, 9.75f}, {0, -5.35f, 9.75f}, 0.2f, 0.26f), 0.5f); // philtrum
    static constexpr std::array<Knot, 4> upper{{{{0, -5.78f, 9.02f}, 0.36f},
                                                {{0.6f, -5.66f, 8.95f}, 0.38f},
                                                {{1.5f, -5.95f, 8.5f}, 0.26f},
                                                {{2.3f, -6.25f, 7.8f}, 0.1f}}};
    static constexpr std::array<Knot, 3> lower{
        {{{0, -6.72f, 8.72f}, 0.48f}, {{1.0f, -6.66f, 8.55f}, 0.4f}, {{2.2f, -6.3f, 7.8f}, 0.1f}}};
    static constexpr std::array<Knot, 4> line{{{{0, -6.23f, 9.35f}, 0.05f},
                                               {{0.6f, -6.16f, 9.2f}, 0.06f},
                                               {{1.5f, -6.26f, 8.75f}, 0.06f},
                                               {{2.45f, -6.25f, 7.95f}, 0.07f}}};
    d = Join(d, Chain(p, upper), 0.35f);
    d = Join(d, Chain(p, lower), 0.4f);
    return Carve(d, Chain(p, line), 0.3f);
}
//<

//> Model an ear
float Ear(const Point3f &p, float d) {
    // Its own axes: x forward, y up, z outward; tilted back and standing off behind
    Point3f q{p.z + 0.9f, p.y + 0.5f, p.x - 7.15f};
    Turn(0.981f, -0.195f, &q.x, &q.y);
    Turn(0.93f, -0.3676f, &q.x, &q.z);
    static constexpr std::array<Knot, 9> helix{{{{0.75f, 0.0f, 0.1f}, 0.16f},
                                                {{1.3f, 1.0f, 0.1f}, 0.22f},
                                                {{1.0f, 2.2f, 0.15f}, 0.25f},
                                                {{-0.1f, 2.85f, 0.2f}, 0.27f},
                                                {{-1.25f, 2.35f, 0.2f}, 0.27f},
                                                {{-1.75f, 1.1f, 0.2f}, 0.25f},
                                                {{-1.6f, -0.3f, 0.15f}, 0.23f},
                                                {{-1.05f, -1.6f, 0.1f}, 0.24f},
                                                {{-0.45f, -2.35f, 0.05f}, 0.3f}}};
    static constexpr std::array<Knot, 4> antihelix{{{{-0.2f, 1.7f, 0.05f}, 0.2f},
                                                    {{-0.9f, 0.7f, 0.12f}, 0.26f},
                                                    {{-0.85f, -0.6f, 0.12f}, 0.26f},
                                                    {{-0.25f, -1.5f, 0.1f}, 0.24f}}};
    float ear = Ellipsoid(q, {-0.15f, 0.1f, -0.2f}, {1.6f, 2.75f, 0.34f});
    ear = Join(ear, Chain(q, helix), 0.3f);
    ear = Join(ear, Chain(q, antihelix), 0.35f);
    ear = Join(ear, Ellipsoid(q, {-0.1f, -2.35f, 0}, {0.7f, 0.75f, 0.3f}), 0.4f);      // lobe
    ear = Carve(ear, Ellipsoid(q, {0.1f, -0.35f, 0.3f}, {0.7f, 0.95f, 0.5f}), 0.3f);   // bowl
    ear = Join(ear, Ellipsoid(q, {0.95f, -0.6f, 0.05f}, {0.38f, 0.55f, 0.32f}), 0.3f); // tragus
    return Join(d, ear, 0.55f);
}
//<

//> Model neck and shoulders
// Neck, shoulders and chest, with the shoulders cut as sculptors do.
float Body(const Point3f &p) {
    float d = Capsule(p, {0, -3.5f, -2.2f}, {0, -16.f, -3.0f}, 4.5f, 4.9f);
    d = Join(d, Ellipsoid(p, {0, -25.f, -3.0f}, {13.6f, 9.0f, 7.6f}), 5.f);                   // chest
    d = Join(d, Capsule(p, {2.2f, -12.f, -5.0f}, {12.4f, -19.4f, -4.4f}, 1.6f, 2.3f), 4.f);   // trapezius
    d = Join(d, Ellipsoid(p, {14.2f, -21.6f, -4.0f}, {3.7f, 4.5f, 4.0f}), 3.f);               // shoulder
    d = Join(d, Capsule(p, {14.6f, -22.4f, -4.0f}, {15.4f, -36.f, -4.f}, 3.4f, 3.2f), 2.f);   // arm
    d = Join(d, Capsule(p, {1.6f, -17.9f, 1.4f}, {12.5f, -18.2f, -1.6f}, 0.55f, 0.6f), 1.8f); // collarbone
    d = Join(d, Capsule(p, {4.3f, -7.f, -1.8f}, {1.9f, -17.0f, 1.3f}, 0.5f, 0.5f), 1.6f);     // neck muscle
    return d;
}
//<

} // namespace

//> Put the head together
float HeadDistance(const Point3f &place) {
    const Point3f p{std::abs(place.x), place.y, place.z};
    // The skull ends at y = -11, the body at 1: whichever is too far off to blend with the other is left out
    constexpr float k = 2.f, skullBottom = -11.f, bodyTop = 1.f;
    float d;
    if (p.y > -9.f) {
        d = Skull(p);
        if (p.y - bodyTop < d + k)
            d = Join(d, Body(p), k);
    } else {
        d = Body(p);
        if (skullBottom - p.y < d + k)
            d = Join(d, Skull(p), k);
    }
    if (Touches(p, {0, -2.6f, 7.6f}, 6.4f, d, 1.6f)) {
        d = Join(d, Capsule(p, {1.1f, 1.95f, 7.75f}, {4.4f, 2.15f, 6.1f}, 0.75f, 0.5f), 1.5f); // brow
        d = Mouth(p, Nose(p, Eye(p, d)));
    }
    if (Touches(p, {7.4f, -0.5f, -1.f}, 3.8f, d, 0.6f))
        d = Ear(p, d);
    return std::max(d, kHeadBottom - p.y);
}
//<

//> Find the normal of the head
Normal3f HeadNormal(const Point3f &p) {
    // Four places of a tetrahedron have the same sum of gradients as six along the axes
    constexpr float h = 0.02f;
    const float a = HeadDistance({p.x + h, p.y - h, p.z - h}), b = HeadDistance({p.x - h, p.y - h, p.z + h}),
                c = HeadDistance({p.x - h, p.y + h, p.z - h}), d = HeadDistance({p.x + h, p.y + h, p.z + h});
    const Vector3f g{a - b - c + d, c + d - a - b, b + d - a - c};
    const float length = g.Length();
    return length > 0 ? g / length : Vector3f{0, 1, 0}; // at an exact centre any direction leads out
}
//<

//> Push a point out of the head
Point3f PushOutOfHead(Point3f p, float offset) {
    // Near the surface two or three steps do it; from deep inside, where parts that blend lead one way and
    // the other, longer and longer ones.
    for (int i = 0; i < 64; ++i) {
        const float d = HeadDistance(p);
        if (d >= offset)
            break;
        p += HeadNormal(p) * ((offset - d + 1e-4f) * std::max(1.f, 0.15f * static_cast<float>(i)));
    }
    return p;
}
//<

} // namespace cuticle
//<
