#!/usr/bin/env bash
# domains_test.sh PROGRAMS DOMAIN [DOMAIN [DOMAIN]]: a server on each of two domains of one machine, none on a third;
# who names a domain, by option or environment, meets its server and nothing of the other's.
set -euo pipefail
if [ $# -lt 4 ]; then # the others are ours alone, too
  exec "$(dirname "${BASH_SOURCE[0]}")/../support/own_domain.sh" bash "${BASH_SOURCE[0]}" "$@" @
fi
bin=$(realpath "$1")
one=$2 other=$3 empty=$4
unset HANDGRAFT_DOMAIN HANDGRAFT_SERVER HANDGRAFT_PEERS HANDGRAFT_INTERFACE
# shellcheck source=tests/system/programs.sh
. "$(dirname "${BASH_SOURCE[0]}")/programs.sh"

start one "$bin/handgraft-server" --domain "$one"
HANDGRAFT_DOMAIN=$other start other "$bin/handgraft-server"
for name in one other; do await event=ready "$scratch/$name.log"; done
start bridge_one "$bin/handgraft-bridge" --domain "$one"
start bridge_other "$bin/handgraft-bridge" --domain "$other" # of the same number: on another domain it is no rival

# === Each keeps its own sessions, edits and followers
"$bin/handgraft" grasp --hand barrett8 --object lemon --contacts lemon_6 --keep --json --domain "$one" >"$scratch/grasp" 2>&1 ||
  { cat "$scratch/grasp"; fail "no grasp on domain $one"; }
session=$(sed -n 's/.*"session_id": *\([0-9]*\).*/\1/p' "$scratch/grasp" | head -1)
[ -n "$session" ] || fail "the grasp names no session"
await "session $session" "$scratch/bridge_one.log"
[ "$(sessions --domain "$one") $(HANDGRAFT_DOMAIN=$other sessions)" = "1 0" ] || fail "sessions are not kept apart"
[ "$(HANDGRAFT_DOMAIN=$other sessions --domain "$one")" = 1 ] || fail "the option does not go before the environment"
edit() { echo 'limit thumb_proximal_flex upper 0.5' | "$bin/handgraft" edit "$session" --domain "$1" >"$scratch/edit" 2>&1; }
edit "$one" || { cat "$scratch/edit"; fail "no edit on domain $one"; }
edit "$other" && fail "the other domain's server edits a session that is not its own"
grep -q "$session" "$scratch/edit" || { cat "$scratch/edit"; fail "it is not said which session there is not"; }
grep -q "session $session" "$scratch/bridge_other.log" && fail "the other domain's bridge follows it"
for log in one other; do
  grep -q another_server "$scratch/$log.log" && fail "servers of two domains mind each other"
done

# === Where there is none, it is said where was looked
begun=$(date +%s%N)
"$bin/handgraft" doctor --domain "$empty" >"$scratch/doctor" 2>&1 && fail "a server answers on domain $empty"
[ $((($(date +%s%N) - begun) / 1000000)) -lt 3000 ] || fail "the doctor took more than 3 s"
grep -q "domain $empty" "$scratch/doctor" || { cat "$scratch/doctor"; fail "the doctor does not say where it looked"; }

# === One that goes leaves the other
kill "${pids[0]}"
wait "${pids[0]}" || true
"$bin/handgraft" doctor --domain "$other" >"$scratch/doctor" || { cat "$scratch/doctor"; fail "the other one went along"; }
echo "domains_test: passed"
