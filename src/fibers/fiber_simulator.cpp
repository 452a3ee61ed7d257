//> Define the fiber simulator
#include "fibers/fiber_simulator.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "fibers/ap.h"

namespace cuticle {

namespace {

//> Draw numbers strictly between 0 and 1
double Uniform(RNG *rng) { return (rng->UniformUInt32() + 0.5) * 0x1p-32; }
//<

//> Know how light is polarised
// Stokes parameters over the intensity, q^2 + u^2 + v^2 <= 1. With p = w x s across the path, q > 0 vibrates
// along s, u > 0 between s and p, and v is circular. All 0: unpolarised.
struct Polarisation {
    double q = 0, u = 0, v = 0;
    Vector3d s;
    //> Turn it to another s
    // Both lie across w. Turned by psi, the plane of q and u turns by 2 psi.
    Polarisation Towards(const Vector3d &w, const Vector3d &other) const {
        const double c = Dot(other, s), d = Dot(other, Cross(w, s));
        const double cos2 = c * c - d * d, sin2 = 2 * c * d;
        return {q * cos2 + u * sin2, u * cos2 - q * sin2, v, other};
    }
    //<
};
//<

//> Hold a path on its way
// Light that travels along w at (y, z) in the section, in the frame of its axes. What remains of its weight
// is known by the lengths that it has gone in cortex and medulla; brightest is the least absorbed channel's
// transmittance.
struct Path {
    enum class Stage { Scales, Facet, Interior, Outside };
    Stage stage = Stage::Scales;
    double y = 0, z = 0;
    Vector3d w;
    double weight = 1, brightest = 1;
    double inCortex = 0, inMedulla = 0;
    size_t chords = 0; // p
    Polarisation polarisation;
    bool inside = false, scattered = false;
    //> Know where on the surface it is
    double along = 0,
           above = 0; // within a scale of length 1: distance from its root end, height over its lowest line
    bool atRiser = false;
    double height = 2; // on the microfacets of a rough facet; 2: above them
    //<
};
//<

//> Keep what leaves the fiber
// The shares of one sample, merged: what comes twice into one cell must be squared as one.
class Deposits {
  public:
    Deposits(size_t classes, size_t channels) : classes_(classes), channels_(channels), entries_(classes) {}

    //> Note a share
    void Add(size_t c, size_t cell, const double *share) {
        for (Entry &e : sample_)
            if (e.c == c && e.cell == cell) {
                for (size_t k = 0; k < channels_; ++k)
                    shares_[e.at + k] += share[k];
                return;
            }
        sample_.push_back({c, cell, shares_.size()});
        shares_.insert(shares_.end(), share, share + channels_);
    }
    void EndSample() {
        for (const Entry &e : sample_)
            entries_[e.c].push_back(e);
        sample_.clear();
    }
    //<
    //> Hand over
    // One class at a time: classes do not share memory in the histogram and can be handed over at once.
    void MoveTo(FiberHistogram *histogram, size_t c) {
        for (const Entry &e : entries_[c])
            histogram->Add(c, e.cell, shares_.data() + e.at);
    }
    void Clear() {
        for (auto &list : entries_)
            list.clear();
        shares_.clear();
        lost = 0;
    }
    size_t Classes() const { return classes_; }
    double lost = 0;
    //<

  private:
    struct Entry {
        size_t c, cell, at;
    };
    size_t classes_, channels_;
    std::vector<Entry> sample_;
    std::vector<std::vector<Entry>> entries_;
    std::vector<double> shares_;
};
//<

//> Trace rays through a fiber
class Tracer {
  public:
    Tracer(const FiberDescription &fiber, const FiberLight &light, const FiberMeasurement &measurement,
           const FiberHistogram &classes);
    void Sample(RNG *rng, Deposits *deposits);

  private:
    //> Name the surfaces that a ray can meet
    // A right-handed frame at a point of the surface: u along, v around, n out of it.
    struct SurfaceFrame {
        Vector3d u, v, n;
    };
    Vector3d Normal(const Path &path) const {
        return Normalize(Vector3d(0, path.y / (a_ * a_), path.z / (b_ * b_)));
    }
    SurfaceFrame FrameAt(const Path &path) const;
    //<
    Path Enter(RNG *rng) const;
    void IntersectScales(Path path);
    void IntersectFacet(Path path);
    void Split(const Path &path, const SurfaceFrame &frame, const Vector3d &w, const Vector3d &m);
    void CrossInterior(Path path);
    bool IntersectMedulla(Path *path, double distance);
    void Leave(const Path &path);
    void Keep(const Path &path);
    double Transmittance(const Path &path, size_t channel) const;

