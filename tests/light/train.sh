#!/usr/bin/env bash
# train.sh PROGRAM SOURCE_DIR: training and rounding to bytes from end to end, on a data set that is made here. Heads that are
# fitted know more of their own places than the mean light does. Exported weights give the same estimates when they are read
# back. No fold trains on a place on which it is tested. Weights rounded together err less than one by one, and the bytes of
# a network are close to it. Exit code 77: there is no PyTorch.
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

# Heads that are fitted to the runtime's features in bytes: first the trunk in bytes, then the features, then the heads.
quantised() {
  "$python" "$models/quantise.py" "$1" --calibrate "$folder/more" --measure "$folder/set" --images 8 --program "$program" -o "$2"
}
"$python" "$models/train.py" --initial --seed 1 --export "$folder/trunk.npz"
quantised "$folder/trunk.npz" "$folder/trunk.light"
for part in set more; do
  "$program" light-features "$folder/trunk.light" "$folder/$part" --mirror -o "$folder/$part.npy" >/dev/null
done
"$python" "$models/train.py" "$folder/set" --views "$folder/more" --weights "$folder/trunk.npz" --features "$folder/set.npy" \
  "$folder/more.npy" -o "$folder/fitted" --test-fold 1 --export "$folder/fitted.npz" >"$folder/fitted.log"
quantised "$folder/fitted.npz" "$folder/fitted.light" || [[ $? == 1 ]]  # heads of so few places magnify what rounding does
"$program" inspect "$folder/fitted.light" | grep -q "float copy   no"
"$program" light-features "$folder/fitted.light" "$folder/set" --mirror -o "$folder/again.npy" >/dev/null
cmp "$folder/set.npy" "$folder/again.npy"  # the heads do not change the trunk
"$python" - "$folder" <<'PY'
import json, sys
import numpy as np
import torch
import light_data
import light_network
import quantise
from light_ridge import angles_deg
folder = sys.argv[1]
fitted = json.load(open(f"{folder}/fitted/fold_1.json"))
assert fitted["train_images"] == 32 and fitted["test_images"] == 8 and fitted["test_locations"] == 1, fitted
net = light_network.LightNet().eval().requires_grad_(False)
assert net.load(folder + "/fitted.npz")
rows = light_data.Rows([folder + "/set"], [folder + "/more"])
for fold in (1, 2, 3):
    trained, tested = rows.split(fold)
    assert {rows.location[i] for i in tested} == {"abc"[fold - 1]} and len(tested) == 8
    assert not {rows.location[i] for i in trained} & {rows.location[i] for i in tested} and len(trained) == 32
trained, tested = rows.split(1)
features_of = light_data.read_features(net, rows, [f"{folder}/{part}.npy" for part in ("set", "more")])
known, new = (net.estimate(torch.from_numpy(np.stack([features_of(i, 0) for i in part]))).numpy() for part in (trained, tested))
written = np.loadtxt(folder + "/fitted/fold_1_estimates.csv", delimiter=",", skiprows=1, usecols=range(1, 11))
assert np.abs(new - written).max() < 2e-6, np.abs(new - written).max()
truth = rows.labels[trained]
ours, means = (angles_deg(made[:, :3], truth[:, :3]).mean() for made in (known, truth.mean(0)[None].repeat(len(truth), 0)))
print(f"direction on its own places: heads {ours:.1f} degrees, mean light {means:.1f}")
assert ours < means
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
