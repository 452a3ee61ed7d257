// The places of a fiber's lobes, for quadrature.
#pragma once

#include "fibers/furnace.h"
#include "fibers/hair_model.h"

namespace cuticle {

struct HairPeaks {
    std::vector<furnace::Peak> theta, phi;

    HairPeaks(const HairLobes<double> &lobes, const Vector3d &wo) {
        const double sinO = wo.x, cosO = std::hypot(wo.y, wo.z);
        for (size_t p = 0; p < kLobes; ++p) {
            const SinCosine<double> axis = Tilted(sinO, cosO, lobes.sinTilt[p], lobes.cosTilt[p]);
            const furnace::Peak peak = {-std::atan2(axis.sin, axis.cos), std::sqrt(lobes.v[p])};
            bool isNew = true;
            for (const furnace::Peak &other : theta)
                isNew =
                    isNew && std::abs(other.centre - peak.centre) + std::abs(other.width - peak.width) > 1e-9;
            if (isNew)
                theta.push_back(peak);
        }
        const Refraction<double> inside =
            Refract(cosO, lobes.h, lobes.cosGammaO, lobes.eta, (lobes.eta - 1) * (lobes.eta + 1));
        const PhiInPlane<double> turn = TurnsOfPaths(lobes.h, lobes.cosGammaO, inside);
        for (size_t p = 0; p < 3; ++p)
            phi.push_back({std::atan2(wo.z, wo.y) + std::atan2(turn.sin[p], turn.cos[p]), lobes.s});
    }
};

} // namespace cuticle
