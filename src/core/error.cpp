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

Error::Error(const std::string &message) : std::runtime_error("error: " + message) {}

static std::string Located(const FileLoc &loc, const std::string &message, std::string_view sourceLine) {
    std::string s = loc.ToString();
    s += (s.empty() ? "" : ": ") + std::string("error: ") + message;
    if (!sourceLine.empty()) {
        // Long lines (a million numbers on one line are real) are shown around the column only.
        constexpr size_t kAround = 60;
        const size_t column = loc.column > 0 ? loc.column - 1 : 0;
        const size_t begin = column > kAround ? column - kAround : 0;
        std::string shown(sourceLine.substr(std::min(begin, sourceLine.size()), 2 * kAround));
        for (char &c : shown)
            if (static_cast<unsigned char>(c) < 32 || c == 127)
                c = c == '\t' ? ' ' : '?';
        s += "\n    " + shown + "\n    " + std::string(column - begin, ' ') + "^";
    }
    return s;
}

Error::Error(const FileLoc &loc, const std::string &message, std::string_view sourceLine)
    : std::runtime_error(Located(loc, message, sourceLine)) {}

std::string Reason(const Error &e) {
    const std::string_view text = e.what();
    constexpr std::string_view prefix = "error: ";
    return std::string(text.starts_with(prefix) ? text.substr(prefix.size()) : text);
}

void Warning(const FileLoc &loc, const std::string &kind, const std::string &message) {
    WarningLog &log = Log();
    const std::lock_guard lock(log.mutex);
    if (log.strict)
        throw Error(loc, message + " (a warning without --strict)");
    if (log.counts[kind]++ == 0) {
        const std::string where = loc.ToString();
        std::cerr << where << (where.empty() ? "" : ": ") << "warning: " << message << "\n";
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
            std::cerr << "warning: " << kind << ": " << count - 1 << " more of this kind\n";
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
