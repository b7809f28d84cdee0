#!/usr/bin/env bash
# Runs a command with @ among its words replaced by a DDS domain that no other test of this machine uses, and no other
# program has joined (test_domain.h): own_domain.sh PROGRAM --domain @
set -euo pipefail
is_taken() { # DOMAIN: a program hears on one of its ports
  local begin=$((7400 + 250 * $1)) port
  while read -r _ port _; do
    port=$((16#${port##*:}))
    if ((port >= begin && port < begin + 250)); then return 0; fi
  done < <(tail -n +2 /proc/net/udp)
  return 1
}
for ((i = 0; i < 100; ++i)); do
  domain=$((1 + ($$ + i) % 100))
  exec {lock}>"${TMPDIR:-/tmp}/handgraft_test_domain_$domain"
  if flock -n "$lock" && ! is_taken "$domain"; then
    words=()
    for word in "$@"; do
      [ "$word" = @ ] && word=$domain
      words+=("$word")
    done
    exec "${words[@]}"
  fi
  exec {lock}>&-
done
echo "own_domain: all DDS domains from 1 to 100 are taken by other programs" >&2
exit 1
