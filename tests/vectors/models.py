"""Models of a hair fiber, written down plainly and computed with forty digits: what generate.py tabulates.

Nothing here is taken from the renderer: the formulas of Kajiya and Kay 1989, Marschner et al. 2003, d'Eon et al. 2011 and
Pharr 2016 (Chiang et al. 2016), as the papers have them where the papers are right. Forty digits stand in for every trick
that binary numbers need. theta is measured from the plane across the fiber, positive toward the tip; o is the viewer, i the
light, both point away; phi = phi_i - phi_o. Radians, unless said to be degrees.
"""
import struct

from mpmath import mp, mpf

mp.dps = 40
PI = mp.pi
TILT_IN_ALPHA = (2, -1, -4, 0)


def binary32(x):
    """The nearest number of binary32: what a renderer in single precision gets, exactly."""
    return mpf(struct.unpack('f', struct.pack('f', float(x)))[0])


# pbrt-v3's weights of red, green and blue, as numbers of binary32
LUMINANCE = tuple(binary32(w) for w in ('0.212671', '0.715160', '0.072169'))


# --- Chiang et al. 2016 ------------------------------------------------------------------------------------------

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


def luminance(c):
    return sum(w * x for w, x in zip(LUMINANCE, c))


def normalised(shares):
    return [x / sum(shares) for x in shares]


def seen_from(theta_o, width):
    """The inclination at which our renderer weighs the light of a lobe of this width for the older models: the viewer's, but
    for one along the fiber half a width beside the axis, where most of the lobe is seen."""
    return mp.acos(max(mp.cos(theta_o), min(width / 2, mpf(1))))


def choose(shares, u):
    """The lobe that u picks, what of u is left within it, in [0, 1), and how near u lies to another lobe."""
    below, nearest, lobe, rest = mpf(0), mpf(1), None, None
    for p, share in enumerate(shares):
        if lobe is None and u < below + share:
            lobe, rest = p, (u - below) / share
        below += share
        nearest = min(nearest, abs(u - below)) if p + 1 < len(shares) else nearest
    return lobe, rest, nearest


def sample_mp(tilted, v, u_cosine, u_turn):
    """theta_i, distributed as M_p cos theta_i."""
    cos_t = 1 + v * mp.log(u_cosine + (1 - u_cosine) * mp.exp(-2 / v))
    sin_t = mp.sqrt(1 - cos_t**2)
    # |cos| of a tilt beyond the pole: the same height on the other side
    return mp.asin(-cos_t * mp.sin(tilted) + sin_t * mp.cos(2 * PI * u_turn) * abs(mp.cos(tilted)))


class Fiber:
    """Parameters as a scene gives them; tilt 1: highlight toward the root (Marschner, Pharr's text); -1: pbrt-v3."""

    def __init__(self, h, eta, sigma, beta_m, beta_n, alpha, tilt):
        self.h, self.eta, self.sigma = h, eta, sigma
        self.v, self.s = longitudinal_variances(beta_m), azimuthal_scale(beta_n)
        self.tilt = [tilt * k * alpha * PI / 180 for k in TILT_IN_ALPHA]

    def colours(self, theta_o):
        """A_p of red, green, blue for each lobe."""
        return list(zip(*[attenuations(self.h, theta_o, self.eta, s) for s in self.sigma]))

    def shares(self, theta_o):
        return normalised([luminance(ap) for ap in self.colours(theta_o)])

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

    def sample(self, lobe, rest, theta_o, u_azimuth, u_cosine, u_turn):
        """theta_i, phi, then f |cos| and density, for random numbers; rest, what is left of the first, is not needed."""
        theta_i = sample_mp(theta_o + self.tilt[lobe], self.v[lobe], u_cosine, u_turn)
        if lobe == 3:
            phi = PI * (2 * u_azimuth - 1)
        else:
            phi = wrap(net_turn(lobe, self.h, theta_o, self.eta) + sample_trimmed_logistic(u_azimuth, self.s))
        return [theta_i, phi] + self.evaluate(theta_o, theta_i, phi)


