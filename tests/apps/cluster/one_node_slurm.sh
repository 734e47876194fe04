#!/bin/bash
# Starts and stops a one-node Slurm in a folder, for tests.
#   one_node_slurm.sh start FOLDER   prints what to export
#   one_node_slurm.sh stop FOLDER
#   one_node_slurm.sh kill_node FOLDER   SIGKILL to slurmd and its jobs
#   one_node_slurm.sh start_node FOLDER
# As root or as any user; nothing outside of FOLDER is written.
set -euo pipefail
folder=$2
PATH=$PATH:/usr/sbin
export SLURM_CONF=$folder/slurm.conf

start_node() {
  slurmd -c -D -N node0 >"$folder/slurmd.out" 2>&1 9>&- &
  echo $! >"$folder/slurmd.id"
}

end() {  # SIGNAL NAME
  local id
  if [[ -e $folder/$2.id ]]; then
    id=$(cat "$folder/$2.id")
    kill "-$1" "$id" 2>/dev/null || true
    for _ in {1..50}; do
      kill -0 "$id" 2>/dev/null || break
      sleep 0.1
    done
    rm "$folder/$2.id"
  fi
}

# Kills the steps and jobs of the node, which were started with this
# configuration.
kill_jobs() {
  local id
  for id in $(grep -lz "^SLURM_CONF=$SLURM_CONF\$" /proc/[0-9]*/environ \
    2>/dev/null | cut -d / -f 3); do
    # Processes that submit jobs have the configuration too, but are no jobs.
    if grep -qz '^SLURM_JOB_ID=' "/proc/$id/environ" 2>/dev/null ||
      grep -qz slurmstepd "/proc/$id/cmdline" 2>/dev/null; then
      kill -KILL "$id" 2>/dev/null || true
    fi
  done
}

wait_for_node() {
  for _ in {1..600}; do
    case $(sinfo -h -o %t 2>/dev/null) in idle | mix | alloc) return ;; esac
    sleep 0.2
  done
  echo "the node does not come up:" >&2
  for file in "$folder"/*.out; do tail -n 5 "$file" >&2; done
  exit 1
}

case $1 in
  start)
    mkdir -p "$folder/state" "$folder/spool"
    chmod 755 "$folder"
    head -c 1024 /dev/urandom >"$folder/munge.key"
    chmod 600 "$folder/munge.key"
    port=$((20000 + RANDOM % 20000))
    cat >"$SLURM_CONF" <<TEXT
ClusterName=test
SlurmctldHost=$(hostname -s)(127.0.0.1)
MailProg=/bin/true
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CredType=cred/munge
SlurmctldPort=$port
SlurmdPort=$((port + 1))
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
SlurmdTimeout=10
InactiveLimit=0
MaxArraySize=1001
NodeName=node0 NodeHostname=$(hostname) NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=test Nodes=node0 Default=YES MaxTime=INFINITE State=UP
TEXT
    munged -F --force --key-file="$folder/munge.key" \
      --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
      --log-file="$folder/munged.log" --seed-file="$folder/munged.seed" \
      --num-threads=2 >"$folder/munged.out" 2>&1 9>&- &
    echo $! >"$folder/munged.id"
    for _ in {1..50}; do
      if [[ -S $folder/munge.socket ]]; then break; fi
      sleep 0.1
    done
    slurmctld -c -D >"$folder/slurmctld.out" 2>&1 9>&- &
    echo $! >"$folder/slurmctld.id"
    start_node
    wait_for_node
    echo "SLURM_CONF=$SLURM_CONF"
    ;;
  start_node)
    start_node
    wait_for_node
    ;;
  kill_node)
    end KILL slurmd
    kill_jobs
    ;;
  stop)
    end TERM slurmctld
    end TERM slurmd
    kill_jobs
    end TERM munged
    ;;
esac
