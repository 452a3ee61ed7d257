//> Go from frame to frame
#include "dynamics/simulation.h"

#include "core/error.h"
#include "core/parallel.h"
#include "dynamics/velocity_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace cuticle {

//> Find where the head is
// Times among those of keys, and how to go from the one before to the one behind: weights of their values,
// and of their slopes, which are those from neighbour to neighbour.
struct KeyPlace {
    size_t i;          // between i - 1 and i; 0 or the number of keys: outside
    double a, b, c, d; // of value i - 1, value i, slope i - 1 and slope i
};
template <typename Key>
static KeyPlace PlaceAmong(const std::vector<Key> &keys, double time) {
    const auto above = std::upper_bound(keys.begin(), keys.end(), time,
                                        [](double t, const Key &key) { return t < key.time; });
    const auto i = static_cast<size_t>(above - keys.begin());
    if (i == 0 || i == keys.size())
        return {i, 1, 0, 0, 0};
    const double span = keys[i].time - keys[i - 1].time, f = (time - keys[i - 1].time) / span, f2 = f * f,
                 f3 = f2 * f;
    return {i, 2 * f3 - 3 * f2 + 1, 3 * f2 - 2 * f3, (f3 - 2 * f2 + f) * span, (f3 - f2) * span};
}
// Goes on a cubic through value(k), a vector for each of the keys, which stands still at both ends.
template <typename Key, typename Value>
static Vector3d OnCubic(const std::vector<Key> &keys, const KeyPlace &at, const Value &value) {
    const auto slope = [&](size_t k) {
        return k == 0 || k + 1 == keys.size()
                   ? Vector3d{}
                   : (value(keys[k + 1]) - value(keys[k - 1])) / (keys[k + 1].time - keys[k - 1].time);
    };
    return value(keys[at.i - 1]) * at.a + value(keys[at.i]) * at.b + slope(at.i - 1) * at.c +
           slope(at.i) * at.d;
}
Pose HeadMotion::At(double time) const {
    if (!poses_.empty())
        return BetweenPoses(time);
    if (keys_.empty())
        return {};
    const KeyPlace at = PlaceAmong(keys_, time);
    if (at.i == 0 || at.i == keys_.size()) {
        const Key &key = at.i == 0 ? keys_.front() : keys_.back();
        return TurnAbout(pivot_, key.turn, key.shift);
    }
    return TurnAbout(pivot_, OnCubic(keys_, at, [](const Key &key) { return key.turn; }),
                     OnCubic(keys_, at, [](const Key &key) { return key.shift; }));
}
//<

//> Follow poses that others made
Pose HeadMotion::BetweenPoses(double time) const {
    const KeyPlace at = PlaceAmong(poses_, time);
    if (at.i == 0 || at.i == poses_.size())
        return (at.i == 0 ? poses_.front() : poses_.back()).pose;
    const auto axis = [&](Vector3d Pose::*which) {
        return OnCubic(poses_, at, [which](const TimedPose &p) { return p.pose.*which; });
    };
    Pose pose;
    pose.x = Normalize(axis(&Pose::x));
    const Vector3d y = axis(&Pose::y);
    pose.y = Normalize(y - pose.x * Dot(pose.x, y));
    pose.z = Cross(pose.x, pose.y);
    pose.origin = axis(&Pose::origin);
    return pose;
}
//<

//> Let gusts travel with the wind
Vector3d Wind::At(const Vector3d &p, double time) const {
    const double speed = velocity.Length();
    if (!(speed > 0))
        return {};
    const Vector3d along = velocity / speed;
    Vector3d across, up;
    CoordinateSystem(along, &across, &up);
    // Three waves whose lengths are no multiples of one another
    const double k = 2 * kPi<double> / gustLength, s = Dot(along, p) - speed * time;
    const double a = std::sin(k * s + 0.7 * k * Dot(across, p)),
                 b = std::sin(0.617 * k * s + k * Dot(up, p) + 1),
                 c = std::sin(0.382 * k * s - 0.5 * k * Dot(across, p) + 2);
    return velocity * (1 + gust * (a + b + c) / 3) + (across * b + up * a) * (speed * gust / 4);
}
//<

namespace {

//> Make the key hairs of a groom
std::vector<uint32_t> KeysOf(const Groom &groom, const SimulationSettings &settings) {
    std::vector<uint32_t> keys = ChooseKeyHairs(groom, settings.keyHairs);
    if (keys.empty())
        throw Error("the hair has no strand of two points apart from each other");
    return keys;
}
KeyStrands KeySet(const Groom &groom, std::span<const uint32_t> keys, const SimulationSettings &settings) {
    KeyStrands set(ResampleKeyHairs(groom, keys, settings.points), settings.points, settings.physics);
    if (settings.balanced)
        set.BalanceUnder(settings.gravity);
    return set;
}
//<

} // namespace

HairSimulation::HairSimulation(Groom groom, std::unique_ptr<Obstacle> obstacle,
                               const SimulationSettings &settings)
    : settings_(settings), groom_(PointsOnCurves(WithoutPlacements(std::move(groom), "the groom"))),
      obstacle_(std::move(obstacle)), keys_(KeysOf(groom_, settings)), set_(KeySet(groom_, keys_, settings)),
      interpolation_(groom_, keys_, set_), pose_(settings.motion.At(0)) {}

size_t HairSimulation::Substeps() const {
    constexpr double kLongest = 1. / 60;
    if (settings_.substeps > 0)
        return settings_.substeps;
    return static_cast<size_t>(std::ceil(1 / (settings_.framesPerSecond * kLongest) - 1e-9));
}

