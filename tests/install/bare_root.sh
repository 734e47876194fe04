#!/bin/bash
# Tests the Debian package in a bare Debian 12: installs it, runs the demo,
# tracks a user's recording and writes its report, tracks from Python, and
# builds and runs the C++ examples.
#
#   tests/install/bare_root.sh kinegraph_0.1.0_amd64.deb FOLDER
#
# Needs superuser rights, debootstrap and a Debian mirror (DEBIAN_MIRROR).
# FOLDER becomes the root file system (about 2 GB); an existing one is reused.
# Prints how long each step took. The Dockerfile installs the package in the
# same way.
set -euo pipefail
. "$(dirname "$(readlink -f "$0")")/bare.sh"

deb=$(readlink -f "$1")
bare "$2"
cp "$deb" "$root/root/kinegraph.deb"

step "package lists" inside "apt-get -q update"
step "apt-get install ./kinegraph.deb" inside \
  "apt-get -q -y install --no-install-recommends /root/kinegraph.deb python3-numpy"
step "kinegraph --version, man page, completion" inside \
  "kinegraph --version | grep -q '^kinegraph [0-9]'
   dpkg -L kinegraph | grep -q man1/kinegraph-track.1
   bash -c '. /usr/share/bash-completion/completions/kinegraph; complete -p kinegraph'"
step "kinegraph demo" inside \
  "rm -rf /root/try && mkdir /root/try && cd /root/try && kinegraph demo
   test -s out/demo/page.html"
step "a user's recording: init, track, report" inside \
  "cd /root/try && kinegraph synthesize --config=configs/synthetic/demo.toml \
     --set='scene.skeleton=halpe26;scene.duration=5' --format=mmpose --out=own
   what='--cameras=own/cameras.json --detections=own/detections_mmpose'
   kinegraph init \$what --frame_rate=25 --out=own/my.toml
   kinegraph track \$what --config=own/my.toml --out=own/take.jsonl
   kinegraph report --tracks=own/take.jsonl \$what --config=own/my.toml --out=own/take.html
   test -s own/take.html"
step "tracks from Python" inside \
  "cd /root/try && kinegraph synthesize --config=configs/synthetic/demo.toml \
     --set=scene.duration=4 --out=take
   python3 -c 'import kinegraph as kg
tracks = kg.track(kg.read_cameras(\"take/cameras.json\"),
                  kg.read_detections(\"take/detections.jsonl\"))
assert len(tracks.ids) > 0, tracks
kg.write_tracks(\"tracks.jsonl\", tracks)'
   kinegraph kinematics --tracks=tracks.jsonl --out=angles.csv
   kinegraph track --cameras=take/cameras.json --detections=take/detections.jsonl \
     --set=output.observations=false --out=command.jsonl
   cmp <(tail -n +2 tracks.jsonl) <(tail -n +2 command.jsonl)"
step "g++, cmake and the libraries' headers" inside \
  "apt-get -q -y install --no-install-recommends \$(dpkg-query -W -f='\${Suggests}' kinegraph | tr -d ,)"
step "build the examples" inside \
  "cd /root/try && cmake -S /usr/share/doc/kinegraph/examples -B examples \
     -DCMAKE_BUILD_TYPE=Release
   cmake --build examples --parallel 2"
step "run the examples" inside \
  "cd /root/try && examples/track_take take/cameras.json take/detections.jsonl own.jsonl
   test -s own.jsonl && examples/own_factor && examples/covariance"
