#include "core/error.h"

#include <algorithm>
#include <iostream>
#include <map>
#include <mutex>
#include <vector>

namespace cuticle {

namespace {

struct WarningLog {
    std::mutex mutex;
    std::map<std::string, size_t> counts;
    bool strict = false;
};

WarningLog &Log() {
    static WarningLog log;
    return log;
}

// The place of the innermost PlaceScope of this thread.
thread_local const FileLoc *currentPlace = nullptr;

// Where something is that happened at loc: there or, where that is not known, at the directive under way.
const FileLoc &PlaceOf(const FileLoc &loc) { return loc.file || !currentPlace ? loc : *currentPlace; }

// What to add to a message at loc: the directive under way that made another file be read.
std::string UsedAt(const FileLoc &loc) {
    if (!currentPlace || !loc.file || !currentPlace->file || *loc.file == *currentPlace->file)
        return "";
    return " (used at " + currentPlace->ToString() + ")";
}

// Words of a damaged file stand in messages: no byte of them may move the cursor or end the text.
std::string Printable(std::string text) {
    for (char &c : text)
        if ((static_cast<unsigned char>(c) < 32 && c != '\n') || c == 127)
            c = c == '\t' ? ' ' : '?';
    return text;
}

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

} // namespace

std::string FileLoc::ToString() const {
    if (!file)
        return "";
    std::string s = *file;
    if (line > 0)
        s += ":" + std::to_string(line);
    if (line > 0 && column > 0)
        s += ":" + std::to_string(column);
    return s;
}

PlaceScope::PlaceScope(const FileLoc &loc) : loc_(loc), outer_(currentPlace) { currentPlace = &loc_; }
PlaceScope::~PlaceScope() { currentPlace = outer_; }

static std::string Located(const FileLoc &given, const std::string &message, std::string_view sourceLine) {
    const FileLoc &loc = PlaceOf(given);
    std::string s = loc.ToString();
    s += (s.empty() ? "" : ": ") + std::string("error: ") + Printable(message) + UsedAt(loc);
    if (!sourceLine.empty()) {
        // Long lines (a million numbers on one line are real) are shown around the column only.
        constexpr size_t kAround = 60;
        const size_t column = loc.column > 0 ? loc.column - 1 : 0;
        const size_t begin = column > kAround ? column - kAround : 0;
        const std::string_view shown = sourceLine.substr(std::min(begin, sourceLine.size()), 2 * kAround);
        s += "\n    " + Printable(std::string(shown)) + "\n    " + std::string(column - begin, ' ') + "^";
    }
    return s;
}

Error::Error(const std::string &message) : Error(FileLoc{}, message) {}

Error::Error(const FileLoc &loc, const std::string &message, std::string_view sourceLine)
    : std::runtime_error(Located(loc, message, sourceLine)) {}

std::string Reason(const Error &e) {
    const std::string_view text = e.what();
    // What a PlaceScope lent it is no place of its own
    const std::string prefix = (currentPlace ? currentPlace->ToString() + ": " : "") + "error: ";
    for (const std::string_view p : {std::string_view(prefix), std::string_view("error: ")})
        if (text.starts_with(p))
            return std::string(text.substr(p.size()));
    return std::string(text);
}

void Warning(const FileLoc &loc, const std::string &kind, const std::string &message) {
    WarningLog &log = Log();
    const std::lock_guard lock(log.mutex);
    if (log.strict)
        throw Error(loc, message + " (a warning without --strict)");
    if (log.counts[kind]++ == 0) {
        const std::string where = PlaceOf(loc).ToString();
        std::cerr << where << (where.empty() ? "" : ": ") << "warning: " << Printable(message) << UsedAt(loc)
                  << "\n";
    }
}

void Warning(const std::string &kind, const std::string &message) { Warning(FileLoc{}, kind, message); }

void SetStrictWarnings(bool strict) {
    const std::lock_guard lock(Log().mutex);
    Log().strict = strict;
}

size_t FlushWarnings() {
    WarningLog &log = Log();
    const std::lock_guard lock(log.mutex);
    size_t total = 0;
    for (const auto &[kind, count] : log.counts) {
        total += count;
        if (count > 1)
            std::cerr << "warning: " << Printable(kind) << ": " << count - 1 << " more of this kind\n";
    }
    log.counts.clear();
    return total;
}

std::string Suggestion(std::string_view name, const std::string_view *names, size_t count) {
    std::string_view best;
    size_t bestDistance = 1 + name.size() / 3;
    for (size_t i = 0; i < count; ++i) {
        const size_t d = EditDistance(name, names[i]);
        if (d <= bestDistance && (best.empty() || d < bestDistance))
            best = names[i], bestDistance = d;
    }
    if (!best.empty())
        return " Did you mean \"" + std::string(best) + "\"?";
    std::string s = " Known are: ";
    for (size_t i = 0; i < count; ++i)
        s += (i ? ", " : "") + std::string(names[i]);
    return s + ".";
}

} // namespace cuticle
