#include "parser/graphics_state.h"

namespace cuticle {

namespace {

bool IsAffine(const Transform::Matrix &m) {
    return m[3][0] == 0 && m[3][1] == 0 && m[3][2] == 0 && m[3][3] == 1;
}

constexpr size_t kMaxBlockDepth = 10000;
constexpr std::array<std::string_view, 3> kBlockNames{"Attribute", "Transform", "Object"};

std::string_view NameOf(BlockKind kind) { return kBlockNames[static_cast<size_t>(kind)]; }

} // namespace

void ScopedNames::Set(NameMap *map, const std::string &name, int index) {
    const auto [at, isNew] = map->try_emplace(name, index);
    hidden_.push_back({map, name, isNew ? kNone : at->second});
    at->second = index;
}

void ScopedNames::Restore(size_t mark) {
    for (; hidden_.size() > mark; hidden_.pop_back()) {
        const HiddenName &h = hidden_.back();
        if (h.index == kNone)
            h.map->erase(h.name);
        else
            (*h.map)[h.name] = h.index;
    }
}

void GraphicsState::BeginWorld(const Token &word) {
    if (inWorld_)
        return text_.Complain(word, "second WorldBegin", "a second WorldBegin; it is ignored, as by pbrt-v3");
    inWorld_ = true;
    ctm_ = {};
    ++transformVersion_;
    active_ = kBoth;
    NameSpace("world");
}

bool GraphicsState::RequireWorld(const Token &word) {
    if (!inWorld_)
        text_.Complain(word, fmt::format("{} before WorldBegin", word.text),
                       "{} belongs between WorldBegin and WorldEnd, and WorldBegin has not come yet; it is "
                       "ignored, as by pbrt-v3",
                       word.text);
    return inWorld_;
}

bool GraphicsState::BeginBlock(const Token &word, BlockKind kind) {
    if (!RequireWorld(word))
        return false;
    if (blocks_.size() >= kMaxBlockDepth)
        text_.Fail(word, "blocks are nested {} deep here: {} without its end?", kMaxBlockDepth, word.text);
    blocks_.push_back({kind, text_.Loc(word), attributes, names.Mark(), ctm_, active_});
    return true;
}

void GraphicsState::EndBlock(const Token &word, BlockKind kind) {
    if (!RequireWorld(word))
        return;
    if (blocks_.empty()) {
        if (!text_.missingFile)
            text_.Complain(word, fmt::format("{} without {}Begin", word.text, NameOf(kind)),
                           "{} without {}Begin; it is ignored, as by pbrt-v3", word.text, NameOf(kind));
        return;
    }
    const Block &b = blocks_.back();
    if (b.kind != kind)
        text_.Fail(word, "{} inside the block of {}Begin at {}: that must end first", word.text,
                   NameOf(b.kind), b.loc.ToString());
    ctm_ = b.ctm;
    ++transformVersion_;
    active_ = b.active;
    if (kind != BlockKind::Transform) {
        attributes = b.attributes;
        names.Restore(b.names);
    }
    if (kind == BlockKind::Object)
        object = -1;
    blocks_.pop_back();
}

std::string GraphicsState::CloseBlocks(std::string_view before) {
    if (blocks_.empty())
        return "";
    const Block &b = blocks_.back();
    std::string message =
        fmt::format("{0}Begin at {1} has no {0}End before {2}", NameOf(b.kind), b.loc.ToString(), before);
    blocks_.clear();
    return message;
}

void GraphicsState::Apply(const Token &word, const Transform &t, bool concat) {
    for (unsigned i = 0; i < 2; ++i) {
        if (!(active_ & (1u << i)))
            continue;
        const Transform next = concat ? ctm_[i] * t : t;
        if (t.IsSingular() || next.IsSingular())
            text_.Fail(word, "{} makes a transformation that cannot be inverted{}", word.text,
                       word.text == "Scale" ? " (a factor is 0?)"
                       : word.text == "LookAt"
                           ? " (the eye is the point looked at, or up points along the view?)"
                           : "");
        ctm_[i] = next;
    }
    ++transformVersion_;
}

void GraphicsState::NoteProjective(const Token &word, const Transform::Matrix &m) {
    if (IsAffine(m))
        return;
    projective_ = {text_.Loc(word),
                   fmt::format("{}: the matrix is projective (its last row, each fourth number, is {:g} {:g} "
                               "{:g} {:g})",
                               word.text, m[3][0], m[3][1], m[3][2], m[3][3])};
}

const Transform &GraphicsState::Current(const FileLoc &loc) {
    if (!IsAffine(ctm_[0].M()))
        throw Error(projective_.loc,
                    "{}, which only a light of directions (infinite, distant) can be, not what stands at {}; "
                    "it must be 0 0 0 1",
                    projective_.what, loc.ToString());
    return CurrentOfDirections(loc);
}

const Transform &GraphicsState::CurrentOfDirections(const FileLoc &loc) {
    if (!(ctm_[0] == ctm_[1]))
        Warning(loc, "motion",
                "motion is not rendered; the transformation at the start time is used throughout");
    return ctm_[0];
}

void GraphicsState::UseSpace(const std::string &name, const Token &at) {
    const auto it = coordinateSystems_.find(name);
    if (it != coordinateSystems_.end()) {
        ctm_ = it->second;
        ++transformVersion_;
    } else if (!text_.missingFile) {
        text_.Complain(
            at, "unknown coordinate system",
            "no coordinate system {} has been named, and the transformation stays, as in pbrt-v3{}",
            Quoted(name), text_.SuggestOnce("unknown coordinate system", name, {&coordinateSystems_}));
    }
}

} // namespace cuticle
