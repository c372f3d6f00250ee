#!/usr/bin/env bash
# The documentation as a site that needs no network: site.sh REFERENCE_FOLDER OUTPUT_FOLDER. REFERENCE_FOLDER is what `powbench
# manual` wrote. Every link that leads nowhere ends it with an error.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
reference=$(realpath "$1")
mkdir -p "$2"
out=$(realpath "$2")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/docs"
cp -r docs/. "$work/docs/"
cp README.md "$work/docs/index.md"
cp CONTRIBUTING.md CHANGELOG.md LICENSE "$work/docs/"
mkdir -p "$work/docs/reference"
cp "$reference"/*.md "$work/docs/reference/"
/usr/bin/python3 -B packaging/site_pages.py "$work/docs"
{
  sed "s#@PROJECT@#$PWD#" packaging/mkdocs.yml
  printf 'docs_dir: %s\nsite_dir: %s\n' "$work/docs" "$out"
} >"$work/mkdocs.yml"
mkdocs build --quiet --strict --clean --config-file "$work/mkdocs.yml"
# what differs from one build to the next: times in the map of the site
rm -f "$out/sitemap.xml" "$out/sitemap.xml.gz"
/usr/bin/python3 -B packaging/check_site.py "$out"
