# Functions of bare_root.sh and bare_wheel.sh: `bare FOLDER [PACKAGES]` makes
# FOLDER the root file system of a bare Debian 12 (debootstrap's smallest
# variant and PACKAGES), or reuses it; `step` runs a command and prints how long
# it took; `inside` runs a shell command in that file system.
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}

step() {  # TITLE COMMAND...
  local title=$1 begin=$SECONDS
  shift
  if ! "$@" >>"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "$(basename "$0" .sh): error: $title failed; its last output is above" >&2
    exit 1
  fi
  printf '%4d s  %s\n' $((SECONDS - begin)) "$title"
}

inside() {
  chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
    LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive bash -ec "$1"
}

bare() {  # FOLDER [PACKAGES]
  root=$(readlink -f "$1")
  log=$root.log
  : >"$log"
  if [[ ! -x $root/usr/bin/apt-get ]]; then
    step "a bare Debian 12${2:+ with $2}" debootstrap --variant=minbase \
      ${2:+--include=$2} bookworm "$root" "$mirror"
  fi
  mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
  trap 'umount "$root/proc"' EXIT
  cp /etc/resolv.conf "$root/etc/resolv.conf"
}
