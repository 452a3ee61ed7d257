//> Run eight strands in the lanes of registers
// This text is included by one source file for each instruction set, which first defines CUTICLE_KERNEL: the
// name of the kernel and of the namespace that keeps it apart. Only what is inlined, and templates over a
// type of that namespace, may be used here: a function shared with the rest of the program could be linked
// in the form that this file compiled, for a processor that the program does not run on.
#include "core/lanes.h"
#include "dynamics/rod.h"
#include "dynamics/rod_batch.h"

namespace cuticle::CUTICLE_KERNEL {
namespace {

//> Wrap a register of eight doubles
// The type is of this namespace, so templates over it are compiled for this kernel alone. A processor with
// narrower registers takes two or four of them.
struct RodRegister {
    typedef double Register __attribute__((vector_size(8 * kRodLanes), may_alias));
    typedef int64_t Mask __attribute__((vector_size(8 * kRodLanes)));
    RodRegister() = default;
    CUTICLE_INLINE RodRegister(Register r) : v(r) {}
    CUTICLE_INLINE explicit RodRegister(double x) : v(x - Register{}) {}
    Register v;
};
//<

//> Give registers the operations of double
CUTICLE_INLINE RodRegister operator+(RodRegister a, RodRegister b) { return a.v + b.v; }
CUTICLE_INLINE RodRegister operator-(RodRegister a, RodRegister b) { return a.v - b.v; }
CUTICLE_INLINE RodRegister operator-(RodRegister a) { return -a.v; }
CUTICLE_INLINE RodRegister operator*(RodRegister a, RodRegister b) { return a.v * b.v; }
CUTICLE_INLINE RodRegister operator/(RodRegister a, RodRegister b) { return a.v / b.v; }
CUTICLE_INLINE RodRegister Max(RodRegister a, RodRegister b) { return a.v > b.v ? a.v : b.v; }
CUTICLE_INLINE RodRegister Select(RodRegister x, RodRegister a, RodRegister b) { return x.v > 0 ? a.v : b.v; }
CUTICLE_INLINE RodRegister Sqrt(RodRegister x) {
    RodRegister::Register r{};
    for (size_t i = 0; i < kRodLanes; ++i)
        r[i] = __builtin_sqrt(x.v[i]);
    return r;
}
//<

//> Look at a batch as registers
using Solver = rods::RodSolver<RodRegister>;
static_assert(sizeof(RodRegister) == sizeof(Octet));

Vector3<RodRegister> *Wide(Vector3<Octet> *p) { return reinterpret_cast<Vector3<RodRegister> *>(p); }
const Vector3<RodRegister> *Wide(const Vector3<Octet> *p) {
    return reinterpret_cast<const Vector3<RodRegister> *>(p);
}
const RodRegister *Wide(const Octet *p) { return reinterpret_cast<const RodRegister *>(p); }
RodRegister *Wide(Octet *p) { return reinterpret_cast<RodRegister *>(p); }

rods::RodArrays<RodRegister> Wide(const rods::RodArrays<Octet> &a) {
    rods::RodArrays<RodRegister> w;
    w.points = a.points, w.fixed = a.fixed;
    w.x = Wide(a.x), w.v = Wide(a.v), w.xBefore = Wide(a.xBefore), w.vBefore = Wide(a.vBefore);
    w.director = Wide(a.director), w.fixedTo = Wide(a.fixedTo), w.fixedDirector = Wide(a.fixedDirector);
    w.length = Wide(a.length), w.mass = Wide(a.mass);
    for (size_t c = 0; c < 3; ++c)
        w.rest[c] = Wide(a.rest[c]);
    w.acceleration = Wide(a.acceleration), w.drag = Wide(a.drag);
    w.contactNormalStiffness = Wide(a.contactNormalStiffness);
    w.contactTangentStiffness = Wide(a.contactTangentStiffness);
    w.contactNormal = Wide(a.contactNormal), w.contactForce = Wide(a.contactForce);
    return w;
}
//<

//> Call the solver's parts on a batch
Solver SolverOf(const RodBatchStep &s) {
    return {Wide(*s.arrays), s.stiffness, s.formula, s.dt, Wide(s.scratch)};
}
void Begin(const RodBatchStep &s) { SolverOf(s).Begin(); }
void Newton(const RodBatchStep &s, Octet *largest) { *Wide(largest) = SolverOf(s).Newton(); }
void ProjectLengths(const RodBatchStep &s, Octet *largest) { *Wide(largest) = SolverOf(s).ProjectLengths(); }
void End(const RodBatchStep &s) { SolverOf(s).End(); }
//<

} // namespace

const RodKernel kRodKernel{Begin, Newton, ProjectLengths, End};

} // namespace cuticle::CUTICLE_KERNEL
//<
