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

//> Join narrower registers
// A register of the processor, and two of them as one: a vector type that is wider than the processor's
// registers would be kept in memory by the compiler.
#if defined(__AVX512F__)
constexpr size_t kPartLanes = 8;
#elif defined(__AVX__)
constexpr size_t kPartLanes = 4;
#else
constexpr size_t kPartLanes = 2;
#endif
struct Part {
    typedef double Native __attribute__((vector_size(8 * kPartLanes), may_alias));
    Native v;
};
CUTICLE_INLINE Part operator+(Part a, Part b) { return {a.v + b.v}; }
CUTICLE_INLINE Part operator-(Part a, Part b) { return {a.v - b.v}; }
CUTICLE_INLINE Part operator-(Part a) { return {-a.v}; }
CUTICLE_INLINE Part operator*(Part a, Part b) { return {a.v * b.v}; }
CUTICLE_INLINE Part operator/(Part a, Part b) { return {a.v / b.v}; }
CUTICLE_INLINE Part Greater(Part a, Part b) { return {a.v > b.v ? a.v : b.v}; }
CUTICLE_INLINE Part Choose(Part x, Part a, Part b) { return {x.v > 0 ? a.v : b.v}; }
CUTICLE_INLINE Part Root(Part x) {
    Part r{};
    for (size_t i = 0; i < kPartLanes; ++i)
        r.v[i] = __builtin_sqrt(x.v[i]);
    return r;
}
CUTICLE_INLINE void Fill(Part *part, double x) { part->v = x - Part::Native{}; }

template <class Half>
struct Twice {
    Half lo, hi;
};
template <class H>
CUTICLE_INLINE Twice<H> operator+(Twice<H> a, Twice<H> b) {
    return {a.lo + b.lo, a.hi + b.hi};
}
template <class H>
CUTICLE_INLINE Twice<H> operator-(Twice<H> a, Twice<H> b) {
    return {a.lo - b.lo, a.hi - b.hi};
}
template <class H>
CUTICLE_INLINE Twice<H> operator-(Twice<H> a) {
    return {-a.lo, -a.hi};
}
template <class H>
CUTICLE_INLINE Twice<H> operator*(Twice<H> a, Twice<H> b) {
    return {a.lo * b.lo, a.hi * b.hi};
}
template <class H>
CUTICLE_INLINE Twice<H> operator/(Twice<H> a, Twice<H> b) {
    return {a.lo / b.lo, a.hi / b.hi};
}
template <class H>
CUTICLE_INLINE Twice<H> Greater(Twice<H> a, Twice<H> b) {
    return {Greater(a.lo, b.lo), Greater(a.hi, b.hi)};
}
template <class H>
CUTICLE_INLINE Twice<H> Choose(Twice<H> x, Twice<H> a, Twice<H> b) {
    return {Choose(x.lo, a.lo, b.lo), Choose(x.hi, a.hi, b.hi)};
}
template <class H>
CUTICLE_INLINE Twice<H> Root(Twice<H> x) {
    return {Root(x.lo), Root(x.hi)};
}
template <class H>
CUTICLE_INLINE void Fill(Twice<H> *twice, double x) {
    Fill(&twice->lo, x), Fill(&twice->hi, x);
}
template <size_t kLanes>
struct RegisterOf {
    using Type = Twice<typename RegisterOf<kLanes / 2>::Type>;
};
template <>
struct RegisterOf<kPartLanes> {
    using Type = Part;
};
//<

//> Wrap a register of eight doubles
// The type is of this namespace, so templates over it are compiled for this kernel alone.
struct RodRegister {
    using Register = RegisterOf<kRodLanes>::Type;
    RodRegister() = default;
    CUTICLE_INLINE RodRegister(Register r) : v(r) {}
    CUTICLE_INLINE explicit RodRegister(double x) { Fill(&v, x); }
    Register v;
};
//<

//> Give registers the operations of double
CUTICLE_INLINE RodRegister operator+(RodRegister a, RodRegister b) { return a.v + b.v; }
CUTICLE_INLINE RodRegister operator-(RodRegister a, RodRegister b) { return a.v - b.v; }
CUTICLE_INLINE RodRegister operator-(RodRegister a) { return -a.v; }
CUTICLE_INLINE RodRegister operator*(RodRegister a, RodRegister b) { return a.v * b.v; }
CUTICLE_INLINE RodRegister operator/(RodRegister a, RodRegister b) { return a.v / b.v; }
CUTICLE_INLINE RodRegister Max(RodRegister a, RodRegister b) { return Greater(a.v, b.v); }
CUTICLE_INLINE RodRegister Select(RodRegister x, RodRegister a, RodRegister b) {
    return Choose(x.v, a.v, b.v);
}
CUTICLE_INLINE RodRegister Sqrt(RodRegister x) { return Root(x.v); }
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