# --- Gaussians, on a line and on a circle ----------------------------------------------------------------------------

def gaussian(width, x):
    return mp.exp(-(x / width)**2 / 2) / (width * mp.sqrt(2 * PI))


def detector(width, x):
    """The sum over k of g(width; x + 2 pi k): images beyond 14 widths are below 1e-42."""
    x = wrap(x)
    reach = 14 * width
    first, last = int(mp.ceil((-reach - x) / (2 * PI))), int(mp.floor((reach - x) / (2 * PI)))
    return sum((gaussian(width, x + 2 * PI * k) for k in range(first, last + 1)), mpf(0))


def normal_cdf(x):
    return mp.erfc(-x / mp.sqrt(2)) / 2


class CutGaussian:
    """Of theta_i: a Gaussian cut to [-pi/2, pi/2]; a centre beyond is put on the pole."""

    def __init__(self, centre, width):
        self.centre, self.width = max(-PI / 2, min(PI / 2, centre)), width
        self.below, above = (normal_cdf((end - self.centre) / width) for end in (-PI / 2, PI / 2))
        self.mass = above - self.below

    def density(self, theta):
        """Per unit of cos theta dtheta."""
        return gaussian(self.width, theta - self.centre) / (self.mass * mp.cos(theta))

    def sample(self, u):
        return self.centre + self.width * mp.sqrt(2) * mp.erfinv(2 * (self.below + u * self.mass) - 1)


def sample_cosine_squared(u, v):
    """theta with a density proportional to cos^2 theta dtheta: sin theta is a coordinate of a point in the unit disk."""
    return mp.asin(mp.sqrt(u) * mp.cos(2 * PI * v))


def gauss_legendre(n, memory={}):
    """Nodes in (0, 1), and weights that add up to 1."""
    key = n, mp.dps
    if key not in memory:
        nodes = []
        for i in range(n):
            x = mp.cos(PI * (i + mpf(3) / 4) / (n + mpf(1) / 2))
            for _ in range(8):  # from 3 digits to all
                before, value = mpf(1), x
                for k in range(2, n + 1):
                    before, value = value, ((2 * k - 1) * x * value - (k - 1) * before) / k
                slope = n * (x * value - before) / (x * x - 1)
                x -= value / slope
            nodes.append(((1 - x) / 2, 1 / ((1 - x * x) * slope**2)))
        memory[key] = nodes
    return memory[key]


def panels(edges, n):
    """Nodes and weights over the intervals between edges, n each."""
    return [(a + (b - a) * x, (b - a) * w) for a, b in zip(edges, edges[1:]) for x, w in gauss_legendre(n)]


# --- a smooth fiber met over its whole width -----------------------------------------------------------------------------

def caustic(p, theta, eta):
    """The gamma where path p turns back (Descartes), or None."""
    if p < 2 or eta_prime(theta, eta) >= p:
        return None
    return mp.asin(mp.sqrt((mpf(p)**2 - eta_prime(theta, eta)**2) / (mpf(p)**2 - 1)))


def solve(turn, turning_point, phi):
    """All gamma in [-pi/2, pi/2] with turn(gamma) = phi, modulo 2 pi: the intervals where it is monotone, bisected."""
    edges = [-PI / 2] + ([-turning_point, turning_point] if turning_point else []) + [PI / 2]
    roots = []
    for low, high in zip(edges, edges[1:]):
        a, b = sorted((turn(low), turn(high)))
        k = mp.ceil((a - phi) / (2 * PI))
        while phi + 2 * PI * k < b:
            target = phi + 2 * PI * k
            roots.append(mp.findroot(lambda g: turn(g) - target, (low, high), solver='anderson', tol=mpf(10)**-30))
            k += 1
    return roots


