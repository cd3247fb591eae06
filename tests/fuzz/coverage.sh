#!/usr/bin/env bash
# Runs all that the fuzzers have kept, and prints which share of each reader's lines that executes: ./sg coverage, which builds the
# preset coverage first. Assimp's part of the mesh reader runs in a process of its own, which counts nothing.
set -euo pipefail
while read -r name files; do
  program=build/coverage/tests/fuzz/fuzz_$name profile=build/coverage/$name
  mkdir -p "build/fuzz/$name"
  kept=("build/fuzz/$name")
  [[ ! -d tests/fuzz/corpus/$name ]] || kept+=("tests/fuzz/corpus/$name")
  find "${kept[@]}" -type f -print0 | LLVM_PROFILE_FILE="$profile.raw" xargs -0 -x -s 2000000 "$program" >/dev/null
  llvm-profdata merge -o "$profile.data" "$profile.raw"
  # The compiler knows the sources by paths from the build, so the reader's are found in the report of all.
  llvm-cov report -instr-profile "$profile.data" "$program" |
    awk -v name="$name" -v files=" $files " 'index(files, " " $1 " ") {printf "%-60s %4d of %4d lines, %s\n", name ": " $1, $8 - $9, $8, $10}'
done <<'READERS'
shadow_file runtime/asset/shadow_asset.cpp
light_file runtime/asset/light_asset.cpp
saved_scene runtime/sand/save.cpp
saved_room runtime/light/room/save.cpp
recording models/simulation/recording.cpp
scene_json models/simulation/scene_file.cpp models/simulation/strict_reader.h
picture models/files/image.cpp models/files/picture_head.cpp models/files/npy.cpp models/rooms/panorama_file.cpp
mesh models/mesh/mesh.cpp
READERS
