//> Step key hairs
#include "dynamics/strand.h"

#include "core/check.h"
#include "core/error.h"
#include "core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace cuticle {

namespace {

using rods::RodEdge;
using rods::RodHinge;

constexpr double kMaxSpeed = 1e6; // cm/s; beyond it a step has gone wrong
constexpr double kLengthTolerance = 1e-6;
constexpr double kTouching = 1e-6; // cm
// Stiffness of contacts in units of 1 / dt^2: a point under gravity sinks in by a ten-thousandth of what it
// would fall in a step, and is then pushed out exactly.
constexpr double kContactStiffness = 1e4;

constexpr double kFar = 0.5; // cm
// A point that sticks gives way by up to this (cm); beyond it slips.
constexpr double kStickLength = 1e-4;

bool AllFinite(const Vector3d &v) { return std::isfinite(v.x + v.y + v.z); }

} // namespace

//> Join what steps found
void StepReport::Join(const StepReport &other) {
    stretch = std::max(stretch, other.stretch);
    penetration = std::max(penetration, other.penetration);
    recovered += other.recovered;
    rounds = std::max(rounds, other.rounds);
}
//<

//> Choose the kernel of rods
const RodKernel &RodKernelFor(InstructionSet isa) {
    switch (isa) {
#ifdef CUTICLE_HAVE_X86_KERNELS
    case InstructionSet::Avx512:
        return avx512::kRodKernel;
    case InstructionSet::Avx2:
        return avx2::kRodKernel;
#endif
    default:
        return sse2::kRodKernel;
    }
}
//<

//> Read and write a lane
static Vector3d LaneOf(const Vector3<Octet> &v, size_t lane) {
    return {v.x.lane[lane], v.y.lane[lane], v.z.lane[lane]};
}
Vector3d KeyStrands::Get(const Vectors &a, size_t n, size_t strand, size_t i) {
    return LaneOf(a[strand / kRodLanes * n + i], strand % kRodLanes);
}
void KeyStrands::Set(Vectors *a, size_t n, size_t strand, size_t i, const Vector3d &v) {
    Vector3<Octet> &to = (*a)[strand / kRodLanes * n + i];
    const size_t lane = strand % kRodLanes;
    to.x.lane[lane] = v.x, to.y.lane[lane] = v.y, to.z.lane[lane] = v.z;
}
//<

//> Lay out the key hairs
KeyStrands::KeyStrands(std::span<const Vector3d> rest, size_t points, const StrandPhysics &physics)
    : strands_(points > 0 ? rest.size() / points : 0), points_(points),
      batches_((strands_ + kRodLanes - 1) / kRodLanes), physics_(physics),
      kernel_(&RodKernelFor(ChooseIsa())), rest_(rest.begin(), rest.end()) {
    if (points < 2)
        throw Error("strands of {} points do not move", points).WithRemedy("give them 2 or more");
    CHECK_EQ(strands_ * points_, rest.size());
    CHECK_LE(physics_.fixed, 2u);
    const size_t n = batches_ * points_;
    for (Vectors *a : {&x_, &v_, &xBefore_, &vBefore_, &director_, &acceleration_, &normal_, &contactForce_})
        a->resize(n);
    fixedTo_.resize(2 * batches_), fixedDirector_.resize(batches_), rootDirector_.resize(batches_);
    for (Numbers *a : {&length_, &mass_, &curvature_[0], &curvature_[1], &curvature_[2], &drag_,
                       &normalStiffness_, &tangentStiffness_})
        a->resize(n);
    contacts_.resize(strands_ * points_);
    for (size_t s = 0; s < batches_ * kRodLanes; ++s) {
        // Lanes without a strand repeat the last one
        const size_t from = std::min(s, strands_ - 1);
        const std::span<const Vector3d> p(rest_.data() + from * points_, points_);
        for (size_t j = 0; j + 1 < points_; ++j) {
            const double length = (p[j + 1] - p[j]).Length();
            if (!(length > 1e-9 && length < 1e9))
                throw Error("strand {}: points {} and {} are {} cm apart", from, j, j + 1, length)
                    .WithRemedy("a strand needs points apart from one another");
            At(&length_, points_, s, j) = length;
            At(&mass_, points_, s, j) += length / 2;
            At(&mass_, points_, s, j + 1) += length / 2;
        }
        Place(s, p);
        Set(&rootDirector_, 1, s, 0, Director(s, 0));
        //> Keep the shape that the groom gave
        for (size_t i = 1; i + 1 < points_; ++i) {
            const auto hinge =
                rods::MeasureHinge(rods::MakeRodEdge(p[i - 1], p[i]), rods::MakeRodEdge(p[i], p[i + 1]),
                                   Director(s, i - 1), Director(s, i));
            for (size_t c = 0; c < 3; ++c)
                At(&curvature_[c], points_, s, i) = hinge.value[c];
        }
        //<
    }
}
//<

