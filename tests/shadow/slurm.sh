#!/usr/bin/env bash
# The catalogue on Slurm: one node, two workers, as the profile in models/baking/catalogue/slurm says. Of three bakes one is
# cancelled in the middle, as a cluster does it (SIGTERM), and one is killed. Afterwards every file has the bytes of an
# uninterrupted bake, and the cancelled bake was resumed.
#   slurm.sh CATALOGUE_FOLDER PROGRAM WORK_FOLDER
# Starts a controller, a node and an authentication service of its own on the loopback, in WORK_FOLDER, and ends them.
# Exit code 77: they are not installed (Debian: slurm-wlm, snakemake), or the user is not root, and a node needs root to
# run a job.
set -euo pipefail
for command in snakemake slurmctld slurmd munged sbatch; do PATH=$PATH:/usr/sbin command -v $command >/dev/null || exit 77; done
((EUID == 0)) || exit 77
export PATH=$PATH:/usr/sbin
catalogue=$1 program=$2 work=$3
rm -rf "$work" && mkdir -p "$work"/{meshes,out,state,spool} && chmod 755 "$work"
run=$(mktemp -d /tmp/sandglass-slurm.XXXXXX)  # for sockets, whose paths must be short
chmod 755 "$run"
daemons=()
finish() {
  for pid in "${daemons[@]}"; do kill "$pid" 2>/dev/null || true; done
  for pid in "${daemons[@]}"; do wait "$pid" 2>/dev/null || true; done
  rm -rf "$run"
}
trap finish EXIT

# -------------------------------------------------------------------------------------------------------------------
# cluster

head -c 1024 /dev/urandom >"$run/key" && chmod 400 "$run/key"
munged --foreground --force --socket="$run/munge" --key-file="$run/key" --pid-file="$run/munge.pid" --seed-file="$run/seed" \
  --log-file="$work/munged.log" >"$work/munged.out" 2>&1 &
daemons+=($!)
name=$(hostname -s)
base=$((20000 + $$ % 20000))
cat >"$run/slurm.conf" <<CONF
ClusterName=sandglass
SlurmctldHost=$name(127.0.0.1)
SlurmctldPort=$base
SlurmdPort=$((base + 1))
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$run/munge
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$run/slurmctld.pid
SlurmdPidFile=$run/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=20
NodeName=$name NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=bake Nodes=$name Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$run/slurm.conf
slurmctld -D >"$work/slurmctld.log" 2>&1 &
daemons+=($!)
slurmd -D -N "$name" >"$work/slurmd.log" 2>&1 &
daemons+=($!)
for i in {1..60}; do
  if [[ $(sinfo --noheader --format=%T 2>/dev/null) == idle ]]; then break; fi
  sleep 0.5
done
[[ $(sinfo --noheader --format=%T) == idle ]] || { tail -n 20 "$work"/*.log; echo "the node did not come up"; exit 1; }

# ---------------------------------------------------------------------------------------------------------------------
# bakes

printf 'v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 3 2\n' >"$work/meshes/tetrahedron.obj"
printf 'v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 2 0\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >"$work/meshes/cone.obj"
printf 'v 0 0 0\nv 1 0 0\nv 0 0 2\nv 0 1 0\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 3 2\n' >"$work/meshes/wedge.obj"
options="--ambient-texels 16 --size 32x1 --textures 1 --steps 20000 --quantised-steps 200 --validation-lights 4"
for mesh in "$work"/meshes/*.obj; do
  "$program" bake "$mesh" -o "$work/$(basename "$mesh" .obj).whole" --threads 1 --no-picture $options >/dev/null 2>&1
done

snakemake -s "$catalogue/Snakefile" --profile "$catalogue/slurm" -d "$work" --nocolor --latency-wait 5 --jobs 10 \
  --max-status-checks-per-second 2 --config meshes="$work/meshes" out="$work/out" program="$program" threads=1 \
  options="$options" >"$work/snakemake.log" 2>&1 &
catalogue_run=$!
running() { squeue --noheader --states=R --format='%i %j' 2>/dev/null || true; }
workers=0 cancelled= killed=
while kill -0 $catalogue_run 2>/dev/null; do
  now=$(running | wc -l)
  ((now <= workers)) || workers=$now
  cone=$(running | awk '$2 == "bake.cone" {print $1}')
  # Training shows its progress after two seconds.
  if [[ -n $cone && -z $cancelled ]] && grep -q training "$work/out/cone.log" 2>/dev/null; then scancel "$cone" && cancelled=$cone; fi
  bake=$(pgrep -f "^$program bake $work/meshes/wedge" || true)
  if [[ -n $bake && -z $killed ]] && grep -q training "$work/out/wedge.log" 2>/dev/null; then kill -9 $bake && killed=$bake; fi
  sleep 0.2
done
wait $catalogue_run || { tail -n 40 "$work/snakemake.log"; exit 1; }
[[ $workers == 2 ]] || { echo "$workers jobs at a time, not 2"; exit 1; }
[[ -n $cancelled && -n $killed ]] || { echo "nothing was ended in the middle"; exit 1; }
grep -q '^3 baked, 0 refused$' "$work/out/summary.txt" || { cat "$work/out/summary.txt"; exit 1; }
for mesh in tetrahedron cone wedge; do
  cmp "$work/$mesh.whole" "$work/out/$mesh.shadow" || { echo "$mesh is not what an uninterrupted bake makes"; exit 1; }
done
grep -q '^going on from' "$work/out/cone.log" || { cat "$work/out/cone.log"; echo "the cancelled bake began again"; exit 1; }
cat "$work/out/summary.txt"
