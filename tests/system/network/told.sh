#!/usr/bin/env bash
# told.sh PROGRAMS [CASE...]: what clients are told where the network is as networks are; a table of what was asked, answered,
# how often, how late. Cases: lossy:SECONDS (20 % lost, 50 ms each way), cut:SECONDS (a partition that heals),
# stop:PROGRAM:SECONDS (SIGSTOP of server, editor or bridge). Exits with 77 where there can be no such network.
set -euo pipefail
bin=$(realpath "$1")
shift
[ $# -gt 0 ] || set -- lossy cut:10 cut:60 stop:server:5 stop:server:15 stop:server:40 stop:editor:5 stop:editor:15 \
  stop:editor:40 stop:bridge:5 stop:bridge:15 stop:bridge:40
# shellcheck source=tests/system/network/wire.sh
. "$(dirname "${BASH_SOURCE[0]}")/wire.sh"
fail() { echo "told: $*" >&2; exit 1; }
makeWire >"$scratch/skip" || { echo "told: skipped: $(cat "$scratch/skip")"; exit 77; }
start a server "$bin/handgraft-server" --interface eth0
server=${pids[-1]}
await event=ready "$scratch/server.log"

edits() { # SECONDS: a stream of edits and questions from the other host, in the background
  start b probe "$bin/network_probe" --interface eth0 edits --rate 10 --seconds "$1"
  probe=${pids[-1]}
  await session "$scratch/probe.log"
}
told() { # CASE: once the stream has ended
  local code=0
  wait "$probe" || code=$?
  echo "$1: $(tail -1 "$scratch/probe.log")"
  [ "$code" = 0 ] || fail "$1: something was never answered, or done more or less often than told"
}

for case in "$@"; do
  IFS=: read -r what first second <<<"$case"
  case $what in
  lossy)
    order loss 20 >/dev/null
    order delay 50 >/dev/null
    edits "${first:-10}"
    told "$case"
    order loss 0 >/dev/null
    order delay 0 >/dev/null
    ;;
  cut)
    edits $((first + 4))
    sleep 2
    order cut 1 >/dev/null
    sleep "$first"
    order cut 0 >/dev/null
    told "$case"
    ;;
  stop)
    edits $((second + 4))
    case $first in
    server) stopped=$server ;;
    editor) stopped=$probe ;;
    bridge)
      start b bridge "$bin/handgraft-bridge" --interface eth0 --session "$(sed -n 's/session //p' "$scratch/probe.log")"
      stopped=${pids[-1]}
      await "session " "$scratch/bridge.log"
      ;;
    *) fail "$case: server, editor or bridge" ;;
    esac
    sleep 2
    kill -STOP "$stopped"
    sleep "$second"
    kill -CONT "$stopped"
    told "$case"
    [ "$first" != bridge ] || { kill "$stopped"; wait "$stopped" || true; cat "$scratch/bridge.log" >&2; }
    ;;
  *) fail "$case: lossy, cut:SECONDS or stop:PROGRAM:SECONDS" ;;
  esac
done
