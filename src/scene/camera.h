// Cameras with pbrt-v3's conventions: perspective and orthographic with a thin lens, and environment, the
// whole sphere around a point.
#pragma once

#include "parser/scene_description.h"

namespace cuticle {

enum class Projection { Perspective, Orthographic, Environment };

// The parameters of a camera. Lengths are in camera units; the environment camera uses none of them.
struct CameraParameters {
    Projection projection = Projection::Perspective;
    float fov = 90; // perspective: degrees over the shorter axis of the screen window
    float lensRadius = 0;
    float focalDistance = 1e6f;
    float screenWindow[4] = {-1, 1, -1, 1}; // x0 x1 y0 y1; orthographic: lengths
};

class Camera {
  public:
    // worldToCamera must not be singular (Error). resolution: of the whole picture, crop windows aside.
    Camera(const Transform &worldToCamera, const CameraParameters &parameters, Point2i resolution);

    // The ray of a film position pFilm, in pixels of the whole picture, (0,0) its upper left corner; uLens
    // in [0,1)^2. It starts on the lens; its direction has unit length in world space.
    //
    // Environment: theta from +y down the rows, phi from +x toward +z along them; against a perspective
    // camera in the same place the picture is mirrored, as pbrt-v3's. Orthographic with a lens: every film
    // position has a lens of its own around its ray, so that a small lens gives the pinhole's picture.
    // pbrt-v3 puts one lens at the camera's origin for all (its issue 315), which makes it a perspective
    // camera, however small the lens.
    Ray GenerateRay(Point2f pFilm, Point2f uLens) const;

    const Transform &WorldToCamera() const { return worldToCamera_; }
    // Whether a matrix maps camera space to screen space; an environment camera has none.
    bool HasCameraToScreen() const { return parameters_.projection != Projection::Environment; }
    // The projection to screen space. Perspective: near 0.01, far 1000. Orthographic: the identity, depth as
    // it is. Environment: of no meaning.
    const Transform &CameraToScreen() const { return cameraToScreen_; }
    // The film position of a world-space point, without a lens (the inverse of GenerateRay).
    Point2f WorldToRaster(const Point3f &p) const;
    // The angle that a pixel at the centre of the screen subtends, in radians; 0 where rays are parallel.
    float PixelAngle() const;
    // The width of a pixel in world space at a distance (>= 0) from the camera, at the centre of the screen.
    float PixelWidthAt(float distance) const;
    const CameraParameters &Parameters() const { return parameters_; }

  private:
    Transform worldToCamera_, cameraToWorld_, cameraToScreen_, worldToRaster_;
    CameraParameters parameters_;
    // The film plane at z = 1 of camera space (orthographic: at any z): its corner, and the step a pixel.
    // Environment: the steps of phi and theta.
    double x0_ = 0, y0_ = 0, dx_ = 0, dy_ = 0;
};

// Makes the camera of a Camera directive; entity.ctm is world to camera. "realistic" is replaced, with a
// Warning, by a perspective camera with a thin lens of its lens file's focal length (50 mm where it cannot
// be read); filmDiagonal in mm. An unknown name or senseless values are an Error. Shutter times are read and
// have no effect: nothing moves.
Camera MakeCamera(const Entity &entity, Point2i resolution, float filmDiagonal = 35);

} // namespace cuticle
