#!/usr/bin/env python3
"""Reference values of hair scattering with forty digits, written as JSON beside this file.

    generate.py           computes all files anew
    generate.py --check   fails if a file is not what this text computes; 77 where mpmath is missing

Nothing here is taken from the renderer: the formulas of Pharr 2016 (Chiang et al. 2016) and d'Eon et al. 2011 are written
down plainly, as the papers have them where the papers are right, and forty digits stand in for every trick that binary
numbers need. Needs mpmath. README.md says how to use the files.
"""
import itertools
import json
import os
import struct
import sys

try:
    from mpmath import mp, mpf
except ImportError:
    print('needs mpmath (Debian: python3-mpmath)', file=sys.stderr)
    sys.exit(77)  # for CTest: skipped

mp.dps = 40
HERE = os.path.dirname(os.path.abspath(__file__))
VERSION = 1
PI = mp.pi
TILT_IN_ALPHA = (2, -1, -4, 0)


def binary32(x):
    """The nearest number of binary32: what a renderer in single precision gets, exactly."""
    return mpf(struct.unpack('f', struct.pack('f', float(x)))[0])


# pbrt-v3's weights of red, green and blue, as numbers of binary32
LUMINANCE = tuple(binary32(w) for w in ('0.212671', '0.715160', '0.072169'))


# --- the model ---------------------------------------------------------------------------------------------------

def i0e(x):
    """exp(-x) I_0(x)."""
    return mp.besseli(0, x) * mp.exp(-x)


def mp_lobe(theta_o, theta_i, v):
    """M_p, d'Eon et al. 2011, its exponents collected."""
    a = mp.cos(theta_i) * mp.cos(theta_o) / v
    return mp.exp(-(1 - mp.cos(theta_i + theta_o)) / v) * i0e(a) / (v * -mp.expm1(-2 / v))


def longitudinal_variances(beta_m):
    v = (mpf('0.726') * beta_m + mpf('0.812') * beta_m**2 + mpf('3.7') * beta_m**20)**2
    return (v, v / 4, 4 * v, 4 * v)


def azimuthal_scale(beta_n):
    return mp.sqrt(PI / 8) * (mpf('0.265') * beta_n + mpf('1.194') * beta_n**2 + mpf('5.372') * beta_n**22)


def logistic_cdf(x, s):
    return 1 / (1 + mp.exp(-x / s))


def trimmed_logistic(x, s):
    e = mp.exp(-abs(x) / s)
    return e / (s * (1 + e)**2) / (logistic_cdf(PI, s) - logistic_cdf(-PI, s))


def sample_trimmed_logistic(u, s):
    below, above = logistic_cdf(-PI, s), logistic_cdf(PI, s)
    return -s * mp.log(1 / (below + u * (above - below)) - 1)


def wrap(x):
    return x - 2 * PI * mp.nint(x / (2 * PI))


def eta_prime(theta_o, eta):
    return mp.sqrt(eta**2 - mp.sin(theta_o)**2) / mp.cos(theta_o)


def net_turn(p, h, theta_o, eta):
    """Phi(p, h): how far a path of p segments turns around the fiber."""
    return 2 * p * mp.asin(h / eta_prime(theta_o, eta)) - 2 * mp.asin(h) + p * PI


def fresnel(cos_i, eta):
    """Reflectance of a smooth dielectric, mean of both polarizations."""
    cos_t = mp.sqrt(1 - (1 - cos_i**2) / eta**2)
    parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    return (parallel**2 + perpendicular**2) / 2


def attenuations(h, theta_o, eta, sigma_a):
    """A_0, A_1, A_2 and the sum of all that follow."""
    f = fresnel(mp.cos(theta_o) * mp.sqrt(1 - h**2), eta)
    cos_theta_t = mp.sqrt(1 - (mp.sin(theta_o) / eta)**2)
    cos_gamma_t = mp.sqrt(1 - (h / eta_prime(theta_o, eta))**2)
    t = mp.exp(-sigma_a * 2 * cos_gamma_t / cos_theta_t)
    if f == 1:  # grazing the edge: the limit
        return (mpf(1), mpf(0), mpf(0), mpf(0))
    a1 = (1 - f)**2 * t
    return (f, a1, a1 * t * f, a1 * t**2 * f**2 / (1 - t * f))


