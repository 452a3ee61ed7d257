// Other renderers, run as programs.
#pragma once

#include "figures/figure.h"
#include "images/image.h"

#include <string>

namespace cuticle {

struct Rendering {
    Image image;
    double cpuSeconds; // of all threads, from the scene's file to the picture
};

// Runs the other renderer on a scene's file and reads its picture; its CPU time is that of the program and
// its children. Throws Error, with the command, if it fails or leaves no picture of the size that the scene
// asks for.
Rendering RenderPeer(const Peer &peer, const std::string &file);

} // namespace cuticle
