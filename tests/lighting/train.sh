#!/usr/bin/env bash
# train.sh PROGRAM SOURCE_DIR: training and rounding to bytes from end to end, on a data set that is made here. A run that
# was killed and resumed ends like one that was not. Training improves random heads. Exported weights give the same
# estimates when they are read back. No fold trains on a place on which it is tested. Cached outputs are those of the
# images. Weights rounded together err less than one by one, and the bytes of a network are close to it. Exit code 77:
# there is no PyTorch.
set -euo pipefail
program=$1 models=$2/models/lighting
. "$(dirname "${BASH_SOURCE[0]}")/find_python.sh"
export PYTHONPATH=$models PYTHONDONTWRITEBYTECODE=1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/rooms"
for seed in 1 2 3; do
  "$program" room --seed $seed --width 64 --samples 4 -o "$folder/rooms/room_$seed.hdr" >/dev/null
done
printf 'file,group,fold\nroom_1.hdr,a,1\nroom_2.hdr,b,2\nroom_3.hdr,c,3\n' >"$folder/groups.csv"
"$program" dataset "$folder/rooms" -o "$folder/set" --manifest "$folder/groups.csv" >/dev/null
"$program" dataset "$folder/rooms" -o "$folder/more" --manifest "$folder/groups.csv" --seed 2 >/dev/null

run() {
  "$python" "$models/train.py" "$folder/set" --views "$folder/more" -o "$1" --cache "$folder/cache" --epochs 3 --batch 8 --copies 2 \
    --test-fold 1 --cpu --export "$1/weights.npz" "${@:2}"
}
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
# Training improves random heads.
"$python" "$models/train.py" --initial --seed 1 --export "$folder/trunk.npz"
run "$folder/learned" --weights "$folder/trunk.npz" >"$folder/learned.log"
# The exported weights are only tested, not trained.
run "$folder/again" --epochs 0 --weights "$folder/whole/weights.npz" >"$folder/again.log"
# Cached outputs of the trunk belong to these images. With other images under the same names nothing of the first is used.
cached() {
  rm -rf "$folder/here" && cp -r "$1" "$folder/here"
  "$python" "$models/train.py" "$folder/here" -o "$folder/$2" --cache "$3" --weights "$folder/whole/weights.npz" --epochs 0 --copies 1 \
    --test-fold 1 --cpu >"$folder/$2.log"
}
cached "$folder/set" first "$folder/cache_here"
cached "$folder/more" other "$folder/cache_here"
cached "$folder/more" alone "$folder/cache_alone"
cmp "$folder/other/fold_1_estimates.csv" "$folder/alone/fold_1_estimates.csv"
! cmp -s "$folder/first/fold_1_estimates.csv" "$folder/other/fold_1_estimates.csv"

# Heads that are fitted to the runtime's features in bytes: first the trunk in bytes, then the features, then the heads.
quantised() {
  "$python" "$models/quantise.py" "$1" --calibrate "$folder/more" --measure "$folder/set" --images 8 --program "$program" -o "$2"
}
quantised "$folder/trunk.npz" "$folder/trunk.light"
for part in set more; do
  "$program" light-features "$folder/trunk.light" "$folder/$part" --mirror -o "$folder/$part.npy" >/dev/null
done
"$python" "$models/train.py" "$folder/set" --views "$folder/more" --weights "$folder/trunk.npz" --features "$folder/set.npy" \
  "$folder/more.npy" --copies 2 --epochs 0 --cpu -o "$folder/fitted" --test-fold 1 --export "$folder/fitted.npz" >"$folder/fitted.log"
quantised "$folder/fitted.npz" "$folder/fitted.light" || [[ $? == 1 ]]  # heads of so few places magnify what rounding does
"$program" inspect "$folder/fitted.light" | grep -q "float copy   no"
"$program" light-features "$folder/fitted.light" "$folder/set" --mirror -o "$folder/again.npy" >/dev/null
cmp "$folder/set.npy" "$folder/again.npy"  # the heads do not change the trunk
"$python" - "$folder" <<'PY'
import json, sys
import numpy as np
import light_data
import quantise
folder = sys.argv[1]
whole, broken = (json.load(open(f"{folder}/{name}/fold_1.json")) for name in ("whole", "broken"))
assert whole["log"] == broken["log"], (whole["log"], broken["log"])
weights = [np.load(f"{folder}/{name}/weights.npz") for name in ("whole", "broken")]
assert all(np.array_equal(weights[0][k], weights[1][k]) for k in weights[0].files)
assert whole["train_images"] == 32 and whole["test_images"] == 8 and whole["test_locations"] == 1, whole
learned = json.load(open(f"{folder}/learned/fold_1.json"))["log"]
assert learned[-1]["loss"] < learned[1]["loss"], learned
estimates = [np.loadtxt(f"{folder}/{name}/fold_1_estimates.csv", delimiter=",", skiprows=1, usecols=range(1, 11))
             for name in ("whole", "again")]
assert np.abs(estimates[0] - estimates[1]).max() < 2e-6, np.abs(estimates[0] - estimates[1]).max()
rows = light_data.Rows([folder + "/set"], [folder + "/more"])
for fold in (1, 2, 3):
    trained, tested = rows.split(fold)
    assert {rows.location[i] for i in tested} == {"abc"[fold - 1]} and len(tested) == 8
    assert not {rows.location[i] for i in trained} & {rows.location[i] for i in tested} and len(trained) == 32
# Of 48 inputs nine tenths of the variance 400 are common. Rounding to nearest leaves 48 / 12 of all of it. Weights that
# make up for one another leave little more than 48 / 12 of each input's own.
random = np.random.default_rng(5)
inputs = 100 + 20 * (np.sqrt(0.9) * random.normal(size=(4000, 1)) + np.sqrt(0.1) * random.normal(size=(4000, 48)))
aims, products = random.uniform(-20, 20, (48, 40)), quantise.Products()
products.note(inputs)
nearest, together = (np.var(inputs @ (quantise.rounded(aims, factor) - aims), axis=0).mean()
                     for factor in (None, products.factor(np.ones(48))))
print(f"mean square error of rounding: to nearest {nearest:.0f}, together {together:.0f}")
assert abs(nearest - 1600) < 560 and together < 1.5 * 160
PY
