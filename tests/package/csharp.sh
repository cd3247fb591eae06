#!/usr/bin/env bash
# The C# that csharp.py made of the headers, by Mono.
#   csharp.sh layout SANDGLASS_CS INCLUDE_FOLDER OUTPUT_FOLDER COMPILER [SED...]   sizes, offsets and constants are those of the target's C
#                                                                                  compiler; SED damages the file before
#   csharp.sh pour SANDGLASS_CS PLUGIN OUTPUT_FOLDER REFERENCE...                  runs against the plug-in; the hash is that of REFERENCE
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mode=$1 mirror=$2 third=$3 output=$4
shift 4
mkdir -p "$output"

compile() { mcs -unsafe -warnaserror -out:"$output/$mode.exe" "$1" "$here/csharp_$mode.cs"; }

layout() {
  local compiler=$1
  shift
  sed -e '' "${@/#/--expression=}" "$mirror" >"$output/Sandglass.cs"
  compile "$output/Sandglass.cs"
  { (cd "$third" && printf '#include "%s"\n' sandglass/*.h) && mono "$output/layout.exe"; } >"$output/csharp_claims.c"
  echo "$(grep -c typedef "$output/csharp_claims.c") claims"
  "$compiler" -std=c99 -fsyntax-only -I "$third" "$output/csharp_claims.c" || { echo "Sandglass.cs differs from the headers"; exit 1; }
}

pour() {
  local printed hash reference
  compile "$mirror"
  printed=$(LD_LIBRARY_PATH=$(dirname "$third") mono "$output/pour.exe")
  echo "$printed"
  hash=$(awk '$1 == "hash" {print $2}' <<<"$printed")
  reference=$("$@" | awk '$1 == "hash" {print $2}')
  [[ -n $hash && $hash == "$reference" ]] || { echo "C# ends in $hash, C++ in $reference"; exit 1; }
}

"$mode" "$@"
