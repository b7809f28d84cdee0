#!/usr/bin/env bash
# crowd.sh PROGRAMS DOMAIN [CLIENTS]: so many clients (90) begin at once; each finds the server, opens a session and has all of its
# edits answered. By hand: it takes a machine for a minute.
set -euo pipefail
bin=$(realpath "$1")
domain=$2
clients=${3:-90}
# shellcheck source=tests/system/programs.sh
. "$(dirname "${BASH_SOURCE[0]}")/../programs.sh"
start server "$bin/handgraft-server" --domain "$domain"
await event=ready "$scratch/server.log"
probes=()
for i in $(seq "$clients"); do
  "$bin/network_probe" --domain "$domain" edits --rate 1 --seconds 5 >"$scratch/probe$i.log" 2>&1 &
  probes+=($!)
  pids+=($!)
done
without=0
for i in $(seq "$clients"); do
  wait "${probes[$((i - 1))]}" || { without=$((without + 1)); tail -1 "$scratch/probe$i.log"; }
done
grep -h -o '"latest_ms":[0-9.]*' "$scratch"/probe*.log | sort -t: -k2 -n | tail -1
echo "$without of $clients were not answered in all; load $(cut -d' ' -f1 /proc/loadavg)"
[ "$without" = 0 ]
