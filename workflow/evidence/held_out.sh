# bash held_out.sh NAME KEYS [FLAG...]: Shelf's held-out camera, into NAME.json
name=$1 keys=$2
shift 2
./kinegraph evaluate --protocol=held_out_camera --cameras=data/shelf/calibration.json \
  --detections=data/shelf/detections/openpose --config=configs/graph/offline.toml \
  --set="graph.solver=sweeps;$keys" --json="$name.json" \
  --held_out_set=data/shelf/reference/held_out_set.json \
  --reference=data/shelf/reference/paper_code_shelf_warm3.json "$@"
