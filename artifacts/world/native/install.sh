#!/bin/sh
# `install.sh FOLDER [MACHINE]`: unpacks MuJoCo's library and cmake from their PyPI wheels into the folder, for this machine or another kind (`aarch64`);
# does nothing where they are.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
into=$1
stamp="$into/$(cksum < "$here/requirements.txt" | tr ' ' '-').done"
[ ! -e "$stamp" ] || exit 0

python3 -m pip --version > /dev/null 2>&1 || {
    echo "carom's set-up needs Python 3 with pip (on Debian: apt-get install python3-pip)" >&2
    exit 1
}
rm -rf "$into"
mkdir -p "$into/wheels"
machine=${2:-$(uname -m)}
python3 -m pip download --quiet --disable-pip-version-check --no-deps --require-hashes --only-binary=:all: \
    --python-version 3.11 --implementation cp --abi cp311 --abi none \
    --platform "manylinux_2_28_$machine" --platform "manylinux2014_$machine" \
    --dest "$into/wheels" --requirement "$here/requirements.txt"
for wheel in "$into"/wheels/*.whl; do
    python3 -m zipfile -e "$wheel" "$into/unpacked"
done
mkdir -p "$into/lib" "$into/bin"
mv "$into/unpacked/mujoco/libmujoco.so.3.17.0" "$into/lib/"
ln -s libmujoco.so.3.17.0 "$into/lib/libmujoco.so"
mv "$into/unpacked/cmake/data" "$into/cmake"
chmod +x "$into"/cmake/bin/*
ln -s ../cmake/bin/cmake "$into/bin/cmake"
rm -rf "$into/wheels" "$into/unpacked"
touch "$stamp"