//> Place a strand and stop it
void KeyStrands::Place(size_t strand, std::span<const Vector3d> p) {
    CHECK_EQ(p.size(), points_);
    lastDt_ = 0;
    Vector3d tangent = Normalize(p[1] - p[0]), director, other;
    CoordinateSystem(tangent, &director, &other);
    for (size_t i = 0; i < points_; ++i) {
        Set(&x_, points_, strand, i, p[i]);
        Set(&xBefore_, points_, strand, i, p[i]);
        Set(&v_, points_, strand, i, {});
        Set(&vBefore_, points_, strand, i, {});
        if (i + 1 < points_) {
            const Vector3d next = Normalize(p[i + 1] - p[i]);
            director = rods::AcrossUnit(rods::Transport(director, tangent, next), next);
            Set(&director_, points_, strand, i, director);
            tangent = next;
        }
    }
}
void KeyStrands::SetVelocity(size_t strand, size_t i, const Vector3d &v) {
    lastDt_ = 0;
    Set(&v_, points_, strand, i, v);
    Set(&vBefore_, points_, strand, i, v);
}
//<

//> Bend the shape at rest until it carries the weight
void KeyStrands::BalanceUnder(const Vector3d &gravity) {
    const double weight[3] = {physics_.bending, physics_.bending, physics_.twist};
    for (size_t s = 0; s < batches_ * kRodLanes; ++s) {
        Vector3d moment, below; // of the weight beyond the point i, about it; that weight
        for (size_t i = points_ - 1; i-- > 1;) {
            const Vector3d f = Position(s, i + 1) - Position(s, i);
            below += gravity * Mass(s, i + 1);
            moment += Cross(f, below);
            const auto e = rods::MakeRodEdge(Position(s, i - 1), Position(s, i));
            const auto hinge = rods::MeasureHinge(e, rods::MakeRodEdge(Position(s, i), Position(s, i + 1)),
                                                  Director(s, i - 1), Director(s, i));
            // What a turn of all beyond the point does to the three measures
            Vector3d by[3];
            for (size_t c = 0; c < 3; ++c)
                by[c] = Cross(f, hinge.byF[c]) + Normalize(f) * hinge.byTurnF[c];
            const double det = Dot(by[0], Cross(by[1], by[2]));
            if (!(std::abs(det) > 1e-6))
                continue; // an edge that folds back; it will sag
            const double share = 2 / (At(&length_, points_, s, i - 1) + At(&length_, points_, s, i));
            for (size_t c = 0; c < 3; ++c) {
                const double strength = Dot(moment, Cross(by[(c + 1) % 3], by[(c + 2) % 3])) / det;
                At(&curvature_[c], points_, s, i) = hinge.value[c] - strength / (weight[c] * share);
            }
        }
    }
}
//<

void KeyStrands::AddRestTwist(size_t strand, double perLength) {
    for (size_t i = 1; i + 1 < points_; ++i) {
        const double share = (EdgeLength(strand, i - 1) + EdgeLength(strand, i)) / 2;
        At(&curvature_[2], points_, strand, i) += 2 * std::tan(perLength * share / 2);
    }
}