class Fiber:
    """Parameters as a scene gives them; tilt 1: highlight toward the root (Marschner, Pharr's text); -1: pbrt-v3."""

    def __init__(self, h, eta, sigma_a, beta_m, beta_n, alpha, tilt):
        self.h, self.eta, self.sigma_a = h, eta, sigma_a
        self.v, self.s = longitudinal_variances(beta_m), azimuthal_scale(beta_n)
        self.tilt = [tilt * k * alpha * PI / 180 for k in TILT_IN_ALPHA]

    def colours(self, theta_o):
        """A_p of red, green, blue for each lobe."""
        return list(zip(*[attenuations(self.h, theta_o, self.eta, s) for s in self.sigma_a]))

    def shares(self, theta_o):
        y = [sum(w * a for w, a in zip(LUMINANCE, ap)) for ap in self.colours(theta_o)]
        return [x / sum(y) for x in y]

    def lobe(self, p, theta_o, theta_i, phi):
        m = mp_lobe(theta_o + self.tilt[p], theta_i, self.v[p])
        if p == 3:
            return m / (2 * PI)
        return m * trimmed_logistic(wrap(phi - net_turn(p, self.h, theta_o, self.eta)), self.s)

    def evaluate(self, theta_o, theta_i, phi):
        """f |cos| in red, green, blue, and the density per solid angle; phi = phi_i - phi_o."""
        lobes = [self.lobe(p, theta_o, theta_i, phi) for p in range(4)]
        f = [sum(ap[c] * m for ap, m in zip(self.colours(theta_o), lobes)) for c in range(3)]
        return f + [sum(s * m for s, m in zip(self.shares(theta_o), lobes))]

    def choose(self, theta_o, u):
        """The lobe that u picks, and how near u lies to another's."""
        below, nearest = mpf(0), mpf(1)
        lobe = None
        for p, share in enumerate(self.shares(theta_o)):
            if lobe is None and u < below + share:
                lobe = p
            below += share
            nearest = min(nearest, abs(u - below)) if p < 3 else nearest
        return lobe, nearest

    def sample(self, lobe, theta_o, u_azimuth, u_cos, u_turn):
        """sin theta_i, phi_i - phi_o, f |cos| and density for random numbers."""
        v, tilted = self.v[lobe], theta_o + self.tilt[lobe]
        cos_t = 1 + v * mp.log(u_cos + (1 - u_cos) * mp.exp(-2 / v))
        sin_t = mp.sqrt(1 - cos_t**2)
        # |cos| of a tilt beyond the pole: the same height on the other side
        sin_i = -cos_t * mp.sin(tilted) + sin_t * mp.cos(2 * PI * u_turn) * abs(mp.cos(tilted))
        theta_i = mp.asin(sin_i)
        if lobe == 3:
            phi = PI * (2 * u_azimuth - 1)
        else:
            phi = wrap(net_turn(lobe, self.h, theta_o, self.eta) + sample_trimmed_logistic(u_azimuth, self.s))
        return [theta_i, phi] + self.evaluate(theta_o, theta_i, phi)


# --- how much rounding the inputs moves a value ------------------------------------------------------------------------

