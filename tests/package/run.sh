#!/usr/bin/env bash
# Installs the build in $1 into a folder of its own there, builds the consumer against it and runs it.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
rm -rf "$build/package_test"
cmake --install "$build" --prefix "$build/package_test/prefix" >/dev/null
cmake -S "$here" -B "$build/package_test/build" -G Ninja -DCMAKE_PREFIX_PATH="$build/package_test/prefix" "${@:2}" >/dev/null
cmake --build "$build/package_test/build"
"$build/package_test/build/consumer"
"$build/package_test/build/pbrt3" --gtest_brief=1