void KeyStrands::SetForce(size_t strand, size_t i, const Vector3d &acceleration, double drag,
                          const Vector3d &dragVelocity) {
    if (!(drag >= 0 && drag < 1e9) || !AllFinite(dragVelocity))
        drag = 0;
    Vector3d a = AllFinite(acceleration) ? acceleration : Vector3d{};
    if (drag > 0)
        a += dragVelocity * drag;
    Set(&acceleration_, points_, strand, i, a);
    At(&drag_, points_, strand, i) = drag;
}

//> Show a batch to the kernel
rods::RodArrays<Octet> KeyStrands::ArraysOf(size_t batch) {
    const size_t at = batch * points_;
    rods::RodArrays<Octet> a;
    a.points = points_, a.fixed = physics_.fixed;
    a.x = &x_[at], a.v = &v_[at], a.xBefore = &xBefore_[at], a.vBefore = &vBefore_[at];
    a.director = &director_[at];
    a.fixedTo = &fixedTo_[2 * batch], a.fixedDirector = &fixedDirector_[batch];
    a.length = &length_[at], a.mass = &mass_[at];
    for (size_t c = 0; c < 3; ++c)
        a.rest[c] = &curvature_[c][at];
    a.acceleration = &acceleration_[at], a.drag = &drag_[at];
    a.contactNormalStiffness = &normalStiffness_[at], a.contactTangentStiffness = &tangentStiffness_[at];
    a.contactNormal = &normal_[at], a.contactForce = &contactForce_[at];
    return a;
}
//<

//> Measure a distance only where it may matter
// Distance is dear and most points are far from every body: one that has moved by less than half of what it
// was apart needs no new measurement. Returns a lower bound then.
double KeyStrands::CachedDistance(size_t at, const Vector3d &local, double clearance,
                                  const Obstacle &obstacle) {
    ContactPoint &c = contacts_[at];
    const double slack = 0.5 * (c.distance - clearance), moved2 = (local - c.measuredAt).LengthSquared();
    if (slack > 0 && moved2 < slack * slack)
        return clearance + slack;
    c.measuredAt = local;
    c.distance = obstacle.Distance(local);
    return c.distance;
}
//<

//> Find contacts and friction at an iterate
void KeyStrands::UpdateContacts(size_t batch, double stiffness, bool isFirst, const Pose &pose,
                                const Obstacle &obstacle) {
    for (size_t s = batch * kRodLanes; s < std::min(strands_, (batch + 1) * kRodLanes); ++s)
        for (size_t i = physics_.fixed; i < points_; ++i) {
            ContactPoint &contact = contacts_[s * points_ + i];
            double &kn = At(&normalStiffness_, points_, s, i), &kt = At(&tangentStiffness_, points_, s, i);
            kn = kt = 0;
            // What was far at the first iterate is asked again when points are pushed out
            if (!isFirst && contact.isFar)
                continue;
            Vector3d force, normal;
            const Vector3d local = pose.LocalPoint(Position(s, i));
            const double depth = contact.clearance + contact.pressed -
                                 CachedDistance(s * points_ + i, local, contact.clearance, obstacle);
            if (depth > 0) {
                const Vector3d n = obstacle.Normal(local);
                kn = stiffness;
                force = n * (stiffness * depth);
                // A depth that no solution has borne yet says nothing of the force
                const double borne = contact.solved ? depth : contact.pressed;
                const Vector3d along = Rub(&contact, local, n);
                kt = stiffness * physics_.friction * borne / std::max(along.Length(), kStickLength);
                force += along * kt;
                force = pose.Direction(force);
                normal = pose.Direction(n);
            }
            contact.solved = depth > 0;
            contact.isFar = depth < -kFar;
            Set(&normal_, points_, s, i, normal);
            Set(&contactForce_, points_, s, i, force);
        }
}
//<

//> Find how far friction is strained
// Returns the way back, along the surface, to where a point that sticks is held.
Vector3d KeyStrands::Rub(ContactPoint *contact, const Vector3d &local, const Vector3d &n) {
    if (!contact->holds)
        contact->anchor = contact->last, contact->holds = true;
    const Vector3d away = contact->anchor - local;
    return away - n * Dot(away, n);
}
//<

