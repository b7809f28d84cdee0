#!/usr/bin/env bash
# demo.sh BIN_DIR OUT_DIR: the main job on the built-in library, through all three programs.
set -euo pipefail
bin=$1
out=$2
mkdir -p "$out"
domain=${HANDGRAFT_DEMO_DOMAIN:-$((RANDOM % 100 + 1))}

say() { printf '\n\033[1m== %s\033[0m\n' "$*"; }

say "a server (Fast DDS) and a bridge with a simulated hand (Cyclone DDS), on loopback, domain $domain"
"$bin/handgraft-server" --domain "$domain" --state :memory: --log-level warning 2>"$out/server.log" &
server=$!
"$bin/handgraft-bridge" --domain "$domain" --json >"$out/bridge.jsonl" 2>"$out/bridge.log" &
bridge=$!
# shellcheck disable=SC2317  # called by the trap
finish() {
  kill -TERM "$bridge" "$server" 2>/dev/null || true
  wait "$bridge" "$server" 2>/dev/null || true
}
trap finish EXIT

failed=0
while read -r hand object contacts; do
  say "$hand grasps $object ($contacts)"
  "$bin/handgraft" grasp --domain "$domain" --hand "$hand" --object "$object" --contacts "$contacts" \
    --png "$out/${hand}_${object}.png" --out "$out/${hand}_${object}.json" || failed=1
done <<'END'
human20 lemon lemon_6
human20 scissors scissors_3
allegro16 box box_5
barrett8 lemon lemon_6
tendon16 wine_glass wine_glass_4
END

say "a box is pulled off a shelf and turned: index and middle slide, the little finger lets go"
data=$(dirname "${BASH_SOURCE[0]}")/demo
"$bin/handgraft" motion join --domain "$domain" box_5 "$data/box_4.json" --path "$data/pull.csv" --name box_pull \
  --out "$out/box_pull.json" || failed=1
for hand in human20 tendon16; do
  "$bin/handgraft" motion solve --domain "$domain" --hand "$hand" --motion box_pull --png "$out/${hand}_box_pull.png" \
    --out "$out/${hand}_box_pull.glb" --out "$out/${hand}_box_pull.npz" || failed=1
done

say "the simulated hand follows"
sleep 2
tail -n 1 "$out/bridge.jsonl"

say "pictures"
ls "$out"/*.png

view=("$bin/handgraft" view --domain "$domain" --hand human20 --object lemon --contacts lemon_6)
if [ -t 0 ] && [ -t 1 ]; then
  say "see it and touch it: a page at this link"
  "${view[@]}" || failed=1
else
  say "see it and touch it: ./dev run handgraft view --hand human20 --object lemon --contacts lemon_6"
fi
exit "$failed"
