#!/usr/bin/env bash
# forged.sh PROGRAMS DOMAIN: plain edits in the name of a client that is there (forge.py). In an open domain they are done, as is
# said of one; in a secured domain none is, and the client is not cut off.
set -euo pipefail
bin=$(realpath "$1")
domain=$2
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
# shellcheck source=tests/system/programs.sh
. "$here/../programs.sh"
unset HANDGRAFT_IDENTITY
keys=$scratch/keys
"$bin/handgraft" keys init "$keys" >"$scratch/said"
"$bin/handgraft" keys add lab --role server --dir "$keys" >"$scratch/said"
"$bin/handgraft" keys add anna --role editor --dir "$keys" >"$scratch/said"

forged() { # NAME IDENTITY...: the client's exit code, 0 where its session has its own edits alone
  local server=() client=()
  [ $# = 1 ] || { server=(--identity "$keys/lab"); client=(--identity "$keys/anna"); }
  start "$1-server" "$bin/handgraft-server" --domain "$domain" "${server[@]}"
  local served=${pids[-1]}
  await event=ready "$scratch/$1-server.log"
  : >"$scratch/$1.log"
  start forge python3 "$here/forge.py" "$domain" "$scratch/$1.log" 8
  local forge=${pids[-1]}
  sleep 0.5
  "$bin/network_probe" --domain "$domain" "${client[@]}" edits --rate 2 --seconds 16 >"$scratch/$1" 2>"$scratch/$1.log" &
  local probe=$! code=0
  pids+=("$probe")
  wait "$forge" || fail "no forgery"
  cat "$scratch/forge.log"
  grep -q nobody "$scratch/forge.log" && fail "nobody was heard, in whose name to write"
  wait "$probe" || code=$?
  echo "$1: $(cat "$scratch/$1")"
  kill "$served"
  wait "$served" || true
  return "$code"
}
forged open && fail "in an open domain nothing was forged: this test shows nothing"
forged secured with || fail "edits were forged in a secured domain, or the client was cut off"
echo "forged: passed"
