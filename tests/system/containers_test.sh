#!/usr/bin/env bash
# containers_test.sh: builds the images (layers that are there are kept), starts what compose.yaml says, and has it
# work by peers alone: health checks, a grasp through the network, a hand that moves, a server started again, an edit,
# the page; then nothing may be left. Exits with 77 where containers cannot be run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
skip() { echo "containers_test: skipped: $*"; exit 77; }
# shellcheck source=docker/engine.sh
. docker/engine.sh || skip "neither docker nor podman with podman-compose runs here"
"$engine" image inspect debian:bookworm-slim >/dev/null 2>&1 || "$engine" pull -q debian:bookworm-slim >/dev/null 2>&1 ||
  skip "there is no image debian:bookworm-slim, nor a registry to have it from (docker/README.md)"
why=$("$engine" run --rm debian:bookworm-slim true 2>&1) || skip "$engine cannot run a container: $why"

export HANDGRAFT_PROJECT=hgtest$$ HANDGRAFT_PORT=$((20000 + RANDOM % 10000)) HANDGRAFT_DOMAIN=$((1 + RANDOM % 100))
scratch=$(mktemp -d)
dropping=""
tidy() {
  docker/containers.sh down 2>/dev/null || true
  [ -z "$dropping" ] || nft delete table bridge "$HANDGRAFT_PROJECT" || true
  rm -rf "$scratch"
}
trap tidy EXIT
fail() { echo "containers_test: $*" >&2; exit 1; }
say() { echo "$(date +%T) $*"; }

say "images"
docker/containers.sh images
say "up"
docker/containers.sh up
named() { "$engine" ps -a --format '{{.Names}}' | grep -E "^${HANDGRAFT_PROJECT}[_-]$1[_-]1\$"; }
server=$(named server) bridge=$(named bridge) page=$(named page)
network=${HANDGRAFT_PROJECT}_handgraft

# === No multicast between the containers
if nft -f - 2>"$scratch/why" <<NFT; then
table bridge $HANDGRAFT_PROJECT {
  chain forward {
    type filter hook forward priority 0; policy accept;
    ip daddr 239.255.0.1 udp dport $((7400 + 250 * HANDGRAFT_DOMAIN)) counter drop
  }
}
NFT
  dropping=yes
  say "multicast is dropped"
else
  say "multicast stays: $(head -1 "$scratch/why")"
fi

healthy() { # CONTAINER
  for _ in $(seq 60); do
    if [ "$engine" = podman ]; then podman healthcheck run "$1" >/dev/null 2>&1 && return; else
      [ "$(docker inspect --format '{{.State.Health.Status}}' "$1")" = healthy ] && return; fi
    sleep 0.5
  done
  "$engine" logs "$1" >&2 || true
  fail "$1 is not healthy after 30 s"
}
client() { # ARGUMENT...: a container beside the others, which names the server
  "$engine" run --rm -i --read-only --cap-drop all --tmpfs /tmp --network "$network" -e HANDGRAFT_PEERS=server -e HANDGRAFT_DOMAIN \
    handgraft-client "$@" 2>"$scratch/client.log" || { cat "$scratch/client.log" >&2; fail "handgraft $* failed"; }
}
grasp() { client grasp --hand barrett8 --object lemon --contacts lemon_6 --keep --json | sed -n 's/.*"session_id": *\([0-9]*\).*/\1/p' | head -1; }
moved() { # SESSION: since the bridge was last looked at, a pose of it was reached
  for _ in $(seq 150); do
    "$engine" logs "$bridge" 2>&1 | tail -n +"$((seen + 1))" >"$scratch/bridge.log"
    grep -q "session $1: pose .* reached" "$scratch/bridge.log" && { seen=$("$engine" logs "$bridge" 2>&1 | wc -l); return; }
    sleep 0.2
  done
  cat "$scratch/bridge.log" >&2
  fail "the emulated hand did not reach a pose of session $1 within 30 s"
}
arm() { # once it has a fresh pose: until then it is refused, which has to be told soon
  local begun=$SECONDS asked
  while [ $((SECONDS - begun)) -lt 20 ]; do
    asked=$SECONDS
    "$engine" exec "$bridge" handgraft bridge arm >"$scratch/arm" 2>&1 && return
    [ $((SECONDS - asked)) -le 8 ] || { cat "$scratch/arm" >&2; fail "handgraft bridge arm took $((SECONDS - asked)) s to answer"; }
    # On a machine that is busy otherwise the emulated motors may be too slow: a fault, which a person would reset.
    if grep 'RESET, then ARM' "$scratch/arm" >/dev/null; then
      say "$(head -1 "$scratch/arm"): reset"
      "$engine" exec "$bridge" handgraft bridge reset >/dev/null 2>&1 || true
    fi
    sleep 0.5
  done
  cat "$scratch/arm" >&2
  fail "the hand is not armed within 20 s"
}
seen=0

say "health"
for one in "$server" "$bridge" "$page"; do healthy "$one"; done
for one in "$server" "$bridge" "$page"; do
  [ "$("$engine" exec "$one" id -u)" = 10001 ] || fail "$one runs as another user"
  "$engine" exec "$one" sh -c 'touch /usr/local/x' 2>/dev/null && fail "$one may write to its root"
done

say "a grasp through the network moves the hand"
session=$(grasp)
[ -n "$session" ] || fail "the grasp names no session"
arm
moved "$session"
"$engine" logs "$bridge" 2>&1 | grep '^motors on' >/dev/null || fail "the emulated motors did not turn"

say "the server is started again, and the session goes on"
"$engine" restart -t 10 "$server" >/dev/null 2>&1 || fail "$server does not start again"
healthy "$server"
healthy "$bridge"
seen=$("$engine" logs "$bridge" 2>&1 | wc -l)
client sessions | grep "$session" >/dev/null || fail "session $session is lost"
arm
printf 'limit thumb_proximal_flex upper 0.5\nlimit index_proximal_flex upper 0.6\n' | client edit "$session" >"$scratch/edit"
moved "$session"

say "the page"
healthy "$page"
exec 3<>"/dev/tcp/127.0.0.1/$HANDGRAFT_PORT"
printf 'GET / HTTP/1.0\r\nHost: localhost:%s\r\n\r\n' "$HANDGRAFT_PORT" >&3
read -r answer <&3
exec 3>&-
[[ $answer == *" 200 "* ]] || fail "the page answers: $answer"
if [ -n "$dropping" ]; then
  nft list table bridge "$HANDGRAFT_PROJECT" | grep -E 'packets [1-9]' >/dev/null || fail "no multicast was dropped: nothing was proven"
fi

say "down"
docker/containers.sh down
"$engine" ps -a --format '{{.Names}}' | grep "$HANDGRAFT_PROJECT" && fail "containers are left over"
"$engine" network ls --format '{{.Name}}' | grep "$HANDGRAFT_PROJECT" && fail "a network is left over"
"$engine" volume ls --format '{{.Name}}' | grep "$HANDGRAFT_PROJECT" && fail "a volume is left over"
echo "containers_test: passed"
