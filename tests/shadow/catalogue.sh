#!/usr/bin/env bash
# The catalogue end to end in small: two objects and a file that is none, one bake killed in the middle.
#   catalogue.sh SNAKEFILE PROGRAM WORK_FOLDER
# Exit code 77: Snakemake is not installed.
set -euo pipefail
command -v snakemake >/dev/null || exit 77
snakefile=$1 program=$2 work=$3
rm -rf "$work" && mkdir -p "$work/meshes"
printf 'v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 3 2\n' >"$work/meshes/tetrahedron.obj"
printf 'v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 2 0\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >"$work/meshes/open cone.obj"
echo 'no mesh' >"$work/meshes/broken.obj"

bake() {
  snakemake -s "$snakefile" -d "$work" --cores 2 --nocolor --config meshes="$work/meshes" out="$work/out" program="$1" threads=1 \
    options="--size 16x1 --textures 1 --steps 200 --quantised-steps 50 --validation-lights 4"
}

# A program that dies in its first try at an object, as a machine that is switched off.
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
grep -q '^  broken: .*broken.obj' "$work/out/summary.txt" || { echo "the refusal does not say why"; exit 1; }

# Nothing is baked twice.
bake "$work/mortal" >"$work/second.log" 2>&1 || { cat "$work/second.log"; exit 1; }
grep -q 'Nothing to be done' "$work/second.log" || { cat "$work/second.log"; exit 1; }
