#!/usr/bin/env bash
# float_network.sh PROGRAM EXCERPT_PIXELS SOURCE_DIR [XNNPACK_TESTS]: rebuilds the float network from which the shipped
# bytes were made. PyTorch's features of the pretrained network must be its reference outputs, its estimates for the
# excerpts those of the table beside them, and so must those of the runtime, with XNNPACK in float on a file that has the
# network. Exit code 77: there is no data folder with the pretrained weights, no PyTorch, or another one.
set -euo pipefail
program=$1 pixels=$2 models=$3/models/lighting
pretrained=${SANDGLASS_DATA_DIR:-}/pretrained
[[ -f $pretrained/densenet121_imagenet_keras_fp32.npz ]] || { echo "no '$pretrained': skipped"; exit 77; }
. "$(dirname "${BASH_SOURCE[0]}")/find_python.sh"
export PYTHONPATH=$models PYTHONDONTWRITEBYTECODE=1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$python" "$models/float_network.py" weights "$pretrained/densenet121_imagenet_keras_fp32.npz" "$folder/weights.npz"
"$pixels" "$models"/excerpts/*.jpg >"$folder/pixels"
"$python" "$models/float_network.py" estimates "$folder/weights.npz" "$folder/pixels" "$folder/estimates.csv"
"$python" - "$folder/estimates.csv" "$models/excerpts/estimates.csv" "$pretrained" <<'PY'
import sys
import numpy as np
import light_network
import quantise
found, kept = (np.loadtxt(path, delimiter=",", skiprows=1, dtype=str) for path in sys.argv[1:3])
assert found.shape == kept.shape == (56, 12) and (found[:, :2] == kept[:, :2]).all(), "other images"
worst = np.abs(found[:, 2:].astype(float) - kept[:, 2:].astype(float)).max()
print("greatest difference between this PyTorch and the table:", worst)
assert worst < 1e-5, worst
net, reference = light_network.LightNet(), np.load(sys.argv[3] + "/densenet121_reference_outputs.npz")
net.load(sys.argv[3] + "/densenet121_imagenet_keras_fp32.npz")
net.eval().requires_grad_(False)
for name in ("bird", "parrot", "cat"):
    off = np.abs(quantise.features_of(net, reference[name + "/rgb_u8"]) - reference[name + "/feat1024"]).max()
    print(f"{name}: features off by {off:.2g}")
    assert off < 1e-3
PY
[[ $# == 4 ]] || exit 0
for seed in 1 2; do "$program" room --seed $seed --width 64 --samples 4 -o "$folder/rooms_$seed.hdr" >/dev/null; done
"$program" dataset "$folder" -o "$folder/set" >/dev/null
# So few images calibrate badly; but the float network beside the bytes is whole.
"$python" "$models/quantise.py" "$folder/weights.npz" --calibrate "$folder/set" --images 8 --keep-float --program "$program" \
  -o "$folder/float.light" || [[ $? == 1 ]]
SANDGLASS_FLOAT_NETWORK=$folder/float.light "$4" --gtest_filter=Xnnpack.InFloatIsPyTorchs | tee "$folder/log"
grep -q "PASSED.* 1 test" "$folder/log"
! grep -q SKIPPED "$folder/log"