class ExactPaths:
    """gamma = asin h of the paths p of a circle, by Snell's law."""

    def __init__(self, p, theta, eta):
        self.p, self.theta, self.eta = p, theta, eta

    def turn(self, gamma):
        return net_turn(self.p, mp.sin(gamma), self.theta, self.eta)

    def slope(self, gamma):
        """Of turn, by gamma."""
        e = eta_prime(self.theta, self.eta)
        return 2 * self.p * mp.cos(gamma) / mp.sqrt(e**2 - mp.sin(gamma)**2) - 2

    def roots(self, phi):
        return solve(self.turn, caustic(self.p, self.theta, self.eta), phi)

    def density(self, gamma):
        """|2 dPhi/dh|^-1."""
        return mp.cos(gamma) / (2 * abs(self.slope(gamma)))

    def spread(self, phi):
        """How densely rays of uniform h leave at phi."""
        return sum((self.density(g) for g in self.roots(phi)), mpf(0))


class CubicPaths(ExactPaths):
    """The same by Marschner's cubic, equation 10. Roots beyond +-pi/2 are no rays."""

    def __init__(self, p, theta, eta):
        super().__init__(p, theta, eta)
        c = mp.asin(1 / eta_prime(theta, eta))
        self.linear, self.cubic = 6 * p * c / PI - 2, -8 * p * c / PI**3

    def turn(self, gamma):
        return self.linear * gamma + self.cubic * gamma**3 + self.p * PI

    def slope(self, gamma):
        return self.linear + 3 * self.cubic * gamma**2

    def roots(self, phi):
        turning = mp.sqrt(self.linear / (-3 * self.cubic)) if self.linear > 0 else None
        return solve(self.turn, turning if turning and turning < PI / 2 else None, phi)


def bravais_fresnel(theta, h, eta):
    """Marschner et al. 2003, appendix B: eta' for the perpendicular component, eta'' for the parallel one."""
    cos_i = mp.sqrt(1 - h**2)
    first, second = eta_prime(theta, eta), eta**2 * mp.cos(theta) / mp.sqrt(eta**2 - mp.sin(theta)**2)
    cos_t = mp.sqrt(1 - (h / first)**2)
    perpendicular = (cos_i - first * cos_t) / (cos_i + first * cos_t)
    parallel = (second * cos_i - cos_t) / (second * cos_i + cos_t)
    return (perpendicular**2 + parallel**2) / 2


def fresnel_at(theta, h, eta):
    return fresnel(mp.cos(theta) * mp.sqrt(1 - h**2), eta)


def segment(h, theta, eta, printed=False):
    """Radii of one crossing. printed: 2 + 2 cos 2 gamma_t, the square of the chord, as two papers have it."""
    chord = 2 * mp.sqrt(1 - (h / eta_prime(theta, eta))**2)
    return (chord**2 if printed else chord) / mp.sqrt(1 - (mp.sin(theta) / eta)**2)


def path_attenuation(p, h, theta, eta, sigma_a, printed=False, reflectance=fresnel_at):
    """A_p of one order, any p, for each of the absorptions."""
    f = reflectance(theta, h, eta)
    if p == 0:
        return [f] * len(sigma_a)
    length = segment(h, theta, eta, printed)
    return [(1 - f)**2 * f**(p - 1) * mp.exp(-p * s * length) for s in sigma_a]


def tail_attenuation(p, h, theta, eta, sigma_a, printed=False):
    """All orders from p on."""
    f, length = fresnel_at(theta, h, eta), segment(h, theta, eta, printed)
    return [(1 - f)**2 * f**(p - 1) * mp.exp(-p * s * length) / (1 - f * mp.exp(-s * length)) for s in sigma_a]


def mean_over_width(values, n):
    """Over h = sin gamma in [0, 1] by n nodes, colour by colour."""
    total = [mpf(0)] * 3
    for x, w in gauss_legendre(n):
        gamma = PI / 2 * x
        total = [t + PI / 2 * w * mp.cos(gamma) * v for t, v in zip(total, values(mp.sin(gamma)))]
    return total


