#!/usr/bin/env bash
# The npm package as its user gets it: packed, installed from the file into a new project, imported by its name, run.
# Where TypeScript is installed, the types are checked too, and must refuse what is wrong.
#   package.sh NPM_FOLDER WORK_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
command -v npm >/dev/null || { echo "npm is not installed"; exit 77; }
npm=$(cd "$1" && pwd) work=$2
rm -rf "$work" && mkdir -p "$work/app"
npm_quiet=(npm --offline --no-audit --no-fund --no-update-notifier --loglevel=error --cache "$work/cache")
file=$(cd "$work" && "${npm_quiet[@]}" pack "$npm" | tail -n 1)
python3 -B "$here/../../toolchains/release.py" "$work/release" 0.0.0 0 "npm=$npm" >/dev/null
diff <(tar -tzf "$work/$file" | sort) <(tar -tzf "$work"/release/*.tgz | sort) || { echo "a release packs other files than npm"; exit 1; }
cd "$work/app"
echo '{"name": "app", "version": "1.0.0", "private": true, "type": "module"}' >package.json
"${npm_quiet[@]}" install "../$file" >/dev/null
ls node_modules/sandglass
printf 'package %s bytes, module %s bytes, %s compressed\n' "$(stat -c %s "../$file")" "$(stat -c %s node_modules/sandglass/sandglass.wasm)" \
  "$(gzip -9 -c node_modules/sandglass/sandglass.wasm | wc -c)"
cp "$here/app.mts" app.mts
# The types are all that the sample has beyond JavaScript, and there are none.
cp app.mts app.mjs
node app.mjs
# A server may import every entry.
for entry in "" /inline /stage /worker /glsl /three /babylon; do echo "import \"sandglass$entry\";"; done | node --input-type=module
if command -v tsc >/dev/null; then
  check=(tsc --noEmit --strict --target es2022 --module node16 --moduleResolution node16 --lib es2022,dom)
  cp "$here"/{right,wrong}.mts .
  "${check[@]}" app.mts right.mts wrong.mts
  grep -v @ts-expect-error wrong.mts >unexpected.mts  # the control
  errors=$("${check[@]}" unexpected.mts | grep -c '^unexpected.mts.*error') || true
  [[ $errors == $(grep -c @ts-expect-error wrong.mts) ]] || { echo "the types refuse $errors lines"; exit 1; }
  # A stage is what its types say, and the page keeps to them.
  page=$here/../../models/page
  mkdir page
  cp "$npm"/*.{mjs,d.ts} page
  cp "$page"/*.mjs page
  for types in page/*.d.ts; do mv "$types" "${types%.ts}.mts"; done
  (cd "$page" && ls -- *.mjs) >page/own.txt
  cp "$here/types_test.mjs" .
  node types_test.mjs "$(dirname "$(realpath "$(command -v tsc)")")/../lib/typescript.js" "$PWD/page"
fi
