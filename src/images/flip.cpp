//> Compute FLIP, the difference that a viewer sees
#include "images/flip.h"

#include "core/error.h"

#include <algorithm>
#include <cmath>

namespace cuticle {

namespace {

//> Go between the colour spaces of FLIP
// Linear sRGB to XYZ relative to white: each row of the matrix is divided by its sum, so that white is (1, 1,
// 1).
using Triple = std::array<double, 3>;

constexpr std::array<Triple, 3> toXYZ = {{{10135552. / 24577794, 8788810. / 24577794, 4435075. / 24577794},
                                          {2613072. / 12288897, 8788810. / 12288897, 887015. / 12288897},
                                          {1425312. / 73733382, 8788810. / 73733382, 70074185. / 73733382}}};
constexpr double RowSum(size_t row) { return toXYZ[row][0] + toXYZ[row][1] + toXYZ[row][2]; }

Triple ToRelativeXYZ(const Triple &rgb) {
    Triple xyz{};
    for (size_t r = 0; r < 3; ++r)
        for (size_t c = 0; c < 3; ++c)
            xyz[r] += toXYZ[r][c] / RowSum(r) * rgb[c];
    return xyz;
}
//<

//> Solve for the colour that has a given XYZ
// The inverse by cofactors (Cramer's rule), which keeps it consistent with the matrix above to the last bits.
Triple FromRelativeXYZ(const Triple &relative) {
    const auto &m = toXYZ;
    const Triple xyz = {relative[0] * RowSum(0), relative[1] * RowSum(1), relative[2] * RowSum(2)};
    const auto determinant = [](const Triple &r0, const Triple &r1, const Triple &r2) {
        return r0[0] * (r1[1] * r2[2] - r1[2] * r2[1]) - r0[1] * (r1[0] * r2[2] - r1[2] * r2[0]) +
               r0[2] * (r1[0] * r2[1] - r1[1] * r2[0]);
    };
    const double whole = determinant(m[0], m[1], m[2]);
    Triple rgb{};
    for (size_t c = 0; c < 3; ++c) {
        std::array<Triple, 3> replaced = m;
        for (size_t r = 0; r < 3; ++r)
            replaced[r][c] = xyz[r];
        rgb[c] = determinant(replaced[0], replaced[1], replaced[2]) / whole;
    }
    return rgb;
}
//<

//> Compare two colours in Hunt-adjusted L*a*b*
// L*a*b* is nearly uniform to the eye; colours that are dark look less colourful (Hunt), so a* and b* are
// scaled by L* / 100. HyAB adds the difference in lightness to the distance in colour: better than Euclid
// where differences are large.
Triple HuntLab(const Triple &rgb) {
    const auto f = [](double t) {
        constexpr double delta = 6. / 29;
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4. / 29;
    };
    const Triple xyz = ToRelativeXYZ(rgb);
    const double x = f(xyz[0]), y = f(xyz[1]), z = f(xyz[2]);
    const double lightness = 116 * y - 16;
    return {lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)};
}

double HyAB(const Triple &a, const Triple &b) {
    return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}
//<

//> Filter a plane by rows and by columns
// Every filter of FLIP is a product of a function of x and one of y. Both kernels have the same odd length;
// beyond the picture its border goes on.
std::vector<double> Convolve(const std::vector<double> &plane, size_t width, size_t height,
                             const std::vector<double> &kernelX, const std::vector<double> &kernelY) {
    const size_t radius = kernelX.size() / 2;
    std::vector<double> rows(plane.size()), result(plane.size());
    // The pixel that the k-th weight of a kernel around i stands over, kept inside the picture
    const auto inside = [&](size_t i, size_t k, size_t size) {
        return std::min(i + k > radius ? i + k - radius : 0, size - 1);
    };
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x)
            for (size_t k = 0; k < kernelX.size(); ++k)
                rows[y * width + x] += kernelX[k] * plane[y * width + inside(x, k, width)];
    for (size_t y = 0; y < height; ++y)
        for (size_t k = 0; k < kernelY.size(); ++k) {
            const double weight = kernelY[k];
            const size_t from = inside(y, k, height);
            for (size_t x = 0; x < width; ++x)
                result[y * width + x] += weight * rows[from * width + x];
        }
    return result;
}
//<

