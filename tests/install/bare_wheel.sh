#!/bin/bash
# The wheel in a bare Debian 12: debootstrap's smallest variant and python3-venv,
# no other package. pip installs it into an empty environment; demo, track and
# report run; then Python, with Debian's NumPy, gives what the command gave.
#
#   tests/install/bare_wheel.sh kinegraph-0.1.0-cp311-....whl FOLDER
#
# Needs root, debootstrap and a Debian mirror (DEBIAN_MIRROR). FOLDER becomes the
# root; one that is there is used again. Prints how long each step took.
set -euo pipefail

wheel=$(readlink -f "$1")
root=$(readlink -f "$2")
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
log=$root.log
: >"$log"

step() {  # TITLE COMMAND...
  local title=$1 begin=$SECONDS
  shift
  if ! "$@" >>"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "bare_wheel: error: $title failed; its last words are above" >&2
    exit 1
  fi
  printf '%4d s  %s\n' $((SECONDS - begin)) "$title"
}
inside() {
  chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
    LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive bash -ec "cd /root/try; $1"
}

if [[ ! -x $root/usr/bin/apt-get ]]; then
  step "a bare Debian 12 with python3-venv" debootstrap --variant=minbase \
    --include=python3-venv bookworm "$root" "$mirror"
fi
mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
trap 'umount "$root/proc"' EXIT
cp /etc/resolv.conf "$root/etc/resolv.conf"
rm -rf "$root/root/try"
mkdir "$root/root/try"
cp "$wheel" "$root/root/try"

step "pip install kinegraph-*.whl, nothing else" inside \
  "python3 -m venv venv
   venv/bin/pip install --no-index --no-deps kinegraph-*.whl"
step "every library is found" inside \
  "! ldd venv/lib/python3*/site-packages/kinegraph/bin/kinegraph-* \
       venv/lib/python3*/site-packages/kinegraph/_kinegraph*.so |
     grep 'not found'"
step "kinegraph --version, man page" inside \
  "venv/bin/kinegraph --version | grep -q '^kinegraph [0-9]'
   test -s venv/share/man/man1/kinegraph-track.1"
step "kinegraph demo" inside "venv/bin/kinegraph demo && test -s out/demo/page.html"
step "kinegraph init, track, report" inside \
  "what='--cameras=out/demo/cameras.json --detections=out/demo/detections.jsonl'
   venv/bin/kinegraph init \$what --out=my.toml
   venv/bin/kinegraph track \$what --set=output.observations=false --out=command.jsonl
   venv/bin/kinegraph report --tracks=command.jsonl \$what --out=page.html"
step "NumPy, and another glog and OpenMP, from Debian" inside \
  "apt-get -q update
   apt-get -q -y install --no-install-recommends python3-numpy libgoogle-glog0v6 libgomp1"
step "import kinegraph gives what the command gave" inside \
  "python3 -m venv --system-site-packages with_numpy
   with_numpy/bin/pip install --no-index kinegraph-*.whl
   with_numpy/bin/python -c 'import kinegraph as kg
kg.write_tracks(\"module.jsonl\",
                kg.track(kg.read_cameras(\"out/demo/cameras.json\"),
                         kg.read_detections(\"out/demo/detections.jsonl\")))'
   cmp <(tail -n +2 module.jsonl) <(tail -n +2 command.jsonl)"
step "beside a glog and an OpenMP that are there for everybody" inside \
  "with_numpy/bin/python -c 'import ctypes
for name in (\"libgomp.so.1\", \"libglog.so.1\"):
    ctypes.CDLL(name, mode=ctypes.RTLD_GLOBAL)
import kinegraph as kg
kg.write_tracks(\"beside.jsonl\",
                kg.track(kg.read_cameras(\"out/demo/cameras.json\"),
                         kg.read_detections(\"out/demo/detections.jsonl\")))'
   cmp beside.jsonl module.jsonl"
