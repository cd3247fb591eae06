#!/usr/bin/env bash
# Runs the demo scene on a virtual clock and compares its hash with the committed one.
#   golden.sh HASH_FILE FRAMES [EMULATOR...] PROGRAM [ARGUMENTS...]
# HASH_FILE holds lines of `FRAMES HASH`.
# Exit code 0: equal; 1: different, or the run failed; 77: the CPU lacks the instruction set.
set -euo pipefail
hash_file=$1 frames=$2
shift 2
golden=$(awk -v frames="$frames" '$1 == frames {print $2}' "$hash_file")
[[ -n $golden ]] || { echo "$hash_file has no hash after $frames frames"; exit 1; }

# The emulator and the program come before `run`. Everything behind the program is an argument of it.
command=()
while (($# > 0)); do
  command+=("$1")
  [[ ${1##*/} == sandglass* ]] && { shift; break; }
  shift
done

# A test is skipped only if the operating system does not report the instruction set. If the program refuses another
# one, that is a failure.
if [[ $* =~ --isa\ (avx2|avx512) ]]; then
  flag=${BASH_REMATCH[1]/avx512/avx512f}
  grep -qw "$flag" /proc/cpuinfo || { echo "this CPU has no $flag"; exit 77; }
fi

output=$("${command[@]}" run demo --frames "$frames" --clock virtual "$@") || { echo "$output"; exit 1; }
echo "$output" | tail -n 5
hash=$(echo "$output" | awk '$1 == "hash" {print $2}' | tail -n 1)
[[ $hash == "$golden" ]] || { echo "hash $hash differs from the golden $golden after $frames frames"; exit 1; }
