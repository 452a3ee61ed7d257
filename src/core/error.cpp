#include "core/error.h"

#include "core/printable.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <vector>

namespace cuticle {

namespace {

// The innermost scopes of this thread set these; ThreadContext carries them to threads that help.
thread_local const FileLoc *currentPlace = nullptr;
thread_local WarningSink *currentSink = nullptr;
thread_local const std::string *currentSandbox = nullptr;

// The place of something that happened at loc: loc itself or, where that is not known, the directive under
// way.
const FileLoc &PlaceOf(const FileLoc &loc) { return loc.file || !currentPlace ? loc : *currentPlace; }

// The directive under way that made another file be read, as an addition to a message at loc.
std::string UsedAt(const FileLoc &loc) {
    if (!currentPlace || !loc.file || !currentPlace->file || *loc.file == *currentPlace->file)
        return "";
    return fmt::format(" (used at {})", currentPlace->ToString());
}

// Longer names are neither compared nor shown whole: nobody types them, and both would take time and room.
constexpr size_t kMaxSuggested = 60;
constexpr size_t kMaxListed = 100; // names

// Levenshtein's distance: insertions, deletions and replacements that turn a into b.
size_t EditDistance(std::string_view a, std::string_view b) {
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j)
        row[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t old = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
            diagonal = old;
        }
    }
    return row[b.size()];
}

// The part of a source line around the column, and a caret under it. Long lines (a million numbers on one
// line are real) are cut, between two characters.
std::string QuotedLine(std::string_view line, uint32_t column1) {
    constexpr size_t kAround = 60;
    const auto isInside = [&](size_t at) {
        return at < line.size() && (static_cast<unsigned char>(line[at]) & 0xc0) == 0x80;
    };
    const size_t column = std::min<size_t>(column1 > 0 ? column1 - 1 : 0, line.size());
    size_t begin = column > kAround ? column - kAround : 0, end = std::min(begin + 2 * kAround, line.size());
    for (int i = 0; i < 3 && begin < column && isInside(begin); ++i)
        ++begin;
    for (int i = 0; i < 3 && end > column && isInside(end); ++i)
        --end;
    const std::string before = Printable(line.substr(begin, column - begin));
    return fmt::format("\n    {}{}\n    {}^", before, Printable(line.substr(column, end - column)),
                       std::string(Columns(before), ' '));
}

} // namespace

std::string FileLoc::ToString() const {
    if (!file)
        return "";
    const std::string name = Printable(*file);
    if (line == 0)
        return name;
    return column == 0 ? fmt::format("{}:{}", name, line) : fmt::format("{}:{}:{}", name, line, column);
}

PlaceScope::PlaceScope(const FileLoc &loc) : loc_(loc), outer_(currentPlace) { currentPlace = &loc_; }
PlaceScope::~PlaceScope() { currentPlace = outer_; }

WarningScope::WarningScope(WarningSink *sink) : outer_(currentSink) { currentSink = sink; }
WarningScope::~WarningScope() { currentSink = outer_; }

SandboxScope::SandboxScope(const std::string &folder) : outer_(currentSandbox) {
    std::error_code failure;
    const std::filesystem::path real = std::filesystem::canonical(folder, failure);
    if (failure || !std::filesystem::is_directory(real, failure))
        throw Error("the sandbox \"{}\" is no folder", folder);
    folder_ = real == "/" ? "/" : real.string() + "/";
    currentSandbox = &folder_;
}
SandboxScope::~SandboxScope() { currentSandbox = outer_; }
const std::string *SandboxScope::Folder() { return currentSandbox; }

ThreadContext::ThreadContext() : sink_(currentSink), place_(currentPlace), sandbox_(currentSandbox) {}
void ThreadContext::Apply() const { currentSink = sink_, currentPlace = place_, currentSandbox = sandbox_; }

