# programs.sh: what tests of programs on this machine stand on, after `bin` is set: a scratch folder, programs in the
# background, waiting for their words. Sourced.
# shellcheck shell=bash
export HANDGRAFT_STATE=:memory:
scratch=$(mktemp -d)
pids=()
tidy() {
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$scratch"
}
trap tidy EXIT
fail() { echo "$(basename "$0" .sh): $*" >&2; exit 1; }
start() { # NAME COMMAND...: in the background, its words in NAME.log
  "${@:2}" >"$scratch/$1.log" 2>&1 &
  pids+=($!)
}
await() { # WORDS FILE
  for _ in $(seq 300); do
    grep -q "$1" "$2" 2>/dev/null && return
    sleep 0.1
  done
  cat "$2" >&2
  fail "waited 30 s for '$1' in $(basename "$2")"
}
# shellcheck disable=SC2154  # of who sources this
sessions() { "$bin/handgraft" sessions --json "$@" | grep -o '"session_id"' | wc -l; }
await_that() { # COMMAND...: until it succeeds, 10 s at most
  for _ in $(seq 100); do
    "$@" && return
    sleep 0.1
  done
  return 1
}
