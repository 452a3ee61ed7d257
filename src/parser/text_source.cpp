#include "parser/text_source.h"

#include "files/file.h"
#include "files/gzip.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace cuticle {

namespace {

// Unpacks gzip data. fail: throws, given what is wrong with the file.
std::string Unpack(std::string_view packed, const std::function<void(const std::string &)> &fail) {
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

void TextSource::Map(int fd, size_t size, const Refusal &fail) {
    // A file whose size is a whole number of pages has no byte behind it: lay the file over a longer stretch
    // of anonymous, zeroed memory.
    mappedSize_ = size + 1;
    void *m = mmap(nullptr, mappedSize_, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (m == MAP_FAILED)
        fail(fmt::format("does not fit into memory: {}", std::strerror(errno)));
    mapped_ = m;
    if (mmap(m, size, PROT_READ, MAP_PRIVATE | MAP_FIXED, fd, 0) == MAP_FAILED)
        fail(fmt::format("cannot be read: {}", std::strerror(errno)));
    madvise(m, size, MADV_SEQUENTIAL);
    begin_ = static_cast<const char *>(m);
    end_ = begin_ + size;
}

void TextSource::ReadToEnd(int fd, const Refusal &fail) {
    std::array<char, 1 << 16> chunk{};
    ssize_t n = 0;
    while ((n = read(fd, chunk.data(), chunk.size())) > 0) {
        const auto got = static_cast<size_t>(n);
        unpacked_.append(chunk.data(), got);
        if (unpacked_[0] != '\x1f' && std::memchr(chunk.data(), 0, got))
            fail("holds binary data, not scene text"); // and may be endless
    }
    if (n < 0)
        fail(fmt::format("cannot be read: {}", std::strerror(errno)));
    begin_ = unpacked_.c_str();
    end_ = begin_ + unpacked_.size();
}

std::unique_ptr<TextSource> TextSource::FromFile(const std::string &filename, const FileLoc &from,
                                                 std::string_view fromLine) {
    const Refusal fail = [&](const std::string &what) {
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
    if (S_ISREG(status.st_mode) && status.st_size > 0)
        s->Map(file.fd, static_cast<size_t>(status.st_size), fail);
    else
        s->ReadToEnd(file.fd, fail);

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