//> Keep for the next step what contacts bear
void KeyStrands::KeepContacts(size_t batch, const Pose &pose, const Obstacle &obstacle) {
    for (size_t s = batch * kRodLanes; s < std::min(strands_, (batch + 1) * kRodLanes); ++s)
        for (size_t i = physics_.fixed; i < points_; ++i) {
            ContactPoint &contact = contacts_[s * points_ + i];
            if (contact.isFar && contact.pressed == 0)
                continue;
            const Vector3d local = pose.LocalPoint(Position(s, i));
            if (Get(normalStiffness_, points_, s, i) > 0)
                contact.pressed =
                    std::max(0., contact.clearance + contact.pressed - obstacle.Distance(local));
            else
                contact.pressed = 0;
            contact.solved = false;
            if (contact.pressed == 0) {
                contact.holds = false;
            } else {
                const Vector3d along = Rub(&contact, local, obstacle.Normal(local));
                const double reach = along.Length();
                contact.anchor = local + along * (reach > kStickLength ? kStickLength / reach : 1);
            }
        }
}
//<

//> Push points out of the obstacle
double KeyStrands::PushOut(size_t batch, const Pose &pose, const Obstacle &obstacle) {
    double deepest = 0;
    for (size_t s = batch * kRodLanes; s < std::min(strands_, (batch + 1) * kRodLanes); ++s)
        for (size_t i = physics_.fixed; i < points_; ++i) {
            const double clearance = contacts_[s * points_ + i].clearance;
            Vector3d local = pose.LocalPoint(Position(s, i));
            double depth = clearance - CachedDistance(s * points_ + i, local, clearance, obstacle);
            if (depth <= -kTouching)
                continue;
            Set(&normal_, points_, s, i, pose.Direction(obstacle.Normal(local)));
            deepest = std::max(deepest, depth);
            for (int k = 0; k < 8 && depth > 0; ++k) { // where distances are rough, more than once
                local += obstacle.Normal(local) * (depth + 1e-9);
                depth = clearance - obstacle.Distance(local);
            }
            Set(&x_, points_, s, i, pose.Point(local));
        }
    return deepest;
}
//<

//> Lay a strand out from its root
// The rounds may have carried a strand far away; this begins with what Newton's method had found. Each point
// goes as far from the one before as it should be, and is turned about that one until it is outside: by what
// leads out where it is, and if that does not end either, toward what leads out where the one before is.
void KeyStrands::LayOut(size_t s, const Vectors &solved, const Pose &pose, const Obstacle &obstacle) {
    constexpr int kTries = 40, kTurns = 20;
    for (size_t i = std::max<size_t>(physics_.fixed, 1); i < points_; ++i) {
        const double clearance = contacts_[s * points_ + i].clearance, length = EdgeLength(s, i - 1);
        const Vector3d from = pose.LocalPoint(Position(s, i - 1)), out = obstacle.Normal(from);
        const Vector3d wish = pose.LocalPoint(LaneOf(solved[i], s % kRodLanes));
        const auto toward = [&](const Vector3d &p) {
            const Vector3d along = p - from;
            return from + (along.LengthSquared() > 0 ? Normalize(along) : out) * length;
        };
        const auto depth = [&](const Vector3d &p) { return clearance - obstacle.Distance(p); };
        Vector3d to = toward(wish);
        for (int k = 0; k < kTries && depth(to) > 0; ++k)
            to = toward(to + obstacle.Normal(to) * (1.1 * depth(to) + 1e-9));
        for (int k = 1; k <= kTurns && depth(to) > 0; ++k) {
            const double share = static_cast<double>(k) / kTurns;
            to = toward(toward(wish) * (1 - share) + (from + out * length) * share);
        }
        Set(&x_, points_, s, i, pose.Point(to));
    }
}
//<

