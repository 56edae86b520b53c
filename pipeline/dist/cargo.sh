#!/bin/sh
# What maturin takes for cargo: it compiles as `cargo zigbuild` compiled the programs (same linker, same glibc), and so finds all that is compiled.
set -eu
if [ "$1" != rustc ]; then
    exec cargo "$@"
fi
shift
for word do
    shift
    [ "$word" != "$CAROM_TARGET" ] || word=$CAROM_TARGET.$CAROM_GLIBC
    set -- "$@" "$word"
done
exec cargo-zigbuild rustc "$@"
