#!/usr/bin/env bash
# Builds an app of one file with pkg-config, as in a shell, and runs it.
#   compile_and_run.sh PREFIX OUTPUT_FOLDER SOURCE "COMPILER FLAGS" [EMULATOR...]
# Of a .md source the first ```cpp block is taken: the README's example is models/examples/pour.cpp, has at most 40 lines,
# and runs. A .c source is linked by the C compiler alone, because the archive needs no C++ runtime library.
set -euo pipefail
prefix=$1 output=$2 source=$3 compiler=$4
shift 4
mkdir -p "$output"

if [[ $source == *.md ]]; then
  example=$output/readme_example.cpp
  awk '/^```cpp$/ {inside = 1; next} /^```$/ && inside {exit} inside' "$source" >"$example"
  lines=$(wc -l <"$example")
  echo "$lines lines in the example"
  ((lines > 0 && lines <= 40)) || { echo "the example must have 1 to 40 lines"; exit 1; }
  diff "$(dirname "$source")/models/examples/pour.cpp" "$example" || { echo "the README's example is not models/examples/pour.cpp"; exit 1; }
  source=$example
fi

pc=$(find "$prefix" -name sandglass.pc)
# Only this folder is searched: for another target the workstation's own packages must not be found.
flags=$(PKG_CONFIG_LIBDIR=$(dirname "$pc") pkg-config --define-prefix --cflags --libs sandglass)
program=$output/$(basename "${source%.*}")
echo "$compiler $source $flags"
# shellcheck disable=SC2086 # both are lists of words
$compiler -O2 "$source" $flags -o "$program"
"$@" "$program"
