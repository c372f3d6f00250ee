#!/usr/bin/env bash
# Writes VERSION into what states one, in the folder it is called in: set_version.sh VERSION DATE. DATE as 2026-11-30.
#   CMakeLists.txt     project(powbench VERSION ...)
#   CHANGELOG.md       '## VERSION (unreleased)' becomes '## VERSION (DATE)'; it must be the first section, and say something
#   debian/changelog   the entry at the top: closed where it is this version's, else a new one
# Refuses with one sentence, and changes nothing, where a file is not as described or VERSION is below the one stated.
set -euo pipefail
fail() {
  printf 'release: %s\n' "$*" >&2
  exit 1
}
version=${1-} date=${2-}
[[ $version =~ ^[0-9]+\.[0-9]+\.[0-9]+$ ]] || fail "'$version' is no version; three numbers are wanted, such as 0.2.0"
[[ $date =~ ^[0-9]{4}-[0-9]{2}-[0-9]{2}$ ]] || fail "'$date' is no date such as 2026-11-30"
stamp=$(LC_ALL=C date -u -R -d "$date 12:00" 2>/dev/null) || fail "'$date' is no day of the calendar"

now=$(sed -n 's/^project(powbench VERSION \([0-9.]*\) .*/\1/p' CMakeLists.txt)
[[ -n $now ]] || fail "CMakeLists.txt: no line 'project(powbench VERSION ...'"
[[ $(printf '%s\n' "$now" "$version" | sort -V | tail -n 1) == "$version" ]] ||
  fail "CMakeLists.txt states $now, and $version is below it"
[[ $(grep -m 1 '^## ' CHANGELOG.md) == "## $version (unreleased)" ]] ||
  fail "CHANGELOG.md: the first section is '$(grep -m 1 '^## ' CHANGELOG.md)'; '## $version (unreleased)' is wanted"
said=$(awk '/^## / { ++n; next } n == 1 && NF { print }' CHANGELOG.md)
[[ -n $said ]] || fail "CHANGELOG.md: the section of $version is empty"
read -r _ debian_version distribution _ <debian/changelog
[[ $debian_version =~ ^\(.*\)$ ]] || fail "debian/changelog: the first line names no version in brackets"
debian_version=${debian_version:1:-1}

sed -i "s/^project(powbench VERSION [0-9.]* /project(powbench VERSION $version /" CMakeLists.txt
sed -i "0,/^## $version (unreleased)$/s//## $version ($date)/" CHANGELOG.md
maintainer=$(sed -n 's/^ -- \(.*>\)  .*/\1/p' debian/changelog | head -n 1)
if [[ $debian_version == "$version" && $distribution == "UNRELEASED;" ]]; then
  sed -i -e '1s/UNRELEASED/bookworm/' -e "0,/^ -- /s|^ -- .*| -- $maintainer  $stamp|" debian/changelog
elif [[ $debian_version != "$version" ]]; then
  {
    printf 'powbench (%s) bookworm; urgency=medium\n\n  * See CHANGELOG.md.\n\n -- %s  %s\n\n' "$version" "$maintainer" "$stamp"
    cat debian/changelog
  } >debian/changelog.new
  mv debian/changelog.new debian/changelog
fi