# --- Kajiya and Kay 1989 -----------------------------------------------------------------------------------------------

class KajiyaKay:
    """The paper leaves the strength of the terms open: here Kd is the energy of the diffuse one, Ks that of the highlight
    for a view square to the fiber."""

    def __init__(self, kd, ks, exponent):
        self.kd, self.ks, self.exponent = kd, ks, exponent
        self.width = 1 / mp.sqrt(max(exponent, mpf(1) / 10))

    def shares(self, _theta_o):
        return normalised([luminance(self.kd), luminance(self.ks)])

    def evaluate(self, theta_o, theta_i):
        n, cosine = self.exponent, mp.cos(theta_o + theta_i)
        diffuse = mp.cos(theta_i) / PI**2
        peak = 1 / (2 * PI * mp.sqrt(PI) * mp.gammaprod([n / 2 + 1], [n / 2 + mpf(3) / 2]))
        highlight = peak * cosine**n if cosine > 0 else mpf(0)
        p_diffuse, p_cone = self.shares(theta_o)
        density = p_diffuse * diffuse + p_cone * CutGaussian(-theta_o, self.width).density(theta_i) / (2 * PI)
        return [d * diffuse + s * highlight for d, s in zip(self.kd, self.ks)] + [density]

    def sample(self, lobe, _rest, theta_o, _u_azimuth, u_cosine, u_turn):
        if lobe == 0:
            theta_i = sample_cosine_squared(u_cosine, u_turn)
        else:
            theta_i = CutGaussian(-theta_o, self.width).sample(u_cosine)
        return [theta_i] + self.evaluate(theta_o, theta_i)


# --- Marschner et al. 2003 -----------------------------------------------------------------------------------------------

class Glint:
    """Section 5.2.2: what stands in the place of a caustic, for one inclination and eta*."""

    def __init__(self, model, theta_d, eta_star):
        self.width = model.w_c * PI / 180
        e, gamma = eta_prime(theta_d, eta_star), caustic(2, theta_d, eta_star)
        if gamma:
            h = mp.sin(gamma)
            self.phi = wrap(net_turn(2, h, theta_d, eta_star))
            # d^2 Phi / dh^2, Phi = 4 asin(h / eta') - 2 asin(h)
            curvature = 4 * h / (e**3 * (1 - (h / e)**2)**mpf('1.5')) - 2 * h / (1 - h**2)**mpf('1.5')
            dh, self.fade = min(model.delta_h, 2 * mp.sqrt(2 * self.width / abs(curvature))), mpf(1)
        else:
            x = min(mpf(1), (e - 2) / model.delta_eta)
            h, self.phi, dh, self.fade = mpf(0), mpf(0), model.delta_h, 1 - x**2 * (3 - 2 * x)
        # the paper leaves open where A is taken: at the caustic
        self.power = [model.k_g * self.fade * a * dh for a in model.attenuation(2, h, theta_d)]

    def kept(self, phi):
        peak = gaussian(self.width, 0)
        return [1 - self.fade * detector(self.width, phi - side * self.phi) / peak for side in (1, -1)]

    def lobes(self, phi):
        return detector(self.width, phi - self.phi) + detector(self.width, phi + self.phi)


