//> Step springs explicitly
// The paper's key hairs (Petrovic, Henne and Anderson 2005, section 5): point masses joined by springs, many
// small explicit steps. The plain sibling of the rods, to compare with.
#include "dynamics/strand.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cuticle {

namespace {

//> Choose the stiffness of springs
// A spring to the point `span` ahead, at rest at `length`, with a stiffness per mass a length (1/s^2 cm).
struct HairSpring {
    size_t from, span;
    double length, stiffness;
};

// sin2: of half the angle by which the strand is bent at rest. Straight hair would ask for infinite springs.
double SpringStiffness(double rigidity, double edge, double sin2) {
    constexpr double kMinSin2 = 0.03; // a bend of 20 degrees
    return rigidity / (edge * edge * edge * std::max(sin2, kMinSin2));
}
//<

//> Keep a point of springs on its side of a plane
// The plane through `at` moves with the body's velocity there; points beyond it are put on it, lose the
// velocity into it and, by friction, some of that along it.
struct SpringContact {
    bool isNear = false;
    Vector3d normal, carried, at;
    void Stop(double time, double friction, Vector3d *x, Vector3d *v) const {
        const double inside = Dot(normal, at + carried * time - *x);
        if (!(inside > 0))
            return;
        *x += normal * inside;
        const Vector3d relative = *v - carried;
        const double into = std::max(0., -Dot(normal, relative));
        const Vector3d slip = relative - normal * Dot(normal, relative);
        const double speed = slip.Length(), kept = speed > 0 ? std::max(0., 1 - friction * into / speed) : 0;
        *v = carried + slip * kept + normal * std::max(0., Dot(normal, relative));
    }
};
//<

} // namespace

//> Put a strand where its springs went
// tangents: of the edges before, from which directors are carried along.
void KeyStrands::PutSprings(size_t s, std::span<const Vector3d> x, std::span<const Vector3d> v,
                            std::span<const Vector3d> tangents) {
    const size_t n = points_;
    for (size_t i = 0; i < n; ++i) {
        Set(&x_, n, s, i, x[i]);
        Set(&v_, n, s, i, v[i]);
        Set(&vBefore_, n, s, i, v[i]);
    }
    for (size_t j = 0; j + 1 < n; ++j) {
        const Vector3d t = Normalize(x[j + 1] - x[j]);
        Set(&director_, n, s, j, rods::AcrossUnit(rods::Transport(Director(s, j), tangents[j], t), t));
    }
}
//<

