#include "parser/curve_reader.h"

#include "core/memory_budget.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <initializer_list>

namespace cuticle {

void CurveStatement::Clear() {
    P.clear(), N.clear();
    hasN = hasWidth = hasWidth0 = hasWidth1 = false;
    width = width0 = width1 = 1;
    type = CurveType::Flat;
    basis = CurveBasis::Bezier;
    degree = 3;
}

namespace {

// A cursor over the text of a statement. Every function takes what it names and says whether it was there;
// where it was not, the cursor may stand anywhere. The text ends with a NUL byte, at which any comparison
// stops.
class CurveScanner {
  public:
    CurveScanner(const char *cursor, const char *end) : p_(cursor), end_(end) {}

    const char *Cursor() const { return p_; }
    bool AtEnd() const { return p_ == end_; }
    void Skip() {
        while (IsBlank(*p_))
            ++p_;
    }
    bool Take(std::string_view literal) {
        for (size_t i = 0; i < literal.size(); ++i)
            if (p_[i] != literal[i])
                return false;
        p_ += literal.size();
        return true;
    }
    // Takes one parameter, its name included, into the statement; false too where it comes a second time.
    bool TakeParameter(CurveStatement *c);

  private:
    bool First(unsigned bit) {
        const bool isFirst = !(seen_ & bit);
        seen_ |= bit;
        return isFirst;
    }
    bool TakeBracket() {
        Skip();
        const bool bracket = *p_ == '[';
        p_ += bracket;
        return bracket;
    }
    bool TakeValue(double *x) {
        const char *after = ScanNumber(p_, end_, x);
        if (!after || !(IsBlank(*after) || *after == ']' || *after == '"' || after == end_) ||
            !(std::abs(*x) <= FLT_MAX))
            return false;
        p_ = after;
        return true;
    }
    // One number, or any number of them in brackets.
    bool Numbers(std::vector<double> *v) {
        const bool bracket = TakeBracket();
        do {
            Skip();
            if (bracket && *p_ == ']') {
                ++p_;
                return true;
            }
            double x;
            if (!TakeValue(&x))
                return false;
            v->push_back(x);
        } while (bracket);
        return true;
    }
    // With or without brackets.
    bool Number(double *x) {
        const bool bracket = TakeBracket();
        Skip();
        if (!TakeValue(x))
            return false;
        if (!bracket)
            return true;
        Skip();
        return Take("]");
    }
    // One of a few strings, with or without brackets; its index, or -1.
    int OneOf(std::initializer_list<std::string_view> words) {
        const bool bracket = TakeBracket();
        Skip();
        int index = 0;
        for (const std::string_view word : words) {
            if (Take(word)) {
                if (!bracket)
                    return index;
                Skip();
                return Take("]") ? index : -1;
            }
            ++index;
        }
        return -1;
    }

