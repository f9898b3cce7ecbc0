#!/usr/bin/env bash
# usage: instructions.sh [COMMIT]...
# Instructions of each stage of a frame in S1 and S2, with two layers and with six, on one core, as callgrind counts
# them, of the library at each commit (default: HEAD). Needs valgrind (Debian: apt-get install valgrind).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
work=$(mktemp -d)
trap 'rm -rf "$work"; git worktree prune' EXIT

for commit in "${@:-HEAD}"; do
  tree=$work/$commit
  git worktree add --quiet --detach "$tree" "$commit"
  cmake -S "$tree" -B "$tree/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTALUS_WITH_MRPT=OFF -DTALUS_WITH_CUDA=OFF \
    -DTALUS_WITH_TBB=OFF -DTALUS_BUILD_TESTS=OFF -DTALUS_BUILD_BENCH=OFF >/dev/null
  cmake --build "$tree/build" --target talus_core >/dev/null
  g++ -std=c++17 -O2 -I"$tree/libs/core/include" instructions.cpp scans.cpp setting.cpp "$tree"/build/lib/libtalus_core.a \
    -o "$tree/instructions"
  echo "$(git rev-parse --short "$commit"):"
  for setting in S1 S1/6_layers S2 S2/6_layers; do
    profile=$tree/${setting/\//_}
    valgrind --quiet --tool=callgrind --instr-atstart=no --callgrind-out-file="$profile" \
      "$tree/instructions" "$setting" "$profile" 2>"$tree/log" || { cat "$tree/log" >&2; exit 1; }
  done
done