def condition(f, angles, numbers, absolute=False):
    """Sum of |d log f / d angle| and |x d log f / d x| (of |d f / ...| if absolute): by how many roundings of its inputs
    a value moves. The worst of the values that f returns as a list. Where an azimuth is compared with a lobe's, callers
    add 2 pi / s: the difference of angles of that size, in widths of the lobe."""
    step = mpf(10)**-18
    inputs = list(angles) + list(numbers)
    centre = f(*inputs)
    total = [mpf(0)] * len(centre)
    for k, x in enumerate(inputs):
        scale = mpf(1) if k < len(angles) else x
        if scale == 0:
            continue
        moved = list(inputs)
        moved[k] = x - step * scale  # to one side: some numbers stand at the end of their range
        for i, (a, b) in enumerate(zip(f(*moved), centre)):
            total[i] += abs(a - b) / step / (1 if absolute or b == 0 else abs(b))
    return max(total)


# --- files ------------------------------------------------------------------------------------------------------------

def number(x):
    if isinstance(x, int):
        return str(x)
    text = mp.nstr(x, 17)
    return text[:-2] if text.endswith('.0') else text


def write(name, quantity, inputs, outputs, notes, rows, tolerance=True):
    head = {
        'format': 'cuticle hair vectors', 'version': VERSION, 'quantity': quantity,
        'made_by': 'tests/vectors/generate.py, mpmath, %d digits, rounded to 17' % mp.dps,
        'inputs': inputs, 'outputs': outputs, 'notes': notes,
    }
    if tolerance:
        head['tolerance'] = ('|x - value| <= u (16 + 2 condition) |value|, u = 2^-24 for binary32 and 2^-53 for binary64; '
                             'condition: how many times its size a rounding of the inputs moves the value')
    columns = inputs + outputs + (['condition'] if tolerance else [])
    body = ',\n'.join('[' + ','.join(number(x) for x in row) + ']' for row in rows)
    text = json.dumps(head, indent=1)[:-2] + ',\n "columns": ' + json.dumps(columns) + ',\n "rows": [\n' + body + '\n]}\n'
    return name, text


def rounded_up(x):
    """A condition number needs no more than three digits."""
    return mpf(mp.nstr(x * mpf('1.005'), 3))


def bessel():
    rows = []
    for k in range(-24, 29):
        for m in (1, mpf('1.375')):
            x = binary32(m * mpf(2)**(mpf(k) / 2))
            rows.append([x, i0e(x), rounded_up(condition(lambda y: [i0e(y)], [], [x]))])
    rows += [[x, i0e(x), rounded_up(condition(lambda y: [i0e(y)], [], [x]))]
             for x in (mpf(12), binary32('12.000001'), mpf(50))]
    return write('bessel.json', 'exp(-x) I_0(x), the exponentially scaled modified Bessel function of order 0', ['x'], ['i0e'],
                 ['x = 12 is where pbrt-v3 and its heirs change from a series to a logarithm'], rows)


def longitudinal():
    rows = []
    variances = [binary32(mpf(10)**k) for k in (-8, -6, -4, -2, -1, 0, 2)]
    variances += [mpf('0.02'), mpf('0.09'), mpf('0.1'), mpf('0.1002'), mpf('0.3')]
    for v, theta_o in itertools.product(map(binary32, variances), (0, 0.5, -1.125, 1.5, -1.5625)):
        theta_o = mpf(theta_o)
        spread = mp.sqrt(v)
        offsets = (0, 1, -2.5) if v < 0.5 else (0, 1)
        for k in offsets:
            theta_i = binary32(max(-1.57, min(1.57, -theta_o + k * spread)))
            value = mp_lobe(theta_o, theta_i, v)
            if value > 1e-30:
                c = condition(lambda o, i, w: [mp_lobe(o, i, w)], [theta_o, theta_i], [v])
                rows.append([v, theta_o, theta_i, value, rounded_up(c)])
    return write('mp.json', 'M_p, the longitudinal lobe: its integral over cos(theta_i) dtheta_i is 1', ['v', 'theta_o', 'theta_i'],
                 ['mp'], ['v: variance of the lobe, radians squared; angles in radians; all inputs are numbers of binary32'], rows)


