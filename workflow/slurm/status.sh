#!/bin/bash
# State of a Slurm job, in Snakemake's terms.
state=$(scontrol show job --oneliner "$1" 2>/dev/null |
  sed -n 's/.* JobState=\([A-Z_]*\).*/\1/p')
# The controller forgets jobs minutes after they end; the accounting, if enabled,
# does not.
if [[ -z $state ]]; then
  state=$(sacct -X -n -P -o State -j "$1" 2>/dev/null | head -n 1)
fi
case $state in
  COMPLETED) echo success ;;
  PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | STOPPED | \
    RESIZING | SIGNALING | STAGE_OUT | REQUEUE*) echo running ;;
  *) echo failed ;;
esac
