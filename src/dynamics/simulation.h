//> Simulate a head of hair
// A groom on a moving head, frame by frame. Units: cm, s, radians.
#pragma once

#include "core/vecmath.h"
#include "dynamics/directing.h"
#include "dynamics/key_hairs.h"
#include "dynamics/obstacle.h"
#include "dynamics/strand.h"
#include "grooms/groom.h"

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace cuticle {

//> Move a head by keys
// Between keys turns and shifts follow smooth cubics; before the first and after the last the head stands.
// Poses that others made (dynamics/pose_file.h) are followed likewise.
class HeadMotion {
  public:
    struct Key {
        double time;   // s, growing from key to key
        Vector3d turn; // about the pivot: its direction the axis, its length the angle
        Vector3d shift;
    };
    struct TimedPose {
        double time; // s, growing from pose to pose
        Pose pose;   // less than half a turn from the one before
    };
    HeadMotion() = default;
    explicit HeadMotion(std::vector<TimedPose> poses) : poses_(std::move(poses)) {}
    HeadMotion(std::vector<Key> keys, const Vector3d &pivot) : keys_(std::move(keys)), pivot_(pivot) {}
    Pose At(double time) const;

  private:
    Pose BetweenPoses(double time) const;
    std::vector<Key> keys_;
    std::vector<TimedPose> poses_;
    Vector3d pivot_;
};
//<

//> Blow a wind
// A mean velocity and gusts about it that travel with it: sums of waves, the same in every run.
struct Wind {
    Vector3d velocity;      // cm/s
    double gust = 0;        // their strength against the mean, 0 to 1 or more
    double gustLength = 15; // cm from gust to gust
    Vector3d At(const Vector3d &p, double time) const;
};
//<

//> Say how hairs hold one another
// Drag of key hairs toward the velocity of the hair around them, on a grid (dynamics/velocity_grid.h).
struct HairCoupling {
    double drag = 0;   // 1/s; 0: none
    double cell = 1.5; // cm, > 0
    size_t passes = 2; // of smoothing
    // The share of the target that is a hair's own velocity and what smoothing changed around it (FLIP),
    // instead of the smoothed velocity itself (PIC): 0 to 1.
    double flip = 0;
};
//<

//> Say what hair is directed to
struct HairDirection {
    std::vector<Vector3d> points; // of the key hairs in the wanted shape, in the world; empty: no direction
    double factor = 3e4;          // cm^2/s^2 for equation 3's energy
    std::vector<double> cells{6, 3, 1.5}; // cm, coarse to fine, each for an equal share of `seconds`
    double seconds = 2;
    DensityKernel kernel = DensityKernel::Smooth;
    double CellAt(double time) const;
};
//<

//> Gather the settings of a simulation
struct SimulationSettings {
    StrandPhysics physics;
    size_t keyHairs = 2500;
    size_t points = 32; // of a key hair
    double framesPerSecond = 24;
    size_t substeps = 0; // of a frame; 0: so many that none is longer than 1/60 s
    Vector3d gravity{0, -981, 0};
    bool balanced = true; // the groom is in balance under gravity at the start
    double drag = 3;      // of the air, 1/s
    Wind wind;
    HeadMotion motion;
    HairCoupling coupling;
    HairDirection direction;
};
//<

//> Declare a simulation
class HairSimulation {
  public:
    // groom: at rest, in the head's coordinates at time 0. Throws Error where it has no strand of two points.
    HairSimulation(Groom groom, std::unique_ptr<Obstacle> obstacle, const SimulationSettings &settings);

    size_t FrameNumber() const { return frame_; } // 0: the groom as it was
    double Time() const { return static_cast<double>(frame_) / settings_.framesPerSecond; }
    // Goes on to the next frame.
    StepReport NextFrame();
    // The energy of equation 3 between the key hairs and their target, on a lattice of this cell (cm).
    double TargetEnergy(double cell) const;
    // All hairs as they are now; the key hairs alone, as wide as the groom's hairs are at their roots.
    Groom Frame() const;
    Groom KeyFrame() const;
    // Returns where the head stands now.
    const Pose &HeadPose() const { return pose_; }
    // State returns what the frames to come depend on, as bytes of this machine. SetState takes that of a
    // simulation that was made alike, and is then at its frame; false, and nothing is changed, for other
    // bytes.
    std::string State() const;
    bool SetState(std::string_view bytes);

    const KeyStrands &Keys() const { return set_; }
    KeyStrands *MutableKeys() { return &set_; }
    const SimulationSettings &Settings() const { return settings_; }
    size_t Substeps() const;
    double StepLength() const { return 1 / (settings_.framesPerSecond * static_cast<double>(Substeps())); }

  private:
    void SetForces(double time);
    void FindCoupledVelocities(); // into velocities_
    std::vector<DensityTarget::Pull> TargetPulls(double time);

    SimulationSettings settings_;
    Groom groom_;
    std::unique_ptr<Obstacle> obstacle_;
    std::vector<uint32_t> keys_;
    KeyStrands set_;
    HairInterpolation interpolation_;
    Pose pose_;
    std::vector<Vector3d> points_, velocities_; // of the key hairs' points, kept from step to step
    std::vector<double> masses_;
    std::unique_ptr<DensityTarget> target_;
    double targetCell_ = 0; // of target_
    size_t frame_ = 0;
};
//<

} // namespace cuticle
//<