class Marschner:
    """alpha, beta: of theta_h, and w_c, degrees. phi_o, phi_i from the major axis. printed: Gaussian in theta_h, cubic paths,
    segments of 2 + 2 cos 2 gamma_t radii, a^2 at phi_h = 0, all as the paper has them; else in theta_i + theta_o, exact
    paths, chords, a^-2 at phi_h = 0."""

    def __init__(self, eta, sigma, alpha, beta, eccentricity, k_g, w_c, delta_eta, delta_h, kd, printed):
        self.eta, self.sigma, self.eccentricity, self.kd, self.printed = eta, sigma, eccentricity, kd, printed
        self.alpha, self.beta = [x * PI / 180 for x in alpha], [x * PI / 180 for x in beta]
        self.k_g, self.w_c, self.delta_eta, self.delta_h = k_g, w_c, delta_eta, delta_h
        self.paths = CubicPaths if printed else ExactPaths

    def attenuation(self, p, h, theta_d):
        return path_attenuation(p, h, theta_d, self.eta, self.sigma, self.printed, bravais_fresnel)

    def eta_star(self, phi_h):
        """Section 5.2.3."""
        square = self.eccentricity**(2 if self.printed else -2)
        first, second = (2 * (self.eta - 1) * s - self.eta + 2 for s in (square, 1 / square))
        return ((first + second) + mp.cos(2 * phi_h) * (first - second)) / 2

    def through(self, p, phi, theta_d, eta):
        """Equation 8: the sum over the paths of a circle of index eta."""
        paths, total = self.paths(p, theta_d, eta), [mpf(0)] * 3
        for gamma in paths.roots(phi):
            a = self.attenuation(p, mp.sin(gamma), theta_d)
            total = [t + x * paths.density(gamma) for t, x in zip(total, a)]
        return total

    def azimuthal(self, p, phi, phi_h, theta_d):
        if p < 2:
            return self.through(p, phi, theta_d, self.eta)
        eta_star = self.eta_star(phi_h)
        glint = Glint(self, theta_d, eta_star)
        first, second = glint.kept(phi)
        return [n * first * second + power * glint.lobes(phi)
                for n, power in zip(self.through(2, phi, theta_d, eta_star), glint.power)]

    def along(self, p, theta_o, theta_i):
        """M_p cos theta_i / cos^2 theta_d."""
        if self.printed:
            m = gaussian(self.beta[p], (theta_i + theta_o) / 2 - self.alpha[p])
        else:
            m = gaussian(2 * self.beta[p], theta_i + theta_o - 2 * self.alpha[p])
        return m * mp.cos(theta_i) / mp.cos((theta_o - theta_i) / 2)**2

    # How our renderer samples: along the fiber a Gaussian cut to the range of theta_i; around it R uniformly, TT and TRT along
    # rays of uniform h; TRT also by its glints and, where eta* depends on the azimuth to be chosen, 0.3 of it uniformly.

    def cone(self, p, theta_o):
        return CutGaussian(2 * self.alpha[p] - theta_o, 2 * self.beta[p])

    def energies(self, theta_o, phi_o):
        """R, TT, TRT without glints (means over the width by three nodes), the glints, the diffuse term, in luminance."""
        seen = [seen_from(theta_o, 2 * beta) for beta in self.beta]
        means = mean_over_width(lambda h: [luminance(self.attenuation(p, h, seen[p])) for p in range(3)], 3)
        return means + [2 * luminance(Glint(self, seen[2], self.eta_star(phi_o)).power), luminance(self.kd)]

    def shares(self, theta_o, phi_o):
        return self.shares_of(self.energies(theta_o, phi_o))

    @staticmethod
    def shares_of(energies):
        r, tt, trt, glints, diffuse = energies
        return normalised([r, tt, trt + glints, diffuse])

    def ways_of_trt(self, energies, phi_o, theta_d):
        """The glint, and the shares of uniform azimuths and of glints."""
        glint = Glint(self, theta_d, self.eta_star(phi_o))
        power, trt = 2 * luminance(glint.power), energies[2]
        uniform = mpf(0) if self.eccentricity == 1 else mpf('0.3')
        return glint, uniform, (1 - uniform) * power / (power + trt)

    def around(self, p, energies, phi_o, theta_d, phi):
        if p == 0:
            return 1 / (2 * PI)
        if p == 1:
            return self.paths(1, theta_d, self.eta).spread(phi)
        glint, uniform, by_glint = self.ways_of_trt(energies, phi_o, theta_d)
        by_ray = self.paths(2, theta_d, self.eta_star(phi_o)).spread(phi)
        return uniform / (2 * PI) + by_glint * glint.lobes(phi) / 2 + (1 - uniform - by_glint) * by_ray

    def evaluate(self, theta_o, theta_i, phi_o, phi_i):
        return self.evaluate_turned(theta_o, theta_i, phi_o, wrap(phi_i - phi_o))

    def evaluate_turned(self, theta_o, theta_i, phi_o, phi):
        theta_d = (theta_o - theta_i) / 2
        energies = self.energies(theta_o, phi_o)
        shares, diffuse = self.shares_of(energies), mp.cos(theta_i) / PI**2
        f, density = [k * diffuse for k in self.kd], shares[3] * diffuse
        for p in range(3):
            m = self.along(p, theta_o, theta_i)
            f = [x + m * n for x, n in zip(f, self.azimuthal(p, phi, phi_o + phi / 2, theta_d))]
            density += shares[p] * self.cone(p, theta_o).density(theta_i) * self.around(p, energies, phi_o, theta_d, phi)
        return f + [density]

    def sample(self, lobe, rest, theta_o, phi_o, u_azimuth, u_cosine, u_turn):
        phi = 2 * PI * u_azimuth
        if lobe == 3:
            theta_i = sample_cosine_squared(u_cosine, u_turn)
        else:
            theta_i = self.cone(lobe, theta_o).sample(u_cosine)
        theta_d, ray = (theta_o - theta_i) / 2, mp.asin(2 * u_azimuth - 1)
        if lobe == 1:
            phi = self.paths(1, theta_d, self.eta).turn(ray)
        elif lobe == 2:
            glint, uniform, by_glint = self.ways_of_trt(self.energies(theta_o, phi_o), phi_o, theta_d)
            if rest >= uniform + by_glint:
                phi = self.paths(2, theta_d, self.eta_star(phi_o)).turn(ray)
            elif rest >= uniform:
                side = -1 if rest < uniform + by_glint / 2 else 1
                phi = side * glint.phi + glint.width * mp.sqrt(2) * mp.erfinv(2 * u_azimuth - 1)
        return [theta_i, wrap(phi)] + self.evaluate_turned(theta_o, theta_i, phi_o, wrap(phi))


