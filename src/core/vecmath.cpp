#include "core/vecmath.h"

namespace cuticle {

namespace {

Transform::Matrix Identity() { return {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}; }

Transform::Matrix Multiply(const Transform::Matrix &a, const Transform::Matrix &b) {
    Transform::Matrix r{};
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j)
            for (size_t k = 0; k < 4; ++k)
                r[i][j] += a[i][k] * b[k][j];
    return r;
}

Transform::Matrix NaNMatrix() {
    Transform::Matrix m;
    for (auto &row : m)
        row.fill(std::numeric_limits<double>::quiet_NaN());
    return m;
}

// Gauss-Jordan with full row pivoting; a singular matrix gives all NaN, which IsSingular() reports.
Transform::Matrix Invert(Transform::Matrix m) {
    Transform::Matrix inv = Identity();
    for (size_t c = 0; c < 4; ++c) {
        size_t pivot = c;
        for (size_t r = c + 1; r < 4; ++r)
            if (std::abs(m[r][c]) > std::abs(m[pivot][c]))
                pivot = r;
        if (!(std::abs(m[pivot][c]) > 0) || !std::isfinite(m[pivot][c]))
            return NaNMatrix();
        std::swap(m[c], m[pivot]);
        std::swap(inv[c], inv[pivot]);
        const double s = 1 / m[c][c];
        for (size_t j = 0; j < 4; ++j)
            m[c][j] *= s, inv[c][j] *= s;
        for (size_t r = 0; r < 4; ++r) {
            const double f = m[r][c];
            if (r == c || f == 0)
                continue;
            for (size_t j = 0; j < 4; ++j)
                m[r][j] -= f * m[c][j], inv[r][j] -= f * inv[c][j];
        }
    }
    return inv;
}

} // namespace

Transform::Transform() : m_(Identity()), inv_(Identity()) {}
Transform::Transform(const Matrix &m) : m_(m), inv_(Invert(m)) {}

Transform Transform::Translate(const Vector3d &d) {
    return {{{{1, 0, 0, d.x}, {0, 1, 0, d.y}, {0, 0, 1, d.z}, {0, 0, 0, 1}}},
            {{{1, 0, 0, -d.x}, {0, 1, 0, -d.y}, {0, 0, 1, -d.z}, {0, 0, 0, 1}}}};
}

Transform Transform::Scale(double x, double y, double z) {
    return Transform(Matrix{{{x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}, {0, 0, 0, 1}}});
}

Transform Transform::Rotate(double degrees, const Vector3d &axis) {
    const Vector3d a = Normalize(axis);
    const double t = degrees * kPi<double> / 180, s = std::sin(t), c = std::cos(t);
    // Rodrigues' formula; the inverse of a rotation is its transpose.
    const Matrix m{
        {{a.x * a.x + (1 - a.x * a.x) * c, a.x * a.y * (1 - c) - a.z * s, a.x * a.z * (1 - c) + a.y * s, 0},
         {a.x * a.y * (1 - c) + a.z * s, a.y * a.y + (1 - a.y * a.y) * c, a.y * a.z * (1 - c) - a.x * s, 0},
         {a.x * a.z * (1 - c) - a.y * s, a.y * a.z * (1 - c) + a.x * s, a.z * a.z + (1 - a.z * a.z) * c, 0},
         {0, 0, 0, 1}}};
    Matrix t4{};
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j)
            t4[i][j] = m[j][i];
    return {m, t4};
}

Transform Transform::LookAt(const Vector3d &eye, const Vector3d &look, const Vector3d &up) {
    const Vector3d dir = Normalize(look - eye);
    const Vector3d right = Normalize(Cross(Normalize(up), dir));
    const Vector3d newUp = Cross(dir, right);
    const Matrix cameraToWorld{{{right.x, newUp.x, dir.x, eye.x},
                                {right.y, newUp.y, dir.y, eye.y},
                                {right.z, newUp.z, dir.z, eye.z},
                                {0, 0, 0, 1}}};
    return Transform(cameraToWorld).Inverse();
}

Transform Transform::Perspective(double fovDegrees, double n, double f) {
    const Matrix persp{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, f / (f - n), -f * n / (f - n)}, {0, 0, 1, 0}}};
    const double invTan = 1 / std::tan(fovDegrees * kPi<double> / 360);
    return Scale(invTan, invTan, 1) * Transform(persp);
}

Transform Transform::operator*(const Transform &b) const {
    return {Multiply(m_, b.m_), Multiply(b.inv_, inv_)};
}

bool Transform::IsIdentity() const { return m_ == Identity(); }

double Transform::Determinant() const {
    return m_[0][0] * (m_[1][1] * m_[2][2] - m_[1][2] * m_[2][1]) -
           m_[0][1] * (m_[1][0] * m_[2][2] - m_[1][2] * m_[2][0]) +
           m_[0][2] * (m_[1][0] * m_[2][1] - m_[1][1] * m_[2][0]);
}

bool Transform::IsSingular() const {
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j)
            if (!std::isfinite(m_[i][j]) || !std::isfinite(inv_[i][j]))
                return true;
    return false;
}

bool Transform::SwapsHandedness() const { return Determinant() < 0; }

bool Transform::ScalesUnevenly() const {
    if (IsSingular() || m_[3][0] != 0 || m_[3][1] != 0 || m_[3][2] != 0)
        return false;
    // A similarity has columns of equal length at right angles to one another: A^T A = s^2 I.
    const double scale2 = std::pow(std::abs(Determinant()), 2. / 3);
    double worst = 0;
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) {
            const double dot = m_[0][i] * m_[0][j] + m_[1][i] * m_[1][j] + m_[2][i] * m_[2][j];
            worst = std::max(worst, std::abs(dot - (i == j ? scale2 : 0)));
        }
    // Twice the relative difference in length, since lengths are squared here.
    return worst > 0.002 * scale2;
}

Point3f Transform::Point(const Point3f &p) const {
    const auto row = [&](size_t i) { return m_[i][0] * p.x + m_[i][1] * p.y + m_[i][2] * p.z + m_[i][3]; };
    const double w = row(3);
    return Point3f(Vector3d(row(0) / w, row(1) / w, row(2) / w));
}

Vector3f Transform::Vector(const Vector3f &v) const {
    const auto row = [&](size_t i) { return m_[i][0] * v.x + m_[i][1] * v.y + m_[i][2] * v.z; };
    return Vector3f(Vector3d(row(0), row(1), row(2)));
}

Normal3f Transform::Normal(const Normal3f &n) const {
    const auto column = [&](size_t i) { return inv_[0][i] * n.x + inv_[1][i] * n.y + inv_[2][i] * n.z; };
    return Normal3f(Vector3d(column(0), column(1), column(2)));
}

Ray Transform::operator()(const Ray &r) const { return {Point(r.o), Vector(r.d), r.tMin, r.tMax}; }

Bounds3f Transform::operator()(const Bounds3f &b) const {
    Bounds3f r;
    if (b.IsEmpty())
        return r;
    for (int i = 0; i < 8; ++i)
        r.Extend(
            Point({i & 1 ? b.pMax.x : b.pMin.x, i & 2 ? b.pMax.y : b.pMin.y, i & 4 ? b.pMax.z : b.pMin.z}));
    return r;
}

} // namespace cuticle
