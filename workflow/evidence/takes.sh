# . workflow/evidence/takes.sh: synthetic takes that are tracked and scored.

# take CONFIG KEYS [FLAG...]: makes one in the folder `take`.
take() {
  rm -rf take
  ./kinegraph synthesize --config="configs/synthetic/$1.toml" --set="$2" \
    "${@:3}" --out=take
}

# score NAME CONFIG KEYS: tracks it; errors and covariances go to NAME.json.
score() {
  ./kinegraph track --cameras=take/cameras.json --detections=take/detections.jsonl \
    --config="configs/$2.toml" --set="$3" --out=tracks.jsonl
  ./kinegraph evaluate --protocol=mpjpe --tracks=tracks.jsonl \
    --ground_truth=take/truth.jsonl --json="$1.json"
}
