// Shape "curve" statements, which a scene of hair holds by the million: read fast where they are written in
// the ordinary way, checked and explained where not, and appended as segments either way.
#pragma once

#include "parser/graphics_state.h"
#include "shapes/curve.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace cuticle {

// One Shape "curve" as written.
struct CurveStatement {
    std::vector<double> P, N; // three numbers a point, a normal
    bool hasN = false, hasWidth = false, hasWidth0 = false, hasWidth1 = false;
    double width = 1, width0 = 1, width1 = 1;
    CurveType type = CurveType::Flat;
    CurveBasis basis = CurveBasis::Bezier;
    int degree = 3;
    int material = 0;            // index into SceneDescription::materials
    const char *begin = nullptr; // of the word Shape

    void Clear(); // but keeps the vectors' memory
};

// Fills the pools and curveGroups of a scene description.
class CurveReader {
  public:
    CurveReader(SceneText *text, GraphicsState *state, SceneDescription *scene)
        : text_(*text), state_(*state), scene_(*scene) {}

    // Reads a statement from behind the word Shape without any allocation, if all of it is written in the
    // ordinary way. Otherwise leaves everything as it was and returns false: the general reader takes over,
    // or says what is wrong.
    bool TryFast(const char *word);
    // The same from a parameter set, with everything checked and said. material: with the statement's own
    // parameters.
    void Read(const ParamSet &params, const Token &word, int material);
    // Gives back what was reserved in excess, when all is read.
    void Finish();

  private:
    void UpdateTransform();
    bool Emit(const CurveStatement &c, std::string *error);
    bool Append(const CurveStatement &c, float width0, float width1, uint32_t group, CurvePool *pool,
                std::string *error);
    bool ToPool(const std::vector<double> &P);
    CurvePool *Pool();
    uint32_t GroupIndex(const CurveGroup &group, const char *at);
    void ClaimMore(CurvePool *pool);

    SceneText &text_;
    GraphicsState &state_;
    SceneDescription &scene_;

    // The current transformation as curves need it, computed when the first one meets it.
    uint64_t transformVersion_ = 0;
    bool keepsPoints_ = true; // curves stay in their own coordinates
    bool isUneven_ = false;
    double scale_ = 1;
    bool swapsHandedness_ = false;

    // The uneven curves of the world and of objects, by object (-1: the world) and transformation; and those
    // of the current one, once they are looked up.
    std::map<std::pair<int, Transform::Matrix>, size_t> unevenAt_;
    std::optional<std::pair<int, size_t>> unevenNow_;

    // Used again for each statement.
    CurveStatement statement_;
    std::vector<Point3f> points_;
    std::vector<Normal3f> normals_;

    std::unordered_map<uint64_t, std::vector<uint32_t>> groupsByState_;
    CurveGroup lastGroup_;
    uint32_t lastGroupIndex_ = UINT32_MAX;
};

} // namespace cuticle
