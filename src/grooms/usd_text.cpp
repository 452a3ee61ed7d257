#include "grooms/usd_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace cuticle {

namespace {

bool IsWordCharacter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == ':' || c == '.' || static_cast<unsigned char>(c) >= 128;
}

} // namespace

FileLoc UsdText::Loc(size_t byte) const {
    const std::string_view before = text_.substr(0, std::min(byte, text_.size()));
    const size_t lineStart = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    return {std::make_shared<const std::string>(name_),
            static_cast<uint32_t>(1 + std::count(before.begin(), before.end(), '\n')),
            static_cast<uint32_t>(1 + before.size() - lineStart)};
}

// The line itself is not quoted: it may hold a million numbers.
void UsdText::Fail(size_t byte, const std::string &what) const { throw Error(Loc(byte), what); }

char UsdText::Peek() {
    while (at_ < text_.size()) {
        const char c = text_[at_];
        if (c == '#')
            at_ = std::min(text_.find('\n', at_), text_.size());
        else if (c == ' ' || c == '\t' || c == '\n' || c == '\r')
            ++at_;
        else
            return c;
    }
    return '\0';
}

bool UsdText::Take(char c) {
    if (Peek() != c || at_ >= text_.size())
        return false;
    ++at_;
    return true;
}

void UsdText::Expect(char c, const char *where) {
    const char next = Peek();
    if (!Take(c))
        Fail(at_, std::string("'") + c + "' was expected " + where +
                      (at_ >= text_.size() ? ", and the file ends" : std::string(", not '") + next + "'"));
}

std::string_view UsdText::Word() {
    Peek();
    const size_t start = at_;
    while (at_ < text_.size() && IsWordCharacter(text_[at_]))
        ++at_;
    if (text_.substr(at_, 2) == "[]") // an array's type
        at_ += 2;
    return text_.substr(start, at_ - start);
}

std::string_view UsdText::String() {
    const char quote = Peek();
    if (quote != '"' && quote != '\'')
        Fail(at_, at_ >= text_.size() ? "the file ends where a string in quotes was expected"
                                      : "a string in quotes was expected");
    const size_t start = at_;
    const std::string three(3, quote);
    const bool isLong = text_.substr(at_, 3) == three;
    at_ += isLong ? 3 : 1;
    const size_t first = at_;
    for (; at_ < text_.size(); ++at_) {
        if (text_[at_] == '\\')
            ++at_;
        else if (isLong ? text_.substr(at_, 3) == three : text_[at_] == quote) {
            const std::string_view inside = text_.substr(first, at_ - first);
            at_ += isLong ? 3 : 1;
            return inside;
        } else if (text_[at_] == '\n' && !isLong) {
            break;
        }
    }
    at_ = text_.size();
    Fail(start, "this string has no end");
}

void UsdText::SkipValue() {
    // Open brackets are counted on a list, not by recursion, which a hostile file could make as deep as it is
    // long
    std::vector<size_t> open;
    do {
        const char c = Peek();
        const size_t start = at_;
        if (at_ >= text_.size())
            Fail(open.empty() ? at_ : open.back(),
                 open.empty() ? "the file ends where a value was expected" : "this bracket is never closed");
        if (c == '(' || c == '[' || c == '{') {
            open.push_back(at_++);
        } else if (c == ')' || c == ']' || c == '}') {
            if (open.empty())
                Fail(at_, "a value was expected");
            const char opened = text_[open.back()];
            if ((opened == '(') != (c == ')') || (opened == '[') != (c == ']'))
                Fail(at_, std::string("'") + c + "' does not close the '" + opened + "' before it");
            open.pop_back();
            ++at_;
        } else if (c == '"' || c == '\'') {
            String();
        } else if (c == '@' || c == '<') {
            const std::string_view end = c == '<' ? ">" : text_.substr(at_, 3) == "@@@" ? "@@@" : "@";
            const size_t found = text_.find(end, at_ + end.size());
            if (found == std::string_view::npos)
                Fail(start, "this path has no end");
            at_ = found + end.size();
            if (c == '@' && open.empty() && Peek() == '<') // a prim within the asset
                SkipValue();
        } else if (IsWordCharacter(c) || c == '-' || c == '+') {
            ++at_;
            while (at_ < text_.size() &&
                   (IsWordCharacter(text_[at_]) || text_[at_] == '-' || text_[at_] == '+'))
                ++at_;
        } else if (!open.empty() && (c == ',' || c == ';' || c == '=' || c == '[')) {
            ++at_;
        } else {
            Fail(at_, std::string("a value was expected, not '") + c + "'");
        }
    } while (!open.empty());
}

double UsdText::Number() {
    Peek();
    const size_t start = at_;
    if (at_ < text_.size() && text_[at_] == '+')
        ++at_;
    double v = 0;
    const char *end = text_.data() + text_.size();
    const auto [stop, status] = std::from_chars(text_.data() + at_, end, v);
    if (status == std::errc::invalid_argument)
        Fail(start,
             start >= text_.size() ? "the file ends where a number was expected" : "a number was expected");
    at_ = static_cast<size_t>(stop - text_.data());
    if (status == std::errc::result_out_of_range) // too small, or too large?
        v = std::string_view(text_.data() + start, at_ - start).find("e-") != std::string_view::npos ||
                    std::string_view(text_.data() + start, at_ - start).find("E-") != std::string_view::npos
                ? 0
                : HUGE_VAL;
    if (!(std::abs(v) <= 3e38))
        Fail(start, "a finite number within +-3e38 was expected, not " +
                        std::string(text_.substr(start, at_ - start)));
    return v;
}

template <typename T>
std::vector<T> UsdText::Flat() {
    std::vector<T> values;
    std::vector<size_t> open;
    do {
        const char c = Peek();
        if (c == '(' || c == '[') {
            open.push_back(at_++);
            if (open.size() > 4)
                Fail(at_ - 1, "numbers lie in at most four brackets");
            continue;
        }
        if (!open.empty() && (c == ')' || c == ']')) {
            if ((text_[open.back()] == '(') != (c == ')'))
                Fail(at_,
                     std::string("'") + c + "' does not close the '" + text_[open.back()] + "' before it");
            open.pop_back();
            ++at_;
        } else {
            if (!open.empty() && at_ >= text_.size())
                Fail(at_, "the file ends within an array of numbers");
            values.push_back(static_cast<T>(Number()));
        }
        if (!open.empty() && Peek() != ')' && Peek() != ']')
            Expect(',', "between the values of an array");
    } while (!open.empty());
    return values;
}

std::vector<double> UsdText::Numbers() { return Flat<double>(); }
std::vector<float> UsdText::Floats() { return Flat<float>(); }

std::vector<std::string> UsdText::Strings() {
    std::vector<std::string> all;
    const bool list = Take('[');
    while (!(list && Take(']'))) {
        const bool quoted = Peek() == '"' || Peek() == '\'';
        const size_t start = at_;
        all.emplace_back(quoted ? String() : Word());
        if (!quoted && all.back().empty())
            Fail(start, "a name in quotes was expected");
        if (!list)
            break;
        if (Peek() != ']')
            Expect(',', "between the names of a list");
    }
    return all;
}

std::string UsdText::OneString() {
    const size_t start = at_;
    const std::vector<std::string> all = Strings();
    if (all.empty())
        Fail(start, "a name in quotes was expected");
    return all.front();
}

} // namespace cuticle
