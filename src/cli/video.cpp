#include "cli/video.h"

#include "cli/commands.h"
#include "cli/stops.h"
#include "core/error.h"
#include "files/file.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <string_view>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

extern char **environ;

namespace cuticle {

namespace {

constexpr const char *kProgram = "ffmpeg";

int NewMemoryFile(const char *name) {
    const int fd = memfd_create(name, MFD_CLOEXEC);
    if (fd < 0)
        throw Error("{} cannot be started: {}", kProgram, std::strerror(errno));
    return fd;
}

std::string ReadFromStart(int fd) {
    std::string bytes;
    std::array<char, 65536> buffer{};
    for (off_t at = 0;;) {
        const ssize_t n = pread(fd, buffer.data(), buffer.size(), at);
        if (n <= 0)
            return bytes;
        bytes.append(buffer.data(), static_cast<size_t>(n));
        at += n;
    }
}

} // namespace

// The running program: frames go down a pipe, and the video and what is said come back in memory.
struct VideoEncoder::Child {
    File video{NewMemoryFile("video")}, said{NewMemoryFile("messages")};
    int pipe = -1; // its end that is written to
    pid_t pid = -1;

    ~Child() {
        ClosePipe();
        if (pid > 0) {
            kill(pid, SIGKILL);
            waitpid(pid, nullptr, 0);
        }
    }
    void ClosePipe() {
        if (pipe >= 0)
            close(std::exchange(pipe, -1));
    }
    // Returns the program's status; a stop (Ctrl-C) that comes meanwhile ends the command.
    int Wait() {
        int status = 0;
        for (pid_t ended = 0; ended != pid; usleep(10000)) {
            ended = waitpid(pid, &status, WNOHANG);
            if (ended == 0)
                CheckStop();
            else if (ended < 0 && errno != EINTR)
                break;
        }
        pid = -1;
        return status;
    }
    static void CheckStop() {
        if (StopAsked())
            throw ExitStatus{StopStatus()};
    }
    void Start(const std::vector<std::string> &words);
    [[noreturn]] void Fail() {
        ClosePipe();
        Wait();
        std::string why = ReadFromStart(said.fd);
        while (!why.empty() && (why.back() == '\n' || why.back() == ' '))
            why.pop_back();
        throw Error("{} failed: {}", kProgram, why.empty() ? "it ended without a word" : why);
    }
};

void VideoEncoder::Child::Start(const std::vector<std::string> &words) {
    std::vector<char *> argv;
    for (const std::string &word : words)
        argv.push_back(const_cast<char *>(word.c_str()));
    argv.push_back(nullptr);
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0)
        throw Error("{} cannot be started: {}", kProgram, std::strerror(errno));
    const File reading(ends[0]);
    pipe = ends[1];
    fcntl(pipe, F_SETFL, O_NONBLOCK);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, reading.fd, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, video.fd, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, said.fd, STDERR_FILENO);
    // In a process group of its own: a Ctrl-C reaches this program, which ends it
    posix_spawnattr_t how;
    posix_spawnattr_init(&how);
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    posix_spawnattr_setsigdefault(&how, &usual);
    posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    const int error = posix_spawnp(&pid, kProgram, &files, &how, argv.data(), environ);
    posix_spawnattr_destroy(&how);
    posix_spawn_file_actions_destroy(&files);
    if (error != 0) {
        pid = -1;
        throw Error("the program {}, which makes videos, cannot be started: {}", kProgram,
                    std::strerror(error))
            .WithRemedy(
                "install it (on Debian and Ubuntu: apt install ffmpeg), or convert picture by picture");
    }
}

// /dev/stdout is a file in memory: MP4 wants to go back and complete its beginning.
VideoEncoder::VideoEncoder(int width, int height, double framesPerSecond, int quality)
    : child_(std::make_unique<Child>()) {
    child_->Start({kProgram, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                   fmt::format("{}x{}", width, height), "-framerate", fmt::format("{}", framesPerSecond),
                   "-i", "-", "-an", "-c:v", "libx264", "-preset", "slow", "-crf", fmt::format("{}", quality),
                   // Colours at half the resolution want even sizes
                   "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart",
                   "-f", "mp4", "/dev/stdout"});
}
VideoEncoder::~VideoEncoder() = default;

void VideoEncoder::Add(const Image &image) {
    const std::string bytes = EncodeSRGB8(image);
    for (std::string_view rest = bytes; !rest.empty();) {
        pollfd room{child_->pipe, POLLOUT, 0};
        poll(&room, 1, 100);
        Child::CheckStop();
        const ssize_t n = write(child_->pipe, rest.data(), rest.size());
        if (n >= 0)
            rest.remove_prefix(static_cast<size_t>(n));
        else if (errno != EINTR && errno != EAGAIN)
            child_->Fail();
    }
}

std::string VideoEncoder::Finish() {
    child_->ClosePipe();
    const int status = child_->Wait();
    std::string video = ReadFromStart(child_->video.fd);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || video.empty()) {
        std::string why = ReadFromStart(child_->said.fd);
        throw Error("{} failed: {}", kProgram, why.empty() ? "it made no video" : why);
    }
    return video;
}

} // namespace cuticle
