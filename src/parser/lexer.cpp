#include "parser/lexer.h"

#include <fast_float/fast_float.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <functional>

namespace cuticle {

namespace {

constexpr size_t kMaxStringLength = 1 << 16;
constexpr size_t kMaxWordLength = 1 << 10;

bool EndsToken(char c) { return IsBlank(c) || c == '"' || c == '[' || c == ']' || c == '#' || c == 0; }

} // namespace

const char *ScanNumber(const char *p, const char *end, double *value) {
    const char *const start = p;
    const bool negative = *p == '-';
    p += *p == '-' || *p == '+';

    // Collect the decimal digits in an integer; 19 of them always fit.
    const char *const digits = p;
    uint64_t mantissa = 0;
    while (static_cast<unsigned char>(*p - '0') < 10)
        mantissa = 10 * mantissa + static_cast<uint64_t>(*p++ - '0');
    auto count = p - digits;
    int exponent = 0;
    if (*p == '.') {
        const char *const fraction = ++p;
        while (static_cast<unsigned char>(*p - '0') < 10)
            mantissa = 10 * mantissa + static_cast<uint64_t>(*p++ - '0');
        exponent = -static_cast<int>(std::min<std::ptrdiff_t>(p - fraction, 100000));
        count += p - fraction;
    }
    if (count == 0)
        return nullptr;
    if (*p == 'e' || *p == 'E') {
        const char *e = p + 1;
        const bool down = *e == '-';
        e += *e == '-' || *e == '+';
        if (static_cast<unsigned char>(*e - '0') < 10) {
            int written = 0;
            for (; static_cast<unsigned char>(*e - '0') < 10; ++e)
                written = std::min(10 * written + (*e - '0'), 100000);
            exponent += down ? -written : written;
            p = e;
        }
    }

    // Clinger's fast path: a mantissa below 2^53 and a power of ten up to 10^22 are exact doubles, so that
    // one multiplication or division rounds correctly.
    static constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                         1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                         1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    if (count <= 19 && mantissa <= (uint64_t(1) << 53) && exponent >= -22 && exponent <= 22) {
        const double m = static_cast<double>(mantissa);
        const double v = exponent < 0 ? m / kPowers[-exponent] : m * kPowers[exponent];
        *value = negative ? -v : v;
        return p;
    }
    // fast_float takes no plus sign.
    const auto result = fast_float::from_chars(start + (*start == '+'), std::min(p, end), *value);
    return result.ptr == p ? p : nullptr;
}

Lexer::Lexer(std::unique_ptr<TextSource> source)
    : source_(std::move(source)), cursor_(source_->Begin()), end_(source_->End()),
      releasedAt_(source_->Begin()), knownAt_(source_->Begin()), knownLineStart_(source_->Begin()) {
    if (end_ - cursor_ >= 3 && std::memcmp(cursor_, "\xef\xbb\xbf", 3) == 0)
        cursor_ += 3; // UTF-8's byte order mark
    else if (end_ - cursor_ >= 2 &&
             (std::memcmp(cursor_, "\xff\xfe", 2) == 0 || std::memcmp(cursor_, "\xfe\xff", 2) == 0))
        Fail(cursor_, "this is UTF-16 text; save the scene as UTF-8 or ASCII");
}

void Lexer::ReleaseNow() {
    // Count the lines first: later questions then start from here and do not touch what is given back.
    Loc(cursor_);
    source_->Release(knownLineStart_);
    releasedAt_ = cursor_;
}

FileLoc Lexer::Loc(const char *at) const {
    if (at < knownLineStart_) {
        // Step back over the lines between, which are few as a rule.
        knownLine_ -= static_cast<uint32_t>(std::count(at, knownLineStart_, '\n'));
        knownLineStart_ = at;
        while (knownLineStart_ > source_->Begin() && knownLineStart_[-1] != '\n')
            --knownLineStart_;
    } else if (at > knownAt_) {
        // Nothing between the start of the line and the last place ends a line.
        while (const void *newline = std::memchr(knownAt_, '\n', static_cast<size_t>(at - knownAt_))) {
            knownAt_ = knownLineStart_ = static_cast<const char *>(newline) + 1;
            ++knownLine_;
        }
    }
    knownAt_ = at;
    return {source_->Name(), knownLine_, static_cast<uint32_t>(at - knownLineStart_) + 1};
}

bool Lexer::Holds(const char *at) const {
    const std::less_equal<const char *> isBefore; // of pointers into different texts too
    return isBefore(source_->Begin(), at) && isBefore(at, end_);
}

std::string_view Lexer::Line(const char *at) const {
    Loc(at);
    constexpr std::ptrdiff_t kBehind = 200;
    const char *last = at, *const limit = std::min(end_, at + kBehind);
    while (last < limit && *last != '\n' && *last != '\r')
        ++last;
    return {knownLineStart_, static_cast<size_t>(last - knownLineStart_)};
}

void Lexer::Fail(const char *at, const std::string &message) const {
    throw Error(Loc(at), message).WithSourceLine(Line(at));
}

Token Lexer::Next() {
    if (peeked_) {
        peeked_ = false;
        return peekedToken_;
    }
    return Scan();
}

const Token &Lexer::Peek() {
    if (!peeked_) {
        peekedToken_ = Scan();
        peeked_ = true;
    }
    return peekedToken_;
}

Token Lexer::Scan() {
    const char *p = cursor_;
    while (true) {
        while (IsBlank(*p))
            ++p;
        if (*p != '#')
            break;
        while (p < end_ && *p != '\n' && *p != '\r')
            ++p;
    }
    Token t;
    t.begin = p;
    cursor_ = p;
    if (p == end_)
        return t;

    const char c = *p;
    if (c == '[' || c == ']') {
        t.kind = c == '[' ? Token::Kind::Open : Token::Kind::Close;
        t.text = {p, 1};
        cursor_ = p + 1;
        return t;
    }
    return c == '"' ? ScanString(p) : ScanWord(p);
}

Token Lexer::ScanString(const char *p) {
    Token t;
    t.begin = p;
    const char *q = p + 1, *const limit =
                               end_ - q > std::ptrdiff_t(kMaxStringLength) ? q + kMaxStringLength : end_;
    while (q < limit && *q != '"' && *q != '\n' && *q != 0)
        q += *q == '\\' && q + 1 < limit && q[1] != '\n' ? 2 : 1;
    if (q >= limit || *q != '"') {
        cursor_ = std::min(q, limit);
        if (limit != end_ && q >= limit)
            Fail(p, fmt::format("this string has no closing quote within {} bytes", kMaxStringLength));
        if (q < limit && *q == 0) {
            cursor_ = q + 1;
            Fail(q, "NUL byte inside a string: this is no text file");
        }
        Fail(p, "this string has no closing quote on its line");
    }
    t.kind = Token::Kind::String;
    t.text = {p + 1, static_cast<size_t>(q - p - 1)};
    cursor_ = q + 1;
    return t;
}

// A word or a number, which reaches to the next delimiter.
Token Lexer::ScanWord(const char *p) {
    Token t;
    t.begin = p;
    const char c = *p;
    const char *q = p;
    const char *const limit = end_ - p > std::ptrdiff_t(kMaxWordLength) ? p + kMaxWordLength : end_;
    while (q < limit && !EndsToken(*q))
        ++q;
    cursor_ = std::max(q, p + 1);
    if (q == limit && limit != end_) {
        while (cursor_ < end_ && !EndsToken(*cursor_))
            ++cursor_;
        Fail(p, fmt::format("a word of more than {} bytes: this does not look like a scene file",
                            kMaxWordLength));
    }
    t.text = {p, static_cast<size_t>(q - p)};
    if (static_cast<unsigned char>(c - '0') < 10 || c == '-' || c == '+' || c == '.') {
        const char *after = ScanNumber(p, q, &t.number);
        if (after != q)
            Fail(p, fmt::format("\"{}\" is not a number", t.text.substr(0, 40)));
        // Everything becomes a binary32 in the end.
        if (!(std::abs(t.number) <= FLT_MAX))
            Fail(p, fmt::format("the number {} is out of range (largest 3.4e38)", t.text.substr(0, 40)));
        t.kind = Token::Kind::Number;
        return t;
    }
    const unsigned char u = static_cast<unsigned char>(c);
    if (u < 32 || u >= 127) {
        while (cursor_ < end_ && !EndsToken(*cursor_))
            ++cursor_;
        Fail(p, fmt::format("byte 0x{:02x} outside quotes: this does not look like a scene file", u));
    }
    t.kind = Token::Kind::Word;
    return t;
}

std::string Lexer::Unescape(const Token &string) const {
    if (string.text.find('\\') == std::string_view::npos)
        return std::string(string.text);
    std::string s;
    for (size_t i = 0; i < string.text.size(); ++i) {
        char c = string.text[i];
        if (c == '\\' && i + 1 < string.text.size()) {
            static constexpr std::string_view kFrom = "bfnrt\\'\"", kTo = "\b\f\n\r\t\\'\"";
            const size_t k = kFrom.find(string.text[++i]);
            if (k == std::string_view::npos)
                Fail(string.text.data() + i - 1,
                     "unknown escape in a string; write / between folders, or \\\\ for a backslash");
            c = kTo[k];
        }
        s += c;
    }
    return s;
}

} // namespace cuticle