    const char *p_;
    const char *const end_;
    unsigned seen_ = 0;
};

bool CurveScanner::TakeParameter(CurveStatement *c) {
    double number = 0;
    if (Take("\"point P\"") || Take("\"point3 P\""))
        return First(1) && Numbers(&c->P);
    if (Take("\"float width0\"")) {
        c->hasWidth0 = true;
        return First(2) && Number(&c->width0);
    }
    if (Take("\"float width1\"")) {
        c->hasWidth1 = true;
        return First(4) && Number(&c->width1);
    }
    if (Take("\"float width\"")) {
        c->hasWidth = true;
        return First(8) && Number(&c->width);
    }
    if (Take("\"string type\"")) {
        const int i = OneOf({"\"flat\"", "\"cylinder\"", "\"ribbon\""});
        c->type = i == 0 ? CurveType::Flat : i == 1 ? CurveType::Cylinder : CurveType::Ribbon;
        return First(16) && i >= 0;
    }
    if (Take("\"normal N\"")) {
        c->hasN = true;
        return First(32) && Numbers(&c->N);
    }
    if (Take("\"string basis\"")) {
        const int i = OneOf({"\"bezier\"", "\"bspline\""});
        c->basis = i == 0 ? CurveBasis::Bezier : CurveBasis::BSpline;
        return First(64) && i >= 0;
    }
    if (Take("\"integer degree\"")) {
        const bool ok = First(128) && Number(&number) && (number == 2 || number == 3);
        c->degree = number == 2 ? 2 : 3;
        return ok;
    }
    if (Take("\"integer splitdepth\""))
        return First(256) && Number(&number) && number == std::floor(number) && std::abs(number) < 1e6;
    return false;
}

} // namespace

bool CurveReader::TryFast(const char *word) {
    CurveScanner scanner(text_.lexer().Cursor(), text_.lexer().Source().End());
    scanner.Skip();
    if (!scanner.Take("\"curve\""))
        return false;
    CurveStatement &c = statement_;
    c.Clear();
    c.material = state_.attributes.material;
    c.begin = word;
    for (scanner.Skip(); *scanner.Cursor() == '"'; scanner.Skip())
        if (!scanner.TakeParameter(&c))
            return false;
    // A statement ends where the next directive begins; anything else is for the general reader to judge,
    // as is the end of an included file, behind which more of it may come.
    const char *const p = scanner.Cursor();
    if (!((scanner.AtEnd() && !text_.IsIncluded()) || (*p >= 'A' && *p <= 'Z')))
        return false;
    if (c.hasN != (c.type == CurveType::Ribbon) || (state_.InObject() && state_.attributes.areaLight >= 0))
        return false;
    if (!Emit(c, nullptr))
        return false;
    text_.lexer().SetCursor(p);
    return true;
}

namespace {

// Looks up the parameters of a curve's statement in a set; Errors where they are not what a curve takes.
class CurveParams {
  public:
    CurveParams(SceneText *text, const ParamSet &params, const Token &word)
        : text_(*text), params_(params), word_(word) {}

    // Leaves the curve out, as pbrt-v3 does with a message.
    template <typename... Args>
    [[noreturn]] void Fail(std::string_view name, fmt::format_string<Args...> format, Args &&...args) const {
        throw ErrorAt(name, fmt::vformat(format, fmt::make_format_args(args...)))
            .WithPbrtInstead("the curve is left out");
    }
    // Null when it is not given, and where pbrt-v3 does not find it: of another type, which is a Warning.
    // how: as it is written, for the message.
    const Param *Typed(std::string_view name, std::initializer_list<ParamType> types,
                       std::string_view how) const {
        const Param *p = params_.Find(name);
        if (!p)
            return nullptr;
        p->used = true;
        if (std::find(types.begin(), types.end(), p->type) != types.end())
            return p;
        Forgive(name, "it is ignored", "a curve's \"{}\" is written {}", name, how);
        return nullptr;
    }
    // False, and *value as it was, when it is not given.
    bool Number(std::string_view name, std::string_view how, double *value) const {
        const Param *p = Typed(name, {ParamType::Float, ParamType::Integer}, how);
        if (!p)
            return false;
        if (p->numbers.size() != 1) {
            Forgive(name, "it is ignored", "a curve's \"{}\" takes one number, not {}", name,
                    p->numbers.size());
            return false;
        }
        *value = p->numbers[0];
        return true;
    }
    // The index of the word that was given, 0 when none was; words.size() for an unknown one, of which
    // *unknown tells.
    template <size_t N>
    size_t Choice(std::string_view name, std::string_view how, const std::array<std::string_view, N> &words,
                  std::optional<Error> *unknown) const {
        const Param *p = Typed(name, {ParamType::String}, how);
        if (!p)
            return 0;
        if (p->strings.size() != 1) {
            Forgive(name, "it is ignored", "a curve's \"{}\" is one word, not {}", name, p->strings.size());
            return 0;
        }
        const std::string_view given = p->strings[0];
        const auto it = std::find(words.begin(), words.end(), given);
        if (it == words.end())
            *unknown = ErrorAt(name, fmt::format("a curve's \"{}\" cannot be {}", name, Quoted(given)))
                           .WithRemedy(Suggestion(given, words.data(), words.size()));
        return static_cast<size_t>(it - words.begin());
    }
    // Three numbers each.
    std::vector<double> Triples(std::string_view name, std::string_view declaration, const Param &p) const {
        std::vector<double> numbers = p.numbers;
        const size_t excess = numbers.size() % 3;
        if (excess != 0)
            Forgive(name, excess == 1 ? "the last is ignored" : "the last two are ignored",
                    "a curve's \"{}\" has {} numbers, which is no multiple of 3", declaration,
                    numbers.size());
        numbers.resize(numbers.size() - excess);
        return numbers;
    }
    // Goes on as pbrt-v3 does, which is what `instead` says, with a Warning.
    template <typename... Args>
    void Forgive(std::string_view name, std::string_view instead, fmt::format_string<Args...> format,
                 Args &&...args) const {
        ErrorAt(name, fmt::vformat(format, fmt::make_format_args(args...)))
            .WithPbrtInstead(std::string(instead))
            .GoOnAsPbrt("curve parameter that pbrt-v3 forgives");
    }

