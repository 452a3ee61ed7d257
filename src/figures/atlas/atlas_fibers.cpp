#include "figures/atlas/atlas_fibers.h"

#include "core/error.h"
#include "core/quadrature.h"
#include "fibers/hair.h"
#include "fibers/hair_as_printed.h"
#include "fibers/mp.h"
#include "fibers/np.h"
#include "fibers/smooth_fiber.h"
#include "fibers/tabulated.h"
#include "figures/figure.h"
#include "materials/hair_models.h"
#include "render/plugins.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>

namespace cuticle {

namespace {

constexpr double kPiD = kPi<double>;

// --- the models --------------------------------------------------------------------------------------------

// A scene of this one hair material, with parameters of its own.
std::string SceneOf(const FiberModel &model, const AtlasInputs &in, std::string_view parameters) {
    const auto number = [](double x) { return Printed("%.9g", x); };
    const std::string shown = number(in.reflectance < 0 ? in.sigmaA : in.reflectance);
    // Coarse: fewer rays than a picture takes; noise of a table is no fault of the model
    return fmt::format(
        "WorldBegin\nMaterial \"hair\" \"string model\" \"{}\" \"float eta\" {} \"float beta_m\" {} "
        "\"float beta_n\" {} \"float alpha\" {} \"rgb {}\" [{} {} {}] {} {}\n"
        "Shape \"sphere\"\nWorldEnd\n",
        model.name, number(in.eta), number(in.betaM), number(in.betaN), number(in.alpha),
        in.reflectance < 0 ? "sigma_a" : "color", shown, shown, shown, parameters, model.coarse);
}

// The materials asked for last, by their scene. Many cells of a map differ in direction and offset only, and
// a material may hold a table that takes a second to make.
std::shared_ptr<const Material> MaterialOf(const std::string &scene) {
    static std::mutex mutex;
    static std::deque<std::pair<std::string, std::shared_ptr<const Material>>> latest;
    constexpr size_t kKept = 32;
    {
        const std::lock_guard<std::mutex> lock(mutex);
        for (const auto &[text, material] : latest)
            if (text == scene)
                return material;
    }
    const SceneDescription description = ParseSceneText(AllPlugins(), scene, "atlas");
    const TextureTable textures(description.floatTextures, description.spectrumTextures);
    std::shared_ptr<const Material> made = MakeMaterial(
        description.materials[static_cast<size_t>(description.shapes[0].state.material)], textures, {});
    const std::lock_guard<std::mutex> lock(mutex);
    latest.emplace_back(scene, made);
    if (latest.size() > kKept)
        latest.pop_front();
    return made;
}

// The place where a ray meets a fiber at h: of a scene's hair it is 1 - 2 v.
SurfaceInteraction MetAt(double h) {
    SurfaceInteraction si;
    si.uv = {0.5f, static_cast<float>((1 - h) / 2)};
    si.isCurve = true;
    return si;
}

// The BSDF in a frame where the fiber lies along x, met at h.
BSDF BsdfOf(const Material &material, double h) {
    BSDF bsdf;
    material.MakeBSDF(MetAt(h), &bsdf);
    bsdf.SetFrame({}, {0, 0, 1});
    return bsdf;
}

// The model that a scene's material makes.
class SceneFiber final : public FiberInDouble {
  public:
    SceneFiber(const std::string &scene, double h)
        : material_(MaterialOf(scene)), bsdf_(BsdfOf(*material_, h)) {}
    FiberValue<double> Evaluate(const Vector3d &wo, const Vector3d &wi) const override {
        float pdf = 0;
        const Spectrum f = bsdf_.FCos(Vector3f(wo), Vector3f(wi), &pdf);
        return {{f[0], f[1], f[2]}, pdf};
    }
    FiberValue<double> Sample(const Vector3d &wo, const std::array<double, 4> &u,
                              Vector3d *wi) const override {
        BSDFSample sample;
        Spectrum weight;
        if (!bsdf_.Sample_f(Vector3f(wo),
                            {static_cast<float>(u[0]), static_cast<float>(u[1]), static_cast<float>(u[2]),
                             static_cast<float>(u[3])},
                            &sample, &weight))
            return {{0, 0, 0}, 0};
        *wi = Vector3d(sample.wi);
        const double pdf = sample.pdf;
        return {{weight[0] * pdf, weight[1] * pdf, weight[2] * pdf}, pdf};
    }

