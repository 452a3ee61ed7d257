#include "core/isa.h"

#include "core/error.h"

#include <cstdlib>

namespace cuticle {
namespace {

struct IsaEntry {
    InstructionSet isa;
    const char *name;
    bool (*supported)();
};
// All instruction sets, the widest first. To add one: give it a place in InstructionSet and a row here,
// compile the kernels for it in CMakeLists.txt (the flags must ask for no more than `supported` does), and
// name their tables in curve_set.cpp and, if hair gains by it, hair_lanes.cpp.
const IsaEntry kIsas[] = {
#ifdef CUTICLE_HAVE_X86_KERNELS
    {InstructionSet::Avx512, "avx512",
     [] {
         return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
                __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("fma");
     }},
    {InstructionSet::Avx2, "avx2",
     [] { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }},
#else
    {InstructionSet::Avx512, "avx512", [] { return false; }},
    {InstructionSet::Avx2, "avx2", [] { return false; }},
#endif
    {InstructionSet::Sse2, "sse2", [] { return true; }},
};
constexpr const char *kKnown = "Known are: sse2, avx2, avx512.";

} // namespace

const char *IsaName(InstructionSet isa) {
    for (const IsaEntry &entry : kIsas)
        if (entry.isa == isa)
            return entry.name;
    return "";
}

std::vector<InstructionSet> SupportedIsas() {
    std::vector<InstructionSet> isas;
    for (const IsaEntry &entry : kIsas)
        if (entry.supported())
            isas.push_back(entry.isa);
    return isas;
}

InstructionSet ChooseIsa(const std::string &option) {
    std::string wanted = option;
    const char *source = "the option isa";
    if (wanted.empty())
        if (const char *environment = std::getenv("CUTICLE_ISA")) {
            wanted = environment;
            source = "the environment's CUTICLE_ISA";
        }
    for (const IsaEntry &entry : kIsas) {
        if (wanted.empty() ? !entry.supported() : wanted != entry.name)
            continue;
        if (!entry.supported())
            throw Error("this processor cannot run \"{}\", which {} asks for", wanted, source)
                .WithRemedy(kKnown);
        return entry.isa;
    }
    throw Error("unknown instruction set \"{}\" in {}", wanted, source).WithRemedy(kKnown);
}

} // namespace cuticle
