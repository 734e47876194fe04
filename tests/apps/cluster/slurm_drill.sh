#!/bin/bash
# Runs forty tasks on a one-node Slurm whose node is killed midway:
#   slurm_drill.sh BATCH MANIFEST OUT FOLDER
# Prints how many tasks were done when the node was killed.
set -euo pipefail
batch=$1 manifest=$2 out=$3 folder=$4
slurm=$(dirname "$0")/one_node_slurm.sh
trap '"$slurm" stop "$folder"' EXIT
"$slurm" start "$folder" >"$folder.start"
export SLURM_CONF=$folder/slurm.conf
cd "$(dirname "$manifest")"

done_count() { find "$out" -name task.json -not -path '*.partial*' 2>/dev/null | wc -l; }
submit() {
  sbatch -Q --array=0-39 --chdir="$PWD" --output="$folder/job.%a.txt" \
    --export=ALL --wrap="'$batch' --manifest='$manifest' --out='$out' \
      --task=\$SLURM_ARRAY_TASK_ID"
}
wait_for_jobs() {
  for _ in {1..2400}; do
    if [[ -z $(squeue -h 2>/dev/null) ]]; then return; fi
    sleep 0.25
  done
  squeue >&2
  exit 1
}

submit
for _ in {1..2400}; do
  if (($(done_count) >= 8)); then break; fi
  sleep 0.05
done
"$slurm" kill_node "$folder"
at_death=$(done_count)
find "$out" -name task.json -newermt '1970-01-01' -printf '%p %T@\n' | sort >"$folder.before"
scancel --user="$(id -un)"
"$slurm" start_node "$folder"
wait_for_jobs
submit
wait_for_jobs
echo "$at_death"
# Finished tasks must not have been run again.
while read -r file time; do
  if [[ $(find "$file" -printf '%T@') != "$time" ]]; then
    echo "run again: $file" >&2
    exit 1
  fi
done <"$folder.before"
"$batch" --merge --manifest="$manifest" --out="$out" >/dev/null
