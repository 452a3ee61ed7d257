//> Bend and twist one strand as a discrete elastic rod
// The mechanics of one strand, or of several in the lanes of a register: T is double, or a pack of doubles
// with the operations of double and Sqrt, Max, Min, Select. Units: cm, s; energies, forces and stiffnesses
// are per mass a length (EI / (rho A) and so on), so that the mass of a point is the length that it carries.
#pragma once

#include "core/vecmath.h"

#include <cmath>
#include <cstddef>

namespace cuticle::rods {

//> Give double the operations of a pack
[[gnu::always_inline]] static inline double Sqrt(double x) { return __builtin_sqrt(x); }
[[gnu::always_inline]] static inline double Max(double a, double b) { return a > b ? a : b; }
[[gnu::always_inline]] static inline double Min(double a, double b) { return a < b ? a : b; }
// a where x > 0, else b; also where x is NaN.
[[gnu::always_inline]] static inline double Select(double x, double a, double b) { return x > 0 ? a : b; }
//<

//> Carry a director from one tangent to the next
// Parallel transport: turns v, which stands across the unit vector `from`, as the smallest rotation turns
// `from` into the unit vector `to`. Opposite directions have no smallest rotation; the result is finite.
template <class T>
Vector3<T> Transport(const Vector3<T> &v, const Vector3<T> &from, const Vector3<T> &to) {
    const T s = Dot(v, to) / Max(T(1) + Dot(from, to), T(1e-6));
    return v - (from + to) * s;
}
//<

//> Take the first of two axes across an edge
// Makes v of unit length and perpendicular to the unit vector t.
template <class T>
Vector3<T> AcrossUnit(const Vector3<T> &v, const Vector3<T> &t) {
    const Vector3<T> a = v - t * Dot(v, t);
    return a * (T(1) / Sqrt(Max(Dot(a, a), T(1e-30))));
}
//<

//> Hold an edge as direction and length
template <class T>
struct RodEdge {
    Vector3<T> t; // unit tangent
    T length, inverse;
};
template <class T>
RodEdge<T> MakeRodEdge(const Vector3<T> &from, const Vector3<T> &to) {
    const Vector3<T> e = to - from;
    const T length = Sqrt(Max(Dot(e, e), T(1e-30)));
    const T inverse = T(1) / length;
    return {e * inverse, length, inverse};
}
//<

//> Measure bending and twist at a point, with their derivatives
// A hinge is a point where two edges e (toward the root) and f meet. Measured are two curvatures about the
// directors and the twist, value[0..2], all integrated over the point's share of the strand (angles, to
// leading order). Their derivatives by the edge vectors, and by turns of the edges' directors about their
// edges.
template <class T>
struct RodHinge {
    T value[3];
    Vector3<T> byE[3], byF[3];
    T byTurnE[3], byTurnF[3];
};

// dE, dF: the first directors of both edges, unit vectors across them.
template <class T>
RodHinge<T> MeasureHinge(const RodEdge<T> &e, const RodEdge<T> &f, const Vector3<T> &dE,
                         const Vector3<T> &dF) {
    RodHinge<T> hinge;
    const T half(0.5);
    //> Find the curvature binormal of two edges
    const T cosine = Dot(e.t, f.t), invChi = T(1) / Max(T(1) + cosine, T(1e-4));
    const Vector3<T> kb = Cross(e.t, f.t) * (T(2) * invChi);
    //<
    //> Take curvatures in the mean frame of the two edges
    const Vector3<T> d2E = Cross(e.t, dE), d2F = Cross(f.t, dF);
    hinge.value[0] = Dot(d2E + d2F, kb) * half;
    hinge.value[1] = Dot(dE + dF, kb) * T(-0.5);
    const Vector3<T> mean = (e.t + f.t) * invChi;
    const Vector3<T> m1 = (dE + dF) * invChi, m2 = (d2E + d2F) * invChi;
    hinge.byE[0] = (Cross(f.t, m2) - mean * hinge.value[0]) * e.inverse;
    hinge.byF[0] = (-Cross(e.t, m2) - mean * hinge.value[0]) * f.inverse;
    hinge.byE[1] = (-Cross(f.t, m1) - mean * hinge.value[1]) * e.inverse;
    hinge.byF[1] = (Cross(e.t, m1) - mean * hinge.value[1]) * f.inverse;
    hinge.byTurnE[0] = Dot(dE, kb) * T(-0.5);
    hinge.byTurnF[0] = Dot(dF, kb) * T(-0.5);
    hinge.byTurnE[1] = Dot(d2E, kb) * T(-0.5);
    hinge.byTurnF[1] = Dot(d2F, kb) * T(-0.5);
    //<
    //> Go from twice the tangent of half the bend to the bend
    // 2 atan(k / 2) is k (1 + 4 q / 15) / (1 + 3 q / 5) to the fifth order, q = k^2 / 4 (Pade), which is off
    // by 1% at 90 degrees and grows without bound like k.
    const T q = T(2) * invChi - T(1), below = T(1) / (T(1) + q * T(0.6));
    const T scale = (T(1) + q * T(4. / 15)) * below;
    // -2 invChi^2 times the slope by q
    const T slopeOfScale = below * below * invChi * invChi * T(2. / 3);
    const Vector3<T> scaleByE = (f.t - e.t * cosine) * (slopeOfScale * e.inverse),
                     scaleByF = (e.t - f.t * cosine) * (slopeOfScale * f.inverse);
    for (size_t c = 0; c < 2; ++c) {
        hinge.byE[c] = hinge.byE[c] * scale + scaleByE * hinge.value[c];
        hinge.byF[c] = hinge.byF[c] * scale + scaleByF * hinge.value[c];
        hinge.value[c] = hinge.value[c] * scale;
        hinge.byTurnE[c] = hinge.byTurnE[c] * scale;
        hinge.byTurnF[c] = hinge.byTurnF[c] * scale;
    }
    //<
    //> Measure the twist against parallel transport
    const Vector3<T> carried = Transport(dE, e.t, f.t);
    const T twist = T(2) * Dot(Cross(carried, dF), f.t) / Max(T(1) + Dot(carried, dF), T(1e-4));
    hinge.value[2] = twist;
    const T slope = T(1) + twist * twist * T(0.25); // of 2 tan(angle / 2) by the angle
    hinge.byE[2] = kb * (half * slope * e.inverse);
    hinge.byF[2] = kb * (half * slope * f.inverse);
    hinge.byTurnE[2] = -slope;
    hinge.byTurnF[2] = slope;
    //<
    return hinge;
}
//<

//> Describe a strand to the solver
// All arrays are of the caller: `points` entries, or where it says edges one less. Edge j joins the points j
// and j + 1. Curvatures and twists stand at the inner points, 1 to points - 2; what stands at the ends is not
// read.
template <class T>
struct RodArrays {
    size_t points = 0;
    size_t fixed = 2; // the first points that the caller moves: 2 a clamp, 1 a joint, 0 a free strand
    // State: positions and velocities, those of the step before, and the first directors of edges.
    Vector3<T> *x, *v, *xBefore, *vBefore, *director;
    // The fixed points end here in this step; with a clamp, the first edge's director so.
    const Vector3<T> *fixedTo, *fixedDirector;
    // At rest: lengths of edges, mass of points (> 0), curvatures and twist.
    const T *length, *mass, *rest[3];
    // Acts during the step: acceleration, and drag (1/s, >= 0) against its velocity beside it.
    const Vector3<T> *acceleration;
    const T *drag;
    // Contacts at the iterate, per mass: stiffness along the normal and across it, the normal, the force.
    const T *contactNormalStiffness, *contactTangentStiffness;
    const Vector3<T> *contactNormal, *contactForce;
};

// Stiffnesses per mass a length: bending and twist cm^4/s^2, stretch cm^2/s^2; damping of bending and twist
// (s): the time in which a bend alone would relax.
struct RodStiffness {
    double bending = 0, twist = 0, stretch = 0, damping = 0;
};

// Names the formula of a step: the second takes the step before into account.
enum class RodFormula { Euler, Bdf2 };
//<

//> Solve a strand's equations in one sweep
// Solves A y = b for a symmetric positive matrix whose row r reaches kBand entries to the left of the
// diagonal: band[r * (kBand + 1) + k] is the entry in column r - k. Rows before `first` are left out. b
// becomes y; the band becomes L and D.
inline constexpr size_t kBand = 10;
template <class T>
void SolveBand(T *band, T *b, size_t first, size_t rows) {
    constexpr size_t w = kBand + 1;
    for (size_t j = first; j < rows; ++j) {
        const T inverse = T(1) / band[j * w];
        const size_t below = rows - 1 - j < kBand ? rows - 1 - j : kBand;
        T column[kBand + 1];
        for (size_t k = 1; k <= below; ++k)
            column[k] = band[(j + k) * w + k];
        for (size_t k = 1; k <= below; ++k) {
            const T l = column[k] * inverse;
            T *row = band + (j + k) * w;
            for (size_t m = 1; m <= k; ++m)
                row[k - m] = row[k - m] - l * column[m];
            row[k] = l;
            b[j + k] = b[j + k] - l * b[j];
        }
        b[j] = b[j] * inverse;
    }
    for (size_t j = rows; j-- > first;) {
        const size_t below = rows - 1 - j < kBand ? rows - 1 - j : kBand;
        for (size_t k = 1; k <= below; ++k)
            b[j] = b[j] - band[(j + k) * w + k] * b[j + k];
    }
}
//<

//> Step strands implicitly
// A step of dt in its parts; the caller updates contacts between them: Begin, then some times { (contacts at
// x) Newton }, then until both are small { (points pushed out of obstacles) ProjectLengths }, then End. What
// one part tells the next lies in the scratch, so a solver may be made anew for each.
template <class T>
class RodSolver {
  public:
    RodSolver(const RodArrays<T> &arrays, const RodStiffness &s, RodFormula formula, double dt, T *scratch);
    // Entries of T that the scratch holds.
    static size_t ScratchSize(size_t points) { return points * (4 * (kBand + 1) + 4 + 4 + 2 + 4 * 3); }

