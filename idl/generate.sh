#!/usr/bin/env bash
# generate.sh FAST_DIR CYCLONE_DIR FILE.idl...: IDL files of one folder through both generators.
# fastddsgen can exit 0 after an exception, so its words decide, not its exit code. It is run once
# for all files, and on the quick compiler of Java: eight times less than once a file. What
# comes out as it was stays as it is, so that nothing is compiled for it.
set -euo pipefail
fast=$1 cyclone=$2
shift 2
mkdir -p "$fast" "$cyclone"
fast=$(cd "$fast" && pwd)
cyclone=$(cd "$cyclone" && pwd)
own=$fast/.generated  # a fixed name: it gets into the guards of headers
rm -rf "$own"
mkdir "$own"
trap 'rm -rf "$own"' EXIT
cd "$(dirname "$1")"
files=("${@##*/}")
said=$(JAVA_TOOL_OPTIONS="-XX:TieredStopAtLevel=1 -XX:+UseSerialGC" \
  fastddsgen -cs -replace -d "$own" -t "$own" -I . "${files[@]}" 2>&1) || { echo "$said" >&2; exit 1; }
if grep -qiE 'error|exception' <<<"$said"; then
  echo "$said" >&2
  exit 1
fi
mkdir "$own/cyclone"
for file in "${files[@]}"; do
  idlc -o "$own/cyclone" -I . "$file"
done

# replace FROM TO: only where they differ.
replace() { cmp -s "$1" "$2" || mv "$1" "$2"; }
for file in "${files[@]}"; do
  subject=${file%.idl}
  for generated in "$subject".{h,cxx} "$subject"PubSubTypes.{h,cxx}; do
    # Addresses of the generator's own objects, in comments: other ones at every run.
    sed -i -E 's|^( *// m_.*)@[0-9a-f]+$|\1|' "$own/$generated"
    replace "$own/$generated" "$fast/$generated"
  done
  for generated in "$subject".{h,c}; do
    sed -i "s|$own/cyclone/||" "$own/cyclone/$generated"
    replace "$own/cyclone/$generated" "$cyclone/$generated"
  done
done