  private:
    std::shared_ptr<const Material> material_;
    BSDF bsdf_;
};

// The common parameters for a model as printed, with its paper's fit of a colour.
FiberInputs PrintedInputs(const AtlasInputs &in) {
    const auto f = [](double x) { return static_cast<float>(x); };
    FiberInputs at;
    at.h = f(in.h), at.eta = f(in.eta), at.betaM = f(in.betaM), at.betaN = f(in.betaN),
    at.alpha = f(in.alpha);
    at.sigmaA.fill(in.reflectance < 0 ? f(in.sigmaA)
                                      : as_printed::SigmaAFromReflectance(f(in.reflectance), at.betaN));
    return at;
}

// Keeps the latest few for those who ask again soon: tables of doubles, of up to 100 MB each.
void Hold(const std::shared_ptr<const FiberInDouble> &fiber) {
    static std::mutex mutex;
    static std::deque<std::shared_ptr<const FiberInDouble>> latest;
    constexpr size_t kKept = 4;
    const std::lock_guard<std::mutex> lock(mutex);
    latest.push_back(fiber);
    if (latest.size() > kKept)
        latest.pop_front();
}

// The model that a scene's material makes, with the same parameters in double.
class DoubleFiber final : public FiberInDouble {
  public:
    DoubleFiber(const FiberModel &model, const AtlasInputs &in) {
        const std::shared_ptr<const Material> material = MaterialOf(SceneOf(model, in, ""));
        const auto &hair = dynamic_cast<const HairMaterial &>(*material);
        FiberInputs at = hair.InputsAt(MetAt(in.h));
        at.h = static_cast<float>(in.h);
        fiber_ = hair.Maker().MakeInDouble(at);
        Hold(fiber_);
    }
    FiberValue<double> Evaluate(const Vector3d &wo, const Vector3d &wi) const override {
        return fiber_->Evaluate(wo, wi);
    }
    FiberValue<double> Sample(const Vector3d &wo, const std::array<double, 4> &u,
                              Vector3d *wi) const override {
        return fiber_->Sample(wo, u, wi);
    }