//> Lay out the strands that no round has mended
void KeyStrands::LayOutBatch(size_t batch, const Vectors &solved, const Pose &pose, const Obstacle &obstacle,
                             StepReport *report) {
    // The worst of a strand: of its lengths, relative, and of its depths
    const auto worst = [&](size_t s) {
        StepReport found;
        for (size_t i = std::max<size_t>(physics_.fixed, 1); i < points_; ++i) {
            const double length = (Position(s, i) - Position(s, i - 1)).Length(),
                         depth = contacts_[s * points_ + i].clearance -
                                 obstacle.Distance(pose.LocalPoint(Position(s, i)));
            found.Join({std::abs(length / EdgeLength(s, i - 1) - 1), depth});
        }
        return found;
    };
    report->stretch = report->penetration = 0;
    for (size_t s = batch * kRodLanes; s < std::min(strands_, (batch + 1) * kRodLanes); ++s) {
        StepReport found = worst(s);
        if (found.stretch > kLengthTolerance || found.penetration > kTouching) {
            LayOut(s, solved, pose, obstacle);
            found = worst(s);
        }
        report->Join(found);
    }
}
//<

//> Keep strands whose step gave no number
size_t KeyStrands::Recover(size_t batch, const Vectors &directors) {
    size_t recovered = 0;
    for (size_t s = batch * kRodLanes; s < (batch + 1) * kRodLanes; ++s) {
        bool good = true;
        for (size_t i = 0; i < points_; ++i) {
            const Vector3d v = Velocity(s, i);
            good = good && AllFinite(Position(s, i)) && v.LengthSquared() < kMaxSpeed * kMaxSpeed &&
                   AllFinite(Get(director_, points_, s, i));
        }
        if (good)
            continue;
        recovered += s < strands_ ? 1 : 0;
        const Vector3d shift =
            physics_.fixed > 0 ? Get(fixedTo_, 2, s, 0) - Get(xBefore_, points_, s, 0) : Vector3d{};
        for (size_t i = 0; i < points_; ++i) {
            const Vector3d p = Get(xBefore_, points_, s, i) + shift;
            Set(&x_, points_, s, i, p);
            Set(&xBefore_, points_, s, i, p);
            Set(&v_, points_, s, i, {});
            Set(&vBefore_, points_, s, i, {});
            Set(&director_, points_, s, i, LaneOf(directors[i], s % kRodLanes));
        }
    }
    return recovered;
}
//<

//> Step one batch
StepReport KeyStrands::StepBatch(size_t batch, double dt, const Pose &pose, const Obstacle &obstacle,
                                 std::vector<Octet> *scratch) {
    const rods::RodArrays<Octet> arrays = ArraysOf(batch);
    const RodBatchStep step{&arrays,
                            {physics_.bending, physics_.twist, physics_.stretch, physics_.damping},
                            dt == lastDt_ ? rods::RodFormula::Bdf2 : rods::RodFormula::Euler,
                            dt,
                            scratch->data()};
    const double stiffness = kContactStiffness / (dt * dt);
    const Vectors directors(arrays.director, arrays.director + points_);
    for (size_t lane = 0; lane < kRodLanes; ++lane) {
        const size_t s = batch * kRodLanes + lane, from = std::min(s, strands_ - 1);
        for (size_t i = 0; i < physics_.fixed; ++i)
            Set(&fixedTo_, 2, s, i, pose.Point(RestPosition(from, i)));
        Set(&fixedDirector_, 1, s, 0, pose.Direction(Get(rootDirector_, 1, s, 0)));
    }
    kernel_->begin(step);
    Octet worst;
    for (size_t k = 0; k < physics_.newtonSteps; ++k) {
        UpdateContacts(batch, stiffness, k == 0, pose, obstacle);
        kernel_->newton(step, &worst);
    }
    KeepContacts(batch, pose, obstacle);
    const Vectors solved(arrays.x, arrays.x + points_);
    StepReport report;
    for (; report.rounds < kMaxRounds; ++report.rounds) {
        report.penetration = PushOut(batch, pose, obstacle);
        kernel_->projectLengths(step, &worst);
        report.stretch = *std::max_element(std::begin(worst.lane), std::end(worst.lane));
        if (report.penetration < kTouching && report.stretch < kLengthTolerance)
            break;
    }
    if (report.rounds == kMaxRounds)
        LayOutBatch(batch, solved, pose, obstacle, &report);
    for (size_t s = batch * kRodLanes; s < std::min(strands_, (batch + 1) * kRodLanes); ++s)
        for (size_t i = 0; i < points_; ++i)
            contacts_[s * points_ + i].last = pose.LocalPoint(Position(s, i));
    kernel_->end(step);
    report.recovered = Recover(batch, directors);
    return report;
}
//<

