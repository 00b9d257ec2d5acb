#!/usr/bin/env bash
# A real Slurm of several nodes on this machine, apart from any that it belongs to: its own keys, ports and folder.
#   tests/support/slurm_cluster.sh start DIR [nodes, default 2] [cores of a node, 1] [MB of a node, 4000]
#   tests/support/slurm_cluster.sh start_node DIR NODE     (n1, n2, ...)
#   tests/support/slurm_cluster.sh kill_node DIR NODE      the node's daemon and all its jobs die at once
#   tests/support/slurm_cluster.sh stop DIR
# Jobs are submitted with SLURM_CONF=DIR/slurm.conf. `start` fails, saying why in one line, where the daemons cannot be started:
# without root, or without Debian's packages slurm-wlm and munge.
set -euo pipefail

action=${1:?what to do} dir=${2:?folder}
fail() { echo "$*" >&2; exit 1; }

kill_pid_file() {
  [ -s "$1" ] || return 0
  kill "-$2" "$(cat "$1")" 2>/dev/null || true
}

# Processes of the node's jobs, and the daemons (slurmstepd) that run them.
job_processes() {
  local environment process step
  for environment in $(grep -lzx "SLURMD_NODENAME=$1" /proc/[0-9]*/environ 2>/dev/null || true); do
    grep -qzx "SLURM_CONF=$dir/slurm.conf" "$environment" 2>/dev/null || continue
    process=$(basename "$(dirname "$environment")")
    step=$(ps -o ppid= -p "$process" | tr -d ' ')
    [ "$(cat "/proc/$step/comm" 2>/dev/null)" = slurmstepd ] && echo "$step"
    echo "$process"
  done
}

start_node() { slurmd -f "$dir/slurm.conf" -N "$1" || fail "slurmd does not start; see $dir/slurmd-$1.log"; }

case $action in
start)
  nodes=${3:-2} cores=${4:-1} memory=${5:-4000}
  [ "$(id -u)" -eq 0 ] || fail "Slurm's daemons need root"
  for program in slurmctld slurmd munged sbatch; do
    command -v "$program" >/dev/null || fail "$program is not installed (Debian: slurm-wlm, munge)"
  done
  mkdir -p "$dir/state" "$dir/munge"
  dd if=/dev/urandom of="$dir/munge/key" bs=1024 count=1 2>/dev/null
  chmod 700 "$dir/munge" && chmod 600 "$dir/munge/key"
  munged --force --key-file="$dir/munge/key" --socket="$dir/munge/socket" --pid-file="$dir/munged.pid" \
    --log-file="$dir/munge/log" --seed-file="$dir/munge/seed" >/dev/null 2>&1 || fail "munged does not start"
  host=$(hostname -s)
  port=$((20000 + RANDOM % 1000 * 20))
  cat >"$dir/slurm.conf" <<CONF
ClusterName=lsmvs-test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
AuthType=auth/munge
AuthInfo=socket=$dir/munge/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=1
JobAcctGatherParams=OverMemoryKill
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool-%n
SlurmUser=root
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd-%n.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd-%n.log
SchedulerParameters=sched_interval=1,sched_min_interval=0,bf_interval=1
ReturnToService=2
SlurmdParameters=config_overrides
SlurmdTimeout=10
InactiveLimit=0
KillWait=2
MpiDefault=none
$(for i in $(seq "$nodes"); do
    echo "NodeName=n$i NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + i)) CPUs=$cores RealMemory=$memory State=UNKNOWN"
  done)
PartitionName=main Nodes=n[1-$nodes] Default=YES MaxTime=INFINITE State=UP
CONF
  # Without cgroups, as in a bare root, newer versions of Slurm go on only if told so; older ones do not know the word.
  [ -d /sys/fs/cgroup ] || [ "$(slurmd -V | tr -dc 0-9.)" \< 24 ] || echo "CgroupPlugin=disabled" >"$dir/cgroup.conf"
  export SLURM_CONF=$dir/slurm.conf
  slurmctld -f "$dir/slurm.conf" || fail "slurmctld does not start; see $dir/slurmctld.log"
  for i in $(seq "$nodes"); do start_node "n$i"; done
  for _ in $(seq 150); do
    [ "$(sinfo -h -N -o %T 2>/dev/null | grep -c idle)" -eq "$nodes" ] && exit 0
    sleep 0.2
  done
  fail "Slurm's nodes do not come up; see $dir/*.log"
  ;;
start_node) start_node "$3" ;;
kill_node)
  kill_pid_file "$dir/slurmd-$3.pid" KILL
  rm -f "$dir/slurmd-$3.pid"
  for process in $(job_processes "$3"); do kill -KILL "$process" 2>/dev/null || true; done
  ;;
stop)
  for file in "$dir"/slurmd-*.pid; do
    node=$(basename "$file" .pid)
    for process in $(job_processes "${node#slurmd-}"); do kill -KILL "$process" 2>/dev/null || true; done
    kill_pid_file "$file" TERM
  done
  kill_pid_file "$dir/slurmctld.pid" TERM
  kill_pid_file "$dir/munged.pid" TERM
  ;;
*) fail "unknown action '$action'" ;;
esac
