#!/usr/bin/env bash
# generate.sh FILE.idl FAST_DIR CYCLONE_DIR: one IDL file through both generators.
# fastddsgen can exit 0 after an exception, so its words decide, not its exit code. It also writes
# the classes of every file included; side by side, several would write one file at once. So each
# works in a folder of its own and hands over its own file's classes.
set -euo pipefail
file=$1 fast=$2 cyclone=$3
folder=$(dirname "$file")
subject=$(basename "$file" .idl)
mkdir -p "$fast" "$cyclone"
fast=$(cd "$fast" && pwd)
own=$(mktemp -d "$fast/.$subject.XXXXXX")
trap 'rm -rf "$own"' EXIT
cd "$folder"
said=$(fastddsgen -cs -replace -d "$own" -t "$own" -I . "$subject.idl" 2>&1) || { echo "$said" >&2; exit 1; }
if grep -qiE 'error|exception' <<<"$said"; then
  echo "$said" >&2
  exit 1
fi
for generated in "$subject".{h,cxx} "$subject"PubSubTypes.{h,cxx}; do
  # Addresses of the generator's own objects, in comments: other ones at every run.
  sed -i -E 's|^( *// m_.*)@[0-9a-f]+$|\1|' "$own/$generated"
  mv "$own/$generated" "$fast/$generated"
done
idlc -o "$cyclone" -I . "$subject.idl"
