#!/usr/bin/env bash
# The golden hash of a program that was linked without any SIMD table.
#   scalar_only.sh NM HASH_FILE PROGRAM USUAL_PROGRAM
# The usual program must have such tables, which shows that the search finds them.
set -euo pipefail
nm=$1 hash_file=$2 program=$3 usual=$4
simd_tables() { "$nm" -C "$1" | grep -cE 'sandglass::(simd|int8)_(avx2|avx512|neon)[a-z_0-9]*::k_[a-z_]*table$' || true; }
(($(simd_tables "$usual") > 0)) || { echo "no SIMD table was found in the usual program"; exit 1; }
(($(simd_tables "$program") == 0)) || { echo "the program has SIMD tables"; exit 1; }
exec bash "$(dirname "${BASH_SOURCE[0]}")/golden.sh" "$hash_file" 90 "$program"
