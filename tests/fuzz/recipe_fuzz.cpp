// Bytes as the recipe of a simulation, of which a few steps are taken, and as poses of a head.
#include "core/error.h"
#include "dynamics/pose_file.h"
#include "dynamics/recipe.h"
#include "grooms/hair_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

namespace cuticle {
namespace {

// A folder with hair.hair, six small strands, and head.poses, which a recipe may name. It stays as long as
// the fuzzer runs.
const std::string &FolderWithHair() {
    static const std::string folder = [] {
        std::string name = std::filesystem::temp_directory_path() / ("recipe-" + std::to_string(getpid()));
        std::filesystem::create_directories(name);
        Groom groom;
        for (size_t s = 0; s < 6; ++s) {
            for (size_t i = 0; i < 5; ++i)
                groom.points.push_back(
                    {static_cast<float>(s), 12 - static_cast<float>(i), 0.2f * static_cast<float>(i)});
            groom.strandOffsets.push_back(static_cast<uint32_t>(groom.points.size()));
        }
        WriteHairFile(name + "/hair.hair", groom);
        std::ofstream(name + "/head.poses") << "1 0 0 0 0 0 0\n2 0 0 0 0 90 0\n";
        return name;
    }();
    return folder;
}

// Whatever a recipe may ask for, hair stays finite; it stays small here so that a step takes no time.
void Simulate(SimulationRecipe recipe) {
    SimulationSettings &s = recipe.settings;
    s.keyHairs = std::min<size_t>(s.keyHairs, 6), s.points = std::min<size_t>(s.points, 8);
    s.substeps = std::min<size_t>(s.substeps, 2);
    s.framesPerSecond = std::max(s.framesPerSecond, 20.); // or there are many substeps
    s.coupling.passes = std::min<size_t>(s.coupling.passes, 3);
    s.physics.springSteps = std::min<size_t>(s.physics.springSteps, 20);
    HairSimulation simulation(std::move(recipe.groom), std::move(recipe.obstacle), s);
    for (int frame = 0; frame < 3; ++frame)
        simulation.NextFrame();
    for (const Point3f &p : simulation.Frame().points)
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            std::abort();
    for (const Point3f &p : simulation.KeyFrame().points)
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            std::abort();
}

// Whatever poses a file holds, the head stays rigid on its way.
void Follow(const std::string &text) {
    const std::vector<HeadMotion::TimedPose> poses = ParsePoses(text, "fuzz.poses", {});
    const HeadMotion motion(poses);
    for (size_t i = 0; i < std::min<size_t>(poses.size(), 20); ++i)
        for (const double f : {0., 0.3, 0.9}) {
            const double next = i + 1 < poses.size() ? poses[i + 1].time : poses[i].time + 1;
            const Pose pose = motion.At(poses[i].time * (1 - f) + next * f);
            if (!(std::abs(Dot(Cross(pose.x, pose.y), pose.z) - 1) < 1e-6) ||
                !std::isfinite(pose.origin.Length()))
                std::abort();
        }
}

} // namespace
} // namespace cuticle

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const std::string text(reinterpret_cast<const char *>(data), size);
    if (text.find("groom") != std::string::npos)
        return 0; // hair that is grown may be any amount of it; target "scene" has its parameters
    cuticle::WarningLog warnings;
    const cuticle::WarningScope scope(&warnings);
    try {
        cuticle::Simulate(cuticle::ParseSimulationRecipe(text, "fuzz.recipe", cuticle::FolderWithHair()));
    } catch (const cuticle::Error &) {
    }
    try {
        cuticle::Follow(text);
    } catch (const cuticle::Error &) {
    }
    return 0;
}
