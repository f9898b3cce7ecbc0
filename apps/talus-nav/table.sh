#!/usr/bin/env bash
# Drives the navigation worlds with both maps and both planners, several seeds each, and prints a table in Markdown.
# usage: table.sh TALUS_NAV DIR SEEDS JOBS      (./dev nav calls it)
set -euo pipefail
talus_nav=$1 dir=$2 seeds=$3 jobs=$4
worlds=$(dirname "${BASH_SOURCE[0]}")/../../datasets/worlds

rm -rf "$dir"
mkdir -p "$dir"
for world in "nav_indoor 15,0" "nav_woods 16,0" "nav_blocked 7,0"; do
  for map in talus octomap; do
    for planner in 2d 3d; do
      for seed in $(seq "$seeds"); do echo "$world $map $planner $seed"; done
    done
  done
done | xargs -P "$jobs" -L 1 bash -c '
  "$0" "$1/$3.yaml" --goal "$4" --map "$5" --planner "$6" --seed "$7" --backend cpu --every 0 --quiet --output "$2/$3.$5.$6.$7" ||
    [ $? -ge 3 ] || echo "$3 $5 $6 seed $7: failed" >&2' "$talus_nav" "$worlds" "$dir"

# One line a run: world map planner ending metres seconds map_ms route_ms navigator_ms
rows() {
  local run
  for run in "$dir"/*/; do
    awk -v run="$(basename "$run")" '
      { gsub(/[",:]/, "") }
      $1 ~ /^(ending|driven_m|time_s|map|route|navigator)$/ { value[$1] = $2 }  # of two "map" the second: milliseconds
      END { split(run, key, "."); print key[1], key[2], key[3], value["ending"], value["driven_m"], value["time_s"],
            value["map"], value["route"], value["navigator"] }' "$run/summary.json"
  done
}

rows | sort -s -k1,1 -k2,2r -k3,3 | awk '
  function flush() {
    if (n == 0) return
    drive = arrived ? sprintf("%.1f (%.1f to %.1f) | %.0f (%.0f to %.0f)", m / arrived, m0, m1, s / arrived, s0, s1) : "- | -"
    printf "| %s | %d of %d | %d | %d | %d | %s | %.0f | %.0f | %.0f |\n", name, arrived, n, blocked, collision, timeout, drive,
      map / n, route / n, 1000 * n / navigator
    n = arrived = blocked = collision = timeout = m = s = m1 = s1 = map = route = navigator = 0
    m0 = s0 = 1e9
  }
  BEGIN {
    m0 = s0 = 1e9
    print "| world | map | planner | arrived | blocked | collisions | timeouts | way driven [m] | time [s] | map [ms] | route [ms] | navigator [steps/s] |"
    print "|---|---|---|---|---|---|---|---|---|---|---|---|"
  }
  { key = $1 " | " $2 " | " $3 }
  key != name { flush(); name = key }
  {
    n++; blocked += $4 == "blocked"; collision += $4 == "collision"; timeout += $4 == "timeout"
    map += $7; route += $8; navigator += $9
  }
  $4 == "arrived" {
    arrived++; m += $5; s += $6
    if ($5 < m0) m0 = $5; if ($5 > m1) m1 = $5; if ($6 < s0) s0 = $6; if ($6 > s1) s1 = $6
  }
  END { flush() }'
