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
    logmap | solve | tables | import | chain | retargeting | edits | page | discovery | table | all) name=$word ;;
    *)
      echo "bench: there is no benchmark '$word'; there are: logmap, solve, tables, import, chain, retargeting, edits, page, discovery, table" >&2
      exit 2
      ;;
  esac
done
data=${HANDGRAFT_SHARED_DATA:-../shared/data}
models=server/models
cache=build/bench_cache # skins take a minute to wrap at a given size

title() { [ -n "$json" ] || printf '\n== %s\n' "$*"; }

# The hand, object and contacts that log maps and transfers are timed on.
choose_grasp() {
  hand=$data/hands/allegro_right/allegro_hand_right.urdf
  object=$data/objects/ycb/006_mustard_bottle.obj
  contacts=$data/contacts/dexycb/006_mustard_bottle_grasp0_contact.ply
  [ -e "$hand" ] || hand=$models/hands/allegro16/allegro16.urdf
  [ -e "$contacts" ] && [ -e "$object" ] && return
  object=$models/objects/lemon.obj
  contacts=$models/contacts/lemon_6.json
}

# shellcheck disable=SC2086  # $json is one word or none
bench_logmap() {
  local mesh hand object contacts
  for mesh in "$models"/objects/*.obj "$data"/objects/ycb_16k/*.stl "$data"/objects/grab/*.obj; do
    [ -e "$mesh" ] || continue
    local radius
    for radius in 0.01 0.02 0.04; do
      title "log map about vertex 100 of $(basename "$mesh"), radius $radius m"
      "$bin/handgraft-bench" logmap "$mesh" --root-vertex 100 --radius "$radius"
    done
  done
  title "log maps against closed forms, on good and on bad triangles"
  "$bin/handgraft-bench" logmap-accuracy $json
  choose_grasp
  title "time of log maps on the skin of $hand and on spheres, beside CGAL's"
  "$bin/handgraft-bench" logmap-speed --hand "$hand" --cache "$cache" $json
  title "transfer of six patches of $contacts onto that skin"
  "$bin/handgraft-bench" transfer --hand "$hand" --object "$object" --contacts "$contacts" \
    --cache "$cache" $json
}

bench_solve() {
  if [ -d "$data/problems" ]; then
    title "all solvers over the real problems of ../shared/data/problems"
    # shellcheck disable=SC2086
    "$bin/handgraft-bench" solvers "$data/problems" $json
  else
    title "the real problems need ../shared/data, which is not part of the project: skipped"
  fi
  if [ -z "$json" ]; then
    title "pairs of hands and contacts, written as problems and solved from the files"
    [ -d "$data/hands" ] && export HANDGRAFT_SHARED_DATA=$data
    "$bin/handgraft-bench" pairs build/bench_pairs --cache "$cache"
  fi
}

# shellcheck disable=SC2086
bench_import() {
  title "what the hands of server/models become on import"
  "$bin/handgraft-bench" import "$models/hands" $json
  if [ -d "$data/hands" ]; then
    title "what the hands and contact maps of ../shared/data become on import"
    "$bin/handgraft-bench" import "$data/hands" "$data/contacts" $json
  fi
}

# shellcheck disable=SC2086
bench_chain() {
  local hand hands=() shipped
  for hand in "$models"/hands/*/*.urdf; do hands+=(--hand "$hand"); done
  shipped=(--object "$models/objects/lemon.obj" --contacts "$models/contacts/lemon_6.json")
  title "hands of server/models grasp its lemon, sites found"
  "$bin/handgraft-bench" chain "${hands[@]}" "${shipped[@]}" --cache "$cache" $json
  if [ -z "$json" ]; then
    title "fingertips dragged at random, and three edits after each"
    "$bin/handgraft-bench" drags --cache "$cache"
    title "in glasses, cartons, skins, sheets and mugs"
    "$bin/handgraft-bench" thin-walls --cache "$cache"
  fi
  if [ -d "$data/hands" ]; then
    title "hands of ../shared/data grasp scanned objects, nothing given but the files"
    HANDGRAFT_SHARED_DATA=$data "$bin/handgraft-bench" chain --cache "$cache" $json
  fi
}

# shellcheck disable=SC2086
bench_retargeting() {
  if [ ! -d "$data/hands" ]; then
    title "retargeting needs ../shared/data, which is not part of the project: skipped"
    return
  fi
  title "recorded human grasps on the hands of ../shared/data, beside what is used today"
  HANDGRAFT_SHARED_DATA=$data "$bin/handgraft-bench" retargeting --cache "$cache" $json
}

# shellcheck disable=SC2086
bench_edits() {
  local hand object contacts grasp
  choose_grasp
  grasp=(--hand "$hand" --object "$object" --contacts "$contacts")
  title "from an edit to its pose, a server and an editor on loopback, $(basename "$hand")"
  "$bin/handgraft-edit-bench" latency "${grasp[@]}" $json
  title "a hundred sessions, ten edits a second each"
  "$bin/handgraft-edit-bench" crowd --seconds 20 "${grasp[@]}" $json
  title "ten thousand edits a second on one session, another one beside it"
  "$bin/handgraft-edit-bench" flood --seconds 5 "${grasp[@]}" $json
}

# shellcheck disable=SC2086
bench_page() {
  local hand object contacts
  choose_grasp
  title "the page in a browser: first picture, and a root dragged, $(basename "$hand")"
  HANDGRAFT_STATE=:memory: node tests/bench/page/page_bench.mjs "$bin" "$bin/../client/web" build/bench_page \
    "${HANDGRAFT_DOMAIN:-96}" "$hand" "$object" "$contacts" $json
}

# write_between FILE WORDS COMMAND...: puts what the command prints between the lines
# "<!-- WORDS: ..." and "<!-- end of WORDS -->" of a file.
write_between() {
  local file=$1 words=$2 table
  shift 2
  table=$(mktemp)
  "$@" >"$table"
  awk -v table="$table" -v words="$words" '
    index($0, "<!-- " words ": ") == 1 { print; while ((getline line < table) > 0) print line; inside = 1 }
    index($0, "<!-- end of " words " -->") == 1 { inside = 0; found = 1 }
    !inside { print }
    END { exit !found }
  ' "$file" >"$table.new"
  cat "$table.new" >"$file"
  rm "$table" "$table.new"
  echo "bench: $file holds the table of this build"
}

case $name in
  logmap) bench_logmap ;;
  solve) bench_solve ;;
  import) bench_import ;;
  chain) bench_chain ;;
  retargeting) bench_retargeting ;;
  edits) bench_edits ;;
  page) bench_page ;;
  discovery) tests/bench/discovery.sh "$bin" ;;
  table)
    write_between core/geometry/DECISIONS.md "accuracy table" "$bin/handgraft-bench" logmap-accuracy --markdown
    ;;
  tables)
    write_between tests/bench/DECISIONS.md "paper tables" "$bin/handgraft-bench" tables --cache "$cache"
    ;;
  all)
    bench_logmap
    bench_solve
    bench_import
    bench_chain
    bench_retargeting
    bench_edits
    ;;
esac
