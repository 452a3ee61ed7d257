#include "parser/text_source.h"

#include "files/file.h"
#include "files/gzip.h"
#include "files/inputs.h"

#include <atomic>
#include <csignal>
#include <fcntl.h>
#include <mutex>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace cuticle {

namespace {

// The mapped texts of the process. A file that somebody cuts while it is mapped has no bytes behind its new
// end, and touching them is the signal SIGBUS. Signals know no owner but the process, so this is the one
// table that all scenes share: the handler finds the text that was touched, lays zeros over the rest of it
// and says so. A signal from elsewhere goes to whoever handled it before.
struct MappedText {
    std::atomic<char *> begin = nullptr; // null: this row is free
    std::atomic<size_t> size = 0;
    std::atomic<bool> wasCut = false;
};
MappedText mappedTexts[256];
struct sigaction busHandlerBefore;
size_t pageSize = 4096;

extern "C" void OnBusError(int, siginfo_t *info, void *) {
    char *const at = static_cast<char *>(info->si_addr);
    for (MappedText &text : mappedTexts) {
        char *const begin = text.begin, *const end = begin + text.size;
        if (!begin || at < begin || at >= end)
            continue;
        char *const page = at - reinterpret_cast<uintptr_t>(at) % pageSize;
        if (::mmap(page, static_cast<size_t>(end - page), PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED,
                   -1, 0) == MAP_FAILED)
            break;
        text.wasCut = true;
        return;
    }
    ::sigaction(SIGBUS, &busHandlerBefore, nullptr); // and the signal comes again
}

// A free row of the table, null where there is none.
MappedText *NewMappedText(char *begin, size_t size) {
    static std::once_flag once;
    std::call_once(once, [] {
        pageSize = static_cast<size_t>(::sysconf(_SC_PAGESIZE));
        struct sigaction action {};
        action.sa_sigaction = OnBusError;
        action.sa_flags = SA_SIGINFO | SA_RESTART;
        ::sigaction(SIGBUS, &action, &busHandlerBefore);
    });
    for (MappedText &text : mappedTexts) {
        char *none = nullptr;
        if (!text.begin.compare_exchange_strong(none, begin))
            continue;
        text.wasCut = false;
        text.size = size;
        return &text;
    }
    return nullptr;
}

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

// The file behind a mapped text, kept open to see whether it changes.
struct TextSource::Mapped {
    File file;
    struct stat status; // as it was when it was opened
    MappedText *row;
    ~Mapped() { row->begin = nullptr; }
};

TextSource::TextSource() = default;

bool TextSource::Map(int fd, size_t size) {
    // The lexer needs a zero behind the text. A file whose size is a whole number of pages has no byte there,
    // and one that somebody writes to may get others: so whole pages are laid over a longer stretch of zeroed
    // memory, and what the last page holds is read into it.
    void *const m = mmap(nullptr, size + 1, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (m == MAP_FAILED)
        return false;
    mapped_ = m;
    mappedSize_ = size + 1;
    const int own = ::fcntl(fd, F_DUPFD_CLOEXEC, 0);
    MappedText *const row = NewMappedText(static_cast<char *>(m), size);
    const size_t whole = size - size % pageSize;
    if (row && own >= 0)
        file_.reset(new Mapped{File(own), {}, row});
    if (!file_ || ::fstat(fd, &file_->status) != 0 ||
        (whole > 0 && mmap(m, whole, PROT_READ, MAP_PRIVATE | MAP_FIXED, fd, 0) == MAP_FAILED) ||
        ::pread(fd, static_cast<char *>(m) + whole, size - whole, static_cast<off_t>(whole)) < 0) {
        Unmap();
        return false;
    }
    madvise(m, size, MADV_SEQUENTIAL);
    begin_ = static_cast<const char *>(m);
    end_ = begin_ + size;
    return true;
}

void TextSource::Unmap() {
    if (mapped_)
        munmap(mapped_, mappedSize_);
    mapped_ = nullptr;
    file_.reset();
}

void TextSource::CheckUnchanged() const {
    struct stat now {};
    if (!file_ ||
        (!file_->row->wasCut && ::fstat(file_->file.fd, &now) == 0 && now.st_size == file_->status.st_size &&
         now.st_mtim.tv_sec == file_->status.st_mtim.tv_sec &&
         now.st_mtim.tv_nsec == file_->status.st_mtim.tv_nsec))
        return;
    throw Error(FileLoc{name_}, "\"{}\" was changed{} while it was read", *name_,
                file_->row->wasCut || now.st_size < file_->status.st_size ? ", and is shorter now," : "")
        .WithRemedy("read it again when it is whole");
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
    const PlaceScope here(from.file ? from : FileLoc{std::make_shared<const std::string>(filename), 0, 0});
    const File file(
        open(AllowedPath(filename).c_str(), O_RDONLY | O_CLOEXEC | (isIncluded ? O_NONBLOCK : 0)));
    struct stat status {};
    if (file.fd < 0 || fstat(file.fd, &status) != 0)
        throw Error(from, "cannot open \"{}\": {}", filename, std::strerror(errno))
            .WithPbrtInstead("it is left out")
            .WithSourceLine(fromLine);
    if (S_ISDIR(status.st_mode))
        fail("is a folder, not a scene file");
    if (isIncluded && !S_ISREG(status.st_mode))
        fail("is a device or a pipe, not a scene file");

    std::unique_ptr<TextSource> s(new TextSource);
    s->name_ = std::make_shared<const std::string>(filename);
    const bool isPlain = S_ISREG(status.st_mode);
    if (!isPlain || status.st_size == 0 || !s->Map(file.fd, static_cast<size_t>(status.st_size)))
        s->ReadToEnd(file.fd, fail);
    NoteInput(filename, file.fd, isPlain ? "" : std::string_view(s->unpacked_));

    const std::string_view raw(s->begin_, static_cast<size_t>(s->end_ - s->begin_));
    if (raw.size() >= 18 && IsGzip(raw)) {
        std::string text;
        try {
            text = Unpack(raw, fail);
        } catch (const Error &) {
            s->CheckUnchanged(); // a better reason
            throw;
        }
        s->CheckUnchanged();
        s->Unmap();
        s->unpacked_ = std::move(text);
        s->begin_ = s->unpacked_.c_str();
        s->end_ = s->begin_ + s->unpacked_.size();
    }
    return s;
}

TextSource::~TextSource() { Unmap(); }

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