def azimuthal():
    def values(theta_o, phi, p, h, eta, beta_n):
        s = azimuthal_scale(beta_n)
        return [trimmed_logistic(wrap(phi - net_turn(p, h, theta_o, eta)), s)]

    rows = []
    grid = itertools.product((0, 1, 2), (0, 0.5, -0.75, 0.96875), (0, 1.125, -1.5), (0.0625, 0.3125, 0.75, 1))
    for k, (p, h, theta_o, beta_n) in enumerate(grid):
        h, theta_o, beta_n, eta = mpf(h), mpf(theta_o), mpf(beta_n), mpf('1.5') if k % 3 else binary32('1.55')
        s = azimuthal_scale(beta_n)
        phi = binary32(wrap(net_turn(p, h, theta_o, eta) + s * (0, 1, -3)[k % 3]))
        c = condition(lambda o, f, hh, e, b: values(o, f, p, hh, e, b), [theta_o, phi], [h, eta, beta_n])
        rows.append([p, h, theta_o, eta, beta_n, phi, wrap(net_turn(p, h, theta_o, eta)),
                     values(theta_o, phi, p, h, eta, beta_n)[0], rounded_up(c + 2 * PI / s)])
    return write('np.json', 'Phi(p, h), wrapped to [-pi, pi], and N_p, the trimmed logistic around it: its integral over phi is 1',
                 ['p', 'h', 'theta_o', 'eta', 'beta_n', 'phi'], ['turn', 'np'],
                 ['phi = phi_i - phi_o', 'turn: its tolerance is absolute, u (16 + 2 condition)'], rows)


def attenuation():
    rows = []
    grid = itertools.product((0, 0.5, -0.75, 0.9375, 0.9990234375), (0, 0.75, -1.25, 1.5, 1.5625),
                             ('1.55', '1.3', '1.0009765625'), (0, 0.25, 4))
    for k, (h, theta_o, eta, sigma) in enumerate(grid):
        if k % 2 and k > 12:
            continue
        h, theta_o, eta, sigma = mpf(h), mpf(theta_o), binary32(eta), mpf(sigma)
        a = attenuations(h, theta_o, eta, sigma)
        if min(a) < 1e-30:
            continue
        c = condition(lambda o, hh, e, s: list(attenuations(hh, o, e, s)), [theta_o], [h, eta, sigma])
        rows.append([h, theta_o, eta, sigma] + list(a) + [sum(a), rounded_up(c)])
    for h, sigma in itertools.product((1, -1), (0, 1)):
        rows.append([mpf(h), mpf('0.5'), binary32('1.55'), mpf(sigma), mpf(1), mpf(0), mpf(0), mpf(0), mpf(1), mpf(0)])
    return write('ap.json', 'A_p, the attenuations: A_0 to A_2, A_3 the sum of all further orders, and their total',
                 ['h', 'theta_o', 'eta', 'sigma_a'], ['a0', 'a1', 'a2', 'a3', 'total'],
                 ['sigma_a per fiber radius; a segment is 2 cos(gamma_t) / cos(theta_t) radii',
                  'h = +-1: the limits; add an absolute tolerance of 64 u, as rounding keeps cos(gamma_o) from 0',
                  'sigma_a = 0: the total is 1'], rows)


SIGMAS = ((0, 0, 0), ('0.125', '0.25', '0.5'), ('3.5', '5.5', '11'))


