#!/usr/bin/env bash
# usage: instructions_without.sh [RULE]
# Instructions of each stage of a frame in S1, one core, as callgrind counts them, of the core as it ships, or compiled
# without a rule of kernels/rules.md. (Switches cost more than rules: loops with them become no vector code.) Builds in
# build-ablate/without/. Needs valgrind.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
build=build-ablate/without
mkdir -p "$build"
launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
{
  cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTALUS_WITH_CUDA=OFF -DTALUS_BUILD_TESTS=ON \
    -DTALUS_TEST_ROOMS=none -DTALUS_WITHOUT_RULE="${1:-}" "${launcher[@]}"
  cmake --build "$build" --target talus-instructions
} >"$build/build.log" || { cat "$build/build.log" >&2; exit 1; }
exec valgrind --quiet --tool=callgrind --instr-atstart=no --callgrind-out-file="$build/S1" \
  "$build/bin/talus-instructions" S1 "$build/S1"
