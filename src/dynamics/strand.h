//> Hold the key hairs
// Key hairs as strands of point masses that stretch hardly, bend and twist, and keep the shape that they were
// groomed to; and the step of time for all of them. Units: cm and s.
#pragma once

#include "core/isa.h"
#include "core/vecmath.h"
#include "dynamics/obstacle.h"
#include "dynamics/rod_batch.h"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

//> Choose rods or springs
// Rods: discrete elastic rods, solved implicitly. Springs: the paper's, in explicit steps.
enum class StrandMethod { Rods, Springs };
//<

//> Say what a hair is made of
// The stiffness of a strand per mass a length, so that its density does not enter: bending is E I / (rho A),
// (cm^4/s^2). A single hair of 80 um has 1.2e5; a key hair stands for a lock, which is stiffer.
struct StrandPhysics {
    double bending = 5e6;
    double twist = 3.75e6;   // G J / (rho A): .75 of bending for a round fiber of Poisson's ratio 1/3
    double stretch = 3e10;   // E / rho of hair (cm^2/s^2); lengths are brought to tolerance beyond it
    double damping = 0.005;  // s, in which a bend without inertia would relax; 0: none
    double friction = 0.3;   // Coulomb's, against obstacles
    double clearance = 0.03; // cm that points keep from obstacles; less where they rest nearer
    size_t newtonSteps = 3;
    StrandMethod method = StrandMethod::Rods;
    size_t springSteps = 200;      // small steps of springs in a step
    bool springsAsPrinted = false; // not held back to what a small step bears: for the atlas
    size_t fixed = 2;              // points that the head carries: 2 a clamp, 1 a joint, 0 none
};
//<

//> Say what a step found
// The worst over all strands of a step.
struct StepReport {
    double stretch = 0;     // relative error of a length at its end
    double penetration = 0; // cm that a point is nearer to an obstacle than it may
    size_t recovered = 0;   // strands whose step gave no number: they stay where they were
    size_t rounds = 0;      // of projection, the most of any batch
    void Join(const StepReport &other);
};
//<

//> Declare the key hairs
// Strands with as many points each. Points that the head carries, and obstacles, follow its pose.
class KeyStrands {
  public:
    // rest: the points of all strands, strand by strand, in the head's coordinates, where they are in balance
    // under no force. Throws Error for fewer than two points a strand, for neighbours that coincide, and for
    // coordinates that are not finite.
    KeyStrands(std::span<const Vector3d> rest, size_t points, const StrandPhysics &physics);

    size_t StrandCount() const { return strands_; }
    size_t PointCount() const { return points_; }
    const StrandPhysics &Physics() const { return physics_; }
    Vector3d Position(size_t strand, size_t i) const { return Get(x_, points_, strand, i); }
    Vector3d Velocity(size_t strand, size_t i) const { return Get(v_, points_, strand, i); }
    Vector3d RestPosition(size_t strand, size_t i) const { return rest_[strand * points_ + i]; }
    Vector3d Director(size_t strand, size_t j) const { return Get(director_, points_, strand, j); }
    // The length that a point carries, which is its mass.
    double Mass(size_t strand, size_t i) const { return Get(mass_, points_, strand, i); }
    double EdgeLength(size_t strand, size_t j) const { return Get(length_, points_, strand, j); }

    // Places a strand's points and stops them, with directors carried along from the root; the shape at rest
    // stays.
    void Place(size_t strand, std::span<const Vector3d> points);
    void SetVelocity(size_t strand, size_t i, const Vector3d &v);
    // Bends the shape at rest so that the strands are in balance where they are now, under this acceleration.
    void BalanceUnder(const Vector3d &gravity);
    // Turns the twist that a strand has at rest, by so many radians a cm.
    void AddRestTwist(size_t strand, double perLength);

    // Acts during the next step, and stays until it is changed: acceleration, and drag (1/s) toward a
    // velocity. Values that are not finite, and negative drags, count as none.
    void SetForce(size_t strand, size_t i, const Vector3d &acceleration, double drag,
                  const Vector3d &dragVelocity);

    // Goes on by dt (s, > 0): the head goes to `pose`, in whose coordinates the obstacle is. The bits are the
    // same for any number of threads.
    StepReport Step(double dt, const Pose &pose, const Obstacle &obstacle);

