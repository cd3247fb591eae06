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

# A program that dies in its first try at an object, like a machine that is switched off.
cat >"$work/mortal" <<MORTAL
#!/usr/bin/env bash
if [[ \$* == *tetrahedron* && -e "$work/mortality" ]]; then rm "$work/mortality"; kill -9 \$\$; fi
exec "$program" "\$@"
MORTAL
chmod +x "$work/mortal"

# bake LOG [OPTIONS]
bake() {
  snakemake -s "$snakefile" -d "$work" --cores 2 --nocolor --config meshes="$work/meshes" out="$work/out" program="$work/mortal" \
    threads=1 options="--quick --size 16 ${2:-}" >"$work/$1.log" 2>&1
}
holds() { grep -q "$1" "$2" || { cat "$work"/*.log "$2"; echo "no line has: $1"; exit 1; }; }

# Wrong options are not the fault of an object: the run fails, and no object counts as done.
! bake typo "--sizes 8" || { echo "a wrong option passed"; exit 1; }
[[ -z $(ls "$work"/out/*.json "$work"/out/summary.txt 2>/dev/null) ]] || { echo "a wrong option refused objects"; exit 1; }
holds sizes "$work/out/tetrahedron.log"

touch "$work/mortality"
bake first || { cat "$work/first.log"; exit 1; }
[[ ! -e $work/mortality ]] || { echo "nothing was killed"; exit 1; }
for name in tetrahedron "open cone"; do
  [[ -s $work/out/$name.shadow && -s $work/out/$name.shadow.png ]] || { echo "$name was not baked"; exit 1; }
  holds "^$name .* 4/4 " "$work/out/summary.txt"  # and how many lights its errors are of
done
holds '^2 baked, 1 refused$' "$work/out/summary.txt"
holds '^  broken: .*broken.obj' "$work/out/summary.txt"

# Nothing is baked twice. A missing shadow is baked again, to the same bytes.
bake second || { cat "$work/second.log"; exit 1; }
holds 'Nothing to be done' "$work/second.log"
mv "$work/out/tetrahedron.shadow" "$work/kept"
bake third || { cat "$work/third.log"; exit 1; }
cmp "$work/kept" "$work/out/tetrahedron.shadow" || { echo "the missing shadow was not baked again to the same bytes"; exit 1; }
