#!/usr/bin/env bash
# Builds the Debian packages of the sources in SOURCE into OUTPUT: build.sh SOURCE OUTPUT. The time stamps are those of the last
# commit, so that equal sources give equal packages. POWBENCH_BUILD: a build of these sources that goes in as it is.
set -euo pipefail
source=$(realpath "$1")
mkdir -p "$2"
output=$(realpath "$2")
cd "$source"
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH-$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CHANGELOG.md)}
export SOURCE_DATE_EPOCH
rm -f "$output"/*.deb
# what debhelper leaves beside its own files; the build itself stays in build/debian
leave_nothing() { rm -rf debian/tmp debian/.debhelper debian/files debian/*.substvars debian/*.debhelper* debian/debhelper-build-stamp \
  debian/powbench debian/python3-powbench debian/powbench-firmware debian/powbench-doc debian/libpowbench-dev; }
trap leave_nothing EXIT
export POWBENCH_PACKAGES=$output
# that build knows no debug information to put into packages of its own
if [[ -n ${POWBENCH_BUILD-} ]]; then export DEB_BUILD_OPTIONS="${DEB_BUILD_OPTIONS-} noautodbgsym"; fi
dpkg-buildpackage --build=binary --no-sign --no-pre-clean --buildinfo-option=-u"$output" \
  --buildinfo-file="$output/powbench.buildinfo" --changes-option=-u"$output" --changes-file="$output/powbench.changes"
