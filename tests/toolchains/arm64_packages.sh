#!/usr/bin/env bash
# The README of linux-arm64 must name what a build for ARM needs: every package for ARM in the tables of `sg`, and every
# package there whose file is a header that a CMakeLists requires. It must name no package that the tables do not have.
#   arm64_packages.sh SOURCE_FOLDER README
set -euo pipefail
source=$1 readme=$2
named=$(grep -oE '`apt install [^`]+`' "$readme" | tr -d '`' | sed 's/apt install//' | tr ' ' '\n' | sort -u)
tables=$(grep -E '^[a-z0-9+-]+[|][^|]+[|]' "$source/sg" | tr -d "'")
needed=$(sed -n "/^readonly packages_arm=/,/'\$/p" "$source/sg" | grep '|' | cut -d'|' -f1)
headers=$(grep -rhoE 'find_path\([A-Z0-9_]+ [A-Za-z0-9_./]+.* REQUIRED\)' --include=CMakeLists.txt "$source"/{models,runtime,tests} | awk '{print $2}' | sort -u)
[[ -n $needed && $(wc -l <<<"$headers") -ge 4 ]] || { echo "nothing was found to compare with"; exit 1; }
for header in $headers; do
  package=$(awk -F'|' -v end="/$header" 'substr($2, length($2) - length(end) + 1) == end {print $1}' <<<"$tables")
  [[ -n $package ]] || { echo "sg has no package for the header $header"; exit 1; }
  needed+=$'\n'$package
done
failed=0
for package in $needed; do
  grep -qxF "$package" <<<"$named" || { echo "the README leaves out $package"; failed=1; }
done
for package in $named; do
  cut -d'|' -f1 <<<"$tables" | grep -qxF "$package" || { echo "sg does not know $package"; failed=1; }
done
echo "$(wc -w <<<"$named") packages named, $(wc -w <<<"$needed") of them compared"
exit "$failed"