//> Take a frame in steps
StepReport HairSimulation::NextFrame() {
    const size_t n = Substeps();
    const double dt = StepLength();
    StepReport report;
    for (size_t k = 0; k < n; ++k) {
        const double time = Time() + dt * static_cast<double>(k + 1);
        SetForces(time);
        pose_ = settings_.motion.At(time);
        report.Join(set_.Step(dt, pose_, *obstacle_));
    }
    ++frame_;
    return report;
}
//<

namespace {

std::vector<Vector3d> AllPositions(const KeyStrands &set) {
    std::vector<Vector3d> points(set.StrandCount() * set.PointCount());
    for (size_t s = 0, n = 0; s < set.StrandCount(); ++s)
        for (size_t i = 0; i < set.PointCount(); ++i)
            points[n++] = set.Position(s, i);
    return points;
}

} // namespace

//> Find the velocities that neighbours ask for
void HairSimulation::FindCoupledVelocities() {
    const HairCoupling &c = settings_.coupling;
    const size_t n = set_.PointCount();
    points_.resize(set_.StrandCount() * n), velocities_.resize(points_.size()),
        masses_.resize(points_.size());
    ParallelForRange(set_.StrandCount(), 64, [&](size_t first, size_t last) {
        for (size_t s = first; s < last; ++s)
            for (size_t i = 0; i < n; ++i) {
                points_[s * n + i] = set_.Position(s, i);
                velocities_[s * n + i] = set_.Velocity(s, i);
                masses_[s * n + i] = set_.Mass(s, i);
            }
    });
    VelocityGrid grid(points_, masses_, velocities_, c.cell);
    std::vector<Vector3d> rough;
    if (c.flip > 0)
        for (size_t i = 0; i < points_.size(); ++i)
            rough.push_back(grid.At(points_[i], velocities_[i]));
    grid.Smooth(c.passes);
    ParallelForRange(points_.size(), 4096, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const Vector3d own = velocities_[i], smooth = grid.At(points_[i], own);
            velocities_[i] = c.flip > 0 ? smooth + (own - rough[i]) * c.flip : smooth;
        }
    });
}
//<

//> Find what pulls hair to its target
double HairDirection::CellAt(double time) const {
    const double share = seconds > 0 ? std::clamp(time / seconds, 0., 1.) : 1;
    const auto n = static_cast<double>(cells.size());
    return cells[static_cast<size_t>(std::min(share * n, n - 1))];
}
std::vector<DensityTarget::Pull> HairSimulation::TargetPulls(double time) {
    const HairDirection &d = settings_.direction;
    if (const double cell = d.CellAt(time); cell != targetCell_) {
        target_ = std::make_unique<DensityTarget>(d.points, cell, d.kernel);
        targetCell_ = cell;
    }
    return target_->Pulls(AllPositions(set_));
}
double HairSimulation::TargetEnergy(double cell) const {
    return DensityTarget(settings_.direction.points, cell, settings_.direction.kernel)
        .Energy(AllPositions(set_));
}
//<

//> Let all forces act
void HairSimulation::SetForces(double time) {
    const bool coupled = settings_.coupling.drag > 0, directed = !settings_.direction.points.empty();
    if (coupled)
        FindCoupledVelocities();
    const std::vector<DensityTarget::Pull> pulls =
        directed ? TargetPulls(time) : std::vector<DensityTarget::Pull>{};
    const double dt = StepLength(), factor = settings_.direction.factor;
    ParallelForRange(set_.StrandCount(), 64, [&](size_t first, size_t last) {
        for (size_t s = first; s < last; ++s)
            for (size_t i = 0; i < set_.PointCount(); ++i) {
                const size_t at = s * set_.PointCount() + i;
                // Several drags are one toward their weighted mean
                double drag = settings_.drag;
                Vector3d push = settings_.wind.At(set_.Position(s, i), time) * drag;
                if (coupled) {
                    drag += settings_.coupling.drag;
                    push += velocities_[at] * settings_.coupling.drag;
                }
                if (directed) { // what would overshoot in a step is held back like by a drag
                    drag += factor * pulls[at].stiffness * dt;
                    push += pulls[at].force * factor;
                }
                set_.SetForce(s, i, settings_.gravity + push, drag, {});
            }
    });
}
//<

//> Show the key hairs alone
Groom HairSimulation::KeyFrame() const {
    Groom keys;
    for (size_t s = 0; s < set_.StrandCount(); ++s) {
        for (size_t i = 0; i < set_.PointCount(); ++i)
            keys.points.push_back(Point3f(set_.Position(s, i)));
        keys.strandOffsets.push_back(static_cast<uint32_t>(keys.points.size()));
        const size_t hair = keys_[s];
        keys.strandWidths.push_back({groom_.Width(hair, 0), groom_.Width(hair, groom_.PointCount(hair) - 1)});
    }
    return keys;
}
//<

//> Go on from a state
std::string HairSimulation::State() const {
    const auto frame = static_cast<uint64_t>(frame_);
    return std::string(reinterpret_cast<const char *>(&frame), sizeof frame) + set_.State();
}
bool HairSimulation::SetState(std::string_view bytes) {
    uint64_t frame = 0;
    if (bytes.size() < sizeof frame || !set_.SetState(bytes.substr(sizeof frame)))
        return false;
    std::memcpy(&frame, bytes.data(), sizeof frame);
    frame_ = frame;
    pose_ = settings_.motion.At(Time());
    return true;
}
//<

Groom HairSimulation::Frame() const {
    return interpolation_.Deform(set_, pose_, *obstacle_, settings_.physics.clearance);
}

} // namespace cuticle
//<
