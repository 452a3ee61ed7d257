#include "files/file.h"

#include "core/error.h"
#include "core/threads.h"
#include "files/gzip.h"
#include "files/inputs.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
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

constexpr std::string_view kTemporaryMark = ".cuticle-";
constexpr size_t kTemporaryLetters = 6;

bool IsTemporaryName(std::string_view name) {
    const size_t ending = kTemporaryMark.size() + kTemporaryLetters;
    return name.size() >= ending && name.substr(name.size() - ending).starts_with(kTemporaryMark);
}

// Removes what killed runs left in a folder: temporary files whose lock nobody holds. Where locks are unknown
// nothing is removed.
void RemoveAbandoned(const std::string &folder) {
    const std::unique_ptr<DIR, int (*)(DIR *)> entries(::opendir(folder.c_str()), ::closedir);
    if (!entries)
        return;
    while (const dirent *entry = ::readdir(entries.get())) {
        if (!IsTemporaryName(entry->d_name))
            continue;
        const std::string path = folder + "/" + entry->d_name;
        const File file(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
        struct stat status {};
        if (file.fd >= 0 && ::fstat(file.fd, &status) == 0 && S_ISREG(status.st_mode) &&
            ::flock(file.fd, LOCK_EX | LOCK_NB) == 0)
            ::unlink(path.c_str());
    }
}

// The folder of a file, as a path that can be opened.
std::string FolderOf(const std::string &filename) {
    const size_t slash = filename.find_last_of('/');
    return slash == std::string::npos ? "." : slash == 0 ? "/" : filename.substr(0, slash);
}

// Follows a link step by step, so that one to a file that is not there yet leads somewhere too; a name that
// is no link stays. False and errno: it goes in a circle, or is unreadable.
bool FollowLinks(std::string *name) {
    for (int step = 0; step < 40; ++step) {
        struct stat status {};
        if (::lstat(name->c_str(), &status) != 0)
            return errno == ENOENT;
        if (!S_ISLNK(status.st_mode))
            return true;
        std::string link(4096, '\0');
        const ssize_t n = ::readlink(name->c_str(), link.data(), link.size());
        if (n < 0)
            return false;
        link.resize(static_cast<size_t>(n));
        *name = link.starts_with('/') ? link : FolderOf(*name) + "/" + link;
    }
    errno = ELOOP;
    return false;
}

} // namespace

std::string AllowedPath(const std::string &filename) {
    const std::string *const sandbox = SandboxScope::Folder();
    if (!sandbox)
        return filename;
    namespace fs = std::filesystem;
    std::error_code failure;
    const fs::path path = fs::weakly_canonical(fs::absolute(filename, failure), failure);
    const auto refuse = [&](const char *why) {
        throw Error("\"{}\" is not opened: {} the sandbox \"{}\"", filename, why, *sandbox).Finally();
    };
    if (failure || !(path.string() + "/").starts_with(*sandbox))
        refuse("it is outside of");
    // What is left of links leads nowhere now, and may lead anywhere once it is written to
    for (fs::path part = path; part.string().size() >= sandbox->size(); part = part.parent_path())
        if (fs::is_symlink(part, failure))
            refuse("a link on its way leads nowhere yet, and has no place in");
    return path.string();
}

File::~File() {
    if (fd >= 0)
        ::close(fd);
}

