//> Define normals of hair and how hair carries them
#include "volume/normals.h"

#include "core/check.h"

namespace cuticle {

//> Take the slope of the distance for a normal
Normal3f ShellNormal(const DenseGrid<float> &distance, const Point3f &p) {
    const Vector3f slope = SampleGradient(distance, p);
    return slope.LengthSquared() > 0 ? Normalize(slope) : Normal3f{};
}
//<

//> Turn by the smallest rotation
// Two mirrors make a rotation: one across a, which turns a round, and one across the bisector of a and b.
Vector3f TurnBySmallest(const Vector3f &a, const Vector3f &b, const Vector3f &about, const Vector3f &v) {
    const Vector3f sum = a + b;
    const float length = sum.LengthSquared();
    if (length < 1e-10f)
        return about * (2 * Dot(about, v)) - v;
    const Vector3f mirrored = v - a * (2 * Dot(a, v));
    return mirrored - sum * (2 * Dot(sum, mirrored) / length);
}
//<

//> Transport a frame along the strand
std::vector<Frame> TransportFrames(std::span<const Point3f> points, const Frame &root) {
    std::vector<Frame> frames(points.size(), root);
    Frame frame = root;
    for (size_t k = 0; k < points.size(); ++k) {
        const Vector3f d = k + 1 < points.size() ? points[k + 1] - points[k] : Vector3f{};
        if (const float length = d.Length(); length > 0) {
            const Vector3f x = d / length, about = frame.y;
            frame.y = TurnBySmallest(frame.x, x, about, frame.y);
            frame.z = TurnBySmallest(frame.x, x, about, frame.z);
            frame.x = x;
        }
        frames[k] = frame;
    }
    return frames;
}
//<

//> Carry normals from the rest pose
std::vector<Normal3f> CarryNormals(std::span<const Point3f> rest, std::span<const Normal3f> normals,
                                   std::span<const Point3f> posed, const Transform &head) {
    CHECK(rest.size() == normals.size() && rest.size() == posed.size());
    if (rest.empty())
        return {};
    // Any frame will do at the rest pose; the posed one is where the head takes it
    const std::vector<Frame> from = TransportFrames(rest, Frame{});
    const Frame &first = from.front();
    const Frame moved{Normalize(head.Vector(first.x)), Normalize(head.Vector(first.y)),
                      Normalize(head.Vector(first.z))};
    const std::vector<Frame> to = TransportFrames(posed, moved);
    std::vector<Normal3f> carried(normals.size());
    for (size_t k = 0; k < normals.size(); ++k)
        carried[k] = to[k].FromLocal(from[k].ToLocal(normals[k]));
    return carried;
}
//<

} // namespace cuticle
//<