    // Moves the fixed points to where they end, and the others to a first guess.
    void Begin();
    // Moves points and turns directors by one step of Newton's method. Returns the largest move of a point
    // (squared, cm^2).
    T Newton();
    // Brings the edges closer to their lengths at rest: one step of Newton's method on all lengths, points
    // weighted by mass; points with a contactNormal of unit length move across it only. Returns the largest
    // relative error that was found.
    T ProjectLengths();
    // Sets velocities, and moves the history on. What a contact stopped leaves no velocity into it behind.
    void End();

  private:
    void AddInertia();
    void AddStretch();
    void AddHinge(size_t i, const RodEdge<T> &e, const RodEdge<T> &f);
    void CarryDirectors();

    RodArrays<T> a;
    size_t points_, firstRow_;
    T *band_, *rhs_, *tension_, *relaxed_[3], *diagonal_, *offDiagonal_;
    Vector3<T> *start_, *target_, *history_, *tangent_;
    double dt_, h_; // h_: the step with which the formula takes accelerations
    double before_; // the weight of the step before
    double stretch_, damping_, weight_[3];
};

template <class T>
RodSolver<T>::RodSolver(const RodArrays<T> &arrays, const RodStiffness &s, RodFormula formula, double dt,
                        T *scratch)
    : a(arrays), points_(arrays.points), dt_(dt), h_(formula == RodFormula::Euler ? dt : dt * 2 / 3),
      before_(formula == RodFormula::Euler ? 0 : 1. / 3), stretch_(s.stretch), damping_(s.damping) {
    firstRow_ = a.fixed == 0 ? 0 : a.fixed == 1 ? 4 : 7;
    band_ = scratch;
    rhs_ = band_ + 4 * points_ * (kBand + 1);
    tension_ = rhs_ + 4 * points_;
    for (size_t c = 0; c < 3; ++c)
        relaxed_[c] = tension_ + (c + 1) * points_;
    diagonal_ = tension_ + 4 * points_;
    offDiagonal_ = diagonal_ + points_;
    start_ = reinterpret_cast<Vector3<T> *>(offDiagonal_ + points_);
    target_ = start_ + points_;
    history_ = target_ + points_;
    tangent_ = history_ + points_;
    const double viscous = 1 + s.damping / h_;
    weight_[0] = weight_[1] = s.bending * viscous;
    weight_[2] = s.twist * viscous;
}

//> Begin a step: where inertia alone would lead
template <class T>
void RodSolver<T>::Begin() {
    const T h(h_), dt(dt_), before(before_), now(1 + before_);
    //> Let the shape of the last step weigh in as internal friction
    const T share(1 - h_ / (h_ + damping_));
    RodEdge<T> e = MakeRodEdge(a.x[0], a.x[1]);
    tangent_[0] = e.t;
    for (size_t i = 1; i + 1 < points_; ++i) {
        const RodEdge<T> f = MakeRodEdge(a.x[i], a.x[i + 1]);
        const RodHinge<T> hinge = MeasureHinge(e, f, a.director[i - 1], a.director[i]);
        for (size_t c = 0; c < 3; ++c)
            relaxed_[c][i] = a.rest[c][i] + (hinge.value[c] - a.rest[c][i]) * share;
        e = f;
        tangent_[i] = e.t;
    }
    //<
    for (size_t i = 0; i < points_; ++i) {
        start_[i] = a.x[i];
        history_[i] = a.x[i] * now - a.xBefore[i] * before;
        target_[i] = history_[i] + (a.v[i] * now - a.vBefore[i] * before) * h;
        tension_[i] = T(0);
        a.x[i] = i < a.fixed ? a.fixedTo[i] : a.x[i] + a.v[i] * dt;
    }
    CarryDirectors();
    if (a.fixed == 2)
        a.director[0] = AcrossUnit(*a.fixedDirector, tangent_[0]);
}
//<

//> Write inertia, drag and contacts into the equations
template <class T>
void RodSolver<T>::AddInertia() {
    constexpr size_t w = kBand + 1;
    const T inverseH(1 / h_), inverseH2(1 / (h_ * h_)), weakest(1e-9);
    for (size_t i = 0; i < 4 * points_ * w; ++i)
        band_[i] = T(0);
    for (size_t i = 0; i < points_; ++i) {
        const T m = a.mass[i], kn = a.contactNormalStiffness[i], kt = a.contactTangentStiffness[i];
        const Vector3<T> &n = a.contactNormal[i];
        const Vector3<T> r = (target_[i] - a.x[i]) * inverseH2 + a.acceleration[i] + a.contactForce[i] -
                             (a.x[i] - history_[i]) * (a.drag[i] * inverseH);
        for (size_t c = 0; c < 3; ++c) {
            T *row = band_ + (4 * i + c) * w;
            row[0] = m * (inverseH2 + a.drag[i] * inverseH + kt);
            for (size_t k = 0; k <= c; ++k)
                row[k] = row[k] + m * (kn - kt) * n[c] * n[c - k];
            rhs_[4 * i + c] = m * r[c];
        }
        band_[(4 * i + 3) * w] = i + 1 < points_ ? weakest : T(1);
        rhs_[4 * i + 3] = T(0);
    }
}
//<

//> Write the tension of edges into the equations
template <class T>
void RodSolver<T>::AddStretch() {
    constexpr size_t w = kBand + 1;
    for (size_t j = 0; j + 1 < points_; ++j) {
        const RodEdge<T> e = MakeRodEdge(a.x[j], a.x[j + 1]);
        const T k = T(stretch_) / a.length[j];
        const T across = Max(tension_[j], T(0)) * e.inverse, along = k - across;
        const T pull = k * (e.length - a.length[j]);
        for (size_t c = 0; c < 3; ++c) {
            T *near = band_ + (4 * j + c) * w, *far = band_ + (4 * j + 4 + c) * w;
            const T force = pull * e.t[c];
            rhs_[4 * j + c] = rhs_[4 * j + c] + force;
            rhs_[4 * j + 4 + c] = rhs_[4 * j + 4 + c] - force;
            for (size_t d = 0; d < 3; ++d) {
                const T entry = along * e.t[c] * e.t[d] + (c == d ? across : T(0));
                if (d <= c) {
                    near[c - d] = near[c - d] + entry;
                    far[c - d] = far[c - d] + entry;
                }
                far[4 + c - d] = far[4 + c - d] - entry; // column 4 j + d
            }
        }
    }
}
//<

//> Write bending and twist at a point into the equations
template <class T>
void RodSolver<T>::AddHinge(size_t i, const RodEdge<T> &e, const RodEdge<T> &f) {
    constexpr size_t w = kBand + 1, unknowns = 11;
    const RodHinge<T> hinge = MeasureHinge(e, f, a.director[i - 1], a.director[i]);
    const T inverseShare = T(2) / (a.length[i - 1] + a.length[i]);
    T *rhs = rhs_ + 4 * (i - 1), *band = band_ + 4 * (i - 1) * w;
    T g[3][unknowns], gw[3][unknowns];
    for (size_t c = 0; c < 3; ++c) {
        for (size_t d = 0; d < 3; ++d) {
            g[c][d] = -hinge.byE[c][d];
            g[c][4 + d] = hinge.byE[c][d] - hinge.byF[c][d];
            g[c][8 + d] = hinge.byF[c][d];
        }
        g[c][3] = hinge.byTurnE[c];
        g[c][7] = hinge.byTurnF[c];
        const T weight = T(weight_[c]) * inverseShare;
        const T moment = weight * (hinge.value[c] - relaxed_[c][i]);
        for (size_t u = 0; u < unknowns; ++u) {
            gw[c][u] = weight * g[c][u];
            rhs[u] = rhs[u] - moment * g[c][u];
        }
    }
    for (size_t u = 0; u < unknowns; ++u)
        for (size_t k = 0; k <= u; ++k) {
            T &entry = band[u * w + k];
            entry = entry + (gw[0][u] * g[0][u - k] + gw[1][u] * g[1][u - k] + gw[2][u] * g[2][u - k]);
        }
}
//<

//> Take a step of Newton's method on a strand
template <class T>
T RodSolver<T>::Newton() {
    AddInertia();
    AddStretch();
    RodEdge<T> e = MakeRodEdge(a.x[0], a.x[1]);
    for (size_t i = 1; i + 1 < points_; ++i) {
        const RodEdge<T> f = MakeRodEdge(a.x[i], a.x[i + 1]);
        AddHinge(i, e, f);
        e = f;
    }
    for (size_t r = 0; r < firstRow_; ++r)
        rhs_[r] = T(0);
    SolveBand(band_, rhs_, firstRow_, 4 * points_);
    //> Move the points and foresee the tensions
    T largest(0);
    for (size_t j = 0; j + 1 < points_; ++j) {
        const Vector3<T> near{rhs_[4 * j], rhs_[4 * j + 1], rhs_[4 * j + 2]};
        const Vector3<T> far{rhs_[4 * j + 4], rhs_[4 * j + 5], rhs_[4 * j + 6]};
        const RodEdge<T> edge = MakeRodEdge(a.x[j], a.x[j + 1]);
        tension_[j] = T(stretch_) / a.length[j] * (edge.length - a.length[j] + Dot(edge.t, far - near));
    }
    for (size_t i = 0; i < points_; ++i) {
        const Vector3<T> move{rhs_[4 * i], rhs_[4 * i + 1], rhs_[4 * i + 2]};
        a.x[i] += move;
        largest = Max(largest, Dot(move, move));
    }
    //<
    //> Turn the directors with their edges and by their own unknowns
    CarryDirectors();
    for (size_t j = 0; j + 1 < points_; ++j) {
        const T half = rhs_[4 * j + 3] * T(0.5), s = half * half;
        const T inverse = T(1) / (T(1) + s);
        a.director[j] = a.director[j] * ((T(1) - s) * inverse) +
                        Cross(tangent_[j], a.director[j]) * (T(2) * half * inverse);
    }
    //<
    return largest;
}
//<

//> Carry all directors along
template <class T>
void RodSolver<T>::CarryDirectors() {
    for (size_t j = 0; j + 1 < points_; ++j) {
        const Vector3<T> t = MakeRodEdge(a.x[j], a.x[j + 1]).t;
        a.director[j] = AcrossUnit(Transport(a.director[j], tangent_[j], t), t);
        tangent_[j] = t;
    }
}
//<

//> Bring edges to their lengths
template <class T>
T RodSolver<T>::ProjectLengths() {
    T largest(0);
    // A pull moves a point so. A contact gives way a little, or an edge that stands on it could not be
    // mended.
    const auto moves = [&](size_t i, const Vector3<T> &v) {
        const T inverseMass = i < a.fixed ? T(0) : T(1) / a.mass[i];
        return (v - a.contactNormal[i] * (T(0.9) * Dot(a.contactNormal[i], v))) * inverseMass;
    };
    //> Write the pulls that mend all lengths at once
    T *pull = rhs_;
    Vector3<T> tBefore{T(0), T(0), T(0)};
    for (size_t j = 0; j + 1 < points_; ++j) {
        const RodEdge<T> e = MakeRodEdge(a.x[j], a.x[j + 1]);
        const Vector3<T> near = moves(j, e.t), far = moves(j + 1, e.t);
        diagonal_[j] = Dot(e.t, near) + Dot(e.t, far) + T(1e-12) / a.mass[j];
        offDiagonal_[j] = j > 0 ? -Dot(tBefore, near) : T(0);
        pull[j] = e.length - a.length[j];
        largest = Max(largest, Max(pull[j], -pull[j]) / a.length[j]);
        band_[j] = e.t.x, band_[points_ + j] = e.t.y, band_[2 * points_ + j] = e.t.z;
        tBefore = e.t;
    }
    //<
    //> Solve for them along the strand and back
    const size_t free = a.fixed > 1 ? a.fixed - 1 : 0, edges = points_ - 1; // edges of fixed points stay
    for (size_t j = free + 1; j < edges; ++j) {
        const T l = offDiagonal_[j] / diagonal_[j - 1];
        diagonal_[j] = diagonal_[j] - l * offDiagonal_[j];
        pull[j] = pull[j] - l * pull[j - 1];
    }
    for (size_t j = edges; j-- > free;) {
        if (j + 1 < edges)
            pull[j] = pull[j] - offDiagonal_[j + 1] * pull[j + 1];
        pull[j] = pull[j] / diagonal_[j];
    }
    //<
    for (size_t j = free; j < edges; ++j) {
        const Vector3<T> t{band_[j], band_[points_ + j], band_[2 * points_ + j]};
        a.x[j] += moves(j, t) * pull[j];
        a.x[j + 1] -= moves(j + 1, t) * pull[j];
    }
    return largest;
}
//<

//> End a step: velocities, and history
template <class T>
void RodSolver<T>::End() {
    CarryDirectors();
    const T inverseH(1 / h_), inverseDt(1 / dt_);
    for (size_t i = 0; i < points_; ++i) {
        const Vector3<T> smooth = (a.x[i] - history_[i]) * inverseH, plain = (a.x[i] - start_[i]) * inverseDt;
        const Vector3<T> &n = a.contactNormal[i];
        const Vector3<T> v = smooth - n * Dot(n, smooth - plain);
        a.vBefore[i] = a.v[i] - n * Dot(n, a.v[i] - v);
        a.v[i] = v;
        a.xBefore[i] = start_[i];
    }
}
//<
//<

} // namespace cuticle::rods
//<