int OpenPlainFile(const std::string &filename, const std::string &what) {
    const auto fail = [&](const std::string &why) {
        Fail(filename, fmt::format("cannot open {}: {}", what, why));
    };
    // Without O_NONBLOCK a pipe that nobody writes to is waited for
    const int fd = ::open(AllowedPath(filename).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
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
    NoteInput(filename, fd);
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

OutputFile::OutputFile(const std::string &filename) : filename_(filename), target_(AllowedPath(filename)) {
    struct stat status {};
    const bool exists = ::stat(filename.c_str(), &status) == 0;
    if (!exists && errno != ENOENT)
        Fail("write");
    // A link of the system to an open pipe (/dev/stdout) does not lead to a name
    if ((!exists || S_ISREG(status.st_mode)) && !FollowLinks(&target_))
        Fail("write");
    if (exists && S_ISDIR(status.st_mode)) {
        errno = EISDIR;
        Fail("write");
    }
    if (const InputLog *const inputs = CurrentInputLog(); inputs && exists)
        if (const std::string input = inputs->NameOf(target_); !input.empty())
            cuticle::Fail(filename_, fmt::format("cannot overwrite what is read here{}",
                                                 input == filename_ ? "" : ", as \"" + input + "\""));
    isPlain_ = !exists || S_ISREG(status.st_mode);
    if (isPlain_)
        OpenTemporary(exists, status.st_mode);
    else
        OpenDevice();
    if (!filename.ends_with(".gz"))
        return;
    // Level 3: within a few percent of the default's size on numbers as text, and three times as fast. zlib
    // gets a descriptor of its own, so that closing it does not give up the lock.
    const int own = ::fcntl(fd_, F_DUPFD_CLOEXEC, 0);
    gz_ = own < 0 ? nullptr : gzdopen(own, "wb3");
    if (gz_ == nullptr) {
        ::close(own);
        ::close(fd_);
        ::unlink(temporary_.c_str());
        errno = ENOMEM;
        Fail("start compression");
    }
    gzbuffer(static_cast<gzFile>(gz_), 1u << 18);
}

// Opens the file that is to be renamed to target_. exists: there is one, of this mode.
void OutputFile::OpenTemporary(bool exists, unsigned mode) {
    if (exists) {
        // A rename would replace also what nobody may write to. Root may write anything, but somebody has
        // taken the trouble to forbid it.
        const File probe(::open(target_.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK));
        if (probe.fd < 0)
            Fail("write");
        if ((mode & 0222) == 0) {
            errno = EACCES;
            Fail("write");
        }
    }
    const std::string folder = FolderOf(target_);
    RemoveAbandoned(folder);
    // The name of the other file must not be too long where this one's is not
    constexpr size_t kMaxStem = 255 - kTemporaryMark.size() - kTemporaryLetters;
    const size_t name = target_.find_last_of('/') + 1; // 0 where there is no slash
    const std::string stem = target_.substr(0, name + std::min(target_.size() - name, kMaxStem));
    for (bool whole = false; !whole;) {
        temporary_ = stem + std::string(kTemporaryMark) + std::string(kTemporaryLetters, 'X');
        fd_ = ::mkostemp(temporary_.data(), O_CLOEXEC);
        if (fd_ < 0) {
            temporary_.clear();
            Fail("create a file beside it");
        }
        // Another run may have taken it for abandoned before it was locked
        struct stat status {};
        whole = ::flock(fd_, LOCK_EX) != 0 || ::fstat(fd_, &status) != 0 || status.st_nlink > 0;
        if (!whole)
            ::close(fd_);
    }
    // mkostemp makes files private to the user; this one gets its predecessor's permissions or the usual
    // ones. A failure here costs nothing that matters.
    const mode_t mask = ::umask(0);
    ::umask(mask);
    static_cast<void>(!::fchmod(fd_, exists ? mode & 07777 : static_cast<mode_t>(0666) & ~mask));
}

void OutputFile::OpenDevice() {
    // Without O_NONBLOCK a pipe that nobody reads is waited for
    fd_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd_ < 0 && errno == ENXIO)
        cuticle::Fail(filename_, "cannot write: it is a pipe that nobody reads");
    // A device that is full says so when nothing is written, too
    if (fd_ < 0 || ::write(fd_, "", 0) < 0) {
        const int reason = errno;
        ::close(fd_);
        fd_ = -1;
        errno = reason;
        Fail("write");
    }
    ::fcntl(fd_, F_SETFL, ::fcntl(fd_, F_GETFL) & ~O_NONBLOCK);
}

OutputFile::~OutputFile() {
    if (gz_ != nullptr)
        gzclose(static_cast<gzFile>(gz_));
    if (!temporary_.empty())
        ::unlink(temporary_.c_str());
    if (fd_ >= 0)
        ::close(fd_);
}

void OutputFile::Reserve(uint64_t bytes) {
    if (isPlain_ && ::fallocate(fd_, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)) != 0 &&
        (errno == ENOSPC || errno == EDQUOT))
        cuticle::Fail(filename_, fmt::format("there is no room for it: it may take {:.1f} MB ({})",
                                             static_cast<double>(bytes) / (1 << 20), std::strerror(errno)));
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

void OutputFile::Commit(bool onDisk) {
    if (void *const gz = std::exchange(gz_, nullptr); gz && gzclose(static_cast<gzFile>(gz)) != Z_OK)
        Fail("finish writing");
    if (!temporary_.empty()) {
        // Room that was set aside and not needed goes back
        if (const off_t end = ::lseek(fd_, 0, SEEK_END); end >= 0)
            static_cast<void>(!::ftruncate(fd_, end));
        if (onDisk && ::fsync(fd_) != 0)
            Fail("finish writing");
        if (::rename(temporary_.c_str(), target_.c_str()) != 0)
            Fail("put the finished file in place");
        temporary_.clear();
    }
    if (::close(std::exchange(fd_, -1)) != 0)
        Fail("finish writing");
}

void WriteFileAtomically(const std::string &filename, const std::string &bytes) {
    OutputFile file(filename);
    file.Write(bytes);
    file.Commit();
}

void MakeFolder(const std::string &folder) {
    std::error_code failure;
    std::filesystem::create_directories(AllowedPath(folder), failure);
    if (failure || !std::filesystem::is_directory(folder))
        throw Error("cannot make the folder \"{}\"{}", folder, failure ? ": " + failure.message() : "");
}

} // namespace cuticle
