#!/usr/bin/env bash
# Every ```cpp block of llms.txt is an app that compiles and runs: llms.sh PREFIX OUTPUT_FOLDER LLMS_TXT "COMPILER FLAGS" [EMULATOR...]
set -euo pipefail
prefix=$1 output=$2 text=$3 compiler=$4
shift 4
rm -rf "$output"
mkdir -p "$output"
awk -v folder="$output" '/^```cpp$/ {file = sprintf("%s/llms%d.cpp", folder, ++n); next} /^```$/ {file = ""} file {print > file}' "$text"
apps=("$output"/*.cpp)
[[ -e ${apps[0]} ]] || { echo "$text has no block of C++"; exit 1; }
for app in "${apps[@]}"; do
  bash "$(dirname "$0")/compile_and_run.sh" "$prefix" "$output" "$app" "$compiler" "$@"
done
