#!/usr/bin/env bash
# names_test.sh PROGRAMS DOMAIN: three servers on one domain, two of them with names; who names one meets that one
# alone, who names none meets the one without a name.
set -euo pipefail
bin=$(realpath "$1")
export HANDGRAFT_DOMAIN=$2
# shellcheck source=tests/system/programs.sh
. "$(dirname "${BASH_SOURCE[0]}")/programs.sh"
words() { # FILE WORD...
  for word in "${@:2}"; do
    grep -q -e "$word" "$1" || { cat "$1" >&2; fail "'$word' is not said"; }
  done
}

for name in left right; do
  start "$name" "$bin/handgraft-server" --name "$name"
  await event=ready "$scratch/$name.log"
done

# === Who names none or another is told which there are
begun=$(date +%s%N)
"$bin/handgraft" doctor >"$scratch/doctor" 2>&1 && fail "a server with a name answered to none"
[ $((($(date +%s%N) - begun) / 1000000)) -lt 3000 ] || fail "the doctor took more than 3 s"
words "$scratch/doctor" '--server left' '--server right'
"$bin/handgraft" models --server middle >"$scratch/models" 2>&1 && fail "there is no server of that name"
words "$scratch/models" 'server middle' '--server left'
status=0
"$bin/handgraft" models --server 'le-ft' >"$scratch/models" 2>&1 || status=$?
[ "$status" = 2 ] || fail "a name that is none was taken"

# === Each keeps its own sessions and followers
start bridge_left "$bin/handgraft-bridge" --server left --bridge-id 1
start bridge_right "$bin/handgraft-bridge" --server right --bridge-id 2
"$bin/handgraft" grasp --hand barrett8 --object lemon --contacts lemon_6 --keep --json --server left >"$scratch/grasp" 2>&1 ||
  { cat "$scratch/grasp"; fail "no grasp of the left one"; }
session=$(sed -n 's/.*"session_id": *\([0-9]*\).*/\1/p' "$scratch/grasp" | head -1)
await "session $session" "$scratch/bridge_left.log"
[ "$(sessions --server left) $(HANDGRAFT_SERVER=right sessions)" = "1 0" ] || fail "sessions are not kept apart"
grep -q "session $session" "$scratch/bridge_right.log" && fail "the right one's bridge follows the left one"

# === A third one, without a name, is everybody's who names none; two of one name are told
start plain "$bin/handgraft-server"
await event=ready "$scratch/plain.log"
"$bin/handgraft" models >"$scratch/models" 2>&1 || { cat "$scratch/models"; fail "the one without a name does not answer"; }
[ "$(sessions)" = 0 ] || fail "the one without a name has another's sessions"
for log in left right plain; do
  grep -q another_server "$scratch/$log.log" && fail "servers of several names mind each other"
done
start second "$bin/handgraft-server" --name right
await event=another_server "$scratch/second.log"
await event=another_server "$scratch/right.log"
kill "${pids[-1]}"
wait "${pids[-1]}" || true

# === One that goes leaves the others
kill "${pids[0]}"
wait "${pids[0]}" || true
"$bin/handgraft" models --server left >"$scratch/models" 2>&1 && fail "a server that ended answers"
"$bin/handgraft" doctor --server right >"$scratch/doctor" || { cat "$scratch/doctor"; fail "the right one went along"; }
words "$scratch/doctor" 'right, '
echo "names_test: passed"
