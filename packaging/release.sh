#!/usr/bin/env bash
# A release: release.sh VERSION [--dry-run]. Version, changelog, packages tried on a fresh Debian 12, site, sources, checksums, tag.
# All of it is made from a clone in build/release-VERSION/source. Only when everything has passed do the commit and the tag
# v<VERSION> come into this tree; with --dry-run they do not. What to publish lies in build/release-VERSION.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
fail() {
  printf 'release: %s\n' "$*" >&2
  exit 1
}
version=${1-} dry=${2-}
[[ -z $dry || $dry == --dry-run ]] || fail "unknown option $dry (known: --dry-run)"
[[ -z $(git status --porcelain) ]] || fail "the tree has changes that are not committed"
if git rev-parse -q --verify "refs/tags/v$version" >/dev/null; then fail "the tag v$version is there already"; fi
out=$PWD/build/release-$version
rm -rf "$out"
mkdir -p "$out"
git clone -q . "$out/source"
(
  cd "$out/source"
  bash packaging/set_version.sh "$version" "$(date -u +%F)"
  git add -A
  name=$(git -C ../../.. log -1 --format=%an) mail=$(git -C ../../.. log -1 --format=%ae)
  git -c user.name="$name" -c user.email="$mail" commit -q -m "Release $version" -m "Version, changelog and packages as published."
  git -c user.name="$name" -c user.email="$mail" tag -a "v$version" -m "powbench $version"
  ./dev package --test
  cp build/packages/*.deb "$out/"
  mkdir "$out/site"
  dpkg-deb --fsys-tarfile build/packages/powbench-doc_*.deb |
    tar -x -C "$out/site" --strip-components=6 ./usr/share/doc/powbench-doc/html
  git archive --format=tar.gz --prefix="powbench-$version/" -o "$out/powbench-$version.tar.gz" "v$version"
)
tar -C "$out" --sort=name --owner=0 --group=0 --numeric-owner -czf "$out/powbench-site-$version.tar.gz" site
(cd "$out" && sha256sum -- *.deb *.tar.gz | tee SHA256SUMS)
if [[ $dry ]]; then
  printf 'release: %s is in %s; the tree is as it was (--dry-run)\n' "$version" "${out#"$PWD/"}"
  exit
fi
git fetch -q "$out/source" "refs/tags/v$version:refs/tags/v$version"
git merge -q --ff-only "v$version"
printf 'release: %s is in %s, and tagged here. To publish: git push --follow-tags, and the files\n' "$version" "${out#"$PWD/"}"
