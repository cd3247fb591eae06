#!/usr/bin/env bash
# The example that apps are to copy: at most 80 lines, and it runs.
#   example.sh SOURCE LIGHT SHADOW OUTPUT PROGRAM...
set -euo pipefail
source=$1 light=$2 shadow=$3 output=$4
shift 4
lines=$(wc -l <"$source")
((lines > 0 && lines <= 80)) || { echo "$source has $lines lines; the example must have 1 to 80"; exit 1; }
"$@" "$light" "$shadow" "$output" | tee "$output.said"
# Of 90 frames, 1.5 seconds, at four estimates a second. Under emulation, where the program is the second word, 4 ms are
# too short for one.
estimates=$(grep -o '[0-9]* estimates' "$output.said" | cut -d ' ' -f 1)
(($# > 1 || estimates >= 3)) || { echo "only $estimates estimates of the light"; exit 1; }
# A PPM of 480 x 360 with more colours than floor and wall have: shadow and sand.
(($(stat -c %s "$output") == 15 + 3 * 480 * 360)) || { echo "$output is not the picture"; exit 1; }
(($(tail -c +16 "$output" | od -An -v -tx1 -w3 | sort -u | wc -l) > 200)) || { echo "$output shows nothing"; exit 1; }
# What is no network, or no shadow, is refused with its sentence.
if "$@" "$source" "$shadow" "$output.not" 2>"$output.said"; then echo "a source file passed for a network"; exit 1; fi
grep -q "$source: ." "$output.said"
if "$@" "$light" "$source" "$output.not" 2>"$output.said"; then echo "a source file passed for a shadow"; exit 1; fi
grep -q "$source: ." "$output.said"
if "$@" "$source.missing" "$shadow" "$output.not" 2>"$output.said"; then echo "a missing file passed"; exit 1; fi
# A folder is no file: its sentence, and no abort.
mkdir -p "$output.folder"
for files in "$output.folder $shadow" "$light $output.folder"; do
  read -r first second <<<"$files"
  code=0
  "$@" "$first" "$second" "$output.not" 2>"$output.said" || code=$?
  ((code == 1)) || { echo "a folder ended it with $code"; exit 1; }
  grep -q "$output.folder: ." "$output.said"
done
[[ ! -e $output.not ]]
