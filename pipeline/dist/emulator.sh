#!/bin/sh
# `emulator.sh FOLDER MACHINE`: unpacks QEMU's emulator of another architecture, and Debian 11's C library (glibc 2.31) of it, into the folder; nothing
# is installed. FOLDER/run PROGRAM runs a program of that architecture.
set -eu
folder=$1
machine=$2
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
echo "deb [arch=$debian signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bullseye main" > "$folder/apt/sources.list"
cat > "$folder/apt/apt.conf" << EOF
APT::Architecture "$debian";
APT::Architectures { "$debian"; };
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
APT_CONFIG="$folder/apt/apt.conf" apt-get -qq update
APT_CONFIG="$folder/apt/apt.conf" apt-get -qq download libc6 libgcc-s1 libstdc++6
dpkg --fsys-tarfile qemu-user-static_*.deb | tar -x -C "$folder" "./usr/bin/qemu-$machine-static"
rm qemu-user-static_*.deb
for package in *.deb; do
    dpkg -x "$package" "$folder/root"
done
rm -r "$folder/apt" "$folder/packages"
cat > "$folder/run" << EOF
#!/bin/sh
exec "$folder/usr/bin/qemu-$machine-static" -L "$folder/root" "\$@"
EOF
chmod +x "$folder/run"
