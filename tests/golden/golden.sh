#!/usr/bin/env bash
# Runs the demo scene on a virtual clock and compares its hash with the committed one.
#   golden.sh HASH_FILE [EMULATOR...] PROGRAM [ARGUMENTS...]
# HASH_FILE holds `frames N` and `hash 0x…`. Exit codes: 0 equal, 1 different or failed, 77 the CPU lacks the instruction set.
set -euo pipefail
hash_file=$1
shift
frames=$(awk '$1 == "frames" {print $2}' "$hash_file")
golden=$(awk '$1 == "hash" {print $2}' "$hash_file")

# The emulator and the program come before `run`; what follows the program are its arguments.
command=()
while (($# > 0)); do
  command+=("$1")
  [[ ${1##*/} == sandglass* ]] && { shift; break; }
  shift
done

# Only an instruction set that the kernel does not report may be skipped; one that the program refuses beyond that is a failure.
if [[ $* =~ --isa\ (avx2|avx512) ]]; then
  flag=${BASH_REMATCH[1]/avx512/avx512f}
  grep -qw "$flag" /proc/cpuinfo || { echo "this CPU has no $flag"; exit 77; }
fi

output=$("${command[@]}" run demo --frames "$frames" --clock virtual "$@") || { echo "$output"; exit 1; }
echo "$output" | tail -n 5
hash=$(echo "$output" | awk '$1 == "hash" {print $2}' | tail -n 1)
[[ $hash == "$golden" ]] || { echo "hash $hash differs from the golden $golden after $frames frames"; exit 1; }
