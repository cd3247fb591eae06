#!/usr/bin/env bash
# install.sh BUILD FOLDER: everything that is installed lies below the prefix, and the program's files are there too.
set -euo pipefail
build=$1 folder=$2 prefix=/opt/sandglass
rm -rf "$folder"
DESTDIR=$folder cmake --install "$build" --prefix "$prefix" >/dev/null
outside=$(find "$folder" -not -type d -not -path "$folder$prefix/*")
[[ -z $outside ]] || { printf 'installed outside the prefix:\n%s\n' "$outside"; exit 1; }
for file in bin/sandglass include/sandglass/sandglass.h share/sandglass/scenes/demo.json; do
  [[ -e $folder$prefix/$file ]] || { echo "not installed: $file"; exit 1; }
done
