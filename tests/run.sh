#!/usr/bin/env bash
# Installs what is missing, builds (Release) and runs every test. Further words go to ctest: tests/run.sh -R image
set -euo pipefail
cd "$(dirname "$0")/.."
bash .ci/setup
cmake --preset release
cmake --build --preset release
exec ctest --preset release -j "$(nproc)" "$@"
