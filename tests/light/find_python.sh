# To be sourced. Sets `python` to a Python that has what the training script needs; without one the test is skipped with
# exit code 77.
export OMP_NUM_THREADS=1
python=
for candidate in python3 /usr/bin/python3; do
  if "$candidate" -c 'import torch, numpy, PIL' 2>/dev/null; then python=$candidate && break; fi
done
[[ -n $python ]] || { echo "no Python with torch, numpy and PIL: skipped"; exit 77; }
