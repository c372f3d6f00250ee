#!/usr/bin/env bash
# Builds the packages once more from a copy of the sources in another folder, without the compiler's cache, and compares them with
# those in FOLDER, byte for byte: reproduce.sh FOLDER. Closes with `N passed, N failed`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
first=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
git clone --quiet . "$work/another-folder"
CCACHE_DISABLE=1 bash packaging/build.sh "$work/another-folder" "$work/packages"
passed=0
failed=0
for package in "$first"/*.deb; do
  name=$(basename "$package")
  if cmp -s "$package" "$work/packages/$name"; then
    passed=$((passed + 1))
  else
    failed=$((failed + 1))
    printf 'failed: %s differs\n' "$name"
  fi
done
printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0 && passed > 0))
