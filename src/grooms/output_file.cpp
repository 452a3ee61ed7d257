#include "grooms/output_file.h"

#include "core/error.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

namespace cuticle {

void OutputFile::Fail(const char *doing) const {
    throw Error(FileLoc{std::make_shared<const std::string>(filename_)},
                std::string("cannot ") + doing + ": " + std::strerror(errno));
}

OutputFile::OutputFile(const std::string &filename) : filename_(filename), temporary_(filename + ".XXXXXX") {
    fd_ = mkstemp(temporary_.data());
    if (fd_ < 0)
        Fail("create a file beside it");
    // mkstemp makes files private to the user; a picture or a scene gets the usual permissions.
    const mode_t mask = umask(0);
    umask(mask);
    fchmod(fd_, static_cast<mode_t>(0666) & ~mask);
    if (filename.ends_with(".gz")) {
        // Level 3: within a few percent of the default's size on numbers as text, and three times as fast.
        gz_ = gzdopen(fd_, "wb3");
        if (gz_ == nullptr) {
            errno = ENOMEM;
            close(fd_);
            unlink(temporary_.c_str());
            Fail("start compression");
        }
        gzbuffer(static_cast<gzFile>(gz_), 1u << 18);
    }
}

OutputFile::~OutputFile() {
    if (gz_ != nullptr)
        gzclose(static_cast<gzFile>(gz_));
    else if (fd_ >= 0)
        close(fd_);
    if (!temporary_.empty())
        unlink(temporary_.c_str());
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
        const ssize_t n = write(fd_, bytes.data(), chunk);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            Fail("write");
        bytes.remove_prefix(static_cast<size_t>(n));
    }
}

void OutputFile::Commit() {
    int status = 0;
    if (gz_ != nullptr)
        status = gzclose(static_cast<gzFile>(gz_)) == Z_OK ? 0 : -1;
    else
        status = close(fd_);
    gz_ = nullptr;
    fd_ = -1;
    if (status != 0)
        Fail("finish writing");
    if (rename(temporary_.c_str(), filename_.c_str()) != 0)
        Fail("put the finished file in place");
    temporary_.clear();
}

} // namespace cuticle
