#!/usr/bin/env bash
# Tries the packages in FOLDER: test.sh FOLDER. lintian; then a fresh Debian 12 installs them and runs the tests of debian/tests. Needs
# root, mounts and the package registry; with POWBENCH_WHERE_POSSIBLE a machine without them is said and no failure. Closes with
# `N passed, N failed`.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit
packages=$(realpath "$1")
passed=0
failed=0
verdict() {
  local name=$1 status=$2
  if ((status)); then
    failed=$((failed + 1))
    printf 'failed: %s\n' "$name"
  else
    passed=$((passed + 1))
    printf 'passed: %s\n' "$name"
  fi
}

lintian --fail-on error,warning --suppress-tags initial-upload-closes-no-bugs "$packages"/*.deb
verdict lintian $?

root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
# A fresh Debian that cannot be made says nothing of the packages.
no_debian() {
  [[ -n ${POWBENCH_WHERE_POSSIBLE-} ]] || verdict 'a fresh Debian 12' 1
  printf 'no fresh Debian 12 can be made on this machine (%s), so the installation was not tried\n' "$1"
  printf '%d passed, %d failed\n' "$passed" "$failed"
  exit $((failed > 0))
}
# POWBENCH_ROOT_TAR: a tar of such a root that is there already
made=0
if [[ -n ${POWBENCH_ROOT_TAR-} ]]; then
  tar -C "$root" -xf "$POWBENCH_ROOT_TAR" || made=$?
else
  mmdebstrap --quiet --variant=minbase bookworm "$root" || made=$?
fi
((made == 0)) || no_debian 'no root system'
mkdir -p "$root/packages" "$root/tests"
cp "$packages"/*.deb "$root/packages/"
cp debian/tests/* "$root/tests/"
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 "$@"; }
mount --bind /proc "$root/proc" || no_debian 'no mounts'
trap 'umount "$root/proc"; rm -rf "$root"' EXIT
inside apt-get -q update >"$packages/install.log" 2>&1 || no_debian 'no package lists'
verdict 'a fresh Debian 12' 0
start=$SECONDS
inside sh -c 'apt-get -q -y --no-install-recommends install /packages/*.deb' >>"$packages/install.log" 2>&1
verdict 'installation' $?
inside sh /tests/demo
verdict demo $?
printf 'from the installation to the first report: %d s\n' $((SECONDS - start))
inside sh /tests/python
verdict python $?
inside sh -c 'apt-get -q -y --no-install-recommends install cmake g++ make' >>"$packages/install.log" 2>&1 && inside sh /tests/library
verdict library $?
inside sh -c 'test -s /usr/share/doc/powbench-doc/html/index.html && bash -n /usr/share/bash-completion/completions/powbench' 
verdict 'documentation and completion' $?
inside sh -c 'apt-get -q -y purge "powbench*" "python3-powbench" libpowbench-dev' >>"$packages/install.log" 2>&1 &&
  ! inside sh -c 'ls /usr/bin/powbench /usr/lib/powbench /usr/share/powbench' 2>/dev/null
verdict 'removal leaves nothing' $?
printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0))
