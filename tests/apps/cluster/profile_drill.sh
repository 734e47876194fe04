#!/bin/bash
# Runs Snakemake with the Slurm profile on one node, which is killed midway:
#   profile_drill.sh BATCH MANIFEST OUT FOLDER SNAKEFILE
# Prints how many tasks were done when the node was killed.
set -euo pipefail
batch=$1 manifest=$2 out=$3 folder=$4 snakefile=$5
slurm=$(dirname "$0")/one_node_slurm.sh
trap '"$slurm" stop "$folder"' EXIT
"$slurm" start "$folder" >"$folder.start"
export SLURM_CONF=$folder/slurm.conf HOME=$folder
cd "$(dirname "$manifest")"

done_count() { find "$out" -name task.json -not -path '*.partial*' 2>/dev/null | wc -l; }
snakemake --quiet -s "$snakefile" --profile "$(dirname "$snakefile")/slurm" \
  --jobs 2 --latency-wait 5 --max-status-checks-per-second 1 \
  --config manifest="$manifest" out="$out" batch="$batch" \
  >"$folder/snakemake.txt" 2>&1 9>&- &
running=$!
for _ in {1..1200}; do
  if (($(done_count) >= 1)); then break; fi
  sleep 0.1
done
"$slurm" kill_node "$folder"
at_death=$(done_count)
"$slurm" start_node "$folder"
if ! wait "$running"; then
  tail -n 20 "$folder/snakemake.txt" .snakemake/slurm-*.txt >&2
  exit 1
fi
echo "$at_death"
