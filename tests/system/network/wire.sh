# shellcheck shell=bash
# To be sourced, after `bin` is set: two hosts, 10.78.0.1 (on a) and .2 (on b), and a bad wire between them (wire.py).
scratch=$(mktemp -d)
tag=hgw$$
pids=()

tidyWire() {
  for pid in "${pids[@]}"; do kill -CONT "$pid" 2>/dev/null || true; kill "$pid" 2>/dev/null || true; done
  for host in "$tag-a" "$tag-b"; do
    ip netns pids "$host" 2>/dev/null | xargs -r kill -KILL 2>/dev/null || true
    ip netns del "$host" 2>/dev/null || true
  done
  wait 2>/dev/null || true
  rm -rf "$scratch"
}
trap tidyWire EXIT

makeWire() { # returns other than 0 and says why where there can be none
  command -v ip >/dev/null || { echo "there is no ip (Debian: iproute2)"; return 1; }
  [ -w /dev/net/tun ] || { echo "/dev/net/tun cannot be written"; return 1; }
  for host in a b; do
    ip netns add "$tag-$host" 2>"$scratch/why" || { echo "network namespaces cannot be made: $(cat "$scratch/why")"; return 1; }
  done
  mkfifo "$scratch/orders"
  python3 "$(dirname "${BASH_SOURCE[0]}")/wire.py" "$tag-a" "$tag-b" "$scratch/orders" >"$scratch/wire.log" 2>"$scratch/wire.err" &
  pids+=($!)
  await wired "$scratch/wire.log"
}
order() { # WORDS...: to the wire; prints what it answers
  local before
  before=$(wc -l <"$scratch/wire.log")
  echo "$*" >"$scratch/orders"
  for _ in $(seq 200); do
    [ "$(wc -l <"$scratch/wire.log")" -gt "$before" ] && break
    sleep 0.02
  done
  tail -1 "$scratch/wire.log"
}
on() { # HOST COMMAND...
  local host=$1
  shift
  HOME=$scratch XDG_CACHE_HOME=$scratch HANDGRAFT_STATE=$scratch/state ip netns exec "$tag-$host" "$@"
}
start() { # HOST NAME COMMAND...: in the background, its words in NAME.log
  local host=$1 name=$2
  shift 2
  (HOME=$scratch XDG_CACHE_HOME=$scratch HANDGRAFT_STATE=$scratch/state exec ip netns exec "$tag-$host" "$@") >"$scratch/$name.log" 2>&1 &
  pids+=($!)
}
await() { # WORDS FILE: within 60 s
  for _ in $(seq 600); do
    grep -q "$1" "$2" 2>/dev/null && return
    sleep 0.1
  done
  cat "$2" >&2
  echo "waited 60 s for '$1' in $(basename "$2")" >&2
  return 1
}
