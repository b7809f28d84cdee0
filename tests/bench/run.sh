#!/usr/bin/env bash
# run.sh BIN_DIR [NAME] [--json]: the benchmarks, each beside its baseline in the same run.
# Without ../shared/data only what the project ships is measured.
set -euo pipefail
bin=$1
shift
name=all
json=
for word in "$@"; do
  case $word in
    --json) json=--json ;;
    logmap | solve | all) name=$word ;;
    *)
      echo "bench: there is no benchmark '$word'; there are: logmap, solve" >&2
      exit 2
      ;;
  esac
done
data=${HANDGRAFT_SHARED_DATA:-../shared/data}
models=server/models

title() { [ -n "$json" ] || printf '\n== %s\n' "$*"; }

bench_logmap() {
  local mesh
  for mesh in "$models"/objects/*.obj "$data"/objects/ycb_16k/*.stl "$data"/objects/grab/*.obj; do
    [ -e "$mesh" ] || continue
    local radius
    for radius in 0.01 0.02 0.04; do
      title "log map about vertex 100 of $(basename "$mesh"), radius $radius m"
      "$bin/handgraft-bench" logmap "$mesh" --root-vertex 100 --radius "$radius"
    done
  done
}

bench_solve() {
  if [ -d "$data/problems" ]; then
    title "all solvers over the real problems of ../shared/data/problems"
    # shellcheck disable=SC2086
    "$bin/handgraft-bench" solvers "$data/problems" $json
  else
    title "the real problems need ../shared/data, which is not part of the project: skipped"
  fi
}

case $name in
  logmap) bench_logmap ;;
  solve) bench_solve ;;
  all)
    bench_logmap
    bench_solve
    ;;
esac
