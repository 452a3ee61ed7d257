// Texture mappings: from a point on a surface to the coordinates (s, t), or the point, where a texture is
// looked up.
#pragma once

#include "materials/interaction.h"
#include "parser/scene_description.h"

#include <memory>

namespace cuticle {

// Maps a surface point to (s, t). A coordinate that is NaN or infinite may give any.
class TextureMapping2D {
  public:
    virtual ~TextureMapping2D() = default;
    virtual Point2f Map(const TexturePoint &point) const = 0;
};

// Carries a world-space point through the texture's transformation. pbrt-v3 applies the transformation
// itself where one would expect its inverse (Scale 2 halves a pattern); scenes are made for what it does, so
// this does the same.
class IdentityMapping3D {
  public:
    explicit IdentityMapping3D(const Transform &ctm) : ctm_(ctm) {}
    Point3f Map(const TexturePoint &point) const { return ctm_.Point(point.p); }

  private:
    Transform ctm_;
};

// Makes the mapping that "string mapping" names: uv (the default), spherical, cylindrical or planar. An
// unknown name, and a spherical or cylindrical mapping whose transformation is singular, is an Error at the
// parameter.
std::unique_ptr<TextureMapping2D> MakeMapping(const TextureEntity &e);

} // namespace cuticle
