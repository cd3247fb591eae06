#!/usr/bin/env bash
# release.py and site.py, of what is at hand: release.sh SOURCE PREFIX OUTPUT_FOLDER
set -euo pipefail
source=$1 prefix=$2 output=$3
rm -rf "$output"
mkdir -p "$output/page/reference"
release() { python3 -B "$source/toolchains/release.py" "$@"; }

echo "<p>live</p>" >"$output/page/live.html"
for page in index scene_8h bodies_8h skin_8h room_8h shadow_8h cast_8h; do echo "$page" >"$output/page/reference/$page.html"; done
python3 -B "$source/toolchains/docs/site.py" "$source" "$output/page/live.html" "$output/page/reference" "$output/site"
for link in $(grep -ohE '(href|src)="[^"]*"' "$output"/site/*.html | cut -d'"' -f2 | sort -u); do
  [[ -e $output/site/$link ]] || { echo "the site links to $link, which is not there"; exit 1; }
done

release "$output/one" 1.2.3 1700000000 linux="$prefix" site="$output/site"
find "$prefix" "$output/site" -type f -exec touch {} +  # other times, other order: the same bytes
release "$output/two" 1.2.3 1700000000 linux="$prefix" site="$output/site" >/dev/null
diff -r "$output/one" "$output/two"
(cd "$output/one" && sha256sum --check --quiet SHA256SUMS && [[ $(wc -l <SHA256SUMS) == $(($(ls | wc -l) - 1)) ]])
tar -tzf "$output/one/sandglass-1.2.3-linux.tar.gz" | grep '^sandglass-1.2.3-linux/include/sandglass/sandglass.h$' >/dev/null
python3 - "$output/one" <<'PYTHON'
import hashlib, json, pathlib, sys
folder = pathlib.Path(sys.argv[1])
bill = json.loads((folder / "sandglass-1.2.3.spdx.json").read_text())
known = {"SPDXRef-DOCUMENT"} | {x["SPDXID"] for x in bill["packages"] + bill["files"]}
for relation in bill["relationships"]:
    assert relation["spdxElementId"] in known and relation["relatedSpdxElement"] in known, relation
assert len(bill["files"]) == 2
for file in bill["files"]:
    assert file["checksums"][0]["checksumValue"] == hashlib.sha256((folder / file["fileName"]).read_bytes()).hexdigest(), file
PYTHON

refused() { if release "${@:2}" 2>"$output/error"; then echo "accepted: ${*:2}"; exit 1; fi; grep -q "$1" "$output/error"; }
refused "build it first" "$output/three" 1.2.3 1700000000 npm="$output/nowhere"
refused "name a new folder" "$output/one" 1.2.3 1700000000 linux="$prefix"
mkdir "$output/npm"
echo '{"files": ["gone.mjs"]}' >"$output/npm/package.json"
refused "lacks" "$output/three" 1.2.3 1700000000 npm="$output/npm"
[[ ! -e $output/three ]]
