#!/usr/bin/env bash
# with_display.sh COMMAND...: runs a command on an X display of its own, drawn on the CPU. Exit code 77: Xvfb is
# missing.
set -euo pipefail
command -v Xvfb >/dev/null || { echo "skipped: no Xvfb is installed (Debian: xvfb, libgl1-mesa-dri)"; exit 77; }

number=$(mktemp)
Xvfb -displayfd 3 -screen 0 1280x1024x24 -nolisten tcp -noreset 3>"$number" >/dev/null 2>&1 &
server=$!
trap 'kill "$server" 2>/dev/null; wait "$server" 2>/dev/null || true; rm -f "$number"' EXIT
for _ in $(seq 200); do
  [[ -s $number ]] && break
  kill -0 "$server" 2>/dev/null || { echo "Xvfb does not start"; exit 1; }
  sleep 0.05
done
[[ -s $number ]] || { echo "Xvfb does not say which display it is"; exit 1; }
DISPLAY=:$(cat "$number") LIBGL_ALWAYS_SOFTWARE=1 "$@"
