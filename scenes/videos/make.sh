#!/usr/bin/env bash
# Makes the six videos of Petrovic and others: simulates, takes shells, renders, encodes. Needs ffmpeg (.ci/setup video).
#   scenes/videos/make.sh CUTICLE FOLDER [FRAMES [NAME ...]]
# FRAMES: FIRST:LAST:STEP, with a STEP of 1, 2, 4, 8 or 16; 0:64 are all, 0:64:2 a draft as long, of every other frame.
# NAME: 1-surface, 2-normals, ... What is there already stays: remove the folder to begin anew. All takes about 15 minutes
# of one core.
set -euo pipefail
cuticle=$(realpath "$1") here=$(realpath "$(dirname "$0")") frames=${3:-0:64}
mkdir -p "$2"
cd "$2"
cp "$here"/*.recipe "$here"/*.pbrt .
names=("${@:4}")
[ ${#names[@]} -gt 0 ] || names=(1-surface 2-normals 3-keys 4-keys-smoothed 5-hair 6-directed)

simulate() { # RECIPE FOLDER OPTION ...: where the last frame is not there yet
  local last=$([ "$2" = wind ] && echo wind/16.hair || echo "$2/0064.hair")
  [ -e "$last" ] || "$cuticle" simulate "$1" -o "$2/$([ "$2" = wind ] && echo %d || echo %04d).hair" "${@:3}"
}
grep -v HairToHair shake.recipe > free.recipe
simulate shake.recipe smooth --head smooth/head-%04d.pbrt
simulate shake.recipe smooth-keys --keys
simulate free.recipe free-keys --keys
simulate wind.recipe wind
simulate directed.recipe directed
mkdir -p shell
IFS=: read -r first last step <<< "$frames"
for n in $(seq -f %04g "$first" "${step:-1}" "$last"); do
  [ -e "shell/$n.ply" ] || "$cuticle" volume "smooth/$n.hair" --cell 0.6 -q -o "shell/$n.ply"
done
for name in "${names[@]}"; do
  "$cuticle" render "$name.pbrt" --frames "$frames" -o "pictures/$name-%04d.exr" --resume
  "$cuticle" convert "pictures/$name-%04d.exr" -o "$name.mp4" --fps $((16 / ${step:-1})) --frames "$frames"
  ffmpeg -y -loglevel error -ss 1 -i "$name.mp4" -frames:v 1 -q:v 3 "$name.jpg"
done