//> Join a strand by springs
// h: the small step (s), which bounds every stiffness.
void KeyStrands::StepSprings(size_t s, double dt, const Pose &before, const Pose &pose,
                             const Obstacle &obstacle) {
    const size_t n = points_, steps = std::max<size_t>(physics_.springSteps, 1);
    const double h = dt / static_cast<double>(steps);
    std::vector<HairSpring> springs;
    for (size_t i = 0; i < n; ++i)
        for (size_t span = 1; span <= 3 && i + span < n; ++span) {
            const double edge = EdgeLength(s, i),
                         length = (RestPosition(s, i + span) - RestPosition(s, i)).Length();
            const double whole = edge * static_cast<double>(span),
                         sin2 = 1 - std::min(1., Sqr(length / whole));
            const double wanted = span == 1   ? physics_.stretch / edge
                                  : span == 2 ? SpringStiffness(physics_.bending, edge, sin2)
                                              : SpringStiffness(physics_.twist, edge, sin2) / 9;
            const double stable = Mass(s, std::min(i, n - 2)) / (h * h);
            const double bearable = (span == 1 ? 0.2 : 0.03) * stable;
            springs.push_back(
                {i, span, length, physics_.springsAsPrinted ? wanted : std::min(wanted, bearable)});
        }
    std::vector<Vector3d> x(n), v(n), force(n), tangents(n);
    for (size_t i = 0; i < n; ++i) {
        x[i] = Position(s, i), v[i] = Velocity(s, i);
        Set(&xBefore_, n, s, i, x[i]);
        if (i > 0)
            tangents[i - 1] = Normalize(x[i] - Position(s, i - 1));
    }
    //> Put a plane beside each point that is near the obstacle
    std::vector<SpringContact> planes(n);
    for (size_t i = physics_.fixed; i < n; ++i) {
        const Vector3d local = before.LocalPoint(x[i]);
        const double distance = CachedDistance(s * n + i, local, contacts_[s * n + i].clearance, obstacle);
        const Vector3d carried = (pose.Point(local) - before.Point(local)) / dt;
        if (distance < 1 + ((v[i] - carried) * dt).Length()) {
            const Vector3d normal = before.Direction(obstacle.Normal(local));
            planes[i] = {true, normal, carried,
                         x[i] - normal * (obstacle.Distance(local) - contacts_[s * n + i].clearance)};
        }
    }
    //<
    //> Go many small steps
    for (size_t step = 1; step <= steps; ++step) {
        const double f = static_cast<double>(step) / static_cast<double>(steps);
        std::fill(force.begin(), force.end(), Vector3d{});
        for (const HairSpring &spring : springs) {
            const Vector3d e = x[spring.from + spring.span] - x[spring.from];
            const double length = std::max(e.Length(), 1e-9);
            const Vector3d along = e / length;
            const double rate = Dot(v[spring.from + spring.span] - v[spring.from], along);
            const double damped = std::min(physics_.damping, h) * rate; // as much as a step can take
            const Vector3d pull = along * (spring.stiffness * (length - spring.length + damped));
            force[spring.from] += pull, force[spring.from + spring.span] -= pull;
        }
        for (size_t i = 0; i < n; ++i) {
            if (i < physics_.fixed) { // on the way from where it was to where it ends
                x[i] = before.Point(RestPosition(s, i)) * (1 - f) + pose.Point(RestPosition(s, i)) * f;
                v[i] = (pose.Point(RestPosition(s, i)) - before.Point(RestPosition(s, i))) / dt;
                continue;
            }
            const double drag = Get(drag_, n, s, i);
            v[i] = (v[i] + (force[i] / Mass(s, i) + Get(acceleration_, n, s, i)) * h) / (1 + h * drag);
            x[i] += v[i] * h;
            if (planes[i].isNear)
                planes[i].Stop(f * dt, physics_.friction, &x[i], &v[i]);
        }
    }
    //<
    for (size_t i = physics_.fixed; i < n; ++i) { // what planes left inside of a curved body
        Vector3d local = pose.LocalPoint(x[i]);
        const double clearance = contacts_[s * n + i].clearance;
        if (CachedDistance(s * n + i, local, clearance, obstacle) >= clearance)
            continue;
        for (int k = 0; k < 8 && clearance > obstacle.Distance(local); ++k)
            local += obstacle.Normal(local) * (clearance - obstacle.Distance(local) + 1e-9);
        x[i] = pose.Point(local);
    }
    PutSprings(s, x, v, tangents);
}
//<

//> Step a batch of springs
StepReport KeyStrands::StepBatchOfSprings(size_t batch, double dt, const Pose &pose,
                                          const Obstacle &obstacle) {
    StepReport report;
    const Vectors directors(&director_[batch * points_], &director_[batch * points_] + points_);
    for (size_t s = batch * kRodLanes; s < std::min(strands_, (batch + 1) * kRodLanes); ++s) {
        for (size_t i = 0; i < physics_.fixed; ++i)
            Set(&fixedTo_, 2, s, i, pose.Point(RestPosition(s, i)));
        StepSprings(s, dt, lastPose_, pose, obstacle);
    }
    report.recovered = Recover(batch, directors);
    for (size_t s = batch * kRodLanes; s < std::min(strands_, (batch + 1) * kRodLanes); ++s)
        for (size_t j = 0; j + 1 < points_; ++j)
            report.stretch =
                std::max(report.stretch,
                         std::abs((Position(s, j + 1) - Position(s, j)).Length() / EdgeLength(s, j) - 1));
    return report;
}
//<

} // namespace cuticle
//<
