#!/usr/bin/env bash
# A small catalogue from end to end: two objects, a file that is no mesh, and one bake that is killed in the middle.
#   catalogue.sh SNAKEFILE PROGRAM WORK_FOLDER
# Exit code 77: Snakemake is not installed.
set -euo pipefail
command -v snakemake >/dev/null || exit 77
snakefile=$1 program=$2 work=$3
rm -rf "$work" && mkdir -p "$work/meshes"
printf 'v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 3 2\n' >"$work/meshes/tetrahedron.obj"
printf 'v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 2 0\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >"$work/meshes/open cone.obj"
echo 'no mesh' >"$work/meshes/broken.obj"

options="--ambient-texels 16 --size 16x1 --textures 1 --steps 200 --quantised-steps 50 --validation-lights 4"
bake() {
  snakemake -s "$snakefile" -d "$work" --cores 2 --nocolor --config meshes="$work/meshes" out="$work/${3:-out}" program="$1" \
    threads=1 options="${2:-$options}"
}

# A program that dies in its first try at an object, like a machine that is switched off.
cat >"$work/mortal" <<MORTAL
#!/usr/bin/env bash
if [[ \$* == *tetrahedron* && ! -e "$work/died" ]]; then touch "$work/died"; kill -9 \$\$; fi
exec "$program" "\$@"
MORTAL
chmod +x "$work/mortal"
bake "$work/mortal" >"$work/first.log" 2>&1 || { cat "$work/first.log"; exit 1; }
[[ -e $work/died ]] || { echo "nothing was killed"; exit 1; }
cat "$work/out/summary.txt"
for name in tetrahedron "open cone"; do
  [[ -s $work/out/$name.shadow && -s $work/out/$name.png ]] || { echo "$name was not baked"; exit 1; }
  grep -q "^$name" "$work/out/summary.txt" || { echo "$name is not in the table"; exit 1; }
done
grep -q '^2 baked, 1 refused$' "$work/out/summary.txt" || { echo "the counts are wrong"; exit 1; }
grep -q '^tetrahedron .* 4/4 ' "$work/out/summary.txt" || { echo "the table does not say how many lights it is of"; exit 1; }
grep -q '^  broken: .*broken.obj' "$work/out/summary.txt" || { echo "the refusal does not say why"; exit 1; }

# Nothing is baked twice.
bake "$work/mortal" >"$work/second.log" 2>&1 || { cat "$work/second.log"; exit 1; }
grep -q 'Nothing to be done' "$work/second.log" || { cat "$work/second.log"; exit 1; }

# A missing shadow is baked again, to the same bytes.
mv "$work/out/tetrahedron.shadow" "$work/kept"
bake "$program" >"$work/third.log" 2>&1 || { cat "$work/third.log"; exit 1; }
cmp "$work/kept" "$work/out/tetrahedron.shadow" || { echo "the missing shadow was not baked again to the same bytes"; exit 1; }

# Wrong options are not the fault of an object: the run fails, and no object counts as done.
! bake "$program" "$options --sizes 8x1" typo >"$work/typo.log" 2>&1 || { echo "a wrong option passed"; exit 1; }
[[ -z $(ls "$work"/typo/*.json "$work"/typo/summary.txt 2>/dev/null) ]] || { echo "a wrong option refused objects"; exit 1; }
grep -q 'sizes' "$work/typo/tetrahedron.log" || { cat "$work/typo.log"; echo "the log does not say why"; exit 1; }
bake "$program" "$options" typo >"$work/mended.log" 2>&1 || { cat "$work/mended.log"; exit 1; }
grep -q '^2 baked, 1 refused$' "$work/typo/summary.txt" || { echo "objects were lost to a wrong option"; exit 1; }

# Checkpoints that cannot be used: one of an interrupted bake with other options, and one that is damaged.
mkdir -p "$work/stale"
"$program" bake "$work/meshes/tetrahedron.obj" -o "$work/stale/tetrahedron.shadow" --threads 1 --size 16x1 --textures 1 --steps 100000000 \
  >"$work/interrupted.log" 2>&1 &
long=$!
for ((i = 0; i < 600; ++i)); do
  if grep -q training "$work/interrupted.log" 2>/dev/null; then break; fi
  sleep 0.1
done
kill -INT "$long" && ! wait "$long"
[[ -s $work/stale/tetrahedron.shadow.checkpoint ]] || { cat "$work/interrupted.log"; echo "there is no stale checkpoint"; exit 1; }
echo 'damaged' >"$work/stale/open cone.shadow.checkpoint"
bake "$program" "$options" stale >"$work/stale.log" 2>&1 || { cat "$work/stale.log"; exit 1; }
grep -q '^2 baked, 1 refused$' "$work/stale/summary.txt" || { cat "$work/stale/summary.txt"; echo "a checkpoint counted as a refusal"; exit 1; }
for name in tetrahedron "open cone"; do
  cmp "$work/out/$name.shadow" "$work/stale/$name.shadow" || { echo "$name: the checkpoint was not thrown away"; exit 1; }
  [[ ! -e $work/stale/$name.shadow.checkpoint ]] || { echo "$name: the checkpoint is still there"; exit 1; }
done
