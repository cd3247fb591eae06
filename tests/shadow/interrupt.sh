#!/usr/bin/env bash
# Ctrl-C in the middle of a bake leaves a checkpoint and no output file, with exit code 130. With --resume the bake
# gives the same bytes as one without interruption.
#   interrupt.sh PROGRAM WORK_FOLDER
set -euo pipefail
program=$1 work=$2
rm -rf "$work" && mkdir -p "$work"
bake=("$program" bake chair --size 32x1 --textures 1 --steps 2000 --quantised-steps 200 --validation-lights 4 --ambient-texels 16 --threads 1 --no-picture)

begin=$(date +%s%N)
"${bake[@]}" -o "$work/whole" >"$work/log" 2>&1
third=$((($(date +%s%N) - begin) / 3000000))  # ms

# Whether a process handles SIGINT already. Before that, the signal ends it as it ends any program.
listens() {
  local caught
  caught=$(sed -n 's/^SigCgt:[[:space:]]*//p' "/proc/$1/status" 2>/dev/null) || return 1
  ((16#${caught:-0} & 2))
}

# Interrupts the bake after a third of the time that a whole one takes. If it has finished by then, tries again with
# half that time.
interrupt() {
  local wait_ms=$third code job
  for attempt in {1..8}; do
    rm -f "$work/parts"
    if [[ -e $work/before ]]; then cp "$work/before" "$work/parts.checkpoint"; else rm -f "$work/parts.checkpoint"; fi
    set -m  # otherwise a background job of a script ignores SIGINT
    "${bake[@]}" -o "$work/parts" "$@" >"$work/log" 2>&1 &
    set +m
    job=$!
    until listens $job || ! kill -0 $job 2>/dev/null; do sleep 0.01; done
    sleep "$((wait_ms / 1000)).$(printf %03d $((wait_ms % 1000)))"
    kill -INT "$job" 2>/dev/null || true
    code=0
    wait "$job" || code=$?
    if [[ $code == 130 ]]; then return; fi
    [[ $code == 0 ]] || break
    wait_ms=$((wait_ms / 2))
  done
  cat "$work/log"
  echo "exit code $code, not 130"
  exit 1
}

for resume in "" --resume; do  # twice: a resumed bake that is interrupted is resumed again
  interrupt $resume
  [[ ! -e $work/parts ]] || { echo "an interrupted bake left a file"; exit 1; }
  [[ -s $work/parts.checkpoint ]] || { echo "an interrupted bake left no checkpoint"; exit 1; }
  [[ -z $resume ]] || grep -q '^going on from' "$work/log" || { cat "$work/log"; echo "the resumed bake began again"; exit 1; }
  cp "$work/parts.checkpoint" "$work/before"
done
"${bake[@]}" -o "$work/parts" --resume >"$work/log" 2>&1
grep -q '^going on from' "$work/log" || { cat "$work/log"; echo "the resumed bake began again"; exit 1; }
cmp "$work/whole" "$work/parts"
[[ ! -e $work/parts.checkpoint ]] || { echo "a finished bake left its checkpoint"; exit 1; }
