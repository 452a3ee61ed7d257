#!/usr/bin/env bash
# From a bare system (.ci/setup) to a picture of hair: installs what is missing, builds (Release), renders quickstart.pbrt.
set -euo pipefail
cd "$(dirname "$0")/.."
bash .ci/setup
cmake --preset release
cmake --build --preset release --target cuticle
mkdir -p out
build/release/cuticle render scenes/quickstart.pbrt -o out/quickstart.exr
build/release/cuticle convert out/quickstart.exr out/quickstart.png
echo "The picture: $PWD/out/quickstart.png (and .exr)"
