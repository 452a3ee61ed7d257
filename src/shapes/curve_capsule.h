//> Declare the pieces of a curve and their capsules
#pragma once

#include "shapes/curve_types.h"

namespace cuticle {

//> Declare the capsules
// A bound of a piece of curve: every point within half the larger width of the curve, from u0 to u1 of a
// segment, is within `radius` of the line from p to p + e. The set tests it before it looks at the curve.
struct CurveCapsule {
    Vector3d p, e;
    double radius;
};
CurveCapsule CapsuleOf(const CurveSegment &segment, double u0, double u1);
//<

//> Declare the pieces of a segment
// Writes 16 numbers, column by column: the matrix that takes a cubic's control points to those of its part
// [u0, u1].
void PieceMatrix(double u0, double u1, double *columns);

// The control points of a piece, and half its larger width.
struct PieceShape {
    Vector3d p[4];
    double radius;
};
// columns: PieceMatrix(u0, u1). u0 and u1 may lie a little outside [0, 1]; the width is then that of the end.
PieceShape ShapeOfPiece(const CurveSegment &segment, const double *columns, double u0, double u1);
CurveCapsule CapsuleOf(const PieceShape &shape);
//<

} // namespace cuticle
//<