//> Blur as the eye does
// The contrast sensitivity of each opponent channel is a sum of Gaussians in frequency, so its filter is one
// of Gaussians in space: a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees (Johnson and Fairchild's form).
// Parameters (a_1, b_1, a_2, b_2) of the paper's table 1: achromatic, red-green, blue-yellow; the window is
// three standard deviations of the widest.
struct Sensitivity {
    double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> sensitivities = {
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

std::vector<double> BlurPlane(const std::vector<double> &plane, size_t width, size_t height,
                              const Sensitivity &s, double pixelsPerDegree) {
    const int radius =
        static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * Sqr(kPi<double>))) * pixelsPerDegree));
    //> Blur by each Gaussian and add the two by their mass
    std::vector<double> result(plane.size());
    double total = 0;
    for (const auto &[a, b] : {std::pair(s.a1, s.b1), std::pair(s.a2, s.b2)}) {
        if (a == 0)
            continue;
        std::vector<double> kernel;
        double mass = 0;
        for (int k = -radius; k <= radius; ++k) {
            kernel.push_back(std::exp(-Sqr(kPi<double> * k / pixelsPerDegree) / b));
            mass += kernel.back();
        }
        const double height0 = a * std::sqrt(kPi<double> / b);
        const auto blurred = Convolve(plane, width, height, kernel, kernel);
        for (size_t i = 0; i < plane.size(); ++i)
            result[i] += height0 * blurred[i];
        total += height0 * mass * mass;
    }
    for (double &v : result)
        v /= total;
    return result;
    //<
}
//<

//> Turn a picture into what is seen of its colours
// The opponent space Y Cx Cz is linear in XYZ, so that a blur there mixes light; its scale and offset leave a
// normalised blur unchanged and are left out.
std::vector<Triple> SeenColours(const Planes &xyz, double pixelsPerDegree) {
    const size_t n = xyz.Size();
    std::array<std::vector<double>, 3> opponent;
    for (size_t i = 0; i < n; ++i) {
        const double x = xyz.channel[0][i], y = xyz.channel[1][i], z = xyz.channel[2][i];
        opponent[0].push_back(y), opponent[1].push_back(x - y), opponent[2].push_back(y - z);
    }
    for (size_t c = 0; c < 3; ++c)
        opponent[c] = BlurPlane(opponent[c], xyz.width, xyz.height, sensitivities[c], pixelsPerDegree);
    std::vector<Triple> seen(n);
    for (size_t i = 0; i < n; ++i) {
        const double y = opponent[0][i];
        Triple rgb = FromRelativeXYZ({y + opponent[1][i], y, y - opponent[2][i]});
        for (double &v : rgb)
            v = std::clamp(v, 0., 1.);
        seen[i] = HuntLab(rgb);
    }
    return seen;
}
//<

//> Bring colour differences to $[0, 1]$
// After a power q_c = 0.7, the largest difference there is, green against blue, becomes 1; the lower 40% of
// the range (p_c) take 95% of the result (p_t), since larger differences are all simply large.
double ColourError(const Triple &a, const Triple &b) {
    constexpr double qc = 0.7, pc = 0.4, pt = 0.95;
    static const double largest = std::pow(HyAB(HuntLab({0, 1, 0}), HuntLab({0, 0, 1})), qc);
    const double error = std::pow(HyAB(a, b), qc), knee = pc * largest;
    return error < knee ? pt / knee * error : std::min(1., pt + (error - knee) / (largest - knee) * (1 - pt));
}
//<

