#!/usr/bin/env bash
# peers_test.sh PROGRAMS: three hosts (network namespaces) behind a router, which passes no multicast; server,
# client and bridge find each other by --peers alone. Exits with 77 where namespaces cannot be made.
set -euo pipefail
bin=$(realpath "$1")
scratch=$(mktemp -d)
tag=hg$$
hosts=()
pids=()

tidy() {
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  for host in "${hosts[@]}"; do ip netns del "$host" 2>/dev/null || true; done
  rm -rf "$scratch"
}
trap tidy EXIT
fail() { echo "peers_test: $*" >&2; exit 1; }
skip() { echo "peers_test: skipped: $*"; exit 77; }

command -v ip >/dev/null || skip "there is no ip (Debian: iproute2)"
ip netns add "$tag-router" 2>"$scratch/why" || skip "network namespaces cannot be made: $(cat "$scratch/why")"
hosts+=("$tag-router")
ip netns exec "$tag-router" sh -c 'echo 1 >/proc/sys/net/ipv4/ip_forward' 2>"$scratch/why" || skip "no routing here: $(cat "$scratch/why")"

host() { # N: the host 10.77.N.2 behind the router's 10.77.N.1
  ip netns add "$tag-$1"
  hosts+=("$tag-$1")
  ip -n "$tag-router" link add "p$1" type veth peer name eth0 netns "$tag-$1"
  ip -n "$tag-router" addr add "10.77.$1.1/24" dev "p$1"
  ip -n "$tag-router" link set "p$1" up
  ip -n "$tag-$1" link set lo up
  ip -n "$tag-$1" link set eth0 up
  ip -n "$tag-$1" addr add "10.77.$1.2/24" dev eth0
  ip -n "$tag-$1" route add default via "10.77.$1.1"
}
on() { # N COMMAND...
  local n=$1
  shift
  HOME=$scratch XDG_CACHE_HOME=$scratch ip netns exec "$tag-$n" "$@"
}
start() { # N NAME COMMAND...: in the background, its words in NAME.log
  local n=$1 name=$2
  shift 2
  (HOME=$scratch XDG_CACHE_HOME=$scratch exec ip netns exec "$tag-$n" "$@") >"$scratch/$name.log" 2>&1 &
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

host 1
host 2
start 1 server "$bin/handgraft-server" --interface auto
await event=ready "$scratch/server.log"

# === Neither multicast nor peers: the cause and the option are named
on 2 "$bin/handgraft" doctor --interface auto >"$scratch/doctor" 2>&1 && fail "a server was found without peers"
grep -q multicast "$scratch/doctor" && grep -q -- --peers "$scratch/doctor" || { cat "$scratch/doctor"; fail "doctor does not say what to do"; }

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

# === Peers of the server alone
kill "${pids[0]}"
wait "${pids[0]}" 2>/dev/null || true
start 1 server2 "$bin/handgraft-server" --interface auto --peers 10.77.2.2
await event=ready "$scratch/server2.log"
on 2 "$bin/handgraft" doctor --interface auto >"$scratch/doctor" 2>&1 || { cat "$scratch/doctor"; fail "a server that names its client was not found"; }

# === A program whose network went away still ends
ip -n "$tag-3" link del eth0
kill "${pids[1]}"
for _ in $(seq 300); do kill -0 "${pids[1]}" 2>/dev/null || break; sleep 0.1; done
kill -0 "${pids[1]}" 2>/dev/null && fail "the bridge does not end by SIGTERM once its network is gone"
echo "peers_test: passed"
