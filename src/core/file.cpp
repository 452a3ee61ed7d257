#include "core/file.h"

#include "core/error.h"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace cuticle {

namespace {

[[noreturn]] void Fail(const std::string &filename, const std::string &why) {
    throw Error("\"" + filename + "\": " + why);
}

} // namespace

File::~File() {
    if (fd >= 0)
        ::close(fd);
}

int OpenPlainFile(const std::string &filename, const std::string &what) {
    const auto fail = [&](const std::string &why) { Fail(filename, "cannot open " + what + ": " + why); };
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
        const ssize_t n = ::read(file.fd, buffer.data(), buffer.size());
        if (n == 0)
            return bytes;
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            Fail(filename, "cannot read " + what + ": " + std::strerror(errno));
        bytes.append(buffer.data(), static_cast<size_t>(n));
    }
}

void WriteFileAtomically(const std::string &filename, const std::string &bytes) {
    const auto fail = [&](const char *what, int error) {
        Fail(filename, std::string(what) + ": " + std::strerror(error));
    };
    const auto writeAll = [&](int fd) {
        for (size_t at = 0; at < bytes.size();) {
            const ssize_t n = ::write(fd, bytes.data() + at, bytes.size() - at);
            if (n < 0 && errno == EINTR)
                continue;
            if (n < 0)
                return errno;
            at += static_cast<size_t>(n);
        }
        return 0;
    };

    // Look at what stands there: a link is followed, a device or pipe is written to and never replaced
    std::string target = filename;
    std::error_code ignored;
    if (std::filesystem::is_symlink(filename, ignored)) {
        const auto resolved = std::filesystem::weakly_canonical(filename, ignored);
        if (!ignored)
            target = resolved.string();
    }
    struct stat status {};
    const bool exists = ::stat(target.c_str(), &status) == 0;
    if (exists && S_ISDIR(status.st_mode))
        fail("cannot write", EISDIR);
    if (exists && !S_ISREG(status.st_mode)) {
        const File device(::open(target.c_str(), O_WRONLY | O_CLOEXEC));
        const int error = device.fd < 0 ? errno : writeAll(device.fd);
        if (error != 0)
            fail("cannot write", error);
        return;
    }

    // Write beside it under a name of our own, then rename; nothing of ours is left behind on failure
    static std::atomic<unsigned> counter{0};
    const std::string temporary =
        target + "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp";
    int error = 0;
    {
        File file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
        if (file.fd < 0)
            fail("cannot create a file in its folder", errno);
        if (exists) // keeps its permissions; a failure here costs nothing that matters
            static_cast<void>(!::fchmod(file.fd, status.st_mode & 07777));
        error = writeAll(file.fd);
        if (::close(file.fd) != 0 && error == 0)
            error = errno;
        file.fd = -1;
    }
    if (error == 0 && ::rename(temporary.c_str(), target.c_str()) != 0)
        error = errno;
    if (error != 0) {
        ::unlink(temporary.c_str());
        fail("cannot write", error);
    }
}

} // namespace cuticle
