#!/usr/bin/env python3
"""Reference values of hair scattering with forty digits, written as JSON beside this file.

    generate.py           computes all files anew
    generate.py --check   fails if a file is not what this text computes; 77 where mpmath is missing

The models are written down in models.py; nothing is taken from the renderer. Needs mpmath. README.md says how to use the
files.
"""
import itertools
import json
import math
import os
import sys

try:
    from mpmath import mp, mpf
    from models import (PI, DEon, ExactPaths, Fiber, KajiyaKay, Marschner, Glint, attenuations, azimuthal_scale, binary32,
                        choose, i0e, logistic_cdf, luminance, mp_lobe, net_turn, panels, path_attenuation,
                        trimmed_logistic, wrap)
except ImportError:
    print('needs mpmath (Debian: python3-mpmath)', file=sys.stderr)
    sys.exit(77)  # for CTest: skipped

HERE = os.path.dirname(os.path.abspath(__file__))
VERSION = 1


# --- how much rounding the inputs moves a value ------------------------------------------------------------------------

def condition(f, angles, numbers, absolute=0):
    """Sum of |d log f / d angle| and |x d log f / d x| (|d f / ...| of the first `absolute` values): by how many roundings
    of its inputs a value moves. The worst of the values that f returns as a list. Where an azimuth is compared with a
    lobe's, callers add 2 pi / s: the difference of angles of that size, in widths of the lobe."""
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
            total[i] += abs(a - b) / step / (1 if i < absolute or b == 0 else abs(b))
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


# --- rows of any model: its parameters, by name, then angles or random numbers, then values ------------------------------

COLOURS, LOBES = ('r', 'g', 'b'), ('R', 'TT', 'TRT')
SUFFIXES = {'sigma': COLOURS, 'kd': COLOURS, 'ks': COLOURS, 'alpha': LOBES, 'beta': LOBES, 'beta_m': LOBES, 'beta_n': LOBES}
VALUES = ['f_cos_r', 'f_cos_g', 'f_cos_b', 'pdf']
RANDOM = ['u_lobe', 'u_azimuth', 'u_cosine', 'u_turn']


def columns_of(parameters):
    return [c for name, value in parameters.items()
            for c in (['%s_%s' % (name, s) for s in SUFFIXES[name]] if isinstance(value, list) else [name])]


def row_of(parameters):
    return [x for value in parameters.values() for x in (value if isinstance(value, list) else [value])]


class Moved:
    """A model whose numbers are moved: those of the parameters named, the three of a colour by one factor."""

    def __init__(self, model, parameters, names):
        self.model, self.parameters = model, parameters
        self.places, self.start = [], []
        for name in names:
            value = parameters[name]
            single = SUFFIXES.get(name) == COLOURS or not isinstance(value, list)
            self.places += [(name, None)] if single else [(name, k) for k in range(len(value))]
            self.start += [mpf(1) if isinstance(value, list) else value] if single else value

    def at(self, numbers):
        moved = dict(self.parameters)
        for (name, k), x in zip(self.places, numbers):
            value = moved[name]
            if k is not None:
                moved[name] = value[:k] + [x] + value[k + 1:]
            else:
                moved[name] = [x * c for c in value] if isinstance(value, list) else x
        return self.model(**moved)


def value_row(model, parameters, names, angles, extra):
    """A list of one row, or of none where nothing is to be seen. extra: added to the condition."""
    value = model(**parameters).evaluate(*angles)
    if min(value) < 1e-30:
        return []
    moved, n = Moved(model, parameters, names), len(angles)
    c = condition(lambda *x: moved.at(x[n:]).evaluate(*x[:n]), angles, moved.start)
    return [row_of(parameters) + angles + value + [rounded_up(c + extra)]]


def sample_row(model, parameters, names, view, u, absolute, extra):
    """The same for a sample; its first `absolute` numbers are angles, and extra(them) is added. None next to another lobe,
    or to the poles."""
    fiber = model(**parameters)
    lobe, rest, nearest = choose(fiber.shares(*view), u[0])
    if nearest < 1e-3:
        return []
    value = fiber.sample(lobe, rest, *view, *u[1:])
    if min(value[absolute:]) < 1e-30 or abs(mp.cos(value[0])) < 1e-3:
        return []
    moved, n = Moved(model, parameters, names), len(view)
    c = condition(lambda *x: moved.at(x[n + 3:]).sample(lobe, rest, *x[:n + 3]), view, list(u[1:]) + moved.start, absolute)
    return [row_of(parameters) + view + list(u) + [lobe] + value + [rounded_up(c + extra(*value[:absolute]))]]


