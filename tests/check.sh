#!/usr/bin/env bash
# check.sh: what is too long for every change, step by step; ./dev check runs it. A step that
# passed is not run again until a tracked file changes; within lint, alone and the suites not even
# then what the change cannot have broken (.ci/passed.py). Prints each step's time and its last line.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
state=$({ git rev-parse HEAD; git diff HEAD; } | sha256sum | cut -c1-16)
passed=build/check/$state
mkdir -p "$passed"
jobs=$(nproc)
failed=()

step() { # NAME COMMAND...
  local name=$1 log=build/check/$1.log begun=$SECONDS
  shift
  if [ -e "$passed/$name" ]; then
    printf '%-12s passed before\n' "$name"
  elif "$@" >"$log" 2>&1; then
    touch "$passed/$name"
    printf '%-12s passed in %d s: %s\n' "$name" $((SECONDS - begun)) "$(tail -n 1 "$log")"
  else
    printf '%-12s FAILED in %d s, see %s\n' "$name" $((SECONDS - begun)) "$log"
    failed+=("$name")
  fi
}

# Without groups: each source and each header must include what it uses, and no name may hide another.
alone() {
  cmake --preset dev -B build/alone -DHANDGRAFT_UNITY=OFF
  cmake --build build/alone -j "$jobs" --target idl_generated
  python3 .ci/each_source.py build/alone alone
}

sanitized() { # PRESET REGEX
  cmake --preset "$1" -DBUILD_TESTING=ON
  cmake --build --preset "$1" -j "$jobs"
  python3 .ci/each_test.py "build/$1" "$2"
}

# What the steps below run.
step built ./dev build release
step lint ./dev lint
step alone alone
# Without CGAL: all of it builds, and works on the skins that the other build has made.
without_cgal() {
  cmake --preset release -B build/without_cgal -DHANDGRAFT_WITH_CGAL=OFF
  cmake --build build/without_cgal -j "$jobs"
  mkdir -p build/without_cgal/tests
  cp -r build/release/tests/cache build/without_cgal/tests/ 2>/dev/null || true
  python3 .ci/each_test.py build/without_cgal '^unit/'
}
step without_cgal without_cgal
# The Debian packages in a clean Debian; where no chroot can be made it says so, and that is no failure.
installed() {
  ./dev package
  tests/package/chroot_test.sh build/release/packages . || [ $? -eq 77 ]
}
step installed installed
step lives env HANDGRAFT_ALL_LIVES=1 build/release/tests/hardware_bridge_test --gtest_filter='*RandomLives*'
# Kept in the last line: killed how often, lost, twice, how soon clients go on.
lost() {
  HANDGRAFT_KILLS=200 HANDGRAFT_EDITS=2000 HANDGRAFT_SESSIONS=1000 XDG_CACHE_HOME=$PWD/build/release/tests/cache \
    build/release/tests/nothing_lost_test --gtest_filter='*HoweverOften*:FailingDisk.*:*ManySessions*' | tee build/check/lost.txt
  grep '^kills' build/check/lost.txt
}
step lost lost
step asan sanitized asan .
step tsan sanitized tsan 'Service|LiveEdits|StrandPool|WorkerPool|SolverThreads|Strand|Motion|Bridge|Transport'
# Without podman or docker it says so, and that is no failure.
containers() { tests/system/containers_test.sh || [ $? -eq 77 ]; }
step containers containers
step fuzz ./dev fuzz 30
[ ${#failed[@]} -eq 0 ] || { printf 'failed: %s\n' "${failed[*]}"; exit 1; }
