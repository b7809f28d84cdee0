#!/usr/bin/env bash
# hostile.sh PROGRAMS DOMAIN [COUNT [SEED]]: mutated datagrams of both vendors' own traffic (traffic.bin) at server, bridge and
# editor: all live, answer, and take no more memory at the end than at the half. COUNT of 1,000,000 by hand.
set -euo pipefail
bin=$(realpath "$1")
domain=$2
count=${3:-60000}
seed=${4:-1}
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
# shellcheck source=tests/system/programs.sh
. "$here/../programs.sh"
export HANDGRAFT_DOMAIN=$domain
start server "$bin/handgraft-server"
declare -A process
process[server]=${pids[-1]}
await event=ready "$scratch/server.log"
start bridge "$bin/handgraft-bridge" --session any
process[bridge]=${pids[-1]}
mkfifo "$scratch/keys"
exec 9<>"$scratch/keys"
"$bin/handgraft" edit --hand barrett8 --object lemon --contacts lemon_6 <"$scratch/keys" >"$scratch/editor.log" 2>&1 &
pids+=($!)
process[editor]=$!
await 'following session' "$scratch/bridge.log"
echo 'weight palm 0.5' >&9

memory() { awk '/VmRSS/ {print $2}' "/proc/$1/status" 2>/dev/null || echo 0; }
judge() { # WHEN
  for name in server bridge editor; do
    kill -0 "${process[$name]}" 2>/dev/null || { tail -5 "$scratch/$name.log"; fail "the $name died $1"; }
  done
  timeout 30 "$bin/handgraft" models >"$scratch/models" 2>&1 || { cat "$scratch/models"; fail "the server does not answer $1"; }
}
# Those that ended or wedged programs before there was a filter: a submessage of eProsima's own, type information of a kind
# that there is not, an announcement without a lease, heartbeats that jump by 2^60.
"$bin/hostile_traffic" "$here/known.bin" --domain "$domain" --as-recorded
sleep 1
judge "after known ones"
declare -A half
for part in 1 2; do
  "$bin/hostile_traffic" "$here/traffic.bin" --domain "$domain" --count $((count / 2)) --seed $((seed * 2 + part))
  judge "after part $part"
  for name in server bridge editor; do
    now=$(memory "${process[$name]}")
    echo "$name: $now kB"
    if [ "$part" = 1 ]; then
      half[$name]=$now
    else
      [ "$now" -lt $((half[$name] * 5 / 4 + 20000)) ] || fail "the $name took $now kB, ${half[$name]} at the half"
    fi
  done
done
before=$(grep -c . "$scratch/editor.log" || true)
echo 'weight palm 0.75' >&9
for _ in $(seq 300); do
  [ "$(grep -c . "$scratch/editor.log")" -gt "$before" ] && break
  sleep 0.1
done
[ "$(grep -c . "$scratch/editor.log")" -gt "$before" ] || fail "the editor does not answer any more"
judge "at the end"
echo "hostile: passed"
