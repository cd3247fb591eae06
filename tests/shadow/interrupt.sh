#!/usr/bin/env bash
# Ctrl-C in the middle of a bake: no output file, a checkpoint, exit code 130; with --resume the same bytes as without.
#   interrupt.sh PROGRAM WORK_FOLDER
set -euo pipefail
program=$1 work=$2
rm -rf "$work" && mkdir -p "$work"
bake=("$program" bake chair --size 32x1 --textures 1 --steps 8000 --quantised-steps 200 --validation-lights 4 --threads 1)

"${bake[@]}" -o "$work/whole" >"$work/log" 2>&1
for stop in 1 2; do  # twice: an interrupted resumption is resumed
  set -m  # a background job of a script ignores SIGINT otherwise
  "${bake[@]}" -o "$work/parts" $([[ $stop == 1 ]] || echo --resume) >"$work/log" 2>&1 &
  set +m
  job=$!
  sleep 1
  kill -INT "$job"
  code=0
  wait "$job" || code=$?
  [[ $code == 130 ]] || { cat "$work/log"; echo "exit code $code, not 130"; exit 1; }
  [[ ! -e $work/parts ]] || { echo "an interrupted bake left a file"; exit 1; }
  [[ -s $work/parts.checkpoint ]] || { echo "an interrupted bake left no checkpoint"; exit 1; }
done
"${bake[@]}" -o "$work/parts" --resume >"$work/log" 2>&1
grep -q '^going on from' "$work/log" || { cat "$work/log"; echo "the resumed bake began again"; exit 1; }
cmp "$work/whole" "$work/parts"
[[ ! -e $work/parts.checkpoint ]] || { echo "a finished bake left its checkpoint"; exit 1; }
