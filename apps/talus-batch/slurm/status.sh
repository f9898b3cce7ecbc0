#!/bin/sh
# What became of a job of Slurm: running, success or failed. Needs no accounting database.
# usage: status.sh JOB
if state=$(squeue --noheader --states=all --format=%T --jobs="$1" 2>&1); then
  case $state in
    COMPLETED) echo success ;;
    # Also a job that Slurm remembers no more: what it has made is whole or not there, and is made again.
    "" | BOOT_FAIL | CANCELLED | DEADLINE | FAILED | NODE_FAIL | OUT_OF_MEMORY | TIMEOUT | REVOKED) echo failed ;;
    *) echo running ;;  # or waits, also to run again where a node has failed
  esac
else
  case $state in
    *"Invalid job id"*) echo failed ;;
    *) echo running ;;  # the controller does not answer; it is asked again
  esac
fi
