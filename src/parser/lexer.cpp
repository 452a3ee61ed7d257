#include "parser/lexer.h"

#include "files/file.h"
#include "files/gzip.h"

#include <fast_float/fast_float.h>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cfloat>
#include <cmath>
#include <cstring>

namespace cuticle {

namespace {

constexpr size_t kMaxStringLength = 1 << 16;
constexpr size_t kMaxWordLength = 1 << 10;
// Unpacked gzip text beyond this is refused where it is also more than kMaxRatio times its packed size: numbers
// as text pack 2 to 20 times, only text made to do harm packs better.
constexpr size_t kGzipGrace = size_t(256) << 20;
constexpr size_t kGzipMaxRatio = 200;

std::string Unpack(std::string_view packed, const auto &fail) {
    // The last four bytes hold the size modulo 2^32: a guess, not a promise.
    std::string out;
    const auto *tail = reinterpret_cast<const unsigned char *>(packed.data()) + packed.size() - 4;
    const size_t guess = static_cast<size_t>(tail[0]) | static_cast<size_t>(tail[1]) << 8 |
                         static_cast<size_t>(tail[2]) << 16 | static_cast<size_t>(tail[3]) << 24;
    size_t capacity = std::clamp(std::min(guess, 20 * packed.size()) + 64, size_t(1) << 16, size_t(1) << 32);

    GzipReader reader(packed);
    size_t size = 0;
    while (true) {
        if (size == capacity)
            capacity += capacity / 2;
        if (out.size() < capacity)
            out.resize(capacity);
        constexpr size_t kStep = size_t(1) << 24; // small enough that a bomb of NUL bytes is seen early
        size_t got = 0;
        try {
            got = reader.Read(out.data() + size, std::min(kStep, capacity - size));
        } catch (const Error &e) {
            fail(e.Message());
        }
        if (got == 0)
            break;
        if (std::memchr(out.data() + size, 0, got))
            fail("unpacks to binary data, not to scene text");
        size += got;
        if (size > kGzipGrace && size / kGzipMaxRatio > packed.size())
            fail(fmt::format("unpacks to more than {} times its size, which no scene text does",
                             kGzipMaxRatio));
    }
    out.resize(size);
    return out;
}

} // namespace

std::unique_ptr<TextSource> TextSource::FromText(const std::string &text, const std::string &name) {
    std::unique_ptr<TextSource> s(new TextSource);
    s->name_ = std::make_shared<const std::string>(name);
    s->begin_ = text.c_str();
    s->end_ = s->begin_ + text.size();
    return s;
}

std::unique_ptr<TextSource> TextSource::FromFile(const std::string &filename, const FileLoc &from,
                                                 std::string_view fromLine) {
    const auto fail = [&](const std::string &what) {
        throw Error(from, "\"{}\" {}", filename, what).WithSourceLine(fromLine);
    };
    // Standard input or a pipe may hold a scene; an Include that opens one would wait, perhaps for ever.
    const bool isIncluded = from.line > 0;
    const File file(open(filename.c_str(), O_RDONLY | O_CLOEXEC | (isIncluded ? O_NONBLOCK : 0)));
    struct stat status {};
    if (file.fd < 0 || fstat(file.fd, &status) != 0)
        throw Error(from, "cannot open \"{}\": {}", filename, std::strerror(errno)).WithSourceLine(fromLine);
    if (S_ISDIR(status.st_mode))
        fail("is a folder, not a scene file");
    if (isIncluded && !S_ISREG(status.st_mode))
        fail("is a device or a pipe, not a scene file");

    std::unique_ptr<TextSource> s(new TextSource);
    s->name_ = std::make_shared<const std::string>(filename);
    if (S_ISREG(status.st_mode) && status.st_size > 0) {
        // A file whose size is a whole number of pages has no byte behind it: lay the file over a longer stretch
        // of anonymous, zeroed memory.
        const size_t size = static_cast<size_t>(status.st_size);
        s->mappedSize_ = size + 1;
        void *m = mmap(nullptr, s->mappedSize_, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (m == MAP_FAILED)
            fail(std::string("does not fit into memory: ") + std::strerror(errno));
        s->mapped_ = m;
        if (mmap(m, size, PROT_READ, MAP_PRIVATE | MAP_FIXED, file.fd, 0) == MAP_FAILED)
            fail(std::string("cannot be read: ") + std::strerror(errno));
        madvise(m, size, MADV_SEQUENTIAL);
        s->begin_ = static_cast<const char *>(m);
        s->end_ = s->begin_ + size;
    } else { // a pipe or a device: size unknown
        std::array<char, 1 << 16> chunk{};
        ssize_t n = 0;
        while ((n = read(file.fd, chunk.data(), chunk.size())) > 0) {
            s->unpacked_.append(chunk.data(), static_cast<size_t>(n));
            if (s->unpacked_[0] != '\x1f' && std::memchr(chunk.data(), 0, static_cast<size_t>(n)))
                fail("holds binary data, not scene text"); // and may be endless
        }
        if (n < 0)
            fail(std::string("cannot be read: ") + std::strerror(errno));
        s->begin_ = s->unpacked_.c_str();
        s->end_ = s->begin_ + s->unpacked_.size();
    }

    const std::string_view raw(s->begin_, static_cast<size_t>(s->end_ - s->begin_));
    if (raw.size() >= 18 && IsGzip(raw)) {
        std::string text = Unpack(raw, fail);
        if (s->mapped_) {
            munmap(s->mapped_, s->mappedSize_);
            s->mapped_ = nullptr;
        }
        s->unpacked_ = std::move(text);
        s->begin_ = s->unpacked_.c_str();
        s->end_ = s->begin_ + s->unpacked_.size();
    }
    return s;
}

TextSource::~TextSource() {
    if (mapped_)
        munmap(mapped_, mappedSize_);
}

void TextSource::Release(const char *upTo) {
    if (!mapped_)
        return;
    const size_t page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    const size_t to = static_cast<size_t>(upTo - begin_) / page * page;
    if (to > released_) {
        madvise(static_cast<char *>(mapped_) + released_, to - released_, MADV_DONTNEED);
        released_ = to;
    }
}

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

    // Clinger's fast path: a mantissa below 2^53 and a power of ten up to 10^22 are exact doubles, so that one
    // multiplication or division rounds correctly.
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
    if (at < knownAt_) {
        // Step back over the lines between, which are few as a rule.
        knownLine_ -= static_cast<uint32_t>(std::count(at, knownAt_, '\n'));
        knownAt_ = at;
        knownLineStart_ = at;
        while (knownLineStart_ > source_->Begin() && knownLineStart_[-1] != '\n')
            --knownLineStart_;
    }
    while (const void *newline = std::memchr(knownAt_, '\n', static_cast<size_t>(at - knownAt_))) {
        knownAt_ = knownLineStart_ = static_cast<const char *>(newline) + 1;
        ++knownLine_;
    }
    knownAt_ = at;
    return {source_->Name(), knownLine_, static_cast<uint32_t>(at - knownLineStart_) + 1};
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

static bool EndsToken(char c) { return IsBlank(c) || c == '"' || c == '[' || c == ']' || c == '#' || c == 0; }

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
    if (c == '"') {
        const char *q = p + 1, *const limit =
                                   end_ - q > std::ptrdiff_t(kMaxStringLength) ? q + kMaxStringLength : end_;
        while (q < limit && *q != '"' && *q != '\n' && *q != 0)
            q += *q == '\\' && q + 1 < limit && q[1] != '\n' ? 2 : 1;
        if (q >= limit || *q != '"') {
            cursor_ = std::min(q, limit);
            if (limit != end_ && q >= limit)
                Fail(p, "this string has no closing quote within " + std::to_string(kMaxStringLength) +
                            " bytes");
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

    // Words and numbers reach to the next delimiter.
    const char *q = p;
    const char *const limit = end_ - p > std::ptrdiff_t(kMaxWordLength) ? p + kMaxWordLength : end_;
    while (q < limit && !EndsToken(*q))
        ++q;
    cursor_ = std::max(q, p + 1);
    if (q == limit && limit != end_) {
        while (cursor_ < end_ && !EndsToken(*cursor_))
            ++cursor_;
        Fail(p, "a word of more than " + std::to_string(kMaxWordLength) +
                    " bytes: this does not look like a scene file");
    }
    t.text = {p, static_cast<size_t>(q - p)};
    if (static_cast<unsigned char>(c - '0') < 10 || c == '-' || c == '+' || c == '.') {
        const char *after = ScanNumber(p, q, &t.number);
        if (after != q)
            Fail(p, "\"" + std::string(t.text.substr(0, 40)) + "\" is not a number");
        // Everything becomes a binary32 in the end.
        if (!(std::abs(t.number) <= FLT_MAX))
            Fail(p, "the number " + std::string(t.text.substr(0, 40)) + " is out of range (largest 3.4e38)");
        t.kind = Token::Kind::Number;
        return t;
    }
    const unsigned char u = static_cast<unsigned char>(c);
    if (u < 32 || u >= 127) {
        while (cursor_ < end_ && !EndsToken(*cursor_))
            ++cursor_;
        constexpr char hex[] = "0123456789abcdef";
        Fail(p, std::string("byte 0x") + hex[u >> 4] + hex[u & 15] +
                    " outside quotes: this does not look like a scene file");
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

std::string SourceLine(const FileLoc &loc) {
    if (!loc.file || loc.line == 0)
        return {};
    struct stat status {};
    if (stat(loc.file->c_str(), &status) != 0 || !S_ISREG(status.st_mode))
        return {};
    try {
        const auto source = TextSource::FromFile(*loc.file, {});
        const char *p = source->Begin();
        for (uint32_t line = 1; line < loc.line && p; ++line) {
            const void *newline = std::memchr(p, '\n', static_cast<size_t>(source->End() - p));
            p = newline ? static_cast<const char *>(newline) + 1 : nullptr;
        }
        if (!p)
            return {};
        const char *last = p;
        const char *const limit =
            source->End() - p > std::ptrdiff_t(loc.column) + 200 ? p + loc.column + 200 : source->End();
        while (last < limit && *last != '\n' && *last != '\r')
            ++last;
        return {p, last};
    } catch (const Error &) {
        return {}; // the message stands without its line
    }
}

} // namespace cuticle
