#!/usr/bin/env bash
# train.sh PROGRAM SOURCE_DIR: the training script end to end on a data set made here. The imported weights give the
# reference features (where SANDGLASS_DATA_DIR is set), and a run that was killed and resumed ends like one that was not.
# Exit code 77: there is no PyTorch.
set -euo pipefail
program=$1 train=$2/models/lighting/train.py
export OMP_NUM_THREADS=1
python=
for candidate in python3 /usr/bin/python3; do
  if "$candidate" -c 'import torch, numpy, PIL' 2>/dev/null; then python=$candidate && break; fi
done
[[ -n $python ]] || { echo "no Python with torch, numpy and PIL: skipped"; exit 77; }

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
pretrained=${SANDGLASS_DATA_DIR:-}/pretrained
if [[ -e $pretrained/densenet121_reference_outputs.npz ]]; then
  "$python" "$train" --weights "$pretrained/densenet121_imagenet_keras_fp32.npz" \
    --check-import "$pretrained/densenet121_reference_outputs.npz"
fi

mkdir "$folder/rooms"
for seed in 1 2 3; do
  "$program" room --seed $seed --width 64 --samples 4 -o "$folder/rooms/room_$seed.hdr" >/dev/null
done
printf 'file,group,fold\nroom_1.hdr,a,1\nroom_2.hdr,b,2\nroom_3.hdr,c,3\n' >"$folder/groups.csv"
"$program" dataset "$folder/rooms" -o "$folder/set" --manifest "$folder/groups.csv" --tiles 1 >/dev/null

run() { "$python" "$train" "$folder/set" -o "$1" --epochs 3 --batch 8 --copies 2 --test-fold 1 --cpu "${@:2}"; }
run "$folder/whole" >"$folder/whole.log"
# Killed after its first epoch, then resumed.
: >"$folder/broken.log"
run "$folder/broken" >"$folder/broken.log" &
pid=$!
until grep -q '"epoch": 1' "$folder/broken.log" && [[ -e $folder/broken/fold_1.checkpoint ]]; do
  kill -0 $pid 2>/dev/null || break
  sleep 0.05
done
kill $pid 2>/dev/null || true
wait $pid 2>/dev/null || true
[[ ! -e $folder/broken/fold_1.json ]] || { echo "the run to be killed was faster"; exit 1; }
run "$folder/broken" --resume >"$folder/resumed.log"
"$python" - "$folder" <<'PY'
import json, sys
whole, broken = (json.load(open(f"{sys.argv[1]}/{name}/fold_1.json")) for name in ("whole", "broken"))
assert whole["log"] == broken["log"], (whole["log"], broken["log"])
assert whole["train_images"] == 16 and whole["test_images"] == 8 and whole["test_locations"] == 1, whole
assert whole["log"][-1]["loss"] < whole["log"][0]["loss"], whole["log"]
print("resumed as unbroken:", whole["log"][-1])
PY

refused() {  # one sentence that contains the words, and a failure
  local words=$1 output
  shift
  if output=$("$python" "$train" "$@" 2>&1); then echo "not refused: $*"; exit 1; fi
  [[ $(wc -l <<<"$output") == 1 && $output == *"$words"* ]] || { echo "unexpected refusal: $output"; exit 1; }
}
refused "no data set is named" -o "$folder/x"
refused "no manifest.csv" "$folder/rooms" -o "$folder/x"
refused "choose another fold" "$folder/set" --test-fold 7 -o "$folder/x"