//> Find edges and points
// First (edges) and second (points) derivatives of a Gaussian of standard deviation w/2, w = 0.082 degrees,
// whose positive and negative weights are scaled to sums of +1 and -1. The strength is the length of the two
// responses, by x and by y.
std::vector<double> FeatureStrength(const std::vector<double> &luminance, size_t width, size_t height,
                                    double pixelsPerDegree, bool points) {
    const double deviation = 0.5 * 0.082 * pixelsPerDegree;
    const int radius = static_cast<int>(std::ceil(3 * deviation));
    std::vector<double> smooth, derivative;
    double mass = 0, positive = 0, negative = 0;
    for (int k = -radius; k <= radius; ++k) {
        const double g = std::exp(-Sqr(k / deviation) / 2);
        smooth.push_back(g), mass += g;
        derivative.push_back(points ? (Sqr(k / deviation) - 1) * g : -k * g);
        (derivative.back() > 0 ? positive : negative) += std::abs(derivative.back());
    }
    for (double &v : smooth)
        v /= mass;
    for (double &v : derivative)
        v /= v > 0 ? positive : negative;
    std::vector<double> strength = Convolve(luminance, width, height, derivative, smooth);
    const std::vector<double> byY = Convolve(luminance, width, height, smooth, derivative);
    for (size_t i = 0; i < strength.size(); ++i)
        strength[i] = std::hypot(strength[i], byY[i]);
    return strength;
}
//<

//> Clamp to what a screen shows
Planes ToScreen(const Planes &rgb) {
    Planes xyz{rgb.width, rgb.height, {}};
    for (size_t i = 0; i < rgb.Size(); ++i) {
        Triple colour = {rgb.channel[0][i], rgb.channel[1][i], rgb.channel[2][i]};
        if (std::isnan(colour[0]) || std::isnan(colour[1]) || std::isnan(colour[2]))
            colour = {1, 0, 1}; // shown, never hidden; Compare() counts it besides
        for (double &v : colour)
            v = std::clamp(v, 0., 1.);
        colour = ToRelativeXYZ(colour);
        for (size_t c = 0; c < 3; ++c)
            xyz.channel[c].push_back(colour[c]);
    }
    return xyz;
}
//<

} // namespace

//> Combine the errors of colours and features
// A difference in an edge or a point, as strong as its square root, raises the colour error by lowering its
// exponent: with no difference in colour nothing is seen, whatever the features.
std::vector<float> FLIP(const Planes &testColours, const Planes &referenceColours, double pixelsPerDegree) {
    if (!(pixelsPerDegree > 0 && pixelsPerDegree <= 10000))
        throw Error("FLIP needs between 0 and 10000 pixels per degree");
    const Planes test = ToScreen(testColours), reference = ToScreen(referenceColours);
    const size_t width = test.width, height = test.height;
    const auto seenTest = SeenColours(test, pixelsPerDegree),
               seenReference = SeenColours(reference, pixelsPerDegree);
    std::vector<double> feature(test.Size());
    for (const bool points : {false, true}) {
        const auto a = FeatureStrength(test.channel[1], width, height, pixelsPerDegree, points);
        const auto b = FeatureStrength(reference.channel[1], width, height, pixelsPerDegree, points);
        for (size_t i = 0; i < feature.size(); ++i)
            feature[i] = std::max(feature[i], std::abs(a[i] - b[i]));
    }
    std::vector<float> flip(test.Size());
    for (size_t i = 0; i < flip.size(); ++i) {
        const double colourError = ColourError(seenTest[i], seenReference[i]);
        const double featureError = std::min(1., std::sqrt(feature[i] / std::numbers::sqrt2));
        flip[i] = colourError == 0 ? 0 : static_cast<float>(std::pow(colourError, 1 - featureError));
    }
    return flip;
}

std::vector<float> FLIP(const Image &test, const Image &reference, double pixelsPerDegree) {
    CheckSameSize(test, reference);
    return FLIP(ToPlanes(test), ToPlanes(reference), pixelsPerDegree);
}
//<

} // namespace cuticle
//<
