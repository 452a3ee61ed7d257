#> Fit the polynomials
"""Fits the polynomials of core/special.h and fibers/hair_kernel.h, prints their coefficients and errors.

    fit_special.py           prints each fit, its largest relative error, and what rounding its coefficients adds
    fit_special.py --check   fails if a source holds other numbers than these; 77 where mpmath is missing

Needs mpmath (Debian: python3-mpmath).
"""
import re
import sys
from pathlib import Path

try:
    from mpmath import atan, besseli, cos, exp, expm1, log, lu_solve, matrix, mp, mpf, nstr, pi, polyval, sin, sqrt
except ImportError:
    print("needs mpmath (Debian: python3-mpmath)", file=sys.stderr)
    sys.exit(77)

mp.dps = 40
SRC = Path(__file__).resolve().parent.parent


#> Interpolate at Chebyshev's nodes
def fit(f, a, b, degree):
    """The polynomial through f at the zeros of a Chebyshev polynomial on [a, b], from the constant upward."""
    n = degree + 1
    nodes = [(a + b) / 2 + (b - a) / 2 * cos(pi * (2 * i + 1) / (2 * n)) for i in range(n)]
    powers = matrix(n, n)
    for i, x in enumerate(nodes):
        for j in range(n):
            powers[i, j] = x ** j
    return list(lu_solve(powers, matrix([f(x) for x in nodes])))
#<


#> Say what is fitted
def scaled_bessel(t):
    """exp(-x) I_0(x) / sqrt(t) for t = 1 / (x + 1/4)."""
    x = 1 / t - mpf(1) / 4
    return besseli(0, x) * exp(-x) / sqrt(t)


# Name, what a polynomial in y stands for, its interval and degree, and the result made of y and the polynomial's
# value there with the exact result beside it. To add one: a row, and its numbers in the source.
FITS = [
    ("I0 below 5", lambda y: besseli(0, sqrt(y)), 0, 25, 7, lambda y, p: (p, besseli(0, sqrt(y)))),
    ("I0 above 5", scaled_bessel, 0, 1 / mpf("5.25"), 7, lambda t, p: (p, scaled_bessel(t))),
    ("exp(r) - 1", lambda r: (expm1(r) - r) / r ** 2 if abs(r) > 1e-15 else mpf(1) / 2, -log(2) / 2, log(2) / 2, 4,
     lambda r, p: (r + r * r * p, expm1(r))),
    ("sine", lambda y: (sin(sqrt(y)) / sqrt(y) - 1) / y, 0, (pi / 4) ** 2, 3,
     lambda y, p: (1 + y * p, sin(sqrt(y)) / sqrt(y))),
    ("cosine", lambda y: (cos(sqrt(y)) - 1) / y, 0, (pi / 4) ** 2, 3, lambda y, p: (1 + y * p, cos(sqrt(y)))),
    ("arc tangent", lambda y: atan(sqrt(y)) / sqrt(y), 0, 1, 8, lambda y, p: (p, atan(sqrt(y)) / sqrt(y))),
]
#<


#> Measure the error
def largest_error(coefficients, a, b, result):
    """Over 600 points that crowd at both ends, the ends left out: there the quotients are 0/0."""
    worst = mpf(0)
    for i in range(1, 600):
        y = (a + b) / 2 - (b - a) / 2 * cos(pi * mpf(i) / 600)
        if y:
            ours, exact = result(y, polyval(coefficients[::-1], y))
            worst = max(worst, abs(ours / exact - 1))
    return worst
#<


#> Compare with the sources
def main():
    check = "--check" in sys.argv[1:]
    sources = "".join((SRC / name).read_text(encoding="utf-8") for name in ("core/special.h", "fibers/hair_kernel.h"))
    known = set(re.findall(r"-?\d[\d.]*(?:e-?\d+)?(?=f\b)", sources))
    missing = 0
    for name, f, a, b, degree, result in FITS:
        rounded = [nstr(c, 10, strip_zeros=True) for c in fit(f, mpf(a), mpf(b), degree)]
        error = largest_error([mpf(c) for c in rounded], mpf(a), mpf(b), result)
        print(f"{name:12} error {nstr(error, 2):8} {' '.join(rounded)}")
        for number in rounded if check else []:
            if not any(abs(mpf(k) - mpf(number)) <= abs(mpf(number)) * mpf(10) ** -9 for k in known):
                print(f"error: no source holds {number}, a coefficient of the {name}")
                missing += 1
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
#<
#<
