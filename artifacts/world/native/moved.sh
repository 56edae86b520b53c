#!/bin/sh
# Removes what cmake keeps of its place in the folder of builds given, where that was moved since: cmake refuses to go on there.
set -eu
for cache in "$1"/*/build/*/out/build/CMakeCache.txt; do
    [ -e "$cache" ] || continue
    folder=$(cd "$(dirname "$cache")" && pwd)
    grep -qxF "CMAKE_CACHEFILE_DIR:INTERNAL=$folder" "$cache" || rm -r "$folder"
done