    static constexpr size_t kMaxRounds = 200; // of pushing points out and mending lengths, in a step

    // All that a step changes, as bytes of this machine: to go on later, to the same bits. SetState takes
    // the State of strands that were made alike; false, and nothing is changed, where the sizes differ.
    std::string State() const;
    bool SetState(std::string_view bytes);

    // Energy of motion, per mass a length (cm^3/s^2); and of bending and twist.
    double KineticEnergy() const;
    double ElasticEnergy() const;
    // Steps by another kernel than that of ChooseIsa(): for tests that compare.
    void UseKernel(const RodKernel &kernel) { kernel_ = &kernel; }

  private:
    using Vectors = std::vector<Vector3<Octet>>;
    using Numbers = std::vector<Octet>;
    // Calls visit(pointer, bytes) for everything that a step changes.
    template <class Self, class Visit>
    static void VisitState(Self *self, const Visit &visit);
    static Vector3d Get(const Vectors &a, size_t n, size_t strand, size_t i);
    static void Set(Vectors *a, size_t n, size_t strand, size_t i, const Vector3d &v);
    static double Get(const Numbers &a, size_t n, size_t strand, size_t i) {
        return a[strand / kRodLanes * n + i].lane[strand % kRodLanes];
    }
    static double &At(Numbers *a, size_t n, size_t strand, size_t i) {
        return (*a)[strand / kRodLanes * n + i].lane[strand % kRodLanes];
    }
    rods::RodArrays<Octet> ArraysOf(size_t batch);
    StepReport StepBatch(size_t batch, double dt, const Pose &pose, const Obstacle &obstacle,
                         std::vector<Octet> *scratch);
    void StepSprings(size_t strand, double dt, const Pose &before, const Pose &pose,
                     const Obstacle &obstacle);
    void PutSprings(size_t strand, std::span<const Vector3d> x, std::span<const Vector3d> v,
                    std::span<const Vector3d> tangents);
    StepReport StepBatchOfSprings(size_t batch, double dt, const Pose &pose, const Obstacle &obstacle);
    void UpdateContacts(size_t batch, double stiffness, bool isFirst, const Pose &pose,
                        const Obstacle &obstacle);
    double PushOut(size_t batch, const Pose &pose, const Obstacle &obstacle);
    void LayOut(size_t strand, const Vectors &solved, const Pose &pose, const Obstacle &obstacle);
    void LayOutBatch(size_t batch, const Vectors &solved, const Pose &pose, const Obstacle &obstacle,
                     StepReport *report);
    double CachedDistance(size_t at, const Vector3d &local, double clearance, const Obstacle &obstacle);
    void KeepContacts(size_t batch, const Pose &pose, const Obstacle &obstacle);
    size_t Recover(size_t batch, const Vectors &directors);

    size_t strands_, points_, batches_;
    StrandPhysics physics_;
    const RodKernel *kernel_;
    Pose lastPose_;     // where the last step left the head
    double lastDt_ = 0; // 0: there is no step before that the next could take into account
    std::vector<Vector3d> rest_;
    Vectors x_, v_, xBefore_, vBefore_, director_, fixedTo_, fixedDirector_, rootDirector_;
    Numbers length_, mass_, curvature_[3];
    Vectors acceleration_;
    Numbers drag_;
    // Contacts
    Numbers normalStiffness_, tangentStiffness_;
    Vectors normal_, contactForce_;
    //> Remember contacts from step to step
    // Places are in the head's coordinates.
    struct ContactPoint {
        double clearance = 0;     // that it keeps
        double pressed = 0;       // the depth that would bear the force of the last step
        Vector3d anchor;          // that friction pulls it back to
        bool holds = false;       // anchor is in use
        bool solved = false;      // the last iterate of this step had this contact
        bool isFar = false;       // from every obstacle, when the step began
        Vector3d last;            // where it was after the last step
        Vector3d measuredAt;      // where its distance was found last, and what it was
        double distance = -1e300; // none yet
    };
    static Vector3d Rub(ContactPoint *contact, const Vector3d &local, const Vector3d &n);
    std::vector<ContactPoint> contacts_; // strand by strand
    bool clearanceKnown_ = false;
    //<
};
//<

// The solver for one of SupportedIsas() (core/isa.h).
const RodKernel &RodKernelFor(InstructionSet isa);

} // namespace cuticle
//<
