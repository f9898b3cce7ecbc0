#!/usr/bin/env bash
# Runs one fuzz target for some seconds: run.sh PROGRAM NAME SEEDS...
# The same inputs each time, unless TALUS_FUZZ_SEED says another number (0: a random one).
# What it finds is put into out/fuzz/NAME/, and the command that shows it again is printed.
set -uo pipefail
program=$1 name=$2
shift 2
seeds=()
for folder in "$@"; do [ -d "$folder" ] && seeds+=("$folder"); done

out=${TALUS_OUT:-$(dirname "$0")/../../out}/fuzz/$name
mkdir -p "$out/corpus" || exit 1
out=$(cd "$out" && pwd)
TMPDIR=$(mktemp -d) || exit 1
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

# What was given back is held for a while only, so that memory that no input holds doesn't count against the limit.
export ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}quarantine_size_mb=16:allocator_release_to_os_interval_ms=500
# An input is small, so that what takes long or much memory is a fault: nothing that is read may cost more than its bytes.
"$program" -seed="${TALUS_FUZZ_SEED:-1}" -max_total_time="${TALUS_FUZZ_SECONDS:-9}" -max_len=16384 -timeout=10 -rss_limit_mb=1024 -malloc_limit_mb=256 \
  -artifact_prefix="$out/" -verbosity=0 -print_final_stats=1 "$out/corpus" "${seeds[@]}" >"$out/log.txt" 2>&1
code=$?
grep -E '^stat::(number_of_executed_units|read_units|peak_rss_mb)' "$out/log.txt"
if [ $code -eq 0 ] && ! grep -q '^stat::read_units: [1-9]' "$out/log.txt"; then
  echo "the reader refused everything, the seeds too: nothing was looked at; TALUS_FUZZ_SHOW=1 $program SEED tells why"
  exit 1
fi
if [ $code -ne 0 ]; then
  cat "$out/log.txt"
  found=$(sed -n 's/^.*Test unit written to //p' "$out/log.txt" | tail -1)
  echo "to see it again: $program ${found:-(no input was kept)}"
fi
exit $code
