// A recipe is what `cuticle simulate` reads: statements in the scene language's syntax (parser/statements.h).
#pragma once

#include "dynamics/simulation.h"

#include <string>

namespace cuticle {

// A simulation as a file asks for it.
struct SimulationRecipe {
    SimulationSettings settings;
    double seconds = 2;
    Groom groom;
    std::unique_ptr<Obstacle> obstacle;
    // Counts all frames, the groom as it was among them.
    size_t FrameCount() const;
};

// Reads a recipe with the groom that it names or grows. Throws Error with file:line:col.
SimulationRecipe ReadSimulationRecipe(const std::string &filename);
// The same from text; names of files are taken from `folder`.
SimulationRecipe ParseSimulationRecipe(const std::string &text, const std::string &name,
                                       const std::string &folder = ".");

// Every statement of a recipe and its parameters, in Markdown.
std::string SimulationManual();

} // namespace cuticle