  private:
    // The error at the parameter, or where that is not given, and for "", at the word Shape.
    Error ErrorAt(std::string_view name, const std::string &message) const {
        const Param *p = name.empty() ? nullptr : params_.Find(name);
        try {
            text_.Fail(p ? text_.PlaceOf(word_, *p) : word_.begin, message);
        } catch (const Error &e) {
            return e;
        }
    }
    SceneText &text_;
    const ParamSet &params_;
    const Token &word_;
};

} // namespace

void CurveReader::Read(const ParamSet &params, const Token &word, int material) {
    CurveStatement &c = statement_;
    c.Clear();
    c.material = material;
    c.begin = word.begin;
    const CurveParams in(&text_, params, word);
    const Param *P = in.Typed("P", {ParamType::Point3}, "\"point P\" [ x y z ... ]");
    if (!P)
        in.Fail("P", "Shape \"curve\" needs control points, \"point P\" [ x y z ... ]");
    c.P = in.Triples("P", "point P", *P);
    c.hasWidth = in.Number("width", "\"float width\" value", &c.width);
    c.hasWidth0 = in.Number("width0", "\"float width0\" value", &c.width0);
    c.hasWidth1 = in.Number("width1", "\"float width1\" value", &c.width1);
    static constexpr std::array<std::string_view, 3> kTypeNames{"flat", "cylinder", "ribbon"};
    static constexpr CurveType kTypes[] = {CurveType::Flat, CurveType::Cylinder, CurveType::Ribbon};
    std::optional<Error> unknown;
    size_t type = in.Choice("type", "\"string type\" name", kTypeNames, &unknown);
    if (type == kTypeNames.size()) {
        Error(*unknown).WithPbrtInstead("it is taken as \"cylinder\"").GoOnAsPbrt("unknown type of curve");
        type = 1;
    }
    c.type = kTypes[type];
    static constexpr std::array<std::string_view, 2> kBasisNames{"bezier", "bspline"};
    const size_t basis = in.Choice("basis", "\"string basis\" name", kBasisNames, &unknown);
    if (basis == kBasisNames.size())
        throw Error(*unknown).WithPbrtInstead("the curve is left out");
    c.basis = basis == 1 ? CurveBasis::BSpline : CurveBasis::Bezier;
    double degree = 3, splitDepth = 3;
    in.Number("degree", "\"integer degree\" 2 or 3", &degree);
    if (degree != 2 && degree != 3)
        in.Fail("degree", "a curve's \"degree\" must be 2 or 3");
    c.degree = degree == 2 ? 2 : 3;
    // pbrt-v3's accelerator wants it, ours does not
    in.Number("splitdepth", "\"integer splitdepth\" value", &splitDepth);
    if (const Param *N = in.Typed("N", {ParamType::Normal}, "\"normal N\" [ x y z ... ]")) {
        if (c.type == CurveType::Ribbon) {
            c.N = in.Triples("N", "normal N", *N);
            c.hasN = true;
        } else {
            Warning(N->loc, "curve normals without ribbon",
                    "\"normal N\" is used for curves of type \"ribbon\" only");
        }
    }
    if (c.type == CurveType::Ribbon && !c.hasN)
        in.Fail("N", "a curve of type \"ribbon\" needs \"normal N\", one at each end of each segment");
    std::string error;
    const size_t segments = CurveSegmentCount(c.P.size() / 3, c.basis, c.degree, &error);
    if (segments == 0)
        in.Fail("", "Shape \"curve\": {}", error);
    if (c.hasN && c.N.size() / 3 != segments + 1)
        in.Fail("N", "{} normals for a ribbon of {} segments: {} are needed", c.N.size() / 3, segments,
                segments + 1);
    if (!Emit(c, &error))
        text_.Fail(word, "Shape \"curve\": {}", error);
    params.ReportUnused("Shape \"curve\"");
}

// Looks at the current transformation once for all curves that follow under it.
void CurveReader::UpdateTransform() {
    transformVersion_ = state_.TransformVersion();
    const Transform &t = state_.Current(text_.lexer().Loc(text_.lexer().Cursor()));
    isUneven_ = t.ScalesUnevenly();
    keepsPoints_ = isUneven_ || t.IsIdentity();
    scale_ = isUneven_ ? 1 : std::cbrt(std::abs(t.Determinant()));
    swapsHandedness_ = !isUneven_ && t.SwapsHandedness(); // of uneven ones the instance tells it
    unevenNow_.reset();
}

// Brings control points into the pool's space, double until the last step; false where one is out of range
// there or in the world.
bool CurveReader::ToPool(const std::vector<double> &P) {
    points_.resize(P.size() / 3);
    const Transform::Matrix &m = state_.AtStart().M();
    bool reached = true;
    for (size_t i = 0; i < points_.size(); ++i) {
        const double x = P[3 * i], y = P[3 * i + 1], z = P[3 * i + 2];
        if (keepsPoints_)
            points_[i] = Point3f(Vector3d(x, y, z));
        if (!keepsPoints_ || isUneven_) {
            const auto row = [&](size_t r) { return m[r][0] * x + m[r][1] * y + m[r][2] * z + m[r][3]; };
            const Point3f inWorld(Vector3d(row(0), row(1), row(2)) / row(3));
            if (!keepsPoints_)
                points_[i] = inWorld;
            reached = reached && IsWithinReach(inWorld);
        }
        reached = reached && IsWithinReach(points_[i]);
    }
    return reached;
}

// Returns the pool that the curves under the current transformation are kept in.
CurvePool *CurveReader::Pool() {
    ObjectDefinition *object =
        state_.InObject() ? &scene_.objects[static_cast<size_t>(state_.object)] : nullptr;
    if (!isUneven_)
        return object ? &object->curves : &scene_.curves;
    std::vector<UnevenCurves> &uneven = object ? object->unevenCurves : scene_.unevenCurves;
    if (!unevenNow_ || unevenNow_->first != state_.object) {
        const Transform &t = state_.AtStart();
        const auto [at, isNew] = unevenAt_.try_emplace({state_.object, t.M()}, uneven.size());
        if (isNew)
            uneven.push_back({t, {}});
        unevenNow_.emplace(state_.object, at->second);
    }
    return &uneven[unevenNow_->second].curves;
}

// Puts the curve into the pool as segments; both readers end here. On a refusal the pool is as it was.
bool CurveReader::Emit(const CurveStatement &c, std::string *error) {
    const auto refuse = [&](const char *why) {
        if (error)
            *error = why;
        return false;
    };
    if (c.P.size() % 3 != 0 || c.N.size() % 3 != 0)
        return refuse("points and normals have three coordinates each");
    if (transformVersion_ != state_.TransformVersion())
        UpdateTransform();
    if (!ToPool(c.P))
        return refuse("a control point is out of range after the transformation (beyond 1e18)");
    const auto w0 = static_cast<float>((c.hasWidth0 ? c.width0 : c.hasWidth ? c.width : 1) * scale_);
    const auto w1 = static_cast<float>((c.hasWidth1 ? c.width1 : c.hasWidth ? c.width : 1) * scale_);

    CurvePool *pool = Pool();
    const ShapeState state = state_.StateOfShape(c.material);
    const uint32_t group =
        GroupIndex({c.type, state, {}, state.reverseOrientation != swapsHandedness_}, c.begin);
    if (MemoryIsLimited())
        ClaimMore(pool);
    return Append(c, w0, w1, group, pool, error); // a strand: textures see u from its root to its tip
}

bool CurveReader::Append(const CurveStatement &c, float width0, float width1, uint32_t group, CurvePool *pool,
                         std::string *error) {
    if (c.type != CurveType::Ribbon)
        return AppendCurve(points_.data(), points_.size(), c.basis, c.degree, width0, width1, group,
                           &pool->segments, error);
    normals_.resize(c.N.size() / 3);
    for (size_t i = 0; i < normals_.size(); ++i) {
        const Normal3f n(Vector3d(c.N[3 * i], c.N[3 * i + 1], c.N[3 * i + 2]));
        normals_[i] = keepsPoints_ ? n : state_.AtStart().Normal(n);
    }
    return AppendRibbon(points_.data(), points_.size(), c.basis, c.degree, width0, width1, normals_.data(),
                        normals_.size(), group, &pool->segments, &pool->ribbonNormals, error);
}

uint32_t CurveReader::GroupIndex(const CurveGroup &group, const char *at) {
    const auto isSame = [&](const CurveGroup &g) {
        return g.type == group.type && g.state == group.state && g.flipped == group.flipped;
    };
    if (lastGroupIndex_ != UINT32_MAX && isSame(lastGroup_))
        return lastGroupIndex_;
    const uint64_t key =
        static_cast<uint64_t>(group.state.material) << 32 | static_cast<uint32_t>(group.state.areaLight);
    std::vector<uint32_t> &candidates = groupsByState_[key];
    uint32_t index = UINT32_MAX;
    for (const uint32_t i : candidates)
        if (isSame(scene_.curveGroups[i]))
            index = i;
    if (index == UINT32_MAX) {
        index = static_cast<uint32_t>(scene_.curveGroups.size());
        scene_.curveGroups.push_back(group);
        scene_.curveGroups.back().loc = text_.Loc(at);
        candidates.push_back(index);
    }
    lastGroup_ = group;
    lastGroupIndex_ = index;
    return index;
}

// Claims what the pool has grown by, a megabyte at a time.
void CurveReader::ClaimMore(CurvePool *pool) {
    const size_t bytes = pool->segments.MemoryBytes();
    if (bytes < pool->claimed + (size_t{1} << 20))
        return;
    const Lexer &lexer = text_.lexer();
    ClaimMemory(fmt::format("curve segments, of which {} are read", pool->segments.size()),
                bytes - pool->claimed, lexer.Loc(lexer.Cursor()));
    pool->claimed = bytes;
}

void CurveReader::Finish() {
    const auto trim = [](CurvePool *pool) { pool->segments.shrink_to_fit(); };
    trim(&scene_.curves);
    for (UnevenCurves &c : scene_.unevenCurves)
        trim(&c.curves);
    for (ObjectDefinition &o : scene_.objects) {
        trim(&o.curves);
        for (UnevenCurves &c : o.unevenCurves)
            trim(&c.curves);
    }
}

} // namespace cuticle
