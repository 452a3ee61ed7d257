//> Simulate a head of hair
// A groom on a moving head, frame by frame. Units: cm, s, radians.
#pragma once

#include "core/vecmath.h"
#include "dynamics/key_hairs.h"
#include "dynamics/obstacle.h"
#include "dynamics/strand.h"
#include "grooms/groom.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace cuticle {

//> Move a head by keys
// Between keys turns and shifts follow smooth cubics; before the first and after the last the head stands.
class HeadMotion {
  public:
    struct Key {
        double time;   // s, growing from key to key
        Vector3d turn; // about the pivot: its direction the axis, its length the angle
        Vector3d shift;
    };
    HeadMotion() = default;
    HeadMotion(std::vector<Key> keys, const Vector3d &pivot) : keys_(std::move(keys)), pivot_(pivot) {}
    Pose At(double time) const;

  private:
    std::vector<Key> keys_;
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
    // All hairs as they are now.
    Groom Frame() const;

    const KeyStrands &Keys() const { return set_; }
    KeyStrands *MutableKeys() { return &set_; }
    const SimulationSettings &Settings() const { return settings_; }
    size_t Substeps() const;

  private:
    void SetForces(double time);

    SimulationSettings settings_;
    Groom groom_;
    std::unique_ptr<Obstacle> obstacle_;
    std::vector<uint32_t> keys_;
    KeyStrands set_;
    HairInterpolation interpolation_;
    Pose pose_;
    size_t frame_ = 0;
};
//<

} // namespace cuticle
//<
