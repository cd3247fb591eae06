#!/usr/bin/env bash
# Tells Snakemake the state of the job with this number: "running", "success" or "failed". The controller remembers a
# finished job for some minutes (MinJobAge). After that the script asks the accounting, if there is one.
state=$(scontrol --oneliner show job "$1" 2>/dev/null | sed -n 's/.* JobState=\([A-Z_]*\).*/\1/p')
[[ -n $state ]] || state=$(sacct --noheader --parsable2 --allocations --format=State --jobs "$1" 2>/dev/null | head -1 | cut -d' ' -f1)
case $state in
  COMPLETED) echo success ;;
  PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | REQUEUED | REQUEUE_HOLD | RESIZING | STAGE_OUT) echo running ;;
  *) echo failed ;;
esac
