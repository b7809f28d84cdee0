# shellcheck shell=bash
# To be sourced: hosts (network namespaces) behind a router that passes no multicast. `scratch`, `tag`, `hosts`, `pids`
# are its variables; `makeRouter` returns other than 0 and says why where namespaces cannot be made.
scratch=$(mktemp -d)
tag=hg$$
hosts=()
pids=()

tidyHosts() {
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  # What these started in turn is theirs, too: first asked, then ended.
  for signal in TERM KILL; do
    for host in "${hosts[@]}"; do
      ip netns pids "$host" 2>/dev/null | xargs -r kill "-$signal" 2>/dev/null || true
    done
    [ "$signal" = KILL ] || sleep 1
  done
  for host in "${hosts[@]}"; do ip netns del "$host" 2>/dev/null || true; done
  rm -rf "$scratch"
}

makeRouter() {
  command -v ip >/dev/null || { echo "there is no ip (Debian: iproute2)"; return 1; }
  ip netns add "$tag-router" 2>"$scratch/why" || { echo "network namespaces cannot be made: $(cat "$scratch/why")"; return 1; }
  hosts+=("$tag-router")
  ip netns exec "$tag-router" sh -c 'echo 1 >/proc/sys/net/ipv4/ip_forward' 2>"$scratch/why" || { echo "no routing here: $(cat "$scratch/why")"; return 1; }
}

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
readdress() { # N ADDRESS: the host has another one from now on
  ip -n "$tag-$1" addr flush dev eth0
  ip -n "$tag-$1" addr add "$2/24" dev eth0
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
await() { # WORDS FILE: within 30 s
  for _ in $(seq 300); do
    grep -q "$1" "$2" 2>/dev/null && return
    sleep 0.1
  done
  cat "$2" >&2
  echo "waited 30 s for '$1' in $(basename "$2")" >&2
  return 1
}
