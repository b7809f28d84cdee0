#!/usr/bin/env bash
# generate.sh FILE.idl FAST_DIR CYCLONE_DIR: one IDL file through both generators.
# fastddsgen can exit 0 after an exception, so its words decide, not its exit code.
set -euo pipefail
file=$1 fast=$2 cyclone=$3
folder=$(dirname "$file")
mkdir -p "$fast" "$cyclone"
cd "$folder"
said=$(fastddsgen -cs -replace -d "$fast" -I . "$(basename "$file")" 2>&1) || { echo "$said" >&2; exit 1; }
if grep -qiE 'error|exception' <<<"$said"; then
  echo "$said" >&2
  exit 1
fi
idlc -o "$cyclone" -I . "$(basename "$file")"