# --- d'Eon et al. 2011 -----------------------------------------------------------------------------------------------------

class DEon:
    """alpha, beta_m of theta_i + theta_o, beta_n around the fiber, degrees, of R, TT, TRT; orders beyond have TRT's widths and
    no shift. h: where the fiber is met; None: the mean over its width. lobes: orders with a lobe of their own, at least 3. printed:
    Fresnel's factor of R at half the angle between the directions (equation 12), segments of 2 + 2 cos 2 gamma_t radii, no
    light in orders beyond; else that factor at h, chords, and one more lobe, uniform around the fiber, for all orders beyond."""

    def __init__(self, eta, sigma, alpha, beta_m, beta_n, lobes, printed, h=None):
        self.h, self.eta, self.sigma, self.lobes, self.printed = h, eta, sigma, lobes, printed
        radians = [[x * PI / 180 for x in three] for three in (alpha, beta_m, beta_n)]
        self.alpha, self.beta_m, self.beta_n = radians

        self.v, self.memory = [b**2 for b in self.beta_m], {}

    def lobe_along(self, p, theta_o):
        """The tilted theta_o and the variance of M_p."""
        return theta_o - (self.alpha[p] if p < 3 else 0), self.v[min(p, 2)]

    def width(self, p):
        return self.beta_n[min(p, 2)]

    def attenuation(self, p, h, theta):
        """Of lobe p; the last is the tail."""
        of = tail_attenuation if p == self.lobes else path_attenuation
        return of(p, h, theta, self.eta, self.sigma, self.printed)

    def all_lobes(self):
        return range(self.lobes + (0 if self.printed else 1))

    def rays(self, p, theta_d):
        """Azimuths where rays of lobe p leave, each for both signs of h, and their light, the mean over which is N_p's."""
        if (p, theta_d) not in self.memory:
            paths = ExactPaths(p, theta_d, self.eta)
            turning, fine = caustic(p, theta_d, self.eta), [mpf(0)]
            for high in ([turning] if turning else []) + [PI / 2]:
                # panels over which the azimuth runs through at most two widths
                low = fine[-1]
                reach = max(abs(paths.slope(low)), abs(paths.slope(high))) * (high - low)
                pieces = int(mp.ceil(reach / (2 * self.width(p))))
                fine += [low + (high - low) * mpf(k) / pieces for k in range(1, pieces + 1)]
            self.memory[p, theta_d] = [
                (paths.turn(g), [w * mp.cos(g) * x for x in self.attenuation(p, mp.sin(g), theta_d)], w * mp.cos(g))
                for g, w in panels(fine, 16)]
        return self.memory[p, theta_d]

    def azimuthal(self, p, theta_d, phi):
        """N_p in three colours, and how samples of the lobe fall around. Of R as printed N_p still lacks Fresnel's factor."""
        if p == self.lobes:
            whole = mean_over_width(lambda h: self.attenuation(p, h, theta_d), 24) if self.h is None else \
                self.attenuation(p, self.h, theta_d)
            return [x / (2 * PI) for x in whole], 1 / (2 * PI)
        width, bare = self.width(p), p == 0 and self.printed
        if self.h is not None:
            seen = detector(width, phi - net_turn(p, self.h, theta_d, self.eta))
            return [seen] * 3 if bare else [x * seen for x in self.attenuation(p, self.h, theta_d)], seen
        n, whole = [mpf(0)] * 3, mpf(0)
        for turn, a, weight in self.rays(p, theta_d):
            light = [weight] * 3 if bare else a
            seen = (detector(width, phi - turn) + detector(width, phi + turn)) / 2
            n = [x + y * seen for x, y in zip(n, light)]
            whole += luminance(light)
        return n, luminance(n) / whole

    def shares(self, theta_o):
        """Of luminance; far field: means over the width by four nodes, of the tail by sixteen."""
        def light(p):
            seen = seen_from(theta_o, self.beta_m[min(p, 2)])
            if self.h is not None:
                return luminance(self.attenuation(p, self.h, seen))
            return luminance(mean_over_width(lambda h: self.attenuation(p, h, seen), 16 if p == self.lobes else 4))
        return normalised([light(p) for p in self.all_lobes()])

    def evaluate(self, theta_o, theta_i, phi):
        """f |cos| in red, green, blue, and the density per solid angle."""
        theta_d = (theta_o - theta_i) / 2
        total = [mpf(0)] * 4
        for p, share in zip(self.all_lobes(), self.shares(theta_o)):
            tilted, v = self.lobe_along(p, theta_o)
            m = mp_lobe(tilted, theta_i, v)
            n, density = self.azimuthal(p, theta_d, phi)
            if p == 0 and self.printed:
                cosine = mp.sin(theta_o) * mp.sin(theta_i) + mp.cos(theta_o) * mp.cos(theta_i) * mp.cos(phi)
                f = fresnel(mp.sqrt((1 + cosine) / 2), self.eta)
                n = [f * x for x in n]
            total = [t + m * x for t, x in zip(total, n + [share * density])]
        return total

    def sample(self, lobe, _rest, theta_o, u_azimuth, u_cosine, u_turn):
        """For one h."""
        theta_i = sample_mp(*self.lobe_along(lobe, theta_o), u_cosine, u_turn)
        phi = 2 * PI * u_azimuth
        if lobe < self.lobes:
            phi = net_turn(lobe, self.h, (theta_o - theta_i) / 2, self.eta) + \
                self.width(lobe) * mp.sqrt(2) * mp.erfinv(2 * u_azimuth - 1)
        return [theta_i, wrap(phi)] + self.evaluate(theta_o, theta_i, wrap(phi))
