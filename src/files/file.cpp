#include "files/file.h"

#include "core/error.h"
#include "files/gzip.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>
#include <zlib.h>

namespace cuticle {

namespace {

[[noreturn]] void Fail(const std::string &filename, const std::string &why) {
    throw Error("\"{}\": {}", filename, why);
}

// As read(), over again where a signal came between. Negative: errno holds the reason.
ssize_t ReadSome(int fd, char *to, size_t size) {
    ssize_t n = 0;
    do
        n = ::read(fd, to, size);
    while (n < 0 && errno == EINTR);
    return n;
}

} // namespace

File::~File() {
    if (fd >= 0)
        ::close(fd);
}

int OpenPlainFile(const std::string &filename, const std::string &what) {
    const auto fail = [&](const std::string &why) {
        Fail(filename, fmt::format("cannot open {}: {}", what, why));
    };
    // Without O_NONBLOCK a pipe that nobody writes to is waited for
    const int fd = ::open(filename.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        fail(std::strerror(errno));
    struct stat status {};
    const bool known = ::fstat(fd, &status) == 0;
    if (!known || !S_ISREG(status.st_mode)) {
        const std::string why = !known                    ? std::strerror(errno)
                                : S_ISDIR(status.st_mode) ? std::strerror(EISDIR)
                                                          : "it is a device or a pipe, not a file";
        ::close(fd);
        fail(why);
    }
    return fd;
}

std::string ReadFile(const std::string &filename, const std::string &what) {
    const File file(OpenPlainFile(filename, what));
    std::string bytes;
    std::vector<char> buffer(size_t{1} << 20);
    for (;;) {
        const ssize_t n = ReadSome(file.fd, buffer.data(), buffer.size());
        if (n == 0)
            return bytes;
        if (n < 0)
            Fail(filename, fmt::format("cannot read {}: {}", what, std::strerror(errno)));
        bytes.append(buffer.data(), static_cast<size_t>(n));
    }
}

InputFile::InputFile(const std::string &filename, const std::string &what)
    : file_(OpenPlainFile(filename, what)), buffer_(size_t(1) << 18) {
    ahead_ = NextPiece();
    if (IsGzip(ahead_))
        gzip_ = std::make_unique<GzipReader>(
            [this] { return ahead_.empty() ? NextPiece() : std::exchange(ahead_, {}); });
}

InputFile::~InputFile() = default;

std::string_view InputFile::NextPiece() {
    const ssize_t n = ReadSome(file_.fd, buffer_.data(), buffer_.size());
    if (n < 0)
        throw Error("cannot read: {}", std::strerror(errno));
    return {buffer_.data(), static_cast<size_t>(n)};
}

size_t InputFile::Read(char *to, size_t size) {
    if (gzip_)
        return gzip_->Read(to, size);
    if (ahead_.empty())
        ahead_ = NextPiece();
    const size_t n = std::min(size, ahead_.size());
    std::memcpy(to, ahead_.data(), n);
    ahead_.remove_prefix(n);
    return n;
}

void OutputFile::Fail(const char *doing) const {
    cuticle::Fail(filename_, fmt::format("cannot {}: {}", doing, std::strerror(errno)));
}

OutputFile::OutputFile(const std::string &filename) : filename_(filename), target_(filename) {
    // Look at what stands there
    std::error_code error;
    if (std::filesystem::is_symlink(filename, error)) {
        const auto resolved = std::filesystem::weakly_canonical(filename, error);
        if (!error)
            target_ = resolved.string();
    }
    struct stat status {};
    const bool exists = ::stat(target_.c_str(), &status) == 0;
    if (exists && S_ISDIR(status.st_mode)) {
        errno = EISDIR;
        Fail("write");
    }
    if (exists && !S_ISREG(status.st_mode)) {
        fd_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
        if (fd_ < 0)
            Fail("write");
    } else {
        temporary_ = target_ + ".XXXXXX";
        fd_ = ::mkostemp(temporary_.data(), O_CLOEXEC);
        if (fd_ < 0) {
            temporary_.clear();
            Fail("create a file beside it");
        }
        // mkostemp makes files private to the user; this one gets its predecessor's permissions or the usual
        // ones. A failure here costs nothing that matters.
        const mode_t mask = ::umask(0);
        ::umask(mask);
        static_cast<void>(
            !::fchmod(fd_, exists ? status.st_mode & 07777 : static_cast<mode_t>(0666) & ~mask));
    }
    if (filename.ends_with(".gz")) {
        // Level 3: within a few percent of the default's size on numbers as text, and three times as fast.
        gz_ = gzdopen(fd_, "wb3");
        if (gz_ == nullptr) {
            ::close(fd_);
            ::unlink(temporary_.c_str());
            errno = ENOMEM;
            Fail("start compression");
        }
        gzbuffer(static_cast<gzFile>(gz_), 1u << 18);
    }
}

OutputFile::~OutputFile() {
    if (gz_ != nullptr)
        gzclose(static_cast<gzFile>(gz_));
    else if (fd_ >= 0)
        ::close(fd_);
    if (!temporary_.empty())
        ::unlink(temporary_.c_str());
}

void OutputFile::Write(std::string_view bytes) {
    bytes_ += bytes.size();
    while (!bytes.empty()) {
        const size_t chunk = std::min<size_t>(bytes.size(), 1u << 30);
        if (gz_ != nullptr) {
            if (gzwrite(static_cast<gzFile>(gz_), bytes.data(), static_cast<unsigned>(chunk)) !=
                static_cast<int>(chunk))
                Fail("write");
            bytes.remove_prefix(chunk);
            continue;
        }
        const ssize_t n = ::write(fd_, bytes.data(), chunk);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            Fail("write");
        bytes.remove_prefix(static_cast<size_t>(n));
    }
}

void OutputFile::Commit() {
    const bool closed = gz_ != nullptr ? gzclose(static_cast<gzFile>(gz_)) == Z_OK : ::close(fd_) == 0;
    gz_ = nullptr;
    fd_ = -1;
    if (!closed)
        Fail("finish writing");
    if (!temporary_.empty() && ::rename(temporary_.c_str(), target_.c_str()) != 0)
        Fail("put the finished file in place");
    temporary_.clear();
}

void WriteFileAtomically(const std::string &filename, const std::string &bytes) {
    OutputFile file(filename);
    file.Write(bytes);
    file.Commit();
}

void MakeFolder(const std::string &folder) {
    std::error_code failure;
    std::filesystem::create_directories(folder, failure);
    if (failure || !std::filesystem::is_directory(folder))
        throw Error("cannot make the folder \"{}\"{}", folder, failure ? ": " + failure.message() : "");
}

} // namespace cuticle
