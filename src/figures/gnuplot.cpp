#include "figures/gnuplot.h"

#include "core/error.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

namespace cuticle {

namespace {

struct CloseFile {
    void operator()(std::FILE *f) const { std::fclose(f); }
};
using TemporaryFile = std::unique_ptr<std::FILE, CloseFile>;

TemporaryFile MakeTemporaryFile() {
    TemporaryFile file(std::tmpfile());
    if (!file)
        throw Error("cannot make a temporary file for a plot: {}", std::strerror(errno));
    return file;
}

std::string Contents(std::FILE *file) {
    std::string text;
    std::rewind(file);
    std::array<char, 65536> buffer;
    for (size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), file)) > 0;)
        text.append(buffer.data(), n);
    return text;
}

} // namespace

std::string RunGnuplot(const std::string &text) {
    const TemporaryFile in = MakeTemporaryFile(), out = MakeTemporaryFile(), complaints = MakeTemporaryFile();
    if (std::fwrite(text.data(), 1, text.size(), in.get()) != text.size() || std::fflush(in.get()) != 0)
        throw Error("cannot hand a plot to gnuplot: {}", std::strerror(errno));
    std::rewind(in.get());

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, fileno(in.get()), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(out.get()), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(complaints.get()), STDERR_FILENO);
    std::string program = "gnuplot", noDefaults = "-d";
    const std::array<char *, 3> words = {program.data(), noDefaults.data(), nullptr};
    pid_t child = 0;
    const int failure = posix_spawnp(&child, "gnuplot", &actions, nullptr, words.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0)
        throw Error("cannot run gnuplot, which draws plots (Debian: apt-get install gnuplot-nox): {}",
                    std::strerror(failure));
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            throw Error("lost sight of gnuplot: {}", std::strerror(errno));
    std::string drawing = Contents(out.get());
    const std::string said = Contents(complaints.get());
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || drawing.empty())
        throw Error("gnuplot could not draw the plot: {}", said.empty() ? "it said nothing" : said);
    return drawing;
}

} // namespace cuticle