  private:
    std::shared_ptr<const FiberInDouble> fiber_;
};

// --- measures ----------------------------------------------------------------------------------------------

bool IsBad(const FiberValue<double> &value) {
    for (const double x : {value.fCos[0], value.fCos[1], value.fCos[2], value.pdf})
        if (!(x >= 0 && x < std::numeric_limits<double>::infinity()))
            return true;
    return false;
}

using Moments = std::array<double, 9>;
// phi is relative to the viewer's.
Moments MomentsOf(double theta, double phi) {
    const double s = std::sin(theta);
    return {1,
            s,
            s * s,
            std::cos(phi),
            std::sin(phi),
            std::cos(2 * phi),
            std::sin(2 * phi),
            s * std::cos(phi),
            s * std::sin(phi)};
}
void AddTo(Moments *sum, double weight, const Moments &m) {
    for (size_t i = 0; i < m.size(); ++i)
        (*sum)[i] += weight * m[i];
}

constexpr double kViewPhi = 0.7; // any

// Gauss's rule between one edge and the next.
ThetaRule RuleBetween(const std::vector<double> &edges, size_t nodesInAPanel) {
    const GaussLegendreRule &gauss = GaussLegendre(nodesInAPanel);
    ThetaRule rule;
    for (size_t i = 1; i < edges.size(); ++i) {
        const double half = (edges[i] - edges[i - 1]) / 2;
        if (half < 1e-9)
            continue; // two peaks' edges in one place
        for (size_t k = 0; k < gauss.x.size(); ++k) {
            rule.theta.push_back(edges[i - 1] + half * (1 + gauss.x[k]));
            rule.weight.push_back(half * gauss.w[k]);
        }
    }
    return rule;
}

struct Integrals {
    double energy = 0, bad = 0;
    Moments ofDensity{};
};
// The nodes of an integral over the sphere: theta, and how many azimuths.
struct SphereRule {
    ThetaRule theta;
    size_t around;
};
SphereRule RuleOfLobes(const AtlasInputs &in, double thetaO) {
    const double s = AzimuthalScale(std::clamp(in.betaN, 0.05, 1.));
    return {MakeThetaRule(LobePeaks(in, thetaO)),
            static_cast<size_t>(std::clamp(2 * kPiD / (0.8 * s), 96., 700.))};
}
// A function that is linear between the middles of a table's cells is integrated from one to the next.
SphereRule RuleOfTable(double thetaO) {
    const SphereCells cells = FiberTable::Cells(thetaO);
    std::vector<double> edges = {-kPiD / 2};
    for (size_t row = 0; row < cells.rows; ++row)
        edges.push_back(cells.Theta(row));
    edges.push_back(kPiD / 2);
    return {RuleBetween(edges, 3), cells.columns};
}
Integrals Integrate(const FiberInDouble &fiber, const SphereRule &sphere, double thetaO) {
    const ThetaRule &rule = sphere.theta;
    const size_t around = sphere.around;
    const Vector3d wo = FiberDirection(thetaO, kViewPhi);
    Integrals sum;
    for (size_t i = 0; i < rule.theta.size(); ++i)
        for (size_t j = 0; j < around; ++j) {
            const double phi = 2 * kPiD * (static_cast<double>(j) + 0.3) / static_cast<double>(around),
                         theta = rule.theta[i];
            const FiberValue<double> value = fiber.Evaluate(wo, FiberDirection(theta, kViewPhi + phi));
            const double area = rule.weight[i] * std::cos(theta) * 2 * kPiD / static_cast<double>(around);
            sum.energy += area * value.fCos[1];
            AddTo(&sum.ofDensity, area * value.pdf, MomentsOf(theta, phi));
            sum.bad += IsBad(value) ? 1 : 0;
        }
    sum.bad /= static_cast<double>(rule.theta.size() * around);
    return sum;
}

// The energy of a smooth fiber, exact, at h or over the width.
double SmoothEnergy(const AtlasInputs &in, double thetaO, bool overTheWidth) {
    const SmoothFiber<double> fiber(std::cos(thetaO), std::max(in.eta, 1.0000001));
    double sigma = in.sigmaA;
    if (in.reflectance >= 0)
        sigma = HairBSDF::SigmaAFromReflectance(Spectrum(static_cast<float>(in.reflectance)),
                                                static_cast<float>(in.betaN))[0];
    const std::array<double, 3> sigmas = {sigma, sigma, sigma};
    const auto at = [&](double gamma) {
        std::array<double, 3> sum = fiber.Tail(1, gamma, sigmas, SegmentLength::Chord);
        sum[0] += fiber.Attenuation(0, gamma, sigmas, SegmentLength::Chord)[0];
        return sum;
    };
    return overTheWidth ? MeanOverWidth<40, double>(at)[0] : at(std::asin(in.h))[0];
}

double Asymmetry(const FiberModel &model, AtlasForm form, AtlasInputs in, double thetaO, size_t offsets,
                 size_t pairs) {
    std::vector<std::unique_ptr<FiberInDouble>> fibers; // at least one
    fibers.reserve(offsets);
    for (size_t k = 0; k < offsets; ++k) {
        in.h = offsets == 1 ? in.h : 2 * (static_cast<double>(k) + 0.5) / static_cast<double>(offsets) - 1;
        fibers.push_back(MakeAtlasFiber(model, form, in));
    }
    const Vector3d wo = FiberDirection(thetaO, kViewPhi);
    double sum = 0, count = 0;
    for (size_t k = 0; k < pairs; ++k) {
        Vector3d wi;
        if (!(fibers[k % fibers.size()]->Sample(wo, EvenlySpread(k), &wi).pdf > 0))
            continue;
        double there = 0, back = 0;
        for (const auto &fiber : fibers) {
            there += fiber->Evaluate(wo, wi).fCos[1] / std::hypot(wi.y, wi.z);
            back += fiber->Evaluate(wi, wo).fCos[1] / std::hypot(wo.y, wo.z);
        }
        if (there + back == 0)
            continue;
        sum += std::abs(there - back) / (there + back);
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

} // namespace

bool HasForm(const FiberModel &model, AtlasForm form) {
    return form != AtlasForm::Published || model.published.absent.empty();
}

std::unique_ptr<FiberInDouble> MakeAtlasFiber(const FiberModel &model, AtlasForm form,
                                              const AtlasInputs &inputs) {
    if (form == AtlasForm::InDouble)
        return std::make_unique<DoubleFiber>(model, inputs);
    if (form == AtlasForm::InFloat)
        return std::make_unique<SceneFiber>(SceneOf(model, inputs, ""), inputs.h);
    if (model.published.make)
        return model.published.make(PrintedInputs(inputs));
    return std::make_unique<SceneFiber>(SceneOf(model, inputs, model.published.parameters), inputs.h);
}
std::unique_ptr<FiberInDouble> OurFiber(const AtlasInputs &inputs) {
    return MakeAtlasFiber(FiberModels().front(), AtlasForm::InFloat, inputs);
}

std::unique_ptr<FiberInDouble> PrintedFiber(const AtlasInputs &inputs, bool tiltOnThetaI) {
    return as_printed::PrintedFiber(PrintedInputs(inputs),
                                    tiltOnThetaI ? as_printed::Tilt::OnThetaI : as_printed::Tilt::OnThetaO);
}

Vector3d FiberDirection(double theta, double phi) {
    return {std::sin(theta), std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi)};
}

// Roberts' sequence: powers of the root of x^5 = x + 1.
std::array<double, 4> EvenlySpread(size_t i) {
    constexpr double root = 1.1673039782614187;
    std::array<double, 4> u;
    double step = 1;
    for (double &x : u) {
        step /= root;
        x = std::min(std::fmod(0.5 + step * static_cast<double>(i + 1), 1.), 1 - 0x1p-24);
    }
    return u;
}

ThetaRule MakeThetaRule(const std::vector<ThetaPeak> &peaks, size_t nodesInAPanel) {
    std::vector<double> edges;
    for (int k = -4; k <= 4; ++k)
        edges.push_back(k * kPiD / 8);
    for (const ThetaPeak &peak : peaks)
        for (const double d : {0., 1.3, 3., 6., 15.})
            for (const double edge : {peak.centre - d * peak.width, peak.centre + d * peak.width})
                if (std::abs(edge) < kPiD / 2)
                    edges.push_back(edge);
    std::sort(edges.begin(), edges.end());
    // Edges of several peaks that crowd together are one
    double narrowest = kPiD;
    for (const ThetaPeak &peak : peaks)
        narrowest = std::min(narrowest, peak.width);
    std::vector<double> apart = {edges.front()};
    for (const double edge : edges)
        if (edge - apart.back() > 0.4 * narrowest || edge == edges.back())
            apart.push_back(edge);
    edges = apart;
    return RuleBetween(edges, nodesInAPanel);
}

std::vector<ThetaPeak> LobePeaks(const AtlasInputs &inputs, double thetaO) {
    const std::array<double, kLobes> v = LongitudinalVariance(std::clamp(inputs.betaM, 0., 1.));
    std::vector<ThetaPeak> peaks;
    for (size_t p = 0; p < kLobes; ++p) {
        const double tilted = thetaO + static_cast<double>(kTiltInAlpha[p]) * inputs.alpha * kPiD / 180;
        peaks.push_back({-std::asin(std::sin(tilted)), std::sqrt(v[p])});
    }
    return peaks;
}

FiberFaults MeasureFiber(const FiberModel &model, AtlasForm form, const AtlasInputs &inputs, double thetaO,
                         bool quick) {
    const std::unique_ptr<FiberInDouble> fiber = MakeAtlasFiber(model, form, inputs);
    const Integrals integrals =
        Integrate(*fiber, model.inCells ? RuleOfTable(thetaO) : RuleOfLobes(inputs, thetaO), thetaO);
    FiberFaults faults{};
    faults.energy = std::abs(integrals.energy - SmoothEnergy(inputs, thetaO, model.farField));

    const Vector3d wo = FiberDirection(thetaO, kViewPhi);
    const size_t n = quick ? 1024 : 4096;
    Moments ofSamples{};
    double bad = 0;
    for (size_t k = 0; k < n; ++k) {
        Vector3d wi;
        const FiberValue<double> value = fiber->Sample(wo, EvenlySpread(k), &wi);
        bad += IsBad(value) ? 1 : 0;
        if (value.pdf == 0) // NaN goes on, and shows
            continue;
        AddTo(&ofSamples, 1 / static_cast<double>(n),
              MomentsOf(std::atan2(wi.x, std::hypot(wi.y, wi.z)), std::atan2(wi.z, wi.y) - kViewPhi));
        for (const double f : value.fCos)
            faults.weight = Worst(faults.weight, f / value.pdf);
    }
    faults.bad = std::max(integrals.bad, bad / static_cast<double>(n));
    for (size_t m = 0; m < ofSamples.size(); ++m)
        faults.disagreement = Worst(faults.disagreement, std::abs(ofSamples[m] - integrals.ofDensity[m]));
    faults.asymmetry = Asymmetry(model, form, inputs, thetaO, model.farField ? 1 : 32, quick ? 16 : 48);
    return faults;
}

double EnergyByQuadrature(const FiberInDouble &fiber, const AtlasInputs &inputs, double thetaO) {
    return Integrate(fiber, RuleOfLobes(inputs, thetaO), thetaO).energy;
}
double EnergyBySamples(const FiberInDouble &fiber, double thetaO, size_t n) {
    double sum = 0;
    for (size_t k = 0; k < n; ++k) {
        Vector3d wi;
        const FiberValue<double> value = fiber.Sample(FiberDirection(thetaO, kViewPhi), EvenlySpread(k), &wi);
        sum += value.pdf > 0 ? value.fCos[1] / value.pdf : 0;
    }
    return sum / static_cast<double>(n);
}

} // namespace cuticle
