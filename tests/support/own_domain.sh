#!/usr/bin/env bash
# Runs a command with @ among its words replaced by a DDS domain that no other test of this machine uses
# (test_domain.h): own_domain.sh PROGRAM --domain @
set -euo pipefail
for ((i = 0; i < 100; ++i)); do
  domain=$((1 + ($$ + i) % 100))
  exec {lock}>"${TMPDIR:-/tmp}/handgraft_test_domain_$domain"
  if flock -n "$lock"; then
    words=()
    for word in "$@"; do
      [ "$word" = @ ] && word=$domain
      words+=("$word")
    done
    exec "${words[@]}"
  fi
  exec {lock}>&-
done
echo "own_domain: all DDS domains from 1 to 100 are taken by other tests" >&2
exit 1
