#!/usr/bin/env bash
# much.sh PROGRAMS [PERCENT...]: an answer of 2 MB, each time to a new client, where so many per cent of frames are lost:
# it comes within 10 s, and the server sends at most three times its bytes. Exits with 77 where there can be no such network.
set -euo pipefail
bin=$(realpath "$1")
shift
[ $# -gt 0 ] || set -- 0 1 5 10
# shellcheck source=tests/system/network/wire.sh
. "$(dirname "${BASH_SOURCE[0]}")/wire.sh"
fail() { echo "much: $*" >&2; exit 1; }
makeWire >"$scratch/skip" || { echo "much: skipped: $(cat "$scratch/skip")"; exit 77; }
start a server "$bin/handgraft-server" --interface eth0
await event=ready "$scratch/server.log"
on b "$bin/network_probe" --interface eth0 much --times 1
for percent in "$@"; do
  order loss "$percent" >/dev/null
  for _ in 1 2 3; do
    order count >/dev/null
    answer=$(on b timeout 60 "$bin/network_probe" --interface eth0 much --there --times 1) || fail "$percent % lost: no answer"
    sent=$(order count)
    echo "$percent % lost: $answer $sent"
    python3 - "$answer" "$sent" <<'END_PY' || fail "$percent % lost: more than 10 s, or than three times its bytes"
import json, sys
answer, sent = map(json.loads, sys.argv[1:])
sys.exit(answer['took_ms'][0] > 10_000 or sent['a_bytes'] > 3 * answer['answer_bytes'])
END_PY
  done
done