# --- Chiang et al. 2016 ------------------------------------------------------------------------------------------------

SIGMAS = ((0, 0, 0), ('0.125', '0.25', '0.5'), ('3.5', '5.5', '11'))


def fibers():
    """A Latin choice of parameters: every value of each occurs, in changing company."""
    hs = (0, 0.5, -0.75, 0.9375, -0.25, 0.9990234375)
    betas = (0.3125, 0.0625, 0.6875, 1, 0.125, 0.25)
    for k in range(12):
        yield dict(h=mpf(hs[k % 6]), eta=binary32('1.55') if k % 4 else mpf('1.375'),
                   sigma=[mpf(s) for s in SIGMAS[(k + k // 3) % 3]], beta_m=mpf(betas[(k + k // 6) % 6]),
                   beta_n=mpf(betas[(5 * k + 1) % 6]), alpha=mpf((2, 0, 5)[(k + k // 6) % 3]), tilt=(1, -1)[k % 2])


PARAMETER_NOTES = [
    'theta from the plane normal to the fiber, positive toward the tip; phi = phi_i - phi_o; radians; alpha in degrees',
    'tilt 1: theta_o + 2 alpha, - alpha, - 4 alpha in M_p of R, TT, TRT (toward the root: Marschner, Pharr\'s text); '
    '-1: the opposite (pbrt-v3\'s program)',
    'lobe 3 holds all orders from 3 on, is uniform in phi and not tilted',
    'the density weighs lobes by 0.212671 r + 0.715160 g + 0.072169 b of A_p, these weights rounded to binary32',
]


# What condition moves.
NUMBERS = ('h', 'eta', 'sigma', 'beta_m', 'beta_n')


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
                rows += value_row(Fiber, f, NUMBERS, [theta_o, theta_i, phi], 2 * PI / fiber.s)
    return write('bsdf.json', 'f |cos theta_n| in red, green, blue, where theta_n is the angle to the surface normal, and the density of sampling, 1/sr',
                 columns_of(f) + ['theta_o', 'theta_i', 'phi'], VALUES, PARAMETER_NOTES, rows)


US = [tuple(mpf(x) / 64 for x in u) for u in ((3, 11, 37, 50), (20, 52, 9, 13), (40, 30, 60, 33), (57, 5, 25, 3), (62, 63, 1, 22))]


def samples():
    rows = []
    for f in fibers():
        for theta_o, u in itertools.product(map(mpf, (0.25, -1.25)), US):
            rows += sample_row(Fiber, f, NUMBERS, [theta_o], u, 2, lambda *_, s=Fiber(**f).s: 2 * PI / s)
    return write('samples.json', 'The direction, its f |cos theta_n| and its density that four random numbers choose',
                 columns_of(f) + ['theta_o'] + RANDOM, ['lobe', 'theta_i', 'phi'] + VALUES,
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
        with mp.workdps(20):
            along = [[sum(m for _, m in step) for step in nodes_along(theta_o + fiber.tilt[p], fiber.v[p], 24)] for p in range(4)]
        around = []
        for p in range(3):
            turn = net_turn(p, fiber.h, theta_o, fiber.eta)
            around.append([logistic_mass(-PI + 2 * PI * j / COLUMNS_OF_CELLS - turn, fiber.s) for j in range(COLUMNS_OF_CELLS)])
        around.append([mpf(1) / COLUMNS_OF_CELLS] * COLUMNS_OF_CELLS)
        shares = fiber.shares(theta_o)
        table = [sum(shares[p] * along[p][i] * around[p][j] for p in range(4))
                 for i in range(ROWS_OF_CELLS) for j in range(COLUMNS_OF_CELLS)]
        assert abs(sum(table) - 1) < 1e-11, sum(table)
        rows.append(row_of(f) + [theta_o] + [mpf(mp.nstr(x, 9)) for x in table])
    return write_cells('cells.json', '', columns_of(f), PARAMETER_NOTES, rows, '9 digits')


def write_cells(name, of, columns, notes, rows, exactness):
    names = ['p_%d_%d' % (i, j) for i in range(ROWS_OF_CELLS) for j in range(COLUMNS_OF_CELLS)]
    return write(name, of + 'The share of sampled directions that falls into each cell of a grid: %d equal steps of sin theta_i from -1 to 1 '
                 'times %d equal steps of phi from -pi to pi' % (ROWS_OF_CELLS, COLUMNS_OF_CELLS), columns + ['theta_o'], names,
                 notes + ['p_i_j: step i of sin theta_i, step j of phi; ' + exactness,
                          'for any way of sampling: Pearson\'s chi-squared with n (cells) p >= 5, or 5 standard deviations a cell'],
                 rows, tolerance=False)


def nodes_along(tilted, v, n):
    """For each step of sin theta_i, theta_i and how much light of M_p each stands for."""
    peak, steps = mp.asin(-mp.sin(tilted)), []
    for i in range(ROWS_OF_CELLS):
        low, high = (mp.asin(-1 + mpf(2) * k / ROWS_OF_CELLS) for k in (i, i + 1))
        inside = [peak + k * mp.sqrt(v) for k in (-12, -6, -3, -1, 0, 1, 3, 6, 12)]  # closing up on the peak
        edges = [low] + [x for x in inside if low < x < high] + [high]
        steps.append([(t, w * mp_lobe(tilted, t, v) * mp.cos(t)) for t, w in panels(edges, n)])
    return steps


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
        whole = [mpf(0)] * 4
        for gamma, w in panels([PI / 2 * k for k in (0, mpf(1) / 2, mpf(3) / 4, mpf(7) / 8, 1)], 20):
            a = attenuations(mp.sin(gamma), theta_o, eta, sigma)
            whole = [e + w * mp.cos(gamma) * x for e, x in zip(whole, a)]
        rows.append([theta_o, eta, sigma] + whole + [sum(whole)])
    return write('energies.json', 'The energy of each lobe and of all, averaged over the width of the fiber (h uniform in [-1, 1])',
                 ['theta_o', 'eta', 'sigma_a'], ['e0', 'e1', 'e2', 'e3', 'albedo'],
                 ['M_p and N_p integrate to 1 each, so the integral of f |cos theta_n| over the sphere at one h is the sum of A_p whatever '
                  'beta_m, beta_n and alpha are: integrate your f itself, for a furnace that samples the BSDF cannot see a wrong M_p',
                  'for quadrature over h take h = sin(gamma): the edge has a square root'],
                 rows, tolerance=False)


# --- far field -----------------------------------------------------------------------------------------------------

def smooth_np():
    rows = []
    for p, theta, eta, sigma in itertools.product((0, 1, 2, 3), (0, 0.75, -1.25), ('1.55', '1.3'), (0, 0.25)):
        theta, eta, sigma = mpf(theta), binary32(eta), mpf(sigma)
        for phi in (0.0625, 0.75, 2.5, -3):
            phi = mpf(phi)
            paths = ExactPaths(p, theta, eta)
            roots = paths.roots(phi)
            steep = any(abs(paths.slope(g)) < 0.05 or mp.cos(g) < 0.01 for g in roots)  # next to a caustic or the edge
            total = sum(path_attenuation(p, mp.sin(g), theta, eta, [sigma])[0] * paths.density(g) for g in roots)
            if roots and not steep:
                rows.append([p, theta, eta, sigma, phi, len(roots), total])
    return write('smooth_np.json', 'N_p of a smooth fiber, lit over its whole width: the sum over all paths of A_p |2 dPhi/dh|^-1',
                 ['p', 'theta_d', 'eta', 'sigma_a', 'phi'], ['paths', 'np'],
                 ['the truth that Marschner et al. 2003 approximate by a cubic; paths: how many leave at phi',
                  'exact to 15 digits; not next to caustics'], rows, tolerance=False)


def rough_np():
    rows = []
    for p, theta, beta, sigma in itertools.product((0, 1, 2, 3), (0, -1.25), ('0.0625', '0.25', '1.25'), (0, 0.25)):
        theta, beta, sigma, eta = mpf(theta), mpf(beta), mpf(sigma), binary32('1.55')

        with mp.workdps(20):
            rough = DEon(eta, [sigma] * 3, [0] * 3, [1] * 3, [beta * 180 / PI] * 3, 4, False)
            for phi in (mpf('0.5'), mpf(3)):
                value = rough.azimuthal(p, theta, phi)[0][0]
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


# --- Kajiya and Kay 1989 -----------------------------------------------------------------------------------------------

def of_binary32(*numbers):
    return [binary32(x) for x in numbers]


KAJIYA_KAY_NOTES = [
    'Kd: energy of the diffuse term; Ks: that of the highlight for a view square to the fiber. The paper leaves both open',
    'f_cos = Kd cos(theta_i) / pi^2 + Ks max(0, cos(theta_o + theta_i))^exponent / (2 pi times the integral of cos^(exponent + 1) '
    'over [-pi/2, pi/2]); phi does not matter',
    'pdf: the diffuse term by cos(theta_i)^2, the highlight by a Gaussian in theta_i around -theta_o of standard deviation '
    '1 / sqrt(max(exponent, 0.1)), cut to [-pi/2, pi/2]; phi uniform; the two weighed by the luminance of Kd and Ks',
]


def cones():
    colours = [(0, 0, 0), (0.5, 0.25, 0.125), (0.0625, 0.125, 0.25), (1, 0.75, 0.5)]
    for k, exponent in enumerate((0, 1, 8.5, 40, 200, 3000, 100000, 6)):
        yield dict(kd=of_binary32(*colours[k % 4]), ks=of_binary32(*colours[(k + 1 + k // 4) % 4]), exponent=mpf(exponent))


KAJIYA_KAY_NUMBERS = ('kd', 'ks', 'exponent')


def kajiya_kay():
    rows = []
    for f in cones():
        for theta_o, (k, away) in itertools.product((0, 0.5, -1.125, 1.5), enumerate((0.25, -1, 2.5))):
            theta_i = binary32(max(-1.55, min(1.55, -theta_o + (-1)**k * away / mp.sqrt(max(1, f['exponent'])))))
            rows += value_row(KajiyaKay, f, KAJIYA_KAY_NUMBERS, [mpf(theta_o), theta_i], 0)
    return write('kajiya_kay.json', 'Kajiya and Kay 1989: f |cos theta_n| and the density of sampling', columns_of(f) + ['theta_o', 'theta_i'],
                 VALUES, KAJIYA_KAY_NOTES, rows)


def kajiya_kay_samples():
    rows = []
    for f in cones():
        for theta_o, u in itertools.product(map(mpf, (0.25, -1.25)), US):
            def rounding(theta_i, o=theta_o, model=KajiyaKay(**f)):
                return condition(lambda i: model.evaluate(o, i), [theta_i], [])
            rows += sample_row(KajiyaKay, f, KAJIYA_KAY_NUMBERS, [theta_o], u, 1, rounding)
    return write('kajiya_kay_samples.json', 'Kajiya and Kay 1989: directions that random numbers choose, f |cos theta_n| and density',
                 columns_of(f) + ['theta_o'] + RANDOM, ['lobe', 'theta_i'] + VALUES,
                 KAJIYA_KAY_NOTES + ['lobe 0, diffuse: sin(theta_i) = sqrt(u_cosine) cos(2 pi u_turn); lobe 1, highlight: theta_i where the '
                                     'Gaussian has u_cosine of its mass below',
                                     'theta_i: the tolerance is absolute, u (16 + 2 condition)'], rows)


# --- Marschner et al. 2003 -----------------------------------------------------------------------------------------------

MARSCHNER_NOTES = [
    'alpha, beta: of theta_h, w_c around the fiber, degrees; phi_o, phi_i from the major axis, radians; far field; eccentricity: a; kd: '
    'energy of a diffuse term',
    'printed 1: as the paper has it, M_p a Gaussian of theta_h, paths by the cubic (roots beyond +-pi/2 are no rays), segments of '
    '2 + 2 cos(2 gamma_t) radii, a^2 at phi_h = 0',
    'printed 0: M_p a Gaussian of theta_i + theta_o with twice the width and mean, half of the former; paths by Snell\'s law; segments of '
    '2 cos(gamma_t) radii; a^-2 at phi_h = 0, where the caustics of an ellipse belong',
    'f_cos = kd cos(theta_i) / pi^2 + sum of M_p N_p cos(theta_i) / cos(theta_d)^2; eta* bends the paths of TRT and not its A; A of the glints is '
    'taken at the caustic; g of section 5.2.2 is summed over all turns',
    'pdf: how Cuticle samples, and no part of the model: theta_i by a Gaussian around 2 alpha - theta_o of 2 beta, cut to [-pi/2, pi/2]; phi '
    'uniform for R, along rays of uniform h for TT and TRT, by the glints for their share of TRT\'s light, and where a is not 1 uniform for '
    '0.3 of TRT; eta* at phi_h = phi_o; lobes by luminance at the viewer\'s inclination, means over the width by 3 nodes of Gauss and '
    'Legendre in gamma (models.py)',
]


def marschner_numbers(f):
    """Those that condition moves: what only scales a term has no need; a circle is not made an ellipse."""
    return ('eta', 'sigma', 'beta', 'w_c', 'delta_eta') + (() if f['eccentricity'] == 1 else ('eccentricity',))


def marschner_fibers():
    """A Latin choice again."""
    for k in range(10):
        yield dict(eta=of_binary32(1.55, 1.5, 1.375)[k % 3],
                   sigma=of_binary32(*((0, 0, 0), (0.125, 0.25, 0.5), (0.5, 1, 2))[(k + k // 3) % 3]),
                   alpha=of_binary32(*((-5, 2.5, 7.5), (0, 0, 0), (-3, 1.5, 4.5))[k // 2 % 3]),
                   beta=of_binary32(*((7.5, 3.75, 15), (5, 2.5, 10), (14, 8, 22))[k // 3 % 3]),
                   eccentricity=binary32((1, 0.9, 1, 0.85, 1.125)[k % 5]), k_g=binary32((1, 0.4, 2.5, 0)[k % 4]),
                   w_c=binary32((15, 1.5, 10, 25)[k // 2 % 4]), delta_eta=binary32((0.3, 0.2)[k % 2]), delta_h=mpf('0.5'),
                   kd=of_binary32(*((0, 0, 0), (0.0625, 0.125, 0.25))[k % 2]), printed=int(k in (1, 4, 6, 9)))


def marschner():
    rows = []
    for k, f in enumerate(marschner_fibers()):
        model = Marschner(**f)
        for j, theta_o in enumerate(map(mpf, (0.5, -0.875) if k % 2 else (0, 1.25))):
            for p in range(3):
                # in the flank of a lobe along the fiber; around it 1 rad away from R, in TT, next to a caustic
                theta_i = binary32(max(-1.55, min(1.55, 2 * model.alpha[p] - theta_o + (-1)**(j + p) * 1.5 * model.beta[p])))
                phi_o = binary32((0.25, -2, 1.75)[(j + k) % 3])
                theta_d = (theta_o - theta_i) / 2
                glint = Glint(model, theta_d, model.eta_star(phi_o))
                away = (1, 3, abs(glint.phi) + (-1.25, 0.5)[k % 2] * glint.width)[p]
                phi_i = binary32(wrap(phi_o + (-1)**j * away))
                rows += value_row(Marschner, f, marschner_numbers(f), [theta_o, theta_i, phi_o, phi_i], 2 * PI / glint.width)
    return write('marschner.json', 'Marschner et al. 2003: f |cos theta_n| = S cos theta_i, and the density of sampling',
                 columns_of(f) + ['theta_o', 'theta_i', 'phi_o', 'phi_i'], VALUES, MARSCHNER_NOTES, rows)


def marschner_samples():
    rows = []
    for k, f in enumerate(marschner_fibers()):
        for j, u in enumerate(US[:4]):
            view = [mpf((0.25, -1.125)[(k + j) % 2]), binary32((0.25, -2, 1.75)[(j + k) % 3])]

            def rounding(theta_i, phi, o=view, model=Marschner(**f)):
                # the azimuth is a difference of angles as large as 2 pi, and steep next to a caustic
                around = condition(lambda x: model.evaluate_turned(o[0], theta_i, o[1], x), [phi], [])
                return 2 * PI * around + condition(lambda i: model.evaluate_turned(o[0], i, o[1], phi), [theta_i], [])
            rows += sample_row(Marschner, f, marschner_numbers(f), view, u, 2, rounding)
    return write('marschner_samples.json', 'Marschner et al. 2003: directions that random numbers choose, f |cos theta_n| and density',
                 columns_of(f) + ['theta_o', 'phi_o'] + RANDOM, ['lobe', 'theta_i', 'phi'] + VALUES,
                 MARSCHNER_NOTES + ['phi = phi_i - phi_o. The recipe is Cuticle\'s, in models.py; another for the same density is as right',
                                    'theta_i, phi: the tolerance is absolute, u (16 + 2 condition)'], rows)


# --- d'Eon et al. 2011 -----------------------------------------------------------------------------------------------------

DEON_NOTES = [
    'alpha, beta_m: of theta_i + theta_o, beta_n around the fiber, degrees; orders beyond TRT have its widths and no shift',
    'printed 1: R\'s Fresnel factor at half the angle between the directions (equation 12), segments of 2 + 2 cos(2 gamma_t) radii, no light '
    'in orders beyond lobes - 1',
    'printed 0: that factor at h, segments of 2 cos(gamma_t) radii, and all orders beyond share one more lobe, uniform in phi, of TRT\'s '
    'width along the fiber',
    'A_p and Phi at theta_d; M_p with theta_o - alpha_p in the place of theta_o; phi = phi_i - phi_o',
    'pdf: lobes by the luminance of A_p at the viewer\'s inclination',
]
DEON_NUMBERS = ('h', 'eta', 'sigma', 'beta_m', 'beta_n')


def deon_fibers(far=False):
    hs = (0, 0.5, -0.75, 0.9375, -0.25)
    for k in range(10):
        yield dict({} if far else {'h': mpf(hs[k % 5])}, eta=of_binary32(1.55, 1.375)[k % 2],
                   sigma=of_binary32(*((0, 0, 0), (0.125, 0.25, 0.5), (0.5, 1, 2))[(k + k // 3) % 3]),
                   alpha=of_binary32(*((-6, 3, 12), (0, 0, 0), (-10, 5, 15))[k // 2 % 3]),
                   beta_m=of_binary32(*((8, 4, 16), (20, 10, 30), (3, 2, 5))[k // 3 % 3]),
                   beta_n=of_binary32(*((8, 8, 16), (25, 12, 40), (4, 70, 30))[(k + 1) % 3]), lobes=(4, 3, 6)[k % 3], printed=int(k % 4 == 3))


def deon_angles(model, k):
    """Views and lights in the flanks of lobes, one of h's path where it leaves."""
    for j, theta_o in enumerate(map(mpf, (0, -1.125, 1.4375) if k % 2 else (0.5, -0.75))):
        for p in range(4):
            tilted, v = model.lobe_along(p, theta_o)
            theta_i = binary32(max(-1.55, min(1.55, -tilted + (-1)**(j + p + k) * 0.75 * mp.sqrt(v))))
            turn = mpf(2) if model.h is None else net_turn(p, model.h, (theta_o - theta_i) / 2, model.eta)
            yield theta_o, theta_i, binary32(wrap(turn + (-1)**k * model.width(p)))


def deon_near():
    rows = []
    for k, f in enumerate(deon_fibers()):
        model = DEon(**f)
        for angles in deon_angles(model, k):
            rows += value_row(DEon, f, DEON_NUMBERS, list(angles), 2 * PI / min(model.beta_n))
    return write('deon_near.json', "d'Eon et al. 2011, met at one h: f |cos theta_n| and the density of sampling",
                 columns_of(f) + ['theta_o', 'theta_i', 'phi'], VALUES, DEON_NOTES, rows)


def deon_samples():
    rows = []
    for k, f in enumerate(deon_fibers()):
        for j, u in enumerate(US):
            rows += sample_row(DEon, f, DEON_NUMBERS, [mpf((0.25, -1.125)[(k + j) % 2])], u, 2, lambda *_, width=min(DEon(**f).beta_n): 2 * PI / width)
    return write('deon_samples.json', "d'Eon et al. 2011, met at one h: directions that random numbers choose, f |cos theta_n| and density",
                 columns_of(f) + ['theta_o'] + RANDOM, ['lobe', 'theta_i', 'phi'] + VALUES,
                 DEON_NOTES + ['theta_i as in samples.json; phi = Phi(p, h) + beta_n sqrt(2) erfinv(2 u_azimuth - 1), of the tail 2 pi u_azimuth',
                               'theta_i, phi: the tolerance is absolute, u (16 + 2 condition)'], rows)


def deon_far():
    rows = []
    with mp.workdps(20):
        for k, f in enumerate(deon_fibers(far=True)):
            model = DEon(**f)
            for theta_o, theta_i, _ in itertools.islice(deon_angles(model, k), k % 4, 1 + k % 4):
                for phi in (mpf('0.25'), mpf(-1.5), mpf('2.875')):
                    rows.append(row_of(f) + [theta_o, theta_i, phi] + [mpf(mp.nstr(x, 12)) for x in model.evaluate(theta_o, theta_i, phi)])
    return write('deon_far.json', "d'Eon et al. 2011 over the whole width of the fiber: f |cos theta_n| and the density of sampling",
                 columns_of(f) + ['theta_o', 'theta_i', 'phi'], VALUES,
                 DEON_NOTES + [FAR_NOTE, '12 digits'], rows, tolerance=False)


FAR_NOTE = 'far field: means over h in [-1, 1]; the weights of lobes in pdf by 4 nodes of Gauss and Legendre in gamma, of the tail by 16'


def deon_cells():
    rows = []
    for k, f in enumerate(deon_fibers(far=True)):
        if k in (1, 3, 6):
            theta_o = mpf((0.25, -1.25, 0.75)[k % 3])
            with mp.workdps(16):
                shares = cells_of(DEon(**f), theta_o)
            rows.append(row_of(f) + [theta_o] + [mpf('%.7f' % x) for x in shares])
    return write_cells('deon_cells.json', "d'Eon et al. 2011 over the whole width of the fiber. ", columns_of(f),
                       DEON_NOTES + [FAR_NOTE], rows, 'to 2e-5')


def cells_of(model, theta_o, inclinations=9):
    """What falls into a step of phi hangs on theta_d, smoothly: it is interpolated between a few inclinations."""
    at = [theta_o / 2 + PI / 4 * mp.cos(PI * (i + mpf(1) / 2) / inclinations) for i in range(inclinations)]  # Chebyshev's
    cells = [[mpf(0)] * COLUMNS_OF_CELLS for _ in range(ROWS_OF_CELLS)]
    for p, share in zip(model.all_lobes(), model.shares(theta_o)):
        around = [shares_around(model, p, theta_d) for theta_d in at]
        for i, step in enumerate(nodes_along(*model.lobe_along(p, theta_o), 8)):
            weights = [mpf(0)] * inclinations
            for theta_i, m in step:
                weights = [w + share * m * x for w, x in zip(weights, lagrange(at, (theta_o - theta_i) / 2))]
            cells[i] = [c + sum(w * a[j] for w, a in zip(weights, around)) for j, c in enumerate(cells[i])]
    whole = [x for row in cells for x in row]
    assert abs(sum(whole) - 1) < 1e-7, sum(whole)
    return whole


def lagrange(at, x):
    """The weights of values at some places, for the polynomial through them at x."""
    return [mp.fprod((x - b) / (a - b) for b in at if b != a) for a in at]


def shares_around(model, p, theta_d):
    """A lobe's share of each step of phi."""
    step = 2 * math.pi / COLUMNS_OF_CELLS
    if p == model.lobes:
        return [1 / COLUMNS_OF_CELLS] * COLUMNS_OF_CELLS
    width, shares = float(model.width(p)) * math.sqrt(2), [0.] * COLUMNS_OF_CELLS
    for turn, a, weight in model.rays(p, theta_d):
        light = float(weight if p == 0 and model.printed else luminance(a))
        for centre in (float(wrap(turn)), -float(wrap(turn))):
            below = [sum(math.erf((-math.pi + step * j + 2 * math.pi * k - centre) / width) for k in range(-3, 4))
                     for j in range(COLUMNS_OF_CELLS + 1)]
            shares = [s + light / 4 * (b - a) for s, a, b in zip(shares, below, below[1:])]
    return [s / sum(shares) for s in shares]


FILES = (bessel, longitudinal, azimuthal, attenuation, bsdf, samples, cells, energies, colours, smooth_np, rough_np, kajiya_kay,
         kajiya_kay_samples, marschner, marschner_samples, deon_near, deon_samples, deon_far, deon_cells)


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
