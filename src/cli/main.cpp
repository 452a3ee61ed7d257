// cuticle: one program, one command for each thing it does.
#include "cli/commands.h"
#include "core/check.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/printable.h"
#include "core/threads.h"
#include "files/inputs.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <poll.h>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

namespace cuticle {

void CheckFolderName(const std::string &folder, const std::string &files) {
    const std::filesystem::path path(folder);
    std::error_code error;
    if (path.has_filename() && path.extension().string().size() > 1 &&
        !std::filesystem::is_directory(path, error))
        throw Error(
            "\"{}\" has the name of a file, and none of this kind is written here: {} (for a folder of this "
            "name add a slash)",
            folder, files);
}

} // namespace cuticle

// A first word that is no command is answered with the nearest one.
static void RequireCommand(const CLI::App &app, int argc, char **argv) {
    const std::string_view word = argc > 1 ? argv[1] : "-";
    std::vector<std::string> names;
    for (const CLI::App *command : app.get_subcommands([](const CLI::App *) { return true; }))
        names.push_back(command->get_name());
    if (word.starts_with("-") || std::find(names.begin(), names.end(), word) != names.end())
        return;
    const std::vector<std::string_view> known(names.begin(), names.end());
    throw cuticle::Error("there is no command \"{}\"", word)
        .WithRemedy(cuticle::Suggestion(word, known.data(), known.size()));
}

// A reader that has seen enough (`cuticle render ... | head -1`), or a file that may not grow, makes a write
// fail and not the program end: a picture is worth more than what is told of it. A handler, unlike SIG_IGN,
// is not handed on to programs that are started.
static void OutliveWrites() {
    for (const int signal : {SIGPIPE, SIGXFSZ}) {
        struct sigaction before {
        }, action{};
        action.sa_handler = [](int) {};
        action.sa_flags = SA_RESTART;
        if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
            sigaction(signal, &action, nullptr);
    }
}

// Limits the threads of the whole program where the system allows fewer than there are cores.
static void LimitThreads(std::optional<cuticle::ThreadLimit> *limit) {
    const size_t cores = cuticle::MaxThreads(), startable = cuticle::StartableThreads(cores);
    if (startable >= cores)
        return;
    limit->emplace(startable);
    cuticle::Warning("threads", fmt::format("{} of {} threads can be started (limits of processes or of "
                                            "memory); these are used",
                                            startable, cores));
}

static int Run(int argc, char **argv) {
    cuticle::InstallCheckHandler();
    CLI::App app{"Cuticle renders pbrt-v3 scenes that hold hair.", "cuticle"};
    app.set_version_flag("--version", "cuticle " CUTICLE_VERSION);
    app.require_subcommand(1);
    app.get_formatter()->column_width(34);
    app.footer("`cuticle COMMAND --help` tells all about a command.\n"
               "Example: cuticle render scenes/quickstart.pbrt -o picture.png");
    std::string logFile;
    int verbosity = 0;
    app.add_option("--log", logFile, "also write warnings, errors and what -v tells to this file, at its end")
        ->type_name("FILE");
    app.add_option("-v,--verbosity", verbosity, "tell what is under way: 1, phases (default: 0, nothing)")
        ->check(CLI::Range(0, 9))
        ->type_name("N");
    std::string sandboxFolder;
    std::optional<cuticle::SandboxScope> sandbox;
    app.add_option("--sandbox", sandboxFolder,
                   "read and write no file outside of this folder: for a stranger's scene")
        ->type_name("DIR");
    // Before any command runs
    std::optional<cuticle::ThreadLimit> threads;
    cuticle::InputLog inputs; // of the command; no output is written over one of them
    const cuticle::InputScope noted(&inputs);
    app.parse_complete_callback([&] {
        cuticle::StartLog("cuticle", logFile, verbosity);
        if (!sandboxFolder.empty())
            sandbox.emplace(sandboxFolder);
        OutliveWrites();
        LimitThreads(&threads);
    });
    app.fallthrough(); // these may also stand behind the command
    cuticle::AddRenderCommand(app);
    cuticle::AddGroomCommand(app);
    cuticle::AddVolumeCommand(app);
    cuticle::AddSimulateCommand(app);
    cuticle::AddCompareCommand(app);
    cuticle::AddConvertCommand(app);
    cuticle::AddGoniometerCommand(app);
    cuticle::AddFigureCommand(app);
    cuticle::AddFeaturesCommand(app);
    cuticle::AddChartCommand(app);
    cuticle::AddAtlasCommand(app);
    try {
        RequireCommand(app, argc, argv);
        app.parse(argc, argv);
    } catch (const CLI::ParseError &e) {
        // Every mistake exits with 1; help and version with 0
        return app.exit(e) == 0 ? 0 : 1;
    } catch (const cuticle::ExitStatus &e) {
        return e.status;
    } catch (const cuticle::Error &e) {
        std::cerr << e.what() << "\n";
        return 1;
    } catch (const std::bad_alloc &) {
        std::cerr << "error: not enough memory\n";
        return 1;
    } catch (const std::exception &e) {
        std::cerr << "error: " << cuticle::Printable(e.what()) << "\n";
        return 1;
    }
    return 0;
}

// Tells whether what was printed has arrived; if not, the program fails: a full disk behind a redirection
// loses no table in silence.
static bool OutputIsWhole() {
    std::cout.flush();
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout)
        return true;
    // A pipe that nobody reads any more: its reader has had enough
    pollfd reader{STDOUT_FILENO, POLLOUT, 0};
    if (poll(&reader, 1, 0) == 1 && (reader.revents & POLLERR) != 0)
        return true;
    std::fputs("error: the standard output could not be written (a full disk, or a closed file?)\n", stderr);
    return false;
}

int main(int argc, char **argv) {
    try {
        const cuticle::PrintableOutput out(&std::cout), error(&std::cerr);
        const int status = Run(argc, argv);
        return OutputIsWhole() || status != 0 ? status : 1;
    } catch (...) {
        std::fputs("error: an unexpected failure\n", stderr);
        return 1;
    }
}