Error::Error(const FileLoc &place, std::string what)
    : place_(PlaceOf(place)), what_(std::move(what)), usedAt_(UsedAt(place_)) {
    Print();
}

Error &&Error::WithRemedy(std::string remedy) && {
    remedy_ = std::move(remedy);
    Print();
    return std::move(*this);
}

Error &&Error::WithSourceLine(std::string_view line) && {
    quotedLine_ = line.empty() ? "" : QuotedLine(line, place_.column);
    Print();
    return std::move(*this);
}

Error &&Error::WithPbrtInstead(std::string instead) && {
    instead_ = std::move(instead);
    return std::move(*this);
}

Error &&Error::Finally() && {
    isFinal_ = true;
    return std::move(*this);
}

void Error::GoOnAsPbrt(const std::string &kind) const {
    if (instead_.empty() || isFinal_)
        throw *this;
    const std::string remedy = remedy_.empty() ? "" : " (" + remedy_ + ")";
    Warning(place_, kind, fmt::format("{}; {}, as by pbrt-v3{}", what_, instead_, remedy));
}

std::string Error::Message() const {
    if (remedy_.empty())
        return what_;
    const bool sentence = remedy_[0] >= 'A' && remedy_[0] <= 'Z';
    return what_ + (sentence ? ". " : "; ") + remedy_;
}

void Error::Print() {
    const std::string where = place_.ToString();
    printed_ = where + (where.empty() ? "" : ": ") + "error: " + Printable(Message()) + usedAt_ + quotedLine_;
}

void WarningLog::Warn(const FileLoc &place, const std::string &kind, const std::string &message) {
    if (strict_)
        throw Error(place, "{} (a warning without --strict)", message);
    const std::lock_guard lock(mutex_);
    if (counts_[kind]++ > 0)
        return;
    const std::string where = place.ToString();
    std::cerr << where << (where.empty() ? "" : ": ") << "warning: " << Printable(message) << UsedAt(place)
              << "\n";
}

size_t WarningLog::Flush() {
    const std::lock_guard lock(mutex_);
    size_t total = 0;
    for (const auto &[kind, count] : counts_) {
        total += count;
        if (count > 1)
            std::cerr << "warning: " << Printable(kind) << ": " << count - 1 << " more of this kind\n";
    }
    counts_.clear();
    return total;
}

void Warning(const FileLoc &loc, const std::string &kind, const std::string &message) {
    if (currentSink) {
        currentSink->Warn(PlaceOf(loc), kind, message);
        return;
    }
    WarningLog printer;
    printer.Warn(PlaceOf(loc), kind, message);
}

void Warning(const std::string &kind, const std::string &message) { Warning(FileLoc{}, kind, message); }

std::string Suggestion(std::string_view name, const std::string_view *names, size_t count) {
    std::string_view best;
    size_t bestDistance = 1 + name.size() / 3;
    for (size_t i = 0; i < count && name.size() <= kMaxSuggested; ++i) {
        const size_t length = names[i].size(); // the distance is at least the difference in length
        if (length > kMaxSuggested ||
            std::max(length, name.size()) - std::min(length, name.size()) > bestDistance)
            continue;
        const size_t d = EditDistance(name, names[i]);
        if (d <= bestDistance && (best.empty() || d < bestDistance))
            best = names[i], bestDistance = d;
    }
    if (!best.empty())
        return fmt::format("Did you mean \"{}\"?", best);
    std::vector<std::string> listed;
    for (size_t i = 0, bytes = 0; i < count && i < kMaxListed && bytes < 20 * kMaxSuggested; ++i) {
        const bool isLong = names[i].size() > kMaxSuggested;
        listed.push_back(std::string(names[i].substr(0, kMaxSuggested)) + (isLong ? "..." : ""));
        bytes += isLong ? listed.back().size() : 0;
    }
    return fmt::format("Known are: {}{}.", fmt::join(listed, ", "), listed.size() < count ? ", ..." : "");
}

} // namespace cuticle