    const FiberDescription &fiber_;
    const FiberLight &light_;
    const FiberHistogram &classes_;
    SphereCells cells_;
    std::optional<size_t> only_;
    double faint_;
    double a_, b_; // semi-axes
    double sinAlpha_, cosAlpha_, slope_, toTip_;
    bool rough_;
    Microfacets microfacets_;
    std::vector<double> medullaSigmaA_, share_;
    std::vector<Path> pending_;
    RNG *rng_ = nullptr;
    Deposits *deposits_ = nullptr;
};
//<

//> Prepare a tracer
Tracer::Tracer(const FiberDescription &fiber, const FiberLight &light, const FiberMeasurement &measurement,
               const FiberHistogram &classes)
    : fiber_(fiber), light_(light), classes_(classes), cells_(measurement.cells), only_(measurement.only),
      faint_(measurement.faint), a_(1 / std::sqrt(fiber.axisRatio)), b_(std::sqrt(fiber.axisRatio)),
      sinAlpha_(std::sin(fiber.alpha)), cosAlpha_(std::cos(fiber.alpha)),
      slope_(std::abs(std::tan(fiber.alpha))), toTip_(fiber.alpha < 0 ? -1 : 1),
      rough_(fiber.roughnessU > 0 || fiber.roughnessV > 0),
      microfacets_(fiber.distribution, fiber.roughnessU, fiber.roughnessV),
      medullaSigmaA_(fiber.medullaSigmaA.empty() ? fiber.sigmaA : fiber.medullaSigmaA),
      share_(fiber.sigmaA.size()) {}
//<

//> Follow one ray and all that it splits into
void Tracer::Sample(RNG *rng, Deposits *deposits) {
    rng_ = rng, deposits_ = deposits;
    pending_.assign(1, Enter(rng));
    constexpr int kPatience = 100'000; // steps; a path in a clear fiber takes some ten
    for (int step = 0; !pending_.empty() && step < kPatience; ++step) {
        const Path path = pending_.back();
        pending_.pop_back();
        switch (path.stage) {
        case Path::Stage::Scales:
            IntersectScales(path);
            break;
        case Path::Stage::Facet:
            IntersectFacet(path);
            break;
        case Path::Stage::Interior:
            CrossInterior(path);
            break;
        case Path::Stage::Outside:
            Leave(path);
            break;
        }
    }
    for (const Path &path : pending_)
        deposits->lost += path.weight;
    deposits->EndSample();
}
//<

//> Let a ray in from the light
// Across the beam, e = (-sin psi, cos psi), the section reaches as far as its support function there says.
double HalfWidth(double a, double b, double psi) { return std::hypot(a * std::sin(psi), b * std::cos(psi)); }

Path Tracer::Enter(RNG *rng) const {
    const double psi = light_.phi - fiber_.rotation, c = std::cos(psi), s = std::sin(psi);
    const double h = light_.h ? *light_.h : 2 * Uniform(rng) - 1;
    const double offset = -h * HalfWidth(a_, b_, psi); // along e
    //> Find the point of the section that the ray meets first
    // The line offset e + t (c, s) meets y^2/a^2 + z^2/b^2 = 1 at two t; the larger faces the light.
    const double ey = -s * offset, ez = c * offset;
    const double qa = Sqr(c / a_) + Sqr(s / b_), qb = c * ey / (a_ * a_) + s * ez / (b_ * b_);
    const double qc = Sqr(ey / a_) + Sqr(ez / b_) - 1;
    const double t = (-qb + std::sqrt(std::max(0., qb * qb - qa * qc))) / qa;
    //<
    Path path;
    path.y = ey + t * c, path.z = ez + t * s;
    const double cosTheta = std::cos(light_.theta);
    path.w = -Vector3d(std::sin(light_.theta), cosTheta * c, cosTheta * s);
    path.along = Uniform(rng), path.above = slope_;
    return path;
}
//<

//> Find the way through the scales
// The surface is a saw in the plane of the fiber's axis (du, toward the tip) and the normal (dn): facets that
// rise from 0 at along = 0 to the slope at along = 1, then fall straight, the riser facing the tip. Rays
// enter and leave through the lines above = slope, outside, and above = 0, inside.
void Tracer::IntersectScales(Path path) {
    const Vector3d n = Normal(path);
    const double du = toTip_ * path.w.x, dn = Dot(path.w, n), side = path.inside ? -1 : 1;
    const auto in = [](double distance, double speed) {
        return speed > 0 ? std::max(0., distance) / speed : std::numeric_limits<double>::infinity();
    };
    //> Without a tilt there is only the mean surface
    if (slope_ == 0) {
        path.stage = side * dn < 0 ? Path::Stage::Facet
                     : path.inside ? Path::Stage::Interior
                                   : Path::Stage::Outside;
        Keep(path);
        return;
    }
    //<
    //> Take the first of leaving, facet and riser
    const double overFacet = side * (path.above - slope_ * path.along);
    const double leaving = path.inside ? in(path.above, -dn) : in(slope_ - path.above, dn);
    const double facet = in(overFacet, -side * (dn - slope_ * du));
    const double riser = path.inside ? in(1 - path.along, du) : in(path.along, -du);
    const double first = std::min(leaving, std::min(facet, riser));
    if (!(first < leaving)) {
        path.stage = path.inside ? Path::Stage::Interior : Path::Stage::Outside;
    } else {
        path.stage = Path::Stage::Facet;
        path.atRiser = riser < facet;
        path.above = std::clamp(path.above + first * dn, 0., slope_);
        path.along = path.atRiser ? 1. : std::clamp(path.along + first * du, 0., 1.);
    }
    Keep(path);
    //<
}
//<

//> Turn the surface's frame with the scale
// Facets lean toward the root: their normal is that of the mean surface, turned by alpha toward -x. A riser's
// is the axis.
Tracer::SurfaceFrame Tracer::FrameAt(const Path &path) const {
    const Vector3d n = Normal(path), u(1, 0, 0);
    if (path.atRiser)
        return {n * -toTip_, Cross(n, u), u * toTip_};
    return {u * cosAlpha_ + n * sinAlpha_, Cross(n, u), n * cosAlpha_ - u * sinAlpha_};
}
//<

//> Reflect and refract at a facet
// Inside the fiber everything is turned over, point by point: up becomes down, and the surface seen from
// below is a surface seen from above. So w here always comes from above.
void Tracer::IntersectFacet(Path path) {
    const SurfaceFrame frame = FrameAt(path);
    const double side = path.inside ? -1 : 1;
    const Vector3d w = side * Vector3d(Dot(path.w, frame.u), Dot(path.w, frame.v), Dot(path.w, frame.n));
    if (!rough_) {
        Split(path, frame, w, {0, 0, 1});
        return;
    }
    //> Walk on over the microfacets, or off them
    const double from = path.height > 1 ? 1 : path.height;
    const double next = microfacets_.NextHeight(w, from, Uniform(rng_));
    if (next > 1) {
        path.height = 2;
        //> Go on to the next scale
        path.stage = Path::Stage::Scales;
        if (path.atRiser) // its two sides are the ends of two scales
            path.along = path.inside ? 1 : 0;
        path.atRiser = false;
        Keep(path);
        //<
        return;
    }
    path.height = next;
    const double u0 = Uniform(rng_), u1 = Uniform(rng_);
    Split(path, frame, w, microfacets_.VisibleNormal(-w, u0, u1));
    //<
}
//<

//> Share polarised light out
// c = cosIncident, t = eta times the cosine of refraction (squared in t2: below 0 the light is totally
// reflected). Amplitudes across and along the plane of incidence are r_s = (c - t) / (c + t) and r_p = (eta^2
// c - t) / (eta^2 c + t); total reflection turns their phases apart. before has its s across that plane.
struct PolarisedShares {
    double reflected, refracted;
    Polarisation afterReflection, afterRefraction;
};
PolarisedShares SharePolarised(const Polarisation &before, double c, double t2, double eta) {
    const double t = std::sqrt(std::max(0., t2)), ec = eta * eta * c;
    const double rs = (c - t) / (c + t), rp = (ec - t) / (ec + t);
    const double ts = 4 * c * t / Sqr(c + t), tp = 4 * ec * t / Sqr(ec + t);
    const auto shareOf = [&](double ofS, double ofP, double both, double turn, Polarisation *after) {
        const double share = (ofS * (1 + before.q) + ofP * (1 - before.q)) / 2;
        *after = {0, 0, 0, before.s};
        if (share > 0) {
            const double cosine = std::cos(turn) * both / share, sine = std::sin(turn) * both / share;
            after->q = (ofS * (1 + before.q) - ofP * (1 - before.q)) / (2 * share);
            after->u = cosine * before.u + sine * before.v;
            after->v = cosine * before.v - sine * before.u;
        }
        return share;
    };
    const double k = std::sqrt(std::max(0., -t2)), turn = 2 * (std::atan2(k, c) - std::atan2(k, ec));
    PolarisedShares shares;
    shares.reflected = shareOf(rs * rs, rp * rp, rs * rp, turn, &shares.afterReflection);
    shares.refracted = shareOf(ts, tp, std::sqrt(ts * tp), 0, &shares.afterRefraction);
    return shares;
}
//<

//> Split a path in two by Fresnel's equations
void Tracer::Split(const Path &path, const SurfaceFrame &frame, const Vector3d &w, const Vector3d &m) {
    const double eta = path.inside ? 1 / fiber_.eta : fiber_.eta;
    const double cosIncident = std::max(1e-9, -Dot(w, m)); // grazing and totally reflected would be 0/0
    const double t2 = (eta - 1) * (eta + 1) + cosIncident * cosIncident, t = std::sqrt(std::max(0., t2));
    //> Find the shares of the two
    PolarisedShares shares;
    if (fiber_.polarised) {
        const Vector3d normal = frame.u * m.x + frame.v * m.y + frame.n * m.z;
        Vector3d s = Cross(path.w, normal), other;
        if (s.LengthSquared() > 1e-24) // s and p cannot be told apart at normal incidence
            s = Normalize(s);
        else
            CoordinateSystem(path.w, &s, &other);
        shares = SharePolarised(path.polarisation.Towards(path.w, s), cosIncident, t2, eta);
    } else {
        const FresnelPair<double> fresnel = Fresnel(cosIncident, t, eta);
        shares.reflected = fresnel.f, shares.refracted = fresnel.oneMinusF;
    }
    //<
    const auto branch = [&](double share, const Polarisation &polarisation, const Vector3d &direction,
                            bool changesSide) {
        Path next = path;
        next.polarisation = polarisation;
        const Vector3d d = Normalize(path.inside ? -direction : direction);
        next.w = frame.u * d.x + frame.v * d.y + frame.n * d.z;
        next.weight *= share;
        if (changesSide) {
            next.inside = !path.inside;
            next.height = -path.height;
        }
        //> A smooth facet is left at once
        if (!rough_) {
            next.height = 2;
            next.stage = Path::Stage::Scales;
            if (next.atRiser)
                next.along = next.inside ? 1 : 0;
            next.atRiser = false;
        }
        //<
        //> Play roulette with faint paths
        const double brightness = next.weight * next.brightest;
        if (brightness < faint_) {
            if (Uniform(rng_) * faint_ >= brightness)
                return;
            next.weight *= faint_ / brightness;
        } else if (!(brightness > 1e-15)) {
            deposits_->lost += next.weight;
            return;
        }
        //<
        Keep(next);
    };
    branch(shares.reflected, shares.afterReflection, w + m * (2 * cosIncident), false);
    branch(shares.refracted, shares.afterRefraction, (w + m * (cosIncident - t)) / eta, true);
}
void Tracer::Keep(const Path &path) { pending_.push_back(path); }
//<

//> Cross the interior
void Tracer::CrossInterior(Path path) {
    //> Find the way to the surface
    const double qa = Sqr(path.w.y / a_) + Sqr(path.w.z / b_);
    const double qb = path.y * path.w.y / (a_ * a_) + path.z * path.w.z / (b_ * b_);
    const double qc = Sqr(path.y / a_) + Sqr(path.z / b_) - 1;
    const double distance = (-qb + std::sqrt(std::max(0., qb * qb - qa * qc))) / qa;
    if (!std::isfinite(distance)) { // along the axis: never out
        deposits_->lost += path.weight;
        return;
    }
    //<
    if (fiber_.medullaRatio > 0 && IntersectMedulla(&path, distance)) {
        Keep(path); // it travels on from inside the medulla
        return;
    }
    if (fiber_.medullaRatio == 0)
        path.inCortex += distance;
    //> Arrive at the surface
    path.y += distance * path.w.y, path.z += distance * path.w.z;
    const double radius = std::hypot(path.y / a_, path.z / b_);
    path.y /= radius, path.z /= radius; // rounding does not add up
    path.brightest = 0;
    for (size_t k = 0; k < share_.size(); ++k)
        path.brightest = std::max(path.brightest, Transmittance(path, k));
    ++path.chords;
    if (only_ && path.chords > *only_)
        return; // there is no way back
    path.along = Uniform(rng_), path.above = 0;
    path.stage = Path::Stage::Scales;
    Keep(path);
    //<
}
//<

//> Absorb
double Tracer::Transmittance(const Path &path, size_t channel) const {
    return std::exp(-fiber_.sigmaA[channel] * path.inCortex - medullaSigmaA_[channel] * path.inMedulla);
}
//<

//> Scatter in the medulla
// Adds the lengths of the way; true if the path was scattered and has a new place and direction.
bool Tracer::IntersectMedulla(Path *path, double distance) {
    //> Find the piece of the way that lies in the medulla
    const double k = fiber_.medullaRatio;
    const double qa = Sqr(path->w.y / a_) + Sqr(path->w.z / b_);
    const double qb = path->y * path->w.y / (a_ * a_) + path->z * path->w.z / (b_ * b_);
    const double qc = Sqr(path->y / a_) + Sqr(path->z / b_) - k * k;
    const double discriminant = qb * qb - qa * qc, root = std::sqrt(std::max(0., discriminant));
    const double begin = std::clamp((-qb - root) / qa, 0., distance);
    const double end = discriminant > 0 ? std::clamp((-qb + root) / qa, begin, distance) : begin;
    //<
    //> Draw the free way, and pass or scatter
    const double free = fiber_.medullaSigmaS > 0 ? -std::log(Uniform(rng_)) / fiber_.medullaSigmaS : Infinity;
    if (free >= end - begin) {
        path->inCortex += distance - (end - begin);
        path->inMedulla += end - begin;
        return false;
    }
    path->inCortex += begin;
    path->inMedulla += free;
    path->y += (begin + free) * path->w.y, path->z += (begin + free) * path->w.z;
    path->scattered = true;
    path->polarisation = {};
    //<
    //> Turn after Henyey and Greenstein
    const double g = fiber_.medullaG, u = Uniform(rng_), psi = 2 * kPi<double> * Uniform(rng_);
    const double f = (1 - g * g) / (1 - g + 2 * g * u);
    const double cosine = std::abs(g) < 1e-4 ? 2 * u - 1 : std::clamp((1 + g * g - f * f) / (2 * g), -1., 1.);
    const double sine = std::sqrt((1 - cosine) * (1 + cosine));
    Vector3d s, t;
    CoordinateSystem(path->w, &s, &t);
    path->w = Normalize(path->w * cosine + s * (sine * std::cos(psi)) + t * (sine * std::sin(psi)));
    return true;
    //<
}
//<

//> Leave the fiber
void Tracer::Leave(const Path &path) {
    if (only_ && (path.chords != *only_ || path.scattered))
        return;
    const size_t c = path.scattered                    ? classes_.Medulla()
                     : path.chords < classes_.Orders() ? path.chords
                                                       : classes_.Rest();
    for (size_t k = 0; k < share_.size(); ++k)
        share_[k] = path.weight * Transmittance(path, k);
    const double cr = std::cos(fiber_.rotation), sr = std::sin(fiber_.rotation);
    const size_t cell =
        cells_.CellOf({path.w.x, cr * path.w.y - sr * path.w.z, sr * path.w.y + cr * path.w.z});
    for (const size_t which : {c, classes_.Sum()})
        for (const size_t where : {cell, cells_.Count()})
            deposits_->Add(which, where, share_.data());
}
//<

//> Refuse what has no meaning
void Check(bool right, const std::string &what) {
    if (!right)
        throw Error("a fiber's " + what);
}
void CheckFiber(const FiberDescription &f) {
    Check(f.eta >= 0.1 && f.eta <= 10, "index of refraction must be in [0.1, 10]");
    Check(f.axisRatio >= 0.05 && f.axisRatio <= 20, "axis ratio must be in [0.05, 20]");
    Check(std::isfinite(f.rotation), "rotation must be a finite angle");
    Check(std::abs(f.alpha) <= kPi<double> / 4 + 1e-12, "scales must tilt by at most 45 degrees");
    Check(f.roughnessU >= 0 && f.roughnessU <= 1 && f.roughnessV >= 0 && f.roughnessV <= 1,
          "roughnesses must be in [0, 1]");
    Check(!f.sigmaA.empty(), "absorption needs a number for each channel, one at least");
    Check(f.medullaSigmaA.empty() || f.medullaSigmaA.size() == f.sigmaA.size(),
          "medulla must absorb in as many channels as its cortex");
    for (const auto *list : {&f.sigmaA, &f.medullaSigmaA})
        for (const double sigma : *list)
            Check(sigma >= 0 && sigma <= 1e18, "absorption must be in [0, 1e18]");
    Check(f.medullaRatio >= 0 && f.medullaRatio < 1, "medulla must have a radius ratio in [0, 1)");
    Check(f.medullaSigmaS >= 0 && f.medullaSigmaS <= 1e3, "medulla must scatter with sigma_s in [0, 1000]");
    Check(std::abs(f.medullaG) < 1, "medulla must have a mean cosine g in (-1, 1)");
}
void CheckMeasurement(const FiberLight &light, const FiberMeasurement &m) {
    Check(std::abs(light.theta) < kPi<double> / 2, "light must come from |theta| < 90 degrees");
    Check(std::isfinite(light.phi), "light must come from a finite azimuth");
    Check(!light.h || std::abs(*light.h) <= 1, "offset h must be in [-1, 1]");
    Check(m.orders >= 1 && m.orders <= 16, "orders to tell apart must be 1 to 16");
    Check(!m.only || *m.only < static_cast<size_t>(m.orders), "only order must be one of those told apart");
    Check(m.faint >= 0 && m.faint <= 1, "faint paths must have a weight in [0, 1]");
    Check(m.samples >= 1 && m.samples <= 1'000'000'000'000, "samples must be 1 to 10^12");
    Check(m.cells.rows >= 1 && m.cells.columns >= 1 && m.cells.Count() <= 4'000'000,
          "sphere must have 1 to 4 million cells");
}
//<

} // namespace

//> Share the samples out
FiberHistogram SimulateFiber(const FiberDescription &fiber, const FiberLight &light,
                             const FiberMeasurement &measurement) {
    CheckFiber(fiber);
    CheckMeasurement(light, measurement);
    FiberHistogram histogram(measurement.cells, measurement.orders, fiber.sigmaA.size());
    // Chunks of samples have random numbers of their own, and are added up in their order: sums are the same
    // to the last bit whoever traced them.
    constexpr uint64_t kChunk = 4096, kWave = 64;
    std::vector<Deposits> wave(kWave, Deposits(histogram.Classes(), histogram.Channels()));
    for (uint64_t begin = 0; begin < measurement.samples; begin += kChunk * kWave) {
        const uint64_t end = std::min(measurement.samples, begin + kChunk * kWave);
        const uint64_t chunks = (end - begin + kChunk - 1) / kChunk;
        ParallelFor(chunks, [&](uint64_t i) {
            const uint64_t first = begin + i * kChunk;
            RNG rng(MixBits(measurement.seed) ^ (first / kChunk));
            Tracer tracer(fiber, light, measurement, histogram);
            wave[i].Clear();
            for (uint64_t s = first; s < std::min(end, first + kChunk); ++s)
                tracer.Sample(&rng, &wave[i]);
        });
        ParallelFor(histogram.Classes(), [&](size_t c) {
            for (uint64_t i = 0; i < chunks; ++i)
                wave[i].MoveTo(&histogram, c);
        });
        double lost = 0;
        for (uint64_t i = 0; i < chunks; ++i)
            lost += wave[i].lost;
        histogram.CountSamples(end - begin, lost);
    }
    return histogram;
}
//<

double FiberWidth(const FiberDescription &fiber, double phi) {
    return 2 * HalfWidth(1 / std::sqrt(fiber.axisRatio), std::sqrt(fiber.axisRatio), phi - fiber.rotation);
}

} // namespace cuticle
//<
