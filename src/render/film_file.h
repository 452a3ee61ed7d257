// Films in files, which a render writes while it is under way, and goes on from after it was stopped.
//
// A file begins with lines of text, "cuticle film 1", then NAME=VALUE each (a backslash stands before a
// backslash; a line's end within a value is \n), and an empty line. Behind it all numbers are little-endian.
// Tile by tile (Film::TileWindow): for each range of samples how many of them the tile has got (32 bits); for
// each pixel the number of samples it holds (32 bits), its lowest bins (3 bytes) and its counters (6 of 64
// bits); with variance the lowest bins (3 bytes) and counters (9 of 64 bits) of the squares. The hash of all
// bytes before it stands at the end, as 32 letters.
#pragma once

#include "render/film.h"

#include <functional>
#include <mutex>
#include <string>

namespace cuticle {

// The counts of a render besides its film, so far.
struct RenderTally {
    double seconds = 0; // on the wall
    uint64_t rays = 0, shadowRays = 0;
};

// Writes a film, so that it appears whole or not at all and outlives the machine. lockTile: is called with
// each tile before it is looked at, and what it returns is held until that is done; null where nobody joins
// tiles meanwhile. Throws Error as OutputFile does.
void WriteFilm(const std::string &filename, const Film &film, const RenderTally &tally,
               const std::function<std::unique_lock<std::mutex>(size_t tile)> &lockTile = nullptr);

struct StoredFilm {
    Film film;
    RenderTally tally;
};
// Reads a film. Throws Error that names the file where it is damaged or of another program; memory is taken
// only for what the file's length bears out.
StoredFilm ReadFilm(const std::string &filename);

} // namespace cuticle