//> Step all strands
StepReport KeyStrands::Step(double dt, const Pose &pose, const Obstacle &obstacle) {
    CHECK(dt > 0 && std::isfinite(dt)) << dt;
    if (!clearanceKnown_) {
        ParallelFor(contacts_.size(), [&](size_t i) {
            contacts_[i].last = rest_[i];
            contacts_[i].clearance = std::min(physics_.clearance, obstacle.Distance(rest_[i]));
        });
        clearanceKnown_ = true;
    }
    std::vector<StepReport> reports(batches_);
    ParallelForRange(batches_, 4, [&](size_t first, size_t last) {
        std::vector<Octet> scratch(rods::RodSolver<Octet>::ScratchSize(points_));
        for (size_t b = first; b < last; ++b)
            reports[b] = physics_.method == StrandMethod::Rods ? StepBatch(b, dt, pose, obstacle, &scratch)
                                                               : StepBatchOfSprings(b, dt, pose, obstacle);
    });
    lastDt_ = dt;
    lastPose_ = pose;
    StepReport all;
    for (const StepReport &report : reports)
        all.Join(report);
    return all;
}
//<

//> Keep the state, to go on from it
template <class Self, class Visit>
void KeyStrands::VisitState(Self *self, const Visit &visit) {
    const auto all = [&](auto &array) {
        static_assert(std::is_trivially_copyable_v<std::remove_reference_t<decltype(array[0])>>);
        visit(array.data(), array.size() * sizeof(array[0]));
    };
    all(self->x_), all(self->v_), all(self->xBefore_), all(self->vBefore_), all(self->director_);
    all(self->normalStiffness_), all(self->tangentStiffness_), all(self->normal_), all(self->contactForce_);
    all(self->contacts_);
    visit(&self->lastPose_, sizeof self->lastPose_);
    visit(&self->lastDt_, sizeof self->lastDt_);
    visit(&self->clearanceKnown_, sizeof self->clearanceKnown_);
}
std::string KeyStrands::State() const {
    std::string bytes;
    VisitState(this,
               [&](const void *from, size_t size) { bytes.append(static_cast<const char *>(from), size); });
    return bytes;
}
bool KeyStrands::SetState(std::string_view bytes) {
    size_t size = 0;
    VisitState(this, [&](void *, size_t n) { size += n; });
    if (bytes.size() != size)
        return false;
    VisitState(this, [&](void *to, size_t n) {
        std::memcpy(to, bytes.data(), n);
        bytes.remove_prefix(n);
    });
    return true;
}
//<

//> Sum the energies
double KeyStrands::KineticEnergy() const {
    double sum = 0;
    for (size_t s = 0; s < strands_; ++s)
        for (size_t i = 0; i < points_; ++i)
            sum += 0.5 * Mass(s, i) * Velocity(s, i).LengthSquared();
    return sum;
}
double KeyStrands::ElasticEnergy() const {
    const double weight[3] = {physics_.bending, physics_.bending, physics_.twist};
    double sum = 0;
    for (size_t s = 0; s < strands_; ++s)
        for (size_t i = 1; i + 1 < points_; ++i) {
            const auto hinge = rods::MeasureHinge(rods::MakeRodEdge(Position(s, i - 1), Position(s, i)),
                                                  rods::MakeRodEdge(Position(s, i), Position(s, i + 1)),
                                                  Director(s, i - 1), Director(s, i));
            for (size_t c = 0; c < 3; ++c)
                sum += weight[c] / (EdgeLength(s, i - 1) + EdgeLength(s, i)) *
                       Sqr(hinge.value[c] - Get(curvature_[c], points_, s, i));
        }
    return sum;
}
//<

} // namespace cuticle
//<
