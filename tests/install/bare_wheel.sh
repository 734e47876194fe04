#!/bin/bash
# Tests the wheel in a bare Debian 12: debootstrap's smallest variant and
# python3-venv, no other package. pip installs the wheel into an empty environment;
# demo, init, track and report run. Then, with Debian's NumPy, glog and OpenMP
# installed, the Python module gives the same tracks as the command.
#
#   tests/install/bare_wheel.sh kinegraph-0.1.0-cp311-....whl FOLDER
#
# Needs superuser rights, debootstrap and a Debian mirror (DEBIAN_MIRROR).
# FOLDER becomes the root file system; an existing one is reused. Prints how
# long each step took.
set -euo pipefail
. "$(dirname "$(readlink -f "$0")")/bare.sh"

wheel=$(readlink -f "$1")
bare "$2" python3-venv
rm -rf "$root/root/try"
mkdir "$root/root/try"
cp "$wheel" "$root/root/try"

try() { inside "cd /root/try; $1"; }

step "pip install kinegraph-*.whl, nothing else" try \
  "python3 -m venv venv
   venv/bin/pip install --no-index --no-deps kinegraph-*.whl"
step "every library is found" try \
  "! ldd venv/lib/python3*/site-packages/kinegraph/bin/kinegraph-* \
       venv/lib/python3*/site-packages/kinegraph/_kinegraph*.so |
     grep 'not found'"
step "kinegraph --version, man page" try \
  "venv/bin/kinegraph --version | grep -q '^kinegraph [0-9]'
   test -s venv/share/man/man1/kinegraph-track.1"
step "kinegraph demo" try "venv/bin/kinegraph demo && test -s out/demo/page.html"
step "kinegraph init, track, report" try \
  "what='--cameras=out/demo/cameras.json --detections=out/demo/detections.jsonl'
   venv/bin/kinegraph init \$what --out=my.toml
   venv/bin/kinegraph track \$what --set=output.observations=false --out=command.jsonl
   venv/bin/kinegraph report --tracks=command.jsonl \$what --out=page.html"
step "install Debian's NumPy, glog and OpenMP" try \
  "apt-get -q update
   apt-get -q -y install --no-install-recommends python3-numpy libgoogle-glog0v6 libgomp1"
step "import kinegraph gives the tracks of the command" try \
  "python3 -m venv --system-site-packages with_numpy
   with_numpy/bin/pip install --no-index kinegraph-*.whl
   with_numpy/bin/python -c 'import kinegraph as kg
kg.write_tracks(\"module.jsonl\",
                kg.track(kg.read_cameras(\"out/demo/cameras.json\"),
                         kg.read_detections(\"out/demo/detections.jsonl\")))'
   cmp <(tail -n +2 module.jsonl) <(tail -n +2 command.jsonl)"
step "the same with Debian's glog and OpenMP loaded globally" try \
  "with_numpy/bin/python -c 'import ctypes
for name in (\"libgomp.so.1\", \"libglog.so.1\"):
    ctypes.CDLL(name, mode=ctypes.RTLD_GLOBAL)
import kinegraph as kg
kg.write_tracks(\"beside.jsonl\",
                kg.track(kg.read_cameras(\"out/demo/cameras.json\"),
                         kg.read_detections(\"out/demo/detections.jsonl\")))'
   cmp beside.jsonl module.jsonl"
