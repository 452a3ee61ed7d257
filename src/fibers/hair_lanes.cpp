//> Choose the kernels of the hair model
#include "fibers/hair_lanes.h"

#include "core/error.h"
#include "fibers/hair_model.h"

#include <atomic>
#include <string_view>

namespace cuticle {

//> Name the kernels that other files compile
#ifdef CUTICLE_HAVE_X86_KERNELS
namespace sse2 {
extern const HairKernels kKernels;
}
namespace avx2 {
extern const HairKernels kKernels;
}
#endif
//<

namespace {

//> Run the plain model as a kernel
// One lobe after the other in binary32: for processors without kernels, and as the opponent in comparisons.
void PlainSetUp(const HairParameters &parameters, HairSetup &setup) {
    const HairLobes<float> lobes(parameters);
    setup.h = lobes.h, setup.cosGammaO = lobes.cosGammaO, setup.eta = lobes.eta;
    setup.sigmaA = {lobes.sigmaA[0], lobes.sigmaA[1], lobes.sigmaA[2], 0};
    setup.v = lobes.v, setup.sinTilt = lobes.sinTilt, setup.cosTilt = lobes.cosTilt;
    setup.s = lobes.s, setup.npTail = lobes.npTail;
}
// NaN and infinity in a direction pass through minima and maxima unseen: nanTaint carries them, 0 or NaN.
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

//> Ask the processor what it runs
// nullptr where it cannot run kernels of that name.
const HairKernels *Find(std::string_view name) {
#ifdef CUTICLE_HAVE_X86_KERNELS
    if (name == "avx2")
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? &avx2::kKernels : nullptr;
    if (name == "sse2")
        return &sse2::kKernels;
#endif
    return name == "scalar" ? &kScalar : nullptr;
}
std::atomic<const HairKernels *> &Current() {
    static std::atomic<const HairKernels *> current{Find(HairKernelNames().front())};
    return current;
}
//<

} // namespace

//> Hand the kernels out
std::vector<std::string> HairKernelNames() {
    std::vector<std::string> names;
    for (const char *name : {"avx2", "sse2", "scalar"})
        if (Find(name))
            names.emplace_back(name);
    return names;
}

const HairKernels &CurrentHairKernels() { return *Current().load(std::memory_order_relaxed); }

void SetHairKernels(const std::string &name) {
    const HairKernels *kernels = Find(name);
    if (!kernels)
        throw Error("no hair kernels \"" + name + "\" on this processor; known are: avx2, sse2, scalar");
    Current().store(kernels);
}
//<

} // namespace cuticle
//<
