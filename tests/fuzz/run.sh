#!/usr/bin/env bash
# run.sh BIN_DIR [MINUTES] [TARGET]: fuzzes the readers of uploaded files and what follows them,
# each target for its share of the minutes (10 in all unless said), from seeds made here and
# now. What it finds is kept in build/fuzz/corpus for the next run; inputs that break a promise
# are left in build/fuzz/findings. Exit code 1 if there is any.
set -euo pipefail
bin=$1
minutes=${2:-10}
targets=(mesh_file raw_mesh urdf contact_set contact_map packed session_file dynamixel ability_hand inspire can hand_config calibration)
[ $# -lt 3 ] || targets=("$3")
corpus=build/fuzz/corpus
findings=build/fuzz/findings

case $minutes in
  '' | *[!0-9]* | 0)
    echo "fuzz: '$minutes' minutes, permitted are whole numbers from 1" >&2
    exit 2
    ;;
esac
mkdir -p "$corpus" "$findings"
python3 tests/fuzz/make_corpus.py server/models/objects "$corpus"
python3 tests/fuzz/make_text_corpus.py server/models/hands "$corpus"
mkdir -p "$corpus/hand_config" "$corpus/calibration"
cp hardware/config/examples/*.yaml "$corpus/hand_config"
printf 'format: handgraft-calibration/1\nhand: h\nmotors:\n  - {name: a, zero_rad: 0.5, direction: -1}\n  - {name: b, zero_rad: -1e-3, direction: 1}\n' \
  >"$corpus/calibration/two_motors.yaml"
cp -r tests/fuzz/regressions/. "$corpus"

declare -A longest=([mesh_file]=8192 [raw_mesh]=2048 [urdf]=16384 [contact_set]=4096 [contact_map]=12288 [packed]=256 [session_file]=2048 [dynamixel]=1024 [ability_hand]=1024 [inspire]=1024
  [can]=1024 [hand_config]=6144 [calibration]=1024)
failed=0
for target in "${targets[@]}"; do
  if [ -z "${longest[$target]:-}" ]; then
    echo "fuzz: no target '$target', there are: ${!longest[*]}" >&2
    exit 2
  fi
  options=(-max_total_time=$((60 * minutes / ${#targets[@]})) -timeout=20 -rss_limit_mb=3000
    -print_final_stats=1 -verbosity=1 "-max_len=${longest[$target]}" "-artifact_prefix=$findings/${target}_")
  [ -f "tests/fuzz/$target.dict" ] && options+=("-dict=tests/fuzz/$target.dict")
  printf '== %s_fuzz\n' "$target"
  mkdir -p "$corpus/$target" # some have no seeds
  log=build/fuzz/$target.log
  if ! "$bin/${target}_fuzz" "${options[@]}" "$corpus/$target" >"$log" 2>&1; then
    failed=1
    tail -n 60 "$log"
  fi
  # Executions, coverage (edges), features, and what stands in the way.
  grep -E ' (INITED|DONE|NEW|REDUCE|pulse) ' "$log" | tail -n 1 || true
  grep -E '^stat::(number_of_executed_units|average_exec_per_sec|slowest_unit|peak_rss)' "$log" || true
done
[ $failed = 0 ] || echo "fuzz: findings are in $findings; try one with $bin/TARGET_fuzz FILE" >&2
exit $failed
