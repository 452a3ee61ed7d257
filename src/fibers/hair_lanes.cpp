//> Choose the kernels of the hair model
#include "fibers/hair_lanes.h"

#include "core/error.h"
#include "core/isa.h"
#include "fibers/hair_model.h"

#include <fmt/format.h>

#include <atomic>
#include <string_view>

namespace cuticle {

//> Name the kernels that other files compile
namespace sse2 {
extern const HairKernels kKernels;
}
#ifdef CUTICLE_HAVE_X86_KERNELS
namespace avx2 {
extern const HairKernels kKernels;
}
namespace avx512 {
extern const HairKernels kKernels;
}
#endif
//<

namespace {

//> Run the plain model as a kernel
// Computes one lobe after the other in binary32: the plain sibling of the kernels, and the baseline of
// comparisons.
void PlainSetUp(const HairParameters &parameters, HairSetup &setup) {
    const HairLobes<float> lobes(parameters);
    setup.h = lobes.h, setup.cosGammaO = lobes.cosGammaO, setup.eta = lobes.eta;
    setup.sigmaA = {lobes.sigmaA[0], lobes.sigmaA[1], lobes.sigmaA[2], 0};
    setup.v = lobes.v, setup.sinTilt = lobes.sinTilt, setup.cosTilt = lobes.cosTilt;
    setup.s = lobes.s, setup.npTail = lobes.npTail;
}
// std::min and std::max drop NaN. nanTaint (0 or NaN) is added to every result so that a NaN input stays
// visible.
HairValue WithNanTaint(HairLobes<float>::Value value, float nanTaint) {
    for (float &c : value.fCos)
        c += nanTaint;
    return {value.fCos, value.pdf + nanTaint};
}
HairValue PlainEvaluate(const HairSetup &setup, const Vector3f &wo, const Vector3f &wi) {
    const float nanTaint = 0 * ((wo.x + wo.y + wo.z) + (wi.x + wi.y + wi.z));
    return WithNanTaint(HairLobes<float>(setup).Evaluate(wo, wi), nanTaint);
}
HairValue PlainSample(const HairSetup &setup, const Vector3f &wo, const std::array<float, 4> &u,
                      Vector3f *wi) {
    const float nanTaint = 0 * ((wo.x + wo.y + wo.z) + ((u[0] + u[1]) + (u[2] + u[3])));
    const HairLobes<float>::Value value = HairLobes<float>(setup).Sample(wo, u, wi);
    *wi += Vector3f(nanTaint, nanTaint, nanTaint);
    return WithNanTaint(value, nanTaint);
}
const HairKernels kScalar = {"scalar", PlainSetUp, PlainEvaluate, PlainSample};
//<

//> List the kernels
// All kernels, the widest first. To add one: compile it in CMakeLists.txt, name it above and here by the name
// of its instruction set in core/isa.cpp.
const HairKernels *const kHairKernels[] = {
#ifdef CUTICLE_HAVE_X86_KERNELS
    &avx512::kKernels, &avx2::kKernels,
#endif
    &sse2::kKernels, &kScalar};
//<

//> Keep the kernels in use
std::atomic<const HairKernels *> current{nullptr}; // null until someone asks

// Returns null where the processor cannot run kernels of that name.
const HairKernels *FindHairKernels(std::string_view name) {
    for (const HairKernels *kernels : kHairKernels) {
        if (name != kernels->name)
            continue;
        for (const InstructionSet isa : SupportedIsas())
            if (name == IsaName(isa))
                return kernels;
        return kernels == &kScalar ? kernels : nullptr;
    }
    return nullptr;
}
//<

} // namespace

//> Hand the kernels out
std::vector<std::string> HairKernelNames() {
    std::vector<std::string> names;
    for (const HairKernels *kernels : kHairKernels)
        if (FindHairKernels(kernels->name))
            names.emplace_back(kernels->name);
    return names;
}

const HairKernels &CurrentHairKernels() {
    const HairKernels *kernels = current.load(std::memory_order_relaxed);
    if (!kernels) [[unlikely]] {
        const HairKernels *chosen = FindHairKernels(IsaName(ChooseIsa()));
        if (current.compare_exchange_strong(kernels, chosen))
            kernels = chosen;
    }
    return *kernels;
}

void SetHairKernels(const std::string &name) {
    const HairKernels *kernels = FindHairKernels(name);
    if (!kernels)
        throw Error("no hair kernels \"{}\" on this processor", name)
            .WithRemedy("known are: {}", fmt::join(HairKernelNames(), ", "));
    current.store(kernels);
}
//<

} // namespace cuticle
//<
