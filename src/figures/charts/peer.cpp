#include "figures/charts/peer.h"

#include "core/clock.h"
#include "core/error.h"
#include "parser/scene_description.h"
#include "render/film.h"
#include "render/plugins.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <spawn.h>
#include <string_view>
#include <sys/wait.h>

extern char **environ;

namespace cuticle {

namespace {

// Quotes a word for sh, so that it stands for itself.
std::string ShellWord(const std::string &text) {
    std::string word = "'";
    for (const char c : text)
        word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return word + "'";
}

// A temporary folder, removed with all that is in it.
class PeerFolder {
  public:
    PeerFolder() : path_((std::filesystem::temp_directory_path() / "cuticle-peer-XXXXXX").string()) {
        if (mkdtemp(path_.data()) == nullptr)
            throw Error("cannot make a temporary folder {}", path_);
    }
    ~PeerFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    PeerFolder(const PeerFolder &) = delete;
    PeerFolder &operator=(const PeerFolder &) = delete;
    const std::string &Path() const { return path_; }

  private:
    std::string path_;
};

// Runs a command and waits for it; "" if it exits with status 0, else what became of it.
std::string RunByShell(std::string command) {
    std::string shell = "sh", option = "-c";
    char *const words[] = {shell.data(), option.data(), command.data(), nullptr};
    pid_t child = 0;
    int status = 0;
    if (posix_spawnp(&child, "sh", nullptr, nullptr, words, environ) != 0 ||
        waitpid(child, &status, 0) != child)
        return "cannot be run";
    if (WIFSIGNALED(status))
        return fmt::format("was ended by signal {}", WTERMSIG(status));
    return WEXITSTATUS(status) == 0 ? "" : fmt::format("ended with status {}", WEXITSTATUS(status));
}

std::string PixelsOf(int width, int height) { return fmt::format("{} x {} pixels", width, height); }

} // namespace

Rendering RenderPeer(const Peer &peer, const std::string &file) {
    const PeerFolder folder;
    const std::string out = folder.Path() + "/picture.exr";
    std::string command = peer.command;
    for (const auto &[mark, text] :
         {std::pair("{scene}", std::filesystem::absolute(file).string()), std::pair("{out}", out)})
        for (size_t at = 0; (at = command.find(mark, at)) != std::string::npos;) {
            const std::string word = ShellWord(text);
            command.replace(at, std::string_view(mark).size(), word);
            at += word.size();
        }
    const auto refused = [&](const std::string &what) {
        return Error("the peer {} {}; its command: {}", peer.name, what, command);
    };
    const double start = ProcessCpuSeconds();
    if (const std::string failure = RunByShell(command); !failure.empty())
        throw refused(failure);
    const double cpuSeconds = ProcessCpuSeconds() - start;
    if (!std::filesystem::exists(out))
        throw refused("wrote no picture to {out}, an .exr file");
    Image image;
    try {
        image = ReadImage(out);
    } catch (const Error &e) {
        throw refused("wrote a picture that cannot be read (" + e.Message() + ")");
    }
    const Point2i asked = Film(ParseScene(AllPlugins(), file).film, {}).Resolution();
    if (image.width != asked.x || image.height != asked.y)
        throw refused(fmt::format("made a picture of {}, the scene asks for {}",
                                  PixelsOf(image.width, image.height), PixelsOf(asked.x, asked.y)));
    return {std::move(image), cpuSeconds};
}

} // namespace cuticle
