#include "files/inputs.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/threads.h"
#include "files/file.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace cuticle {

namespace {

int64_t Nanoseconds(const timespec &t) { return int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec; }

// The name of a file as a scene of that folder means it: a scene that is moved with all that lies below it
// stays the same.
std::string NameSeenFrom(const std::string &folder, const std::string &filename) {
    std::error_code error;
    const std::filesystem::path from =
        std::filesystem::weakly_canonical(folder.empty() ? "." : folder, error);
    const std::filesystem::path file = std::filesystem::weakly_canonical(filename, error);
    const std::string relative = file.lexically_relative(from).string();
    return relative.empty() || relative.starts_with("..") ? file.string() : relative;
}

// The hash of a piece of an open file; its bytes may be fewer than asked for if somebody cuts it meanwhile.
std::string HashOfPiece(int fd, off_t begin, off_t size) {
    ContentHash hash;
    std::vector<char> buffer(size_t{1} << 18);
    for (off_t at = begin; at < begin + size;) {
        const auto wanted = std::min(static_cast<off_t>(buffer.size()), begin + size - at);
        const ssize_t n = ::pread(fd, buffer.data(), static_cast<size_t>(wanted), at);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            throw Error("cannot read it again: {}", std::strerror(errno));
        if (n == 0)
            break;
        hash.Add({buffer.data(), static_cast<size_t>(n)});
        at += n;
    }
    return hash.Hex();
}

// The hash of an open file, made of those of its pieces so that all threads can help.
std::string HashOfFile(int fd, off_t size) {
    constexpr off_t kPiece = off_t{1} << 24;
    const auto pieces = static_cast<size_t>((size + kPiece - 1) / kPiece);
    std::vector<std::string> hashes(pieces);
    ParallelFor(pieces,
                [&](size_t i) { hashes[i] = HashOfPiece(fd, static_cast<off_t>(i) * kPiece, kPiece); });
    ContentHash all;
    for (const std::string &hash : hashes)
        all.Add(hash);
    return all.Hex();
}

} // namespace

// Each step is one-to-one in the lane for a given word, and in the word for a given lane.
void ContentHash::Mix(const char *block) {
    for (size_t i = 0; i < 4; ++i) {
        uint64_t word = 0;
        std::memcpy(&word, block + 8 * i, 8);
        lanes_[i] = std::rotl((lanes_[i] ^ word) * 0x9e3779b97f4a7c15, 29) + 0x2545f4914f6cdd1d;
    }
}

void ContentHash::Add(std::string_view bytes) {
    const size_t held = size_ % kBlock;
    size_ += bytes.size();
    if (held > 0) {
        const size_t taken = std::min(kBlock - held, bytes.size());
        std::memcpy(rest_ + held, bytes.data(), taken);
        bytes.remove_prefix(taken);
        if (held + taken < kBlock)
            return;
        Mix(rest_);
    }
    for (; bytes.size() >= kBlock; bytes.remove_prefix(kBlock))
        Mix(bytes.data());
    if (!bytes.empty())
        std::memcpy(rest_, bytes.data(), bytes.size());
}

std::string ContentHash::Hex() const {
    ContentHash end = *this;
    std::fill(end.rest_ + size_ % kBlock, end.rest_ + kBlock, '\0');
    end.Mix(end.rest_);
    // Every lane reaches every bit of both halves
    uint64_t a = size_, b = ~size_;
    for (const uint64_t lane : end.lanes_) {
        a = (a ^ lane) * 0xd6e8feb86659fd93;
        a ^= a >> 32;
        b = std::rotl(b + lane, 23) * 0xa0761d6478bd642f;
        b ^= b >> 29;
    }
    return fmt::format("{:016x}{:016x}", a * 0xd6e8feb86659fd93, b * 0xa0761d6478bd642f);
}

void InputLog::Add(const std::string &filename, int fd, std::string_view text) {
    struct stat status {};
    if (::fstat(fd, &status) != 0)
        return;
    Seen seen{status.st_dev, status.st_ino, status.st_size, Nanoseconds(status.st_mtim), ""};
    if (!S_ISREG(status.st_mode)) {
        ContentHash hash;
        hash.Add(text);
        seen.hash = hash.Hex();
    }
    const std::lock_guard lock(mutex_);
    files_.try_emplace(filename, seen); // what was seen first has to hold to the end
}

std::string InputLog::NameOf(const std::string &path) const {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode))
        return "";
    const std::lock_guard lock(mutex_);
    for (const auto &[name, seen] : files_)
        if (seen.device == status.st_dev && seen.inode == status.st_ino)
            return name;
    return "";
}

std::string InputLog::Digest(const std::string &folder) const {
    std::map<std::string, Seen> files;
    {
        const std::lock_guard lock(mutex_);
        files = files_;
    }
    const InputScope unnoted(nullptr);
    std::vector<std::string> lines;
    for (const auto &[name, seen] : files) {
        std::string hash = seen.hash;
        if (hash.empty()) {
            const File file(OpenPlainFile(name, "a file of the scene again"));
            struct stat status {};
            hash = HashOfFile(file.fd, seen.size);
            if (::fstat(file.fd, &status) != 0 || status.st_size != seen.size ||
                Nanoseconds(status.st_mtim) != seen.changed)
                throw Error("\"{}\" was changed while the scene was read", name)
                    .WithRemedy("render again when it is whole");
        }
        // A pipe has another name in every run
        lines.push_back(fmt::format("{} {}\n", hash, seen.hash.empty() ? NameSeenFrom(folder, name) : ""));
    }
    std::sort(lines.begin(), lines.end());
    ContentHash all;
    for (const std::string &line : lines)
        all.Add(line);
    return all.Hex();
}

InputScope::InputScope(InputLog *log) : outer_(CurrentInputLog()) { CurrentInputLog() = log; }
InputScope::~InputScope() { CurrentInputLog() = outer_; }

void NoteInput(const std::string &filename, int fd, std::string_view text) {
    if (InputLog *const log = CurrentInputLog())
        log->Add(filename, fd, text);
}

} // namespace cuticle
