#!/bin/sh
# `emulator.sh FOLDER MACHINE SUITE PACKAGE...`: unpacks QEMU's emulator of another architecture, and packages of a Debian release of it with all that they
# depend on, into the folder; nothing is installed. FOLDER/run PROGRAM runs a program of that architecture.
set -eu
folder=$1
machine=$2
suite=$3
shift 3
[ ! -e "$folder/run" ] || exit 0
case $machine in
    aarch64) debian=arm64 ;;
    x86_64) debian=amd64 ;;
    *) echo "no emulator of $machine is set up" >&2; exit 1 ;;
esac
rm -rf "$folder"
mkdir -p "$folder/packages" "$folder/apt/lists/partial" "$folder/apt/archives/partial" "$folder/root"
folder=$(cd "$folder" && pwd)
: > "$folder/apt/status"
echo "deb [arch=$debian signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian $suite main" > "$folder/apt/sources.list"
cat > "$folder/apt/apt.conf" << EOF
APT::Architecture "$debian";
APT::Architectures { "$debian"; };
APT::Install-Recommends "no";
APT::Sandbox::User "";
Acquire::Languages "none";
Dir::State "$folder/apt";
Dir::State::status "$folder/apt/status";
Dir::Cache "$folder/apt";
Dir::Etc::sourcelist "$folder/apt/sources.list";
Dir::Etc::sourceparts "-";
EOF
cd "$folder/packages"
emulator() { apt-get -qq -o APT::Sandbox::User= download qemu-user-static; }
emulator || { apt-get -qq update && emulator; }
dpkg --fsys-tarfile qemu-user-static_*.deb | tar -x -C "$folder" "./usr/bin/qemu-$machine-static"
export APT_CONFIG="$folder/apt/apt.conf"
apt-get -qq update
apt-get -qq --yes --download-only install "$@" > "$folder/apt/said"
for package in "$folder"/apt/archives/*.deb; do
    dpkg -x "$package" "$folder/root"
done
cd "$folder"
rm -r apt packages
cat > run << EOF
#!/bin/sh
exec "$folder/usr/bin/qemu-$machine-static" -L "$folder/root" "\$@"
EOF
chmod +x run
