// Another renderer that takes Cuticle's hair and curves: written against pbrt-v3's class interface.
#include <cuticle/fibers/hair.h>
#include <cuticle/shapes/curve.h>

#include <cstdio>

using namespace cuticle;

int main() {
    const HairBSDF hair(0.3f, 1.55f, HairBSDF::SigmaAFromConcentration(0.3f, 0), 0.3f, 0.3f, 2);
    const Vector3f wo(0, 0, 1);
    Vector3f wi;
    Float pdf = 0;
    const Spectrum f = hair.Sample_f(wo, &wi, Point2f(0.25f, 0.75f), &pdf);
    if (!(pdf > 0) || f.IsBlack() || std::abs(hair.Pdf(wo, wi) / pdf - 1) > 1e-3f)
        return 1;

    CurveSegment segment;
    for (int i = 0; i < 4; ++i)
        segment.cp[i] = Point3f(static_cast<float>(i), 0, 0);
    segment.width[0] = segment.width[1] = 0.5f;
    CurveHit hit;
    const Curve curve(segment, CurveType::Flat);
    if (!curve.Intersect(Ray{Point3f(1.5f, 0.1f, -2), Vector3f(0, 0, 1)}, &hit) ||
        std::abs(hit.u - 0.5f) > 1e-4f)
        return 1;
    std::puts("the installed package works");
    return 0;
}
