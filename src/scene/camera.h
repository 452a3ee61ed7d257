// The camera: perspective with a thin lens, pbrt-v3's conventions.
#pragma once

#include "scene/scene_description.h"

namespace cuticle {

// fov in degrees over the shorter axis of the screen window; lensRadius and focalDistance in camera units.
struct CameraParameters {
    float fov = 90;
    float lensRadius = 0;
    float focalDistance = 1e6f;
    float screenWindow[4] = {-1, 1, -1, 1}; // x0 x1 y0 y1
};

class Camera {
  public:
    // worldToCamera must not be singular (Error). resolution: of the whole picture, crop windows aside.
    Camera(const Transform &worldToCamera, const CameraParameters &parameters, Point2i resolution);

    // pFilm in pixels of the whole picture, (0,0) its upper left corner; uLens in [0,1)^2. The ray starts on
    // the lens; its direction has unit length in world space.
    Ray GenerateRay(Point2f pFilm, Point2f uLens) const;

    const Transform &WorldToCamera() const { return worldToCamera_; }
    // Perspective projection, near 0.01, far 1000: camera space to screen space.
    const Transform &CameraToScreen() const { return cameraToScreen_; }
    // Where a world-space point falls on the film of a pinhole camera (the inverse of GenerateRay).
    Point2f WorldToRaster(const Point3f &p) const;
    // The angle that a pixel at the centre of the screen subtends, in radians.
    float PixelAngle() const;
    const CameraParameters &Parameters() const { return parameters_; }

  private:
    Transform worldToCamera_, cameraToWorld_, cameraToScreen_, worldToRaster_;
    CameraParameters parameters_;
    // Film plane at z = 1 of camera space: corner and step a pixel.
    double x0_ = 0, y0_ = 0, dx_ = 0, dy_ = 0;
};

// Camera directives. entity.ctm is world to camera. perspective: fov, halffov, frameaspectratio,
// screenwindow, lensradius, focaldistance (shutter times are read and have no effect: nothing moves).
// orthographic, environment and realistic are replaced by perspective with a Warning; an unknown name or
// senseless values are an Error.
Camera MakeCamera(const Entity &entity, Point2i resolution);

} // namespace cuticle
