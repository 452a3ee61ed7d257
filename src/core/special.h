//> Let one text serve numbers and registers
// Special functions and the handful of operations that let one text serve numbers and registers of numbers.
//
// A template of the fiber model runs for float, double, long double and for a register of floats (the kernels
// of src/fibers). It calls Exp, Expm1, Sqrt, Select, Max: the overloads for numbers stand here, those for
// registers in the kernel. Everything here is always inlined: kernels are compiled for other processors than
// the rest, and no function of theirs may be the one that the linker keeps for all.
#pragma once

#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>

#define CUTICLE_INLINE [[gnu::always_inline]] inline

namespace cuticle {

//> Give numbers the operations that the model asks for
template <std::floating_point T>
CUTICLE_INLINE T Sqrt(T x) {
    return std::sqrt(x);
}
template <std::floating_point T>
CUTICLE_INLINE T Exp(T x) {
    return std::exp(x);
}
template <std::floating_point T>
CUTICLE_INLINE T Expm1(T x) {
    return std::expm1(x);
}
template <std::floating_point T>
CUTICLE_INLINE T Select(bool condition, T yes, T no) {
    return condition ? yes : no;
}
// An angle, as its sine and its cosine.
template <typename V>
struct SinCosine {
    V sin, cos;
};

// The larger of two numbers; a if b is smaller or not comparable.
template <std::floating_point T>
CUTICLE_INLINE T Max(T a, T b) {
    return a < b ? b : a;
}
//<

//> Evaluate a polynomial, four coefficients at a time
// Evaluates a polynomial, coefficients (numbers or registers) from the constant upward: four at a time by
// pairs, so that fewer multiplications wait for each other than in Horner's rule. What the kernels cost is
// mostly waiting.
template <typename V, typename C0>
CUTICLE_INLINE V Polynomial(V, C0 c0) {
    return V(c0);
}
template <typename V, typename C0, typename C1>
CUTICLE_INLINE V Polynomial(V x, C0 c0, C1 c1) {
    return V(c0) + x * V(c1);
}
template <typename V, typename C0, typename C1, typename C2>
CUTICLE_INLINE V Polynomial(V x, C0 c0, C1 c1, C2 c2) {
    return (V(c0) + x * V(c1)) + (x * x) * V(c2);
}
template <typename V, typename C0, typename C1, typename C2, typename C3, typename... C>
CUTICLE_INLINE V Polynomial(V x, C0 c0, C1 c1, C2 c2, C3 c3, C... rest) {
    const V x2 = x * x, low = (V(c0) + x * V(c1)) + x2 * (V(c2) + x * V(c3));
    if constexpr (sizeof...(rest) == 0)
        return low;
    else
        return low + (x2 * x2) * Polynomial(x, rest...);
}
//<

//> Compute $e^{-x} I_0(x)$ in single precision
// The exponentially scaled modified Bessel function of order 0 in two parts:
//     exp(-x) I_0(x) = factor * exp(-exponent),   x >= 0,
// so that a caller whose result holds another exponential takes one of the sum. For float and for registers
// of floats: one evaluation of a polynomial whose coefficients depend on the side of x = 5, in x^2 below and
// in 1 / (x + 1/4) above (fits of core/fit_special.py, relative error below 6e-8 before rounding).
template <typename V>
struct ScaledBessel {
    V factor, exponent;
};
template <typename V>
CUTICLE_INLINE ScaledBessel<V> SplitI0e(V x) {
    const auto small = x < V(5.f);
    const V t = V(1.f) / (x + V(0.25f));
    const V y = Select(small, x * x, t);
    const auto c = [small](float below, float above) { return Select(small, V(below), V(above)); };
    const V p = Polynomial(y, c(0.9999999406f, 0.3989422922f), c(0.250000304f, 0.09972770261f),
                           c(0.0156247454f, 0.05694282937f), c(0.0004341087895f, 0.02125113883f),
                           c(6.769073416e-6f, 0.6998527047f), c(6.887625289e-8f, -5.677961349f),
                           c(4.22232154e-10f, 26.93223739f), c(3.534933798e-12f, -42.85610836f));
    return {p * Select(small, V(1.f), Sqrt(t)), Select(small, x, V(0.f))};
}
//<

//> Compute $e^{-x} I_0(x)$ in any precision
// exp(-x) I_0(x) for x >= 0; an infinite x gives 0, NaN gives NaN. float: the fit above. double and long
// double: the power series, all of whose terms are positive, below x = 30, and the asymptotic series
// (Abramowitz and Stegun 9.7.1) above, whose smallest term there is of the order of exp(-60).
template <std::floating_point T>
T I0e(T x) {
    if constexpr (std::same_as<T, float>) {
        const ScaledBessel<float> split = SplitI0e(x);
        return split.factor * std::exp(-split.exponent);
    } else if (x < T(30)) {
        const T quarter = x * x / 4;
        T term = 1, sum = 1;
        for (int k = 1; k < 200 && term > sum * std::numeric_limits<T>::epsilon() / 16; ++k) {
            term *= quarter / (T(k) * T(k));
            sum += term;
        }
        return std::exp(-x) * sum;
    } else {
        T term = 1, sum = 1;
        for (int k = 1; k < 60 && term > std::numeric_limits<T>::epsilon() / 16; ++k) {
            term *= T(2 * k - 1) * T(2 * k - 1) / (T(8) * T(k) * x);
            sum += term;
        }
        return sum / std::sqrt(2 * std::numbers::pi_v<T> * x);
    }
}
template <>
CUTICLE_INLINE ScaledBessel<double> SplitI0e(double x) {
    return {I0e(x), 0};
}
template <>
CUTICLE_INLINE ScaledBessel<long double> SplitI0e(long double x) {
    return {I0e(x), 0};
}
//<

} // namespace cuticle
//<
