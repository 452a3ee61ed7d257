// A head and shoulders to grow hair on, as a signed distance and as triangles; and the scalp, where hair
// grows. Units are centimetres, y up, the face looks along +z, +x is the head's left; the origin lies between
// the ears.
#pragma once

#include "core/vecmath.h"

#include <cstdint>
#include <string>
#include <vector>

namespace cuticle {

// Distance to the surface of the bust, negative inside. Near the surface it is right to about a tenth (smooth
// unions of ellipsoids and capsules bend it a little), and its sign is exact by definition: the zero set IS
// the head. An adult's sizes: 14.6 wide, 18.6 from brow to back, 22 from chin to crown; shoulders 38 wide.
float HeadDistance(const Point3f &p);
// Unit normal of the level set through p (central differences of HeadDistance).
Normal3f HeadNormal(const Point3f &p);
// The nearest point with HeadDistance(p) >= offset along the normals; p itself where it is that far already.
Point3f PushOutOfHead(Point3f p, float offset);

// A point of the scalp: where, the normal there, and how strongly hair grows, 0 to 1.
struct ScalpPoint {
    Point3f p;
    Normal3f n;
    float density = 0;
};

// The hairline: 1 well inside the scalp, 0 outside, a soft edge of some millimetres between.
float HairDensity(const Point3f &p);

// Picks points on the scalp in proportion to area times density (more around the crown); stratified input
// gives stratified roots. The hairline is kept to the size of the cells that density is tabulated in, 3 mm.
class Scalp {
  public:
    Scalp();
    // u, v in [0, 1).
    ScalpPoint Sample(float u, float v) const;
    float Area() const { return area_; } // cm^2, weighted by density

  private:
    static constexpr size_t kAzimuth = 192, kHeight = 128;
    Point3f SurfaceAlong(float azimuth, float cosine) const;
    std::vector<float> rowCdf_;    // over heights
    std::vector<float> columnCdf_; // per row, over azimuths
    float area_ = 0;
};

// A triangle mesh with a unit normal at every vertex.
struct SurfaceMesh {
    std::vector<Point3f> points;
    std::vector<Normal3f> normals;
    std::vector<uint32_t> indices; // three per triangle, counter-clockwise seen from outside
};

// The bust as triangles of edges near `spacing` cm (0.05 to 5, else Error), cut off flat below the chest.
// Every vertex above the cut lies on the zero set to 1e-3 cm.
SurfaceMesh MakeHeadMesh(float spacing = 0.3f);

// Writes binary PLY with normals, whole or not at all. Throws Error naming the path.
void WritePly(const std::string &filename, const SurfaceMesh &mesh);

} // namespace cuticle
