#!/usr/bin/env bash
# replayed.sh PROGRAMS DOMAIN: whoever records a wire and plays it again. An operator arms a hand, disarms it and
# edits a session; the whole of it is sent again while all are there, once the operator's programs are gone, and to a server and a
# hand that were started anew. No session changes and no hand moves. Exit code 77 where a wire may not be recorded.
set -euo pipefail
bin=$(realpath "$1")
export HANDGRAFT_DOMAIN=$2
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
# shellcheck source=tests/system/programs.sh
. "$here/../programs.sh"
unset HANDGRAFT_IDENTITY
keys=$scratch/keys
export HANDGRAFT_STATE=$scratch/state
"$bin/handgraft" keys init "$keys" >"$scratch/said"
for name in server operator hand; do "$bin/handgraft" keys add "a-$name" --role "$name" --dir "$keys" >"$scratch/said"; done
as_operator() { HANDGRAFT_IDENTITY=$keys/a-operator timeout 60 "$bin/handgraft" "$@"; }
does() { as_operator "$@" >"$scratch/said" 2>&1 || { cat "$scratch/said"; fail "'$*' is not done"; }; }
field() { sed -n "s/.*\"$1\": *\"\{0,1\}\([a-z0-9]*\).*/\1/p" "$2" | head -1; }
state() { does bridge status --json; field state "$scratch/said"; }
revision() { does sessions --json; field revision "$scratch/said"; }
is_past() { [ "$(revision)" -gt "$1" ]; }

start recorder python3 "$here/replay.py" record "$scratch/wire" "$HANDGRAFT_DOMAIN"
recorder=${pids[-1]}
sleep 1
grep -q hears "$scratch/recorder.log" || { cat "$scratch/recorder.log"; echo "skipped: a wire may not be recorded here"; exit 77; }
run() { # NUMBER [OPTION...]: a server and a hand
  start "server$1" "$bin/handgraft-server" --identity "$keys/a-server"
  server=${pids[-1]}
  await event=ready "$scratch/server$1.log"
  start "hand$1" "$bin/handgraft-bridge" --identity "$keys/a-hand" --disarmed "${@:2}"
  hand=${pids[-1]}
  await 'simulated hand' "$scratch/hand$1.log"
}
run 1
does grasp --hand barrett8 --object lemon --contacts lemon_6 --keep --json
session=$(field session_id "$scratch/said")
await "session $session" "$scratch/hand1.log"
# A client that stays while it is replayed: its writers and numbers are known, its keys are in use.
mkfifo "$scratch/line"
exec 9<>"$scratch/line"
HANDGRAFT_IDENTITY=$keys/a-operator "$bin/handgraft" edit "$session" <"$scratch/line" >"$scratch/editing" 2>&1 &
editor=$!
pids+=("$editor")
before=$(revision)
echo 'weight palm 0.5' >&9
await_that is_past "$before" || { cat "$scratch/editing"; fail "no edit to record"; }
does bridge arm
[ "$(state)" = armed ] || fail "no ARM to record"
does bridge disarm
kill "$recorder"
wait "$recorder" || true
held=$(stat -c %s "$scratch/wire")
[ "$held" -gt 100000 ] || fail "only $held bytes were recorded"

unchanged() { # WHEN
  python3 "$here/replay.py" send "$scratch/wire" 2
  sleep 1
  [ "$(state)" = idle ] || { cat "$scratch/said"; fail "the hand is $(state), not idle, $1"; }
  [ "$(revision)" = "$after" ] || fail "a replayed edit was done $1: revision $(revision), was $after"
  for pid in "$server" "$hand"; do kill -0 "$pid" || fail "a program ended $1"; done
  echo "$1: nothing changed"
}
after=$(revision)
unchanged "while the editor is there"
echo 'weight palm 0.75' >&9 # it is not cut off either
await_that is_past "$after" || { cat "$scratch/editing"; fail "the editor was cut off by its own words"; }
after=$(revision)
kill "$editor"
wait "$editor" || true
unchanged "once the editor is gone"
kill "$server" "$hand"
wait "$server" "$hand" || true
# The session is named, since a hand passes over what only the store kept: an ARM would be taken here, were it heard.
run 2 --session "$session"
await "session $session" "$scratch/hand2.log"
unchanged "on a server and a hand started anew"
grep -q level=error "$scratch"/server?.log && { cat "$scratch"/server?.log; fail "the server logs errors"; }
does edit "$session" --script <(echo 'weight palm 1')
does bridge arm
[ "$(state)" = armed ] || fail "the operator's own ARM is not obeyed: the hand is $(state)"
echo "replayed: passed"
