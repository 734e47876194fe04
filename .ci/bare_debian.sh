#!/bin/bash
# Runs a command in a fresh clone, inside a bare Debian 12 with only the
# packages of debootstrap's smallest variant. Needs root and debootstrap.
#
#   .ci/bare_debian.sh [FOLDER [COMMAND...]]     default: ./kinegraph test
#
# FOLDER (default: a temporary folder) receives the root file system and is
# removed at the end, or kept with KEEP=1; it must be empty or not exist. The
# proxy is taken from this machine's apt and environment; so is apt's mirror, if
# it has Debian 12 (otherwise deb.debian.org). Uncommitted changes are not
# included.
set -euo pipefail
project=$(cd -P "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)

fail() {
  printf 'bare_debian: error: %s\n' "$*" >&2
  exit 1
}

((EUID == 0)) || fail "must run as root"
command -v debootstrap >/dev/null || fail "debootstrap is not installed"

# A path with a space, which scripts easily mishandle.
readonly inside="/root/a clone"

# In a separate mount namespace, so that no mount outlives this script.
if [[ ${1:-} == --in-namespace ]]; then
  root=$2
  shift 2
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  environment=(PATH=/usr/bin:/bin HOME=/root)
  for name in http_proxy https_proxy no_proxy; do
    if [[ -n ${!name:-} ]]; then environment+=("$name=${!name}"); fi
  done
  # shellcheck disable=SC2016  # expanded by the inner shell
  exec chroot "$root" /usr/bin/env -i "${environment[@]}" \
    /bin/bash -c 'cd "$1" && shift && exec "$@"' bash "$inside" "$@" </dev/null
fi

folder=${1:-$(mktemp -d)}
shift $(($# > 0 ? 1 : 0))
(($# > 0)) || set -- ./kinegraph test
mkdir -p "$folder"
folder=$(cd -P "$folder" && pwd)
[[ -z $(ls -A "$folder") ]] || fail "$folder is not empty"
if [[ -z ${KEEP:-} ]]; then trap 'rm -rf --one-file-system "$folder"' EXIT; fi

# shellcheck disable=SC2016  # apt expands it
mirror=$(apt-get indextargets --format '$(CODENAME) $(REPO_URI)' \
  'Created-By: Packages' | awk '$1 == "bookworm" { print $2; exit }')
mirror=${mirror:-http://deb.debian.org/debian}
echo "bare_debian: debootstrap from $mirror into $folder"
debootstrap --variant=minbase bookworm "$folder" "$mirror" \
  >"$folder.log" 2>&1 || {
  tail -20 "$folder.log" >&2
  fail "debootstrap failed, see $folder.log"
}
rm -f "$folder.log"
apt-config dump | grep -E '^Acquire::(https?::Proxy|Check-Valid-Until|Check-Date) ' \
  >"$folder/etc/apt/apt.conf.d/90host" || true
cp /etc/resolv.conf "$folder/etc/resolv.conf"

git clone -q --no-hardlinks "$project" "$folder$inside"
echo "bare_debian: $* (commit $(git -C "$project" rev-parse --short HEAD))"
start=$SECONDS
outcome=0
unshare --mount "$project/.ci/bare_debian.sh" --in-namespace "$folder" "$@" ||
  outcome=$?
echo "bare_debian: exit $outcome after $((SECONDS - start)) s"
exit "$outcome"
