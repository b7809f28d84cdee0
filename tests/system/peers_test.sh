#!/usr/bin/env bash
# peers_test.sh PROGRAMS: three hosts (network namespaces) behind a router, which passes no multicast; server,
# client and bridge find each other by --peers alone. Exits with 77 where namespaces cannot be made.
set -euo pipefail
bin=$(realpath "$1")
# shellcheck source=tests/system/hosts.sh
. "$(dirname "${BASH_SOURCE[0]}")/hosts.sh"
trap tidyHosts EXIT
fail() { echo "peers_test: $*" >&2; exit 1; }
makeRouter >"$scratch/skip" || { echo "peers_test: skipped: $(cat "$scratch/skip")"; exit 77; }

host 1
host 2
start 1 server "$bin/handgraft-server" --interface auto
await event=ready "$scratch/server.log"

# === Neither multicast nor peers: the cause and the option are named
begun=$(date +%s%N)
on 2 "$bin/handgraft" doctor --interface auto >"$scratch/doctor" 2>&1 && fail "a server was found without peers"
took_ms=$((($(date +%s%N) - begun) / 1000000))
[ "$took_ms" -lt 3000 ] || fail "the doctor took $took_ms ms"
for word in multicast --peers; do
  grep -q -e "$word" "$scratch/doctor" || { cat "$scratch/doctor"; fail "doctor does not say what to do"; }
done

# === Peers of the client alone, by option and by the environment
on 2 "$bin/handgraft" doctor --interface auto --peers 10.77.1.2 >"$scratch/doctor" 2>&1 || { cat "$scratch/doctor"; fail "no server by --peers"; }
HANDGRAFT_PEERS=10.77.9.9,10.77.1.2 HANDGRAFT_INTERFACE=eth0 on 2 "$bin/handgraft" models >"$scratch/models" 2>&1 || { cat "$scratch/models"; fail "no server by HANDGRAFT_PEERS"; }
on 2 "$bin/handgraft" grasp --hand barrett8 --object lemon --contacts lemon_6 --keep --json --interface auto --peers 10.77.1.2 \
  >"$scratch/grasp.json" 2>"$scratch/grasp.log" || { cat "$scratch/grasp.log"; fail "no grasp through the router"; }

# === A host that comes late: its bridge follows, and an edit from the other one reaches it
host 3
start 3 bridge "$bin/handgraft-bridge" --interface auto --peers 10.77.1.2 --session any
session=$(sed -n 's/.*"session_id": *\([0-9]*\).*/\1/p' "$scratch/grasp.json" | head -1)
[ -n "$session" ] || fail "the grasp names no session"
printf 'lock %s\nunlock %s\n' thumb_distal_flex thumb_distal_flex >"$scratch/edits"
on 2 "$bin/handgraft" edit "$session" --script "$scratch/edits" --interface auto --peers 10.77.1.2 >"$scratch/edit.log" 2>&1 ||
  { cat "$scratch/edit.log"; fail "no edit through the router"; }
await "session $session" "$scratch/bridge.log"

# === A host that changes its address: its bridge, started again, follows without a word to the others
kill "${pids[1]}"
wait "${pids[1]}" 2>/dev/null || true
readdress 3 10.77.3.9
start 3 bridge2 "$bin/handgraft-bridge" --interface auto --peers 10.77.1.2 --session any
await "session $session" "$scratch/bridge2.log"
on 2 "$bin/handgraft" bridge status --interface auto --peers 10.77.1.2,10.77.3.9 >"$scratch/status" 2>&1 ||
  { cat "$scratch/status"; fail "the bridge is not heard at its new address"; }

# === The server's host changes its address, too: who names the new one finds it, who names the old one is told
kill "${pids[0]}"
wait "${pids[0]}" 2>/dev/null || true
readdress 1 10.77.1.9
start 1 moved "$bin/handgraft-server" --interface auto
await event=ready "$scratch/moved.log"
on 2 "$bin/handgraft" doctor --interface auto --peers 10.77.1.2 >"$scratch/doctor" 2>&1 && fail "a server answers at an address that is gone"
grep -q 10.77.1.2 "$scratch/doctor" || { cat "$scratch/doctor"; fail "doctor does not say where it looked"; }
on 2 "$bin/handgraft" doctor --interface auto --peers 10.77.1.9 >"$scratch/doctor" 2>&1 || { cat "$scratch/doctor"; fail "no server at its new address"; }

# === Peers of the server alone, one of which has no address (yet)
kill "${pids[3]}"
wait "${pids[3]}" 2>/dev/null || true
start 1 server2 "$bin/handgraft-server" --interface auto --peers no.such.host.invalid,10.77.2.2
await event=ready "$scratch/server2.log"
on 2 "$bin/handgraft" doctor --interface auto >"$scratch/doctor" 2>&1 || { cat "$scratch/doctor"; fail "a server that names its client was not found"; }

# === A program whose network went away still ends
ip -n "$tag-3" link del eth0
kill "${pids[2]}"
for _ in $(seq 300); do kill -0 "${pids[2]}" 2>/dev/null || break; sleep 0.1; done
kill -0 "${pids[2]}" 2>/dev/null && fail "the bridge does not end by SIGTERM once its network is gone"
echo "peers_test: passed"
