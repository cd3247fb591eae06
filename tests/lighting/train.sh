#!/usr/bin/env bash
# train.sh PROGRAM SOURCE_DIR: the training script from end to end, on a data set that is made here. A run that was
# killed and resumed ends like one that was not. Exported weights give the same estimates when they are read back. No fold trains on a place on which it
# is tested. Exit code 77: there is no PyTorch.
set -euo pipefail
program=$1 train=$2/models/lighting/train.py
. "$(dirname "${BASH_SOURCE[0]}")/find_python.sh"
export PYTHONPATH=$(dirname "$train") PYTHONDONTWRITEBYTECODE=1

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/rooms"
for seed in 1 2 3; do
  "$program" room --seed $seed --width 64 --samples 4 -o "$folder/rooms/room_$seed.hdr" >/dev/null
done
printf 'file,group,fold\nroom_1.hdr,a,1\nroom_2.hdr,b,2\nroom_3.hdr,c,3\n' >"$folder/groups.csv"
"$program" dataset "$folder/rooms" -o "$folder/set" --manifest "$folder/groups.csv" --tiles 1 >/dev/null

"$program" dataset "$folder/rooms" -o "$folder/more" --manifest "$folder/groups.csv" --tiles 1 --seed 2 >/dev/null

run() {
  "$python" "$train" "$folder/set" --views "$folder/more" -o "$1" --cache "$folder/cache" --epochs 3 --batch 8 --copies 2 \
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
# Cached outputs of the trunk belong to these images. With other images under the same names nothing of the first is
# used, and with the first ones again nothing is computed.
cached() {
  rm -rf "$folder/here" && cp -r "$1" "$folder/here"
  "$python" "$train" "$folder/here" -o "$folder/$2" --cache "$3" --weights "$folder/whole/weights.npz" --epochs 0 --copies 1 \
    --test-fold 1 --cpu >"$folder/$2.log"
}
cached "$folder/set" first "$folder/cache_here"
cached "$folder/more" other "$folder/cache_here"
cached "$folder/more" alone "$folder/cache_alone"
cached "$folder/set" same "$folder/cache_here"
cmp "$folder/other/fold_1_estimates.csv" "$folder/alone/fold_1_estimates.csv"
cmp "$folder/first/fold_1_estimates.csv" "$folder/same/fold_1_estimates.csv"
! cmp -s "$folder/first/fold_1_estimates.csv" "$folder/other/fold_1_estimates.csv"
grep -q "copy 1 of 1" "$folder/other.log"
! grep -q "copy 1 of 1" "$folder/same.log"
# Every layer learns where that is asked for. If only the last layers learn, the trunk stays.
"$python" "$train" "$folder/set" -o "$folder/every" --layers all --epochs 1 --batch 8 --test-fold 1 --cpu \
  --weights "$folder/whole/weights.npz" --export "$folder/every.npz" >"$folder/every.log"
# Training improves random heads.
"$python" "$train" --initial --seed 1 --export "$folder/trunk.npz"
run "$folder/learned" --weights "$folder/trunk.npz" >"$folder/learned.log"
# Lanes carry brightness to the averages over all pixels and over parts of them. Heads start from them, and training
# goes on.
"$python" "$train" --initial --lanes --weights "$folder/trunk.npz" --export "$folder/lanes.npz"
"$python" - "$folder" <<'PY'
import sys
import numpy as np
import torch
import torch.nn.functional as F
folder = sys.argv[1]
import light_data
import light_network
import light_ridge
import train
arrays = dict(np.load(folder + "/lanes.npz"))
np.savez(folder + "/lanes_trunk.npz", **{k: v for k, v in arrays.items() if k.split("/")[0] not in ("latent", *train.LOSS_WEIGHTS)})
net, rows = light_network.LightNet(), light_data.Rows([folder + "/set"])
net.learned = 16
assert not net.load(folder + "/lanes_trunk.npz")
net.eval()
rgb = light_data.to_tensor([light_data.prepared(rows, i, 0, 1) for i in range(4)], "cpu")
with torch.no_grad():
    features = net.features(net.trunk(rgb))[:, torch.from_numpy(net.lanes)].double()
mean = torch.tensor(light_network.MEAN).view(1, 3, 1, 1)
smooth = F.avg_pool2d(F.pad(rgb - mean, (3, 3, 3, 3)), 7, 2) + mean  # beyond the image there is the mean
lanes = torch.cat([F.max_pool2d((smooth[:, c:c + 1] - t).clamp(min=0), 3, 2, 1) for c, t in light_network.LANES], 1).double()
lanes = F.avg_pool2d(lanes, 8)
parts = [lanes.mean((2, 3))]
for k in range(1, light_network.LAYOUT_LAYERS + 1):
    parts += [lanes[:, :, k:].sum((2, 3)) / 48, lanes[:, :, :, k:].sum((2, 3)) / 48]
count = len(light_network.LANES)
found = features.split(count, 1)
assert len(found) == len(parts) and lanes.mean() > 0.05
assert np.allclose(found[0].sort(1).values, parts[0].sort(1).values, atol=1e-5)  # their places are in the order in which they are used
for a, b in zip(found[1:], parts[1:]):
    assert np.allclose(a, b, atol=1e-5), np.abs(a - b).max()
# A channel that is no longer read is replaced by the mean and the deviation of a rectified normal distribution.
norm = torch.nn.BatchNorm2d(3)
norm.weight.data, norm.bias.data = torch.tensor([0.5, 1.0, 2.0]), torch.tensor([0.3, -1.0, 0.0])
drawn = np.maximum(np.random.default_rng(1).normal(size=(1000000, 3)) * norm.weight.data.numpy() + norm.bias.data.numpy(), 0)
found_mean, found_deviation = light_network.expected(norm, torch.arange(3))
assert np.allclose(found_mean.detach(), drawn.mean(0), atol=5e-3) and np.allclose(found_deviation.detach(), drawn.std(0), atol=5e-3)
# A trust t means a ridge that is 1/t^2 times as large. With uncorrelated features of deviation 1 the slope is
# c t^2 / (t^2 + ridge).
design = np.array([[1, 1, 1, 1, -1, -1, -1, -1], [1, 1, -1, -1, 1, 1, -1, -1], [1, -1, 1, -1, 1, -1, 1, -1]], float).T
labels = np.full((8, 10), 0.5)
labels[:, :3] = 0.2 * design
trust = np.array([1.0, 0.3, 0.1])
slopes = light_ridge.Regression(design, labels, np.ones(8), trust).slopes((0.25,) * 4)
assert np.allclose(slopes[:, :3], np.diag(0.1 * trust ** 2 / (trust ** 2 + 0.25)), atol=1e-12)
PY
run "$folder/laned" --weights "$folder/lanes_trunk.npz" --epochs 1 >"$folder/laned.log"
"$python" - "$folder" <<'PY'
import json, sys
import numpy as np
import light_ridge
laned = json.load(open(sys.argv[1] + "/laned/fold_1.json"))
assert len(laned["trusts"]) == 4 and all(trust in light_ridge.TRUSTS for trust in laned["trusts"]), laned
assert np.array_equal(np.load(sys.argv[1] + "/laned/weights.npz")["lanes"], np.load(sys.argv[1] + "/lanes.npz")["lanes"])
PY
# The exported weights are only tested, not trained.
run "$folder/again" --epochs 0 --weights "$folder/whole/weights.npz" >"$folder/again.log"
"$python" - "$folder" <<'PY'
import json, sys
import numpy as np
folder = sys.argv[1]
import light_data
whole, broken = (json.load(open(f"{folder}/{name}/fold_1.json")) for name in ("whole", "broken"))
assert whole["log"] == broken["log"], (whole["log"], broken["log"])
weights = [np.load(f"{folder}/{name}/weights.npz") for name in ("whole", "broken")]
assert all(np.array_equal(weights[0][k], weights[1][k]) for k in weights[0].files)
assert whole["train_images"] == 32 and whole["test_images"] == 8 and whole["test_locations"] == 1, whole
every = json.load(open(f"{folder}/every/fold_1.json"))
assert np.isfinite(every["log"][-1]["loss"]) and every["train_images"] == 16, every["log"]
before, after = np.load(f"{folder}/whole/weights.npz"), np.load(f"{folder}/every.npz")
for name in ("conv1/conv/kernel", "conv3_block2_1_conv/kernel", "pool4_conv/kernel", "conv5_block16_2_conv/kernel", "latent/kernel"):
    assert np.abs(before[name] - after[name]).max() > 0, name
start, last = np.load(f"{folder}/trunk.npz"), np.load(f"{folder}/learned/weights.npz")
for name, learns in (("conv1/conv/kernel", False), ("pool4_conv/kernel", False), ("conv5_block16_2_conv/kernel", True)):
    assert np.array_equal(start[name], last[name]) != learns, name
learned = json.load(open(f"{folder}/learned/fold_1.json"))["log"]
assert learned[-1]["loss"] < learned[1]["loss"], learned
estimates = [np.loadtxt(f"{folder}/{name}/fold_1_estimates.csv", delimiter=",", skiprows=1, usecols=range(1, 11))
             for name in ("whole", "again")]
assert np.abs(estimates[0] - estimates[1]).max() < 2e-6, np.abs(estimates[0] - estimates[1]).max()
assert np.allclose(np.linalg.norm(estimates[0][:, :3], axis=1), 1, atol=1e-5)
rows = light_data.Rows([folder + "/set"], [folder + "/more"])
for fold in (1, 2, 3):
    trained, tested = rows.split(fold)
    assert {rows.location[i] for i in tested} == {"abc"[fold - 1]} and len(tested) == 8
    assert not {rows.location[i] for i in trained} & {rows.location[i] for i in tested} and len(trained) == 32
assert len(rows.split(None)[0]) == 48 and len(rows.split(None)[1]) == 0
image, mirror = (light_data.prepared(rows, 5, copy, 1) for copy in (0, 1))
assert np.array_equal(mirror, image[:, ::-1]) and not np.array_equal(mirror, image)
label = rows.labels[5]
mirrored = light_data.label_of(rows, 5, 1, 1)
assert mirrored[0] == -label[0] != 0 and np.array_equal(mirrored[1:], label[1:])
# The mean of an augmented image, before its noise and JPEG, has the same gain as its ambient colour.
bright = light_data.label_of(rows, 5, 2, 1)[6:9] / label[6:9]
gain = light_data.gain_of(np.random.default_rng([1, 5, 2]))
assert np.allclose(bright, gain, rtol=1e-5) and np.array_equal(light_data.label_of(rows, 5, 2, 1)[:3], label[:3])
print("resumed as unbroken:", whole["log"][-1])
PY
# The evaluation reads the table of estimates. Made-up rooms of three places prove nothing, so any verdict will do.
"${program%/*}/sandglass_lab" verify lighting --panoramas "$folder/rooms/room_1.hdr" --manifest "$folder/groups.csv" --samples 0 \
  --estimates "$folder/whole/fold_1_estimates.csv" >"$folder/verify.log" || [[ $? == 1 ]]
grep -q "direction against" "$folder/verify.log"
# The plain float network in C++ gives PyTorch's estimates for 56 excerpts.
mkdir "$folder/others"
cp "$folder/rooms/room_1.hdr" "$folder/others/room_0.hdr"
printf 'file,group,fold\nroom_0.hdr,a,2\n' >"$folder/others.csv"
for seed in 4 5 6 7 8 9 10; do
  "$program" room --seed $seed --width 64 --samples 4 -o "$folder/others/room_$seed.hdr" >/dev/null
  printf 'room_%s.hdr,b%s,1\n' $seed $seed >>"$folder/others.csv"
done
"$program" dataset "$folder/others" -o "$folder/others_set" --manifest "$folder/others.csv" --tiles 1 >/dev/null
"$python" "$train" "$folder/others_set" -o "$folder/fifty" --cache "$folder/cache_others" --epochs 0 --copies 1 --test-fold 1 --cpu \
  --weights "$folder/whole/weights.npz" >"$folder/fifty.log"
rm "$folder/others/room_0.hdr"
"${program%/*}/sandglass_lab" verify lighting --panoramas "$folder/others" --manifest "$folder/others.csv" --samples 0 \
  --network "$folder/whole/weights.npz" --out "$folder/float" >"$folder/float.log" || [[ $? == 1 ]]
"$python" - "$folder" <<'PY'
import sys
import numpy as np
a, b = ({row[0]: np.array(row[1:11], float) for row in np.loadtxt(f"{sys.argv[1]}/{name}/{file}.csv", delimiter=",", skiprows=1, dtype=str)}
        for name, file in (("fifty", "fold_1_estimates"), ("float", "estimates")))
assert len(a) == len(b) == 56 and a.keys() == b.keys(), (sorted(a)[:3], sorted(b)[:3])
worst = max(np.abs(a[key] - b[key]).max() for key in a)
print("greatest difference between PyTorch and C++ on 56 excerpts:", worst)
assert worst < 1e-3
PY

# Heads that are fitted to the runtime's features in bytes: first the trunk in bytes, then the features, then the heads.
# The runtime's output with these heads is PyTorch's estimate from those features, except for the bytes of the latent
# layer.
quantised() {
  "$program" quantise-light "$1" --calibrate "$folder/more" --measure "$folder/set" --images 8 "${@:3}" -o "$2" || [[ $? == 1 ]]
}
quantised "$folder/trunk.npz" "$folder/trunk.light" >"$folder/trunk.log"
for part in set more; do
  "$program" light-features "$folder/trunk.light" "$folder/$part" --mirror -o "$folder/$part.npy" >/dev/null
done
fitted() {
  "$python" "$train" "$folder/set" --views "$folder/more" --weights "$folder/trunk.npz" --features "$folder/set.npy" \
    "$folder/more.npy" --copies 2 --epochs 0 --cpu -o "$folder/fitted" "$@"
}
fitted --test-fold 1 --export "$folder/fitted.npz" >"$folder/fitted.log"
quantised "$folder/fitted.npz" "$folder/fitted.light" --keep-float >>"$folder/trunk.log"
"$program" inspect "$folder/trunk.light" | grep -q "float copy   no"
"$program" inspect "$folder/fitted.light" | grep -q "float copy   yes"
"$program" light-features "$folder/fitted.light" "$folder/set" --mirror -o "$folder/again.npy" >/dev/null
cmp "$folder/set.npy" "$folder/again.npy"  # the heads do not change the trunk
"${program%/*}/sandglass_lab" verify lighting --panoramas "$folder/rooms/room_1.hdr" --manifest "$folder/groups.csv" --samples 0 \
  --network "$folder/fitted.light" --out "$folder/bytes" >"$folder/bytes.log" || [[ $? == 1 ]]
grep -q "camera turns by 90 deg" "$folder/bytes.log"
"$python" - "$folder" <<'PY'
import json, sys
import numpy as np
folder = sys.argv[1]
import light_data
import light_ridge
a, b = (np.loadtxt(f"{folder}/{file}.csv", delimiter=",", skiprows=1, usecols=range(1, 11))
        for file in ("fitted/fold_1_estimates", "bytes/estimates"))
print("greatest difference between heads in float and in bytes:", np.abs(a - b).max())
assert a.shape == b.shape == (8, 10) and np.abs(a - b).max() < 0.05, np.abs(a - b).max()
assert all(r in light_ridge.RIDGES for r in json.load(open(f"{folder}/fitted/fold_1.json"))["ridges"])
# The closed form: with a very weak ridge the labels of a linear law come back, with a strong one their mean.
random = np.random.default_rng(3)
features = random.normal(size=(400, 6)) * [1, 2, 3, 1, 2, 3] + 5
logits = 0.1 * (features - 5) @ random.normal(size=(6, 10))
labels = np.concatenate([2 * logits[:, :3], 1 / (1 + np.exp(-logits[:, 3:]))], 1)
regression = light_ridge.Regression(features, labels, np.ones(400))
found = regression.answer + (features - regression.mean) @ regression.slopes((1e-9,) * 4)
assert np.allclose(found, logits, atol=1e-6)
assert np.abs(regression.slopes((1e9,) * 4)).max() < 1e-6
# Other folds choose the ridge. A law that they share gives the weakest ridge, labels without any law the strongest.
folds, weights, judged = np.arange(400) % 4, np.ones(400), np.ones(400, bool)
def chosen_ridges(*arguments):
    return light_ridge.best_ridges(light_ridge.ridge_errors(*arguments))
assert chosen_ridges(features, labels, weights, folds, judged)[1:] == (light_ridge.RIDGES[0],) * 3
noise = random.normal(size=(400, 150))
assert min(chosen_ridges(noise, labels, weights, folds, judged)[1:]) >= 10
assert chosen_ridges(features, labels, weights, folds * 0, judged) == light_ridge.USUAL_RIDGES
# Sets of features to choose from: one is noise, one is the labels, and one has the labels of the tested place alone.
rows = light_data.Rows([folder + "/set"], [folder + "/more"])
at = 0
for name in ("set", "more"):
    count = rows.folder.count(f"{folder}/{name}")
    labels = np.concatenate([[light_data.label_of(rows, i, copy, 1) for i in range(at, at + count)] for copy in (0, 1)])
    tested = np.tile(rows.fold[at:at + count] == 1, 2)
    nothing = random.normal(size=(2 * count, 1024)).astype(np.float32)
    for kind, told in (("nothing", tested & False), ("labels", tested | True), ("tested", tested)):
        made = nothing.copy()
        made[told, :10] = 100 * labels[told]
        np.save(f"{folder}/{kind}_{name}.npy", made)
    at += count
PY
# The training folds choose, in any order of the sets. The tested place has no influence.
"$python" - "$folder" >"$folder/between.log" <<'PY'
import json, sys
folder = sys.argv[1]
import train
for one, other in (("nothing", "labels"), ("labels", "nothing"), ("nothing", "tested")):
    files = [[f"{folder}/{kind}_{name}.npy" for name in ("set", "more")] for kind in (one, other)]
    sys.argv = ["train.py", folder + "/set", "--views", folder + "/more", "--copies", "2", "--epochs", "0", "--cpu", "--test-fold", "1",
                "-o", f"{folder}/between_{one}_{other}", "--features", *files[0], "--or-features", *files[1]]
    assert train.main() == 0
late, early, blind = (json.load(open(f"{folder}/between_{name}/fold_1.json"))
                      for name in ("nothing_labels", "labels_nothing", "nothing_tested"))
assert (late["features"], early["features"]) == (1, 0) and late["network"] == early["network"], (late, early)
assert late["inner"] == early["inner"][::-1] and late["inner"][1][0] < late["inner"][0][0]
assert blind["inner"][0] == blind["inner"][1] == late["inner"][0] and blind["features"] == 0, blind["inner"]
PY

"$python" -c "import numpy, sys; numpy.savez(sys.argv[1], a=numpy.zeros(3))" "$folder/odd.npz"
refused() {  # it must fail with one sentence that contains the words
  local words=$1 output
  shift
  if output=$("$python" "$train" "$@" 2>&1); then echo "not refused: $*"; exit 1; fi
  [[ $(wc -l <<<"$output") == 1 && $output == *"$words"* ]] || { echo "unexpected refusal: $output"; exit 1; }
}
refused "no data set is named" -o "$folder/x"
refused "no manifest.csv" "$folder/rooms" -o "$folder/x"
refused "choose another fold" "$folder/set" --test-fold 7 -o "$folder/x"
refused "no file" "$folder/set" --weights "$folder/none.npz" -o "$folder/x"
refused "files of features for" "$folder/set" -o "$folder/x" --epochs 0 --features "$folder/set.npy" "$folder/more.npy"
refused "make it again from" "$folder/set" --features "$folder/set.npy" -o "$folder/x" --epochs 0 --copies 1
refused "no file of features" "$folder/set" --features "$folder/none.npy" -o "$folder/x" --epochs 0
refused "give --epochs 0" "$folder/set" --features "$folder/set.npy" -o "$folder/x"
refused "beside --initial" "$folder/set" --lanes -o "$folder/x" --epochs 0
refused "only tests a choice" "$folder/set" --or-features "$folder/set.npy" -o "$folder/x" --epochs 0
cp -r "$folder/set" "$folder/two_folds" && sed -i 's/,c,3,/,c,2,/' "$folder/two_folds/manifest.csv"
refused "fewer than two" "$folder/two_folds" --features "$folder/nothing_set.npy" --or-features "$folder/labels_set.npy" \
  -o "$folder/x" --copies 2 --epochs 0 --cpu
"$python" -c "import numpy, sys; numpy.savez(sys.argv[2], **{**numpy.load(sys.argv[1]), 'lanes': numpy.zeros(3)})" \
  "$folder/lanes.npz" "$folder/odd_lanes.npz"
refused "array lanes" "$folder/set" --weights "$folder/odd_lanes.npz" -o "$folder/x" --epochs 0
refused "no array" "$folder/set" --weights "$folder/odd.npz" -o "$folder/x"
head -c 5000 "$folder/trunk.npz" >"$folder/cut.npz"
refused "no file of weights" "$folder/set" --weights "$folder/cut.npz" -o "$folder/x"
for option in batch copies epochs rate threads seed dropout decay; do
  for value in nan -1 x; do refused "--$option" "$folder/set" -o "$folder/x" "--$option" $value; done
done
for option in batch copies rate threads; do refused "--$option" "$folder/set" -o "$folder/x" "--$option" 0; done
refused "--layers" "$folder/set" -o "$folder/x" --layers some
refused "cannot be made" "$folder/set" -o "$folder/odd.npz/x"
[[ ! -e $folder/x/fold_1.json ]]
bad() {  # runs on a copy of the data set that a command has changed
  rm -rf "$folder/bad" && cp -r "$folder/set" "$folder/bad"
  (cd "$folder/bad" && eval "$2")
  refused "$1" "$folder/bad" -o "$folder/x" --copies 1 --epochs 0 --cpu
}
bad "line 2 of" "sed -i 's/,contrast,/,kontrast,/' manifest.csv"
bad "no image" "sed -i '1s/image/picture/' manifest.csv"
bad "line 3 of" "sed -i '3s/,[^,]*,[^,]*\$//' manifest.csv"
bad "words" "sed -i '3s/,1,/,one,/' manifest.csv"
bad "no light" "sed -i '4s/,[^,]*,\([^,]*\)\$/,nan,\1/' manifest.csv"
bad "room_1_2.png' of the manifest cannot be read" "rm images/room_1_2.png"
bad "room_1_2.png' is no image" "echo nothing >images/room_1_2.png"
bad "room_1_2.png' is no image" "head -c 300 ../set/images/room_1_2.png >images/room_1_2.png"
for content in nothing "$(printf 'PK\003\004')" ""; do
  printf '%s' "$content" >"$folder/broken/fold_1.checkpoint"
  if output=$(run "$folder/broken" --resume 2>&1); then echo "a damaged checkpoint is read"; exit 1; fi
  [[ $(tail -1 <<<"$output") == *"fold_1.checkpoint' is damaged"* && $output != *Traceback* ]] || { echo "$output"; exit 1; }
done
