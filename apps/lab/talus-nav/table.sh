#!/usr/bin/env bash
# Drives the navigation worlds with several sensors and three maps, several seeds each. Prints tables in Markdown;
# DIR/runs.csv has a row a run.
# usage: table.sh TALUS_NAV DIR SEEDS JOBS [FOLDER_OF_WORLDS]      (./dev nav calls it)
# WORLDS, SENSORS and MAPS, words with spaces between, choose some of them. PLANNERS="2d 3d" drives with both planners,
# which drive alike, as the robot has one shape at all heights. DROPS=slope drives boldly. Needs only bash, awk, sed and
# xargs.
set -euo pipefail
talus_nav=$1 dir=$2 seeds=$3 jobs=$4
datasets=$(dirname "${BASH_SOURCE[0]}")/../../../datasets
folder=${5:-$datasets/worlds}

# world, goal, the right end
all_worlds='nav_indoor 15,0 arrived
nav_woods 16,0 arrived
nav_blocked 7,0 blocked
nav/nav_ditch_beside 7,-3.5 arrived
nav/nav_ditch_across 9,0 blocked
nav/nav_ditch_bridge 9,0 arrived
nav/nav_shaft 9,0 arrived
nav/nav_dock 9,0 arrived
nav/nav_trench_ramp 8.5,-2.5 arrived
nav/nav_crest_drop 11,0 blocked
nav/nav_terrace 1,2.2 arrived
nav/nav_pothole15 8,0 arrived
nav/nav_pothole30 8,0 arrived'
# name, scanner, mounting
all_sensors='RS-LiDAR-16 RS-LiDAR-16 0,0,0.68,0,0,0
RS-LiDAR-16-tilted RS-LiDAR-16 0,0,0.68,0,20,0
VLP-16 VLP-16 0,0,0.68,0,0,0
OS1-64 OS1-64 0,0,0.68,0,0,0
OS0-128 OS0-128 0,0,0.68,0,0,0
depth-camera depth-camera 0.2,0,0.68,0,25,0'

chosen() {  # the lines of $1 whose first word, without its folder, is among $2; all where that is empty
  awk -v words="$2" 'BEGIN { n = split(words, w, " "); for (i in w) want[w[i]] }
    { name = $1; sub(/.*\//, "", name) } n == 0 || name in want' <<<"$1"
}

runs() {
  local world goal right sensor scanner mount map planner seed
  while read -r world goal right; do
    while read -r sensor scanner mount; do
      for map in ${MAPS:-talus octomap onesurface}; do
        for planner in ${PLANNERS:-2d}; do
          for seed in $(seq "$seeds"); do echo "$world $goal $sensor $scanner $mount $map $planner $seed"; done
        done
      done
    done < <(chosen "$all_sensors" "${SENSORS:-}")
  done < <(chosen "$all_worlds" "${WORLDS:-}")
}

rm -rf "$dir"
mkdir -p "$dir"
for planner in 2d 3d; do
  sed "s/^drops  *= avoid/drops = ${DROPS:-avoid}/" \
    "$datasets/configs/reactive${planner}_config.ini" >"$dir/$planner.ini"
done
runs | xargs -P "$jobs" -L 1 bash -c '
  out="$2/runs/${3##*/}.$5.$8.$9.${10}"
  mkdir -p "$2/runs"
  "$0" "$1/$3.yaml" --goal "$4" --scanner "$6" --mount "$7" --map "$8" --planner "$9" --seed "${10}" \
    --planner-config "$2/$9.ini" --timeout 120 \
    --backend cpu --threads 1 --every 0 --quiet --output "$out" || [ $? -ge 3 ] || echo "$out: failed" >&2
  rm -f "$out/log.reactivenavlog" "$out/map.tif"' "$talus_nav" "$folder" "$dir"

rows() {
  local run
  echo "world,sensor,map,planner,seed,ending,driven_m,time_s,map_ms,route_ms,navigator_ms"
  for run in "$dir"/runs/*/; do
    awk -v run="$(basename "$run")" '
      { gsub(/[",:]/, "") }
      $1 ~ /^(ending|driven_m|time_s|map|route|navigator)$/ { value[$1] = $2 }  # of two "map" the second: milliseconds
      END { split(run, key, "."); OFS = ","; print key[1], key[2], key[3], key[4], key[5], value["ending"], value["driven_m"],
            value["time_s"], value["map"], value["route"], value["navigator"] }' "$run/summary.json"
  done
}
rows >"$dir/runs.csv"

# One row for each of what the field `by` has, in the order of the lists above.
endings() {
  awk -F, -v by="$1" -v order="$2" -v right="$3" '
    function count(map, ending) { return n[key, map, ending] + 0 }
    function cells(map) {
      if (!any[key, map]) return " - | - |"
      return sprintf(" %d of %d | %d |", count(map, "arrived"), any[key, map], count(map, "fall") + count(map, "collision"))
    }
    NR > 1 { n[$by, $3, $6]++; any[$by, $3]++; seen[$by] }
    END {
      head = right ? "| right end " : ""; line = right ? "|---" : ""
      print "| " (by == 1 ? "world" : "sensor") " " head "| talus: arrived | blocked | **falls** | hits | timeouts | " \
            "octomap: arrived | falls, hits | onesurface: arrived | falls, hits |"
      print "|---" line "|---|---|---|---|---|---|---|---|---|"
      m = split(order, keys, " ")
      for (i = 1; i <= m; i++) {
        split(keys[i], part, "="); key = part[1]
        if (!(key in seen)) continue
        printf "| %s |%s", key, right ? " " part[2] " |" : ""
        printf " %d of %d | %d | %d | %d | %d |", count("talus", "arrived"), any[key, "talus"], count("talus", "blocked"),
          count("talus", "fall"), count("talus", "collision"), count("talus", "timeout")
        print cells("octomap") cells("onesurface")
      }
    }' "$dir/runs.csv"
}

# How long the ways are on which talus arrived, and what a step takes, with the sensor of the robot as it is.
costs() {
  awk -F, '
    $3 == "talus" && $2 == "RS-LiDAR-16" && $6 == "arrived" && $1 ~ /indoor|woods/ {
      k = $1 " | " $4; if (!n[k]++) { m0[k] = s0[k] = 1e9 }
      m[k] += $7; s[k] += $8; map[k] += $9; route[k] += $10; navigator[k] += $11
      if ($7 < m0[k]) m0[k] = $7; if ($7 > m1[k]) m1[k] = $7; if ($8 < s0[k]) s0[k] = $8; if ($8 > s1[k]) s1[k] = $8
    }
    END {
      for (k in n) printf "| %s | %d | %.1f (%.1f to %.1f) | %.0f (%.0f to %.0f) | %.0f | %.0f | %.0f |\n", k, n[k], m[k] / n[k],
        m0[k], m1[k], s[k] / n[k], s0[k], s1[k], map[k] / n[k], route[k] / n[k], 1000 * n[k] / navigator[k]
    }' "$dir/runs.csv" | sort
}

endings 1 "$(awk '{ sub(/.*\//, "", $1); printf "%s=%s ", $1, $3 }' <<<"$all_worlds")" yes
echo
endings 2 "$(awk '{ printf "%s ", $1 }' <<<"$all_sensors")" ""
echo
echo "| world | planner | arrived | way driven [m] | time [s] | map [ms] | route [ms] | navigator [steps/s] |"
echo "|---|---|---|---|---|---|---|---|"
costs
