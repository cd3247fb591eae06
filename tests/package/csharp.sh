#!/usr/bin/env bash
# The C# mirror of the headers (toolchains/unity/Sandglass.cs), by Mono.
#
#   csharp.sh layout SANDGLASS_CS INCLUDE_FOLDER OUTPUT_FOLDER COMPILER    sizes, offsets and constants are those of the target's C
#                                                                          compiler; every struct and function is there
#   csharp.sh pour SANDGLASS_CS PLUGIN OUTPUT_FOLDER [REFERENCE...]        runs against the plug-in; the hash is that of REFERENCE
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mode=$1 mirror=$2 third=$3 output=$4
shift 4
mkdir -p "$output"

compile() { mcs -unsafe -warnaserror -out:"$output/$1.exe" "$mirror" "$here/csharp_$1.cs"; }

layout() {
  local declared mirrored missing
  compile layout
  mono "$output/layout.exe" >"$output/csharp_claims.c"
  echo "$(grep -c typedef "$output/csharp_claims.c") claims"
  "$1" -std=c99 -fsyntax-only -I "$third" "$output/csharp_claims.c" || { echo "Sandglass.cs differs from the headers"; exit 1; }
  # The headers declare these structs with a body, and these functions.
  declared=$(grep -hoE '^typedef struct sandglass_[a-z_]+ \{' "$third"/sandglass/*.h | awk '{print $3}'
    tr '\n' ' ' < <(cat "$third"/sandglass/*.h) | grep -oE 'SANDGLASS_API [^;/]*\(' | grep -oE 'sandglass_[a-z0-9_]+\(' | tr -d '(')
  mirrored=$(awk '$2 == "mirrored" {print $3}' "$output/csharp_claims.c")
  missing=$(comm -23 <(sort -u <<<"$declared") <(sort -u <<<"$mirrored"))
  echo "$(sort -u <<<"$declared" | wc -l) structs and functions in the headers"
  [[ -z $missing ]] || { echo "not in Sandglass.cs: $missing"; exit 1; }
}

pour() {
  local printed hash reference
  compile pour
  printed=$(LD_LIBRARY_PATH=$(dirname "$third") mono "$output/pour.exe")
  echo "$printed"
  hash=$(awk '$1 == "hash" {print $2}' <<<"$printed")
  reference=$("$@" | awk '$1 == "hash" {print $2}')
  [[ -n $hash && $hash == "$reference" ]] || { echo "C# ends in $hash, C++ in $reference"; exit 1; }
}

"$mode" "$@"
