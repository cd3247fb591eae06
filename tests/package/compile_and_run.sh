#!/usr/bin/env bash
# Builds an app of one file with pkg-config, as in a shell, and runs it.
#   compile_and_run.sh PREFIX OUTPUT_FOLDER SOURCE "COMPILER FLAGS" [EMULATOR...]
# A .c source is linked by the C compiler alone, because the archive needs no C++ runtime library.
set -euo pipefail
prefix=$1 output=$2 source=$3 compiler=$4
shift 4
mkdir -p "$output"

pc=$(find "$prefix" -name sandglass.pc)
# Only this folder is searched: for another target the workstation's own packages must not be found.
flags=$(PKG_CONFIG_LIBDIR=$(dirname "$pc") pkg-config --define-prefix --cflags --libs sandglass)
program=$output/$(basename "${source%.*}")
echo "$compiler $source $flags"
# shellcheck disable=SC2086 # both are lists of words
$compiler -O2 "$source" $flags -o "$program"
"$@" "$program"
