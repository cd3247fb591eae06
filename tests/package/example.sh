#!/usr/bin/env bash
# The example that apps are to copy: at most 80 lines, and it runs.
#   example.sh SOURCE SHADOW OUTPUT PROGRAM...
set -euo pipefail
source=$1 shadow=$2 output=$3
shift 3
lines=$(wc -l <"$source")
((lines > 0 && lines <= 80)) || { echo "$source has $lines lines; the example must have 1 to 80"; exit 1; }
"$@" "$shadow" "$output"
# A PPM of 480 x 360 with more colours than floor and wall have: shadow and sand.
(($(stat -c %s "$output") == 15 + 3 * 480 * 360)) || { echo "$output is not the picture"; exit 1; }
(($(tail -c +16 "$output" | od -An -v -tx1 -w3 | sort -u | wc -l) > 200)) || { echo "$output shows nothing"; exit 1; }
# What is no shadow is refused with its sentence.
if "$@" "$source" "$output.not" 2>"$output.said"; then echo "a source file passed for a shadow"; exit 1; fi
grep -q "$source: ." "$output.said"
