#!/bin/sh
# scripts/one_node_slurm.sh COMMAND...: a Slurm cluster of this machine alone, for as long as COMMAND runs; its exit
# code is the command's. Needs Debian's slurmctld, slurmd, slurm-client and munge, and root; exit code 77 where they are
# missing or cannot be started. For tests: nothing of the system's own configuration is used or changed.
set -eu
[ $# -gt 0 ] || {
  echo "usage: scripts/one_node_slurm.sh COMMAND..." >&2
  exit 2
}
no_slurm() {
  echo "one_node_slurm: $1" >&2
  exit 77
}
[ "$(id -u)" -eq 0 ] || no_slurm "needs root"
for program in munged slurmctld slurmd sbatch sinfo; do
  PATH=$PATH:/usr/sbin:/sbin command -v "$program" >/dev/null ||
    no_slurm "no $program (apt-get install slurmctld slurmd slurm-client munge)"
done
PATH=$PATH:/usr/sbin:/sbin

folder=$(mktemp -d "${TMPDIR:-/tmp}/facet-slurm-XXXXXX")
started=""
clean_up() {
  for pid in $started; do kill "$pid" 2>/dev/null || true; done
  for pid in $started; do wait "$pid" 2>/dev/null || true; done
  rm -rf "$folder"
}
trap clean_up EXIT
trap 'exit 130' INT TERM

# munge refuses folders that others may write to.
chmod 755 "$folder"
mkdir -p "$folder/state" "$folder/spool" "$folder/munge"
head -c 1024 /dev/urandom >"$folder/munge/key"
chmod 700 "$folder/munge"
chmod 600 "$folder/munge/key"
munged --foreground --force --key-file="$folder/munge/key" --socket="$folder/munge.socket" \
  --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" --seed-file="$folder/munge/seed" \
  >"$folder/munged.out" 2>&1 &
started="$started $!"

host=$(hostname -s)
cat >"$folder/slurm.conf" <<EOF
ClusterName=facet
SlurmctldHost=$host(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
SlurmUser=root
SlurmdUser=root
SlurmctldPort=${SLURM_TEST_PORT:-26817}
SlurmdPort=$((${SLURM_TEST_PORT:-26817} + 1))
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MpiDefault=none
CredType=cred/munge
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
EOF
export SLURM_CONF="$folder/slurm.conf"
slurmctld -D >"$folder/slurmctld.out" 2>&1 &
started="$started $!"
slurmd -D -N "$host" >"$folder/slurmd.out" 2>&1 &
started="$started $!"

i=0
until sinfo -h -o %t 2>/dev/null | grep -q idle; do
  i=$((i + 1))
  if [ $i -gt 60 ]; then
    tail -n 5 "$folder"/*.out >&2
    no_slurm "the cluster of this machine did not start"
  fi
  sleep 0.5
done
set +e
"$@"
exit $?
