// Everything of core and fibers links without a library of anybody's (see CMakeLists.txt), and one hair
// scatters light.
#include "core/parallel.h"
#include "fibers/hair.h"

#include <atomic>
#include <cstdio>

using namespace cuticle;

int main() {
    const HairBSDF hair(0.3f, 1.55f, HairBSDF::SigmaAFromConcentration(0.3f, 0), 0.3f, 0.3f, 2);
    const Vector3f wo(0, 0, 1), wi = Normalize(Vector3f(0.2f, 0.3f, 1));
    const Spectrum f = hair.f(wo, wi);
    if (!f.IsFinite() || f.IsBlack() || !(hair.Pdf(wo, wi) > 0))
        return std::puts("the hair is black, or not finite"), 1;
    std::atomic<size_t> done = 0;
    ParallelForRange(100, 7, [&](size_t begin, size_t end) { done += end - begin; });
    if (done != 100)
        return std::puts("a loop without threads leaves something out"), 1;
    std::puts("core and fibers need no library");
    return 0;
}