def fibers():
    """A Latin choice of parameters: every value of each occurs, in changing company."""
    hs = (0, 0.5, -0.75, 0.9375, -0.25, 0.9990234375)
    betas = (0.3125, 0.0625, 0.6875, 1, 0.125, 0.25)
    for k in range(12):
        yield dict(h=mpf(hs[k % 6]), eta=binary32('1.55') if k % 4 else mpf('1.375'),
                   sigma_a=[mpf(s) for s in SIGMAS[(k + k // 3) % 3]], beta_m=mpf(betas[(k + k // 6) % 6]),
                   beta_n=mpf(betas[(5 * k + 1) % 6]), alpha=mpf((2, 0, 5)[(k + k // 6) % 3]), tilt=(1, -1)[k % 2])


PARAMETERS = ['h', 'eta', 'sigma_r', 'sigma_g', 'sigma_b', 'beta_m', 'beta_n', 'alpha', 'tilt']
PARAMETER_NOTES = [
    'theta from the plane normal to the fiber, positive toward the tip; phi = phi_i - phi_o; radians; alpha in degrees',
    'tilt 1: theta_o + 2 alpha, - alpha, - 4 alpha in M_p of R, TT, TRT (toward the root: Marschner, Pharr\'s text); '
    '-1: the opposite (pbrt-v3\'s program)',
    'lobe 3 holds all orders from 3 on, is uniform in phi and not tilted',
    'the density weighs lobes by 0.212671 r + 0.715160 g + 0.072169 b of A_p, these weights rounded to binary32',
]


def row_of(f):
    return [f['h'], f['eta'], *f['sigma_a'], f['beta_m'], f['beta_n'], f['alpha'], f['tilt']]


def moved_fiber(f, h, eta, sigma, beta_m, beta_n):
    """The fiber with other numbers; sigma scales the absorption."""
    return Fiber(h, eta, [sigma * s for s in f['sigma_a']], beta_m, beta_n, f['alpha'], f['tilt'])


def numbers_of(f):
    return [f['h'], f['eta'], mpf(1), f['beta_m'], f['beta_n']]


def bsdf():
    rows = []
    views = (0, 0.5, -1.125, 1.5)
    for k, f in enumerate(fibers()):
        fiber = Fiber(**f)
        for j, theta_o in enumerate(map(mpf, views)):
            for p in range(4):
                # in the flank of a lobe, the last case somewhere else
                lobe = (p + k + j) % 4
                theta_i = binary32(max(-1.55, min(1.55, -(theta_o + fiber.tilt[lobe]) + (-1)**j * 0.75 * mp.sqrt(fiber.v[lobe]))))
                if lobe == 3:
                    phi = binary32((-1)**j * 2.5 + 0.25 * k - 1.5)
                else:
                    phi = binary32(wrap(net_turn(lobe, fiber.h, theta_o, fiber.eta) + (-1)**p * fiber.s))
                value = fiber.evaluate(theta_o, theta_i, phi)
                if min(value) < 1e-30:
                    continue
                c = condition(lambda o, i, a, *x: moved_fiber(f, *x).evaluate(o, i, a), [theta_o, theta_i, phi], numbers_of(f))
                rows.append(row_of(f) + [theta_o, theta_i, phi] + value + [rounded_up(c + 2 * PI / fiber.s)])
    return write('bsdf.json', 'f |cos theta_n| in red, green, blue, where theta_n is the angle to the surface normal, and the density of sampling, 1/sr',
                 PARAMETERS + ['theta_o', 'theta_i', 'phi'], ['f_cos_r', 'f_cos_g', 'f_cos_b', 'pdf'],
                 PARAMETER_NOTES, rows)


def samples():
    rows = []
    us = [tuple(mpf(x) / 64 for x in u) for u in ((3, 11, 37, 50), (20, 52, 9, 13), (40, 30, 60, 33), (57, 5, 25, 3), (62, 63, 1, 22))]
    for f in fibers():
        fiber = Fiber(**f)
        for theta_o, u in itertools.product(map(mpf, (0.25, -1.25)), us):
            lobe, nearest = fiber.choose(theta_o, u[0])
            if nearest < 1e-3:
                continue
            value = fiber.sample(lobe, theta_o, *u[1:])
            if min(value[2:]) < 1e-30 or abs(mp.cos(value[0])) < 1e-3:
                continue
            numbers = list(u[1:]) + numbers_of(f)
            c = condition(lambda o, ua, uc, ut, *x: moved_fiber(f, *x).sample(lobe, o, ua, uc, ut)[2:], [theta_o], numbers)
            a = condition(lambda o, ua, uc, ut, *x: moved_fiber(f, *x).sample(lobe, o, ua, uc, ut)[:2], [theta_o], numbers, True)
            rows.append(row_of(f) + [theta_o, *u, lobe] + value + [rounded_up(max(a, c) + 2 * PI / fiber.s)])
    return write('samples.json', 'The direction, its f |cos theta_n| and its density that four random numbers choose',
                 PARAMETERS + ['theta_o', 'u_lobe', 'u_azimuth', 'u_cosine', 'u_turn'],
                 ['lobe', 'theta_i', 'phi', 'f_cos_r', 'f_cos_g', 'f_cos_b', 'pdf'],
                 PARAMETER_NOTES + [
                     'the recipe is pbrt-v3\'s (u_lobe, u_azimuth: halves of its first number, u_cosine, u_turn: of its second), but for '
                     'lobe 3, whose phi is pi (2 u_azimuth - 1): another recipe for the same density is as right; hold it against cells.json',
                     'theta_i, phi: the tolerance is absolute, u (16 + 2 condition)'], rows)


ROWS_OF_CELLS, COLUMNS_OF_CELLS = 16, 12


def cells():
    """Probabilities of a grid of equal steps of sin theta_i and of phi."""
    rows = []
    for k, f in enumerate(fibers()):
        if k % 2:
            continue
        fiber = Fiber(**f)
        theta_o = mpf((0.25, -1.25, 0.75)[k // 2 % 3])
        along = [[mp.quad(lambda t, q=p: mp_lobe(theta_o + fiber.tilt[q], t, fiber.v[q]) * mp.cos(t),
                          panels(i, theta_o + fiber.tilt[p], fiber.v[p])) for i in range(ROWS_OF_CELLS)] for p in range(4)]
        around = []
        for p in range(3):
            turn = net_turn(p, fiber.h, theta_o, fiber.eta)
            around.append([logistic_mass(-PI + 2 * PI * j / COLUMNS_OF_CELLS - turn, fiber.s) for j in range(COLUMNS_OF_CELLS)])
        around.append([mpf(1) / COLUMNS_OF_CELLS] * COLUMNS_OF_CELLS)
        shares = fiber.shares(theta_o)
        table = [sum(shares[p] * along[p][i] * around[p][j] for p in range(4))
                 for i in range(ROWS_OF_CELLS) for j in range(COLUMNS_OF_CELLS)]
        assert abs(sum(table) - 1) < 1e-20, sum(table)
        rows.append(row_of(f) + [theta_o] + [mpf(mp.nstr(x, 9)) for x in table])
    names = ['p_%d_%d' % (i, j) for i in range(ROWS_OF_CELLS) for j in range(COLUMNS_OF_CELLS)]
    return write('cells.json', 'The share of sampled directions that falls into each cell of a grid: %d equal steps of sin theta_i from -1 to 1 '
                 'times %d equal steps of phi from -pi to pi' % (ROWS_OF_CELLS, COLUMNS_OF_CELLS), PARAMETERS + ['theta_o'], names,
                 PARAMETER_NOTES + ['p_i_j: step i of sin theta_i, step j of phi; 9 digits',
                                    'for any way of sampling: Pearson\'s chi-squared with n (cells) p >= 5, or 5 standard deviations a cell'],
                 rows, tolerance=False)


def panels(i, tilted, v):
    """Edges for the quadrature of M_p over a step of sin theta_i, closing up on the peak."""
    low, high = (mp.asin(-1 + mpf(2) * k / ROWS_OF_CELLS) for k in (i, i + 1))
    peak = mp.asin(-mp.sin(tilted))
    inside = [peak + k * mp.sqrt(v) for k in (-12, -6, -3, -1, 0, 1, 3, 6, 12)]
    return [low] + [x for x in inside if low < x < high] + [high]


def logistic_mass(start, s):
    """The trimmed logistic's mass in one step that begins at start, around the circle."""
    step = 2 * PI / COLUMNS_OF_CELLS
    start = start - 2 * PI * mp.floor((start + PI) / (2 * PI))  # in [-pi, pi)
    whole = logistic_cdf(PI, s) - logistic_cdf(-PI, s)
    mass = logistic_cdf(min(start + step, PI), s) - logistic_cdf(start, s)
    if start + step > PI:
        mass += logistic_cdf(start + step - 2 * PI, s) - logistic_cdf(-PI, s)
    return mass / whole


def energies():
    rows = []
    for theta_o, eta, sigma in itertools.product((0, 0.75, -1.25, 1.5), ('1.55', '1.3'), (0, 0.25, 2)):
        theta_o, eta, sigma = mpf(theta_o), binary32(eta), mpf(sigma)
        whole = [mp.quad(lambda g, q=p: attenuations(mp.sin(g), theta_o, eta, sigma)[q] * mp.cos(g), [0, PI / 4, PI / 2]) for p in range(4)]
        rows.append([theta_o, eta, sigma] + whole + [sum(whole)])
    return write('energies.json', 'The energy of each lobe and of all, averaged over the width of the fiber (h uniform in [-1, 1])',
                 ['theta_o', 'eta', 'sigma_a'], ['e0', 'e1', 'e2', 'e3', 'albedo'],
                 ['M_p and N_p integrate to 1 each, so the integral of f |cos theta_n| over the sphere at one h is the sum of A_p whatever '
                  'beta_m, beta_n and alpha are: integrate your f itself, for a furnace that samples the BSDF cannot see a wrong M_p',
                  'for quadrature over h take h = sin(gamma): the edge has a square root'],
                 rows, tolerance=False)


# --- far field: a smooth fiber met over its whole width, d'Eon et al. 2011, Marschner et al. 2003 -------------------------

def smooth_paths(p, phi, theta, eta):
    """All gamma = asin h whose path p leaves at phi: the intervals where Phi is monotone, bisected."""
    def turn(gamma):
        return net_turn(p, mp.sin(gamma), theta, eta)

    square = mpf(p)**2
    caustic = mp.asin(mp.sqrt((square - eta_prime(theta, eta)**2) / (square - 1))) if p > 1 and eta_prime(theta, eta) < p else None
    edges = [-PI / 2] + ([-caustic, caustic] if caustic else []) + [PI / 2]
    roots = []
    for low, high in zip(edges, edges[1:]):
        a, b = sorted((turn(low), turn(high)))
        k = mp.ceil((a - phi) / (2 * PI))
        while phi + 2 * PI * k < b:
            target = phi + 2 * PI * k
            roots.append(mp.findroot(lambda g: turn(g) - target, (low, high), solver='anderson', tol=mpf(10)**-30))
            k += 1
    return roots


def smooth_np():
    rows = []
    for p, theta, eta, sigma in itertools.product((0, 1, 2, 3), (0, 0.75, -1.25), ('1.55', '1.3'), (0, 0.25)):
        theta, eta, sigma = mpf(theta), binary32(eta), mpf(sigma)
        for phi in (0.0625, 0.75, 2.5, -3):
            phi = mpf(phi)
            total, steep, roots = mpf(0), False, smooth_paths(p, phi, theta, eta)
            for g in roots:
                slope = abs(mp.diff(lambda x: net_turn(p, mp.sin(x), theta, eta), g))
                steep = steep or slope < 0.05 or mp.cos(g) < 0.01  # next to a caustic or the edge
                total += path_attenuation(p, mp.sin(g), theta, eta, sigma) * mp.cos(g) / (2 * slope)
            if roots and not steep:
                rows.append([p, theta, eta, sigma, phi, len(roots), total])
    return write('smooth_np.json', 'N_p of a smooth fiber, lit over its whole width: the sum over all paths of A_p |2 dPhi/dh|^-1',
                 ['p', 'theta_d', 'eta', 'sigma_a', 'phi'], ['paths', 'np'],
                 ['the truth that Marschner et al. 2003 approximate by a cubic; paths: how many leave at phi',
                  'exact to 15 digits; not next to caustics'], rows, tolerance=False)


def path_attenuation(p, h, theta, eta, sigma):
    """A_p of one order, any p."""
    f = fresnel(mp.cos(theta) * mp.sqrt(1 - h**2), eta)
    if p == 0:
        return f
    length = 2 * mp.sqrt(1 - (h / eta_prime(theta, eta))**2) / mp.sqrt(1 - (mp.sin(theta) / eta)**2)
    return (1 - f)**2 * f**(p - 1) * mp.exp(-p * sigma * length)


def rough_np():
    rows = []
    for p, theta, beta, sigma in itertools.product((0, 1, 2, 3), (0, -1.25), ('0.0625', '0.25', '1.25'), (0, 0.25)):
        theta, beta, sigma, eta = mpf(theta), mpf(beta), mpf(sigma), binary32('1.55')

        def integrand(g, phi):
            x = wrap(phi - net_turn(p, mp.sin(g), theta, eta))
            detector = sum(mp.exp(-((x + 2 * PI * k) / beta)**2 / 2) for k in range(-3, 4)) / (beta * mp.sqrt(2 * PI))
            return path_attenuation(p, mp.sin(g), theta, eta, sigma) * detector * mp.cos(g) / 2

        # panels of Gauss and Legendre, so narrow that no lobe is missed
        panels = int(mp.ceil(8 / beta)) + 8
        edges = [PI * (mpf(k) / panels - mpf(1) / 2) for k in range(panels + 1)]
        with mp.workdps(20):
            for phi in (mpf('0.5'), mpf(3)):
                value = mp.quad(lambda g, f=phi: integrand(g, f), edges, method='gauss-legendre', maxdegree=3)
                if value > 1e-6:
                    rows.append([p, theta, eta, sigma, beta, phi, mpf(mp.nstr(value, 12))])
    return write('rough_np.json', "N_p through d'Eon's Gaussian detector: 1/2 the integral over h of A_p sum_k g(beta; phi - Phi(p, h) + 2 pi k)",
                 ['p', 'theta_d', 'eta', 'sigma_a', 'beta', 'phi'], ['np'],
                 ['A_0 is F at h; beta in radians; 12 digits, so that orders of quadrature can be judged'], rows, tolerance=False)


def colours():
    rows = []
    for c, beta_n in itertools.product(('0.0625', '0.25', '0.5', '0.9375', '1'), ('0.0625', '0.3125', '0.75', '1')):
        c, b = mpf(c), mpf(beta_n)
        scale = sum(mpf(k) * b**i for i, k in enumerate(('5.969', '-0.215', '2.532', '-10.73', '5.574', '0.245')))
        rows.append([c, b, (mp.log(c) / scale)**2, rounded_up(condition(
            lambda cc: [(mp.log(cc) / scale)**2], [], [c]) if c < 1 else mpf(0))])
    return write('reflectance.json', 'sigma_a with which a mass of hair looks of a colour: the fit of Chiang et al. 2016',
                 ['reflectance', 'beta_n'], ['sigma_a'], ['one channel; sigma_a per fiber radius'], rows)


FILES = (bessel, longitudinal, azimuthal, attenuation, bsdf, samples, cells, energies, colours, smooth_np, rough_np)


def main():
    check = sys.argv[1:] == ['--check']
    if sys.argv[1:] and not check:
        sys.exit(__doc__)
    wrong = []
    for make in FILES:
        name, text = make()
        path = os.path.join(HERE, name)
        if check:
            with open(path, encoding='utf-8') as file:
                if file.read() != text:
                    wrong.append(name)
        else:
            with open(path + '.new', 'w', encoding='utf-8') as file:
                file.write(text)
            os.replace(path + '.new', path)
            print('wrote %s: %d bytes, %d rows' % (name, len(text), text.count('\n[')))
    if wrong:
        sys.exit('not what generate.py computes: ' + ', '.join(wrong))


if __name__ == '__main__':
    main()
