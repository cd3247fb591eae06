#!/usr/bin/env bash
# float_network.sh NETWORK_TESTS EXCERPT_PIXELS SOURCE_DIR [XNNPACK_TESTS]: rebuilds the float network from which the
# shipped bytes were made. Its outputs for the excerpts must be those of the table beside them: by PyTorch, by the plain
# float network in C++, and by the runtime, with XNNPACK in float on a file that has the network. Exit code 77: there is
# no data folder with the pretrained weights, no PyTorch, or another one.
set -euo pipefail
tests=$1 pixels=$2 models=$3/models/lighting
pretrained=${SANDGLASS_DATA_DIR:-}/pretrained/densenet121_imagenet_keras_fp32.npz
[[ -f $pretrained ]] || { echo "no '$pretrained': skipped"; exit 77; }
. "$(dirname "${BASH_SOURCE[0]}")/find_python.sh"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$python" "$models/float_network.py" weights "$pretrained" "$folder/weights.npz"
"$pixels" "$models"/excerpts/*.jpg >"$folder/pixels"
"$python" "$models/float_network.py" estimates "$folder/weights.npz" "$folder/pixels" "$folder/estimates.csv"
"$python" - "$folder/estimates.csv" "$models/excerpts/estimates.csv" <<'PY'
import sys
import numpy as np
found, kept = (np.loadtxt(path, delimiter=",", skiprows=1, dtype=str) for path in sys.argv[1:])
assert found.shape == kept.shape == (56, 12) and (found[:, :2] == kept[:, :2]).all(), "other images"
worst = np.abs(found[:, 2:].astype(float) - kept[:, 2:].astype(float)).max()
print("greatest difference between this PyTorch and the table:", worst)
assert worst < 1e-5, worst
PY
says_so() {
  SANDGLASS_FLOAT_WEIGHTS=$folder/weights.npz "$1" --gtest_filter="$2" | tee "$folder/log"
  grep -q "PASSED.* 1 test" "$folder/log"
  ! grep -q SKIPPED "$folder/log"
}
says_so "$tests" Excerpts.TheFloatNetworkInCppIsPyTorchs
[[ $# == 3 ]] || says_so "$4" Xnnpack.InFloatIsPyTorchs
