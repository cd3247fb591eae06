#!/usr/bin/env bash
# Writes the hashes and the recording of the demo scene as the program of the preset host computes them: ./sg golden.
set -euo pipefail
program=build/host/bin/sandglass hashes=tests/golden/demo.hash
{
  grep '^#' $hashes
  for frames in 30 90; do
    said=$($program run demo --frames $frames --clock virtual --isa scalar)
    printf '%d %s\n' $frames "$(awk '$1 == "hash" {print $2}' <<<"$said" | tail -n 1)"
  done
} >build/host/demo.hash
mv build/host/demo.hash $hashes
cat $hashes
$program run demo --frames 60 --budget-ms 1.5 --record tests/golden/demo.recording
