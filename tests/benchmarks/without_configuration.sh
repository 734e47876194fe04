#!/bin/bash
# What `init` and `track` without --config reach on takes for which there are
# hand-made configurations, against those of an older, frozen commit:
#
#   tests/benchmarks/without_configuration.sh BASE_COMMANDS BASE_CONFIGS OUT
#
# BASE_COMMANDS holds the frozen commit's kinegraph-track and others, as
# BASE_CONFIGS its configurations; COMMANDS (default build/apps) those to try.
# Writes a line a take and way to OUT/table.txt and standard output.
set -euo pipefail

base=$1 configs=$2 out=$3
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
new=${COMMANDS:-$root/build/apps}
data=${KINEGRAPH_DATA:-$root/../shared/data}
told=""
mkdir -p "$out"
: >"$out/table.txt"

say() { printf '%s\n' "$*" | tee -a "$out/table.txt"; }

# What is compared: PCP's mean of actors, MPJPE, or the held-out error.
figures() { grep -m 1 -E '^(total|all|MPJPE, mm:)' "$1" || echo '?'; }

# NAME WAY COMMANDS CONFIG SET: tracks, scores by cameras left out, and with
# `score` (protocol and ground truth) against the truth.
try() {
  local name=$1 way=$2 commands=$3 config=$4 keys=$5
  local at=$out/$name.$way
  local what=(--cameras="$cameras" --detections="$detections" --config="$config")
  if [[ -n $keys ]]; then what+=(--set="$keys"); fi
  "$commands/kinegraph-track" "${what[@]}" --out="$at.jsonl" >"$at.track.txt" 2>&1
  local truth=""
  if ((${#score[@]})); then
    "$new/kinegraph-evaluate" --tracks="$at.jsonl" "${score[@]}" \
      --json="$at.truth.json" >"$at.truth.txt" 2>&1
  fi
  if [[ -n $reference ]]; then
    "$commands/kinegraph-evaluate" --protocol=held_out_camera "${what[@]}" \
      --reference="$reference" "${held_out_set[@]}" --json="$at.held.json" \
      >"$at.held.txt" 2>&1
  fi
  local file=$at.held.txt
  if [[ -e $at.truth.txt ]]; then file=$at.truth.txt; fi
  say "$name  $way  $(figures "$file")"
}

# NAME RATE [CONFIG]: asks `init` for a configuration; `told` is what neither
# file tells. With CONFIG what is scored
# by cameras left out is named by the frozen commit's paper mode, the same for
# everybody; without it there is a truth.
begin() {
  local name=$1 rate=$2 config=${3:-}
  reference=""
  "$new/kinegraph-init" --cameras="$cameras" --detections="$detections" \
    --frame_rate="$rate" ${told:+--set="$told"} --out="$out/$name.toml" \
    >"$out/$name.init.txt" 2>&1
  if [[ -z $config ]]; then return; fi
  "$base/kinegraph-track" --cameras="$cameras" --detections="$detections" \
    --config="$config" --mode=paper --set=output.observations=true \
    --out="$out/$name.reference.jsonl" >/dev/null 2>&1
  reference=$out/$name.reference.jsonl
}

shelf() {
  cameras=$data/shelf/calibration.json detections=$data/shelf/detections/openpose
  score=(--protocol=shelf --ground_truth="$data/shelf/tum/actorsGT.mat")
  held_out_set=()
  begin shelf 25
  try shelf base_window "$base" "$configs/graph/shelf.toml" ""
  try shelf new_default "$new" default.toml input.frame_rate=25
  try shelf base_offline "$base" "$configs/graph/offline.toml" ""
  try shelf new_init "$new" "$out/shelf.toml" ""
}

campus() {
  cameras=$data/campus/calibration.json
  detections=$data/campus/detections_modelled/typical
  score=(--protocol=campus --ground_truth="$data/campus/annotation_3d.json")
  held_out_set=()
  # Its calibration is for coordinates divided by the size of the image, and has
  # lens coefficients that do not fit.
  told="cameras.image_size=[360,288];cameras.ignore_distortion=true"
  begin campus 25
  try campus base_window "$base" "$configs/graph/campus.toml" ""
  try campus new_default "$new" default.toml "input.frame_rate=25;$told"
  try campus new_init "$new" "$out/campus.toml" ""
  told=""
}

pose2sim() {
  cameras=$data/pose2sim/calibration/Calib.toml score=() held_out_set=()
  for trial in single multi; do
    detections=$data/pose2sim/$trial/pose
    begin "pose2sim_$trial" 60 "$configs/paper/pose2sim.toml"
    try "pose2sim_$trial" base_paper "$base" "$configs/paper/pose2sim.toml" ""
    try "pose2sim_$trial" new_default "$new" default.toml input.frame_rate=60
    try "pose2sim_$trial" new_init "$new" "$out/pose2sim_$trial.toml" ""
  done
}

# One frame: the frozen files repeat it, the switch for single frames is newer.
panoptic() {
  cameras=$data/panoptic/calibration_160422_ultimatum1.json
  detections=$data/panoptic/detections
  score=(--protocol=panoptic
    --ground_truth="$data/panoptic/body3DScene_00010600.json")
  held_out_set=()
  local which="cameras.use=[00_00,00_01,00_03,00_07,00_16];detections.first_frame=10600"
  told="$which;input.independent_frames=true"
  begin panoptic 25
  try panoptic base_paper "$base" "$configs/paper/panoptic_frame.toml" ""
  # A list of names belongs into a file there.
  { cat "$configs/graph/panoptic.toml"
    sed -n '/^\[cameras\]/,/^first_frame/p' "$configs/paper/panoptic_frame.toml"
  } >"$out/panoptic_window.toml"
  try panoptic base_window "$base" "$out/panoptic_window.toml" \
    input.repeat_first_frame=3
  try panoptic new_default "$new" default.toml "$told;input.frame_rate=25"
  try panoptic new_init "$new" "$out/panoptic.toml" ""
  told=""
}

synthetic() {
  local scene rate
  for scene in ${SCENES:-demo hard correlated_25hz correlated_60hz correlated_120hz}; do
    "$base/kinegraph-synthesize" --config="$configs/synthetic/$scene.toml" \
      --set="scene.duration=${SECONDS_OF_SCENE:-10}" --out="$out/$scene.scene" >/dev/null 2>&1
    cameras=$out/$scene.scene/cameras.json
    detections=$out/$scene.scene/detections.jsonl
    score=(--protocol=mpjpe --ground_truth="$out/$scene.scene/truth.jsonl")
    held_out_set=()
    rate=$(sed -n 's/.*"frame_rate": *\([0-9.]*\).*/\1/p;1q' "$detections")
    begin "$scene" "$rate"
    try "$scene" base_window "$base" "$configs/synthetic/track_window.toml" ""
    try "$scene" new_default "$new" default.toml ""
    try "$scene" base_batch "$base" "$configs/synthetic/track_batch.toml" ""
    try "$scene" new_init "$new" "$out/$scene.toml" ""
  done
}

for take in ${TAKES:-shelf campus panoptic pose2sim synthetic}; do "$take"; done
