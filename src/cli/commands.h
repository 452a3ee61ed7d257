// The commands of the program: each adds itself to the command line.
#pragma once

#include <CLI/CLI.hpp>

#include <cstdint>

namespace cuticle {

// Thrown by a command that has done its work and ends with a status other than 0 (a comparison beyond its
// threshold).
struct ExitStatus {
    int status;
};

// Refuses the name of an output folder that looks like a file's ("lobes.bmp") and is none that exists, before
// work is spent on it; names a folder all the same if it ends in a slash. files: what may stand there, or
// what the folder gets, for the message. Throws Error.
void CheckFolderName(const std::string &folder, const std::string &files);

// The largest --seed: a double, as which pictures and JSON keep it, holds it exactly.
inline constexpr uint64_t kMaxSeed = uint64_t{1} << 53;

void AddRenderCommand(CLI::App &app);
void AddGroomCommand(CLI::App &app);
void AddVolumeCommand(CLI::App &app);
void AddSimulateCommand(CLI::App &app);
void AddCompareCommand(CLI::App &app);
void AddConvertCommand(CLI::App &app);
void AddGoniometerCommand(CLI::App &app);
void AddFigureCommand(CLI::App &app);
void AddChartCommand(CLI::App &app);
void AddAtlasCommand(CLI::App &app);
void AddFeaturesCommand(CLI::App &app);

} // namespace cuticle
