"""What is promised of what is shipped: sizes, and the oldest glibc."""

import re
import subprocess

# Bytes.
SIZES = {"carom": 35e6, "_carom.abi3.so": 36e6, "strike": 8e6, "wheel": 20e6}
GLIBC = (2, 31)


def check_size(name, size):
    print(f"{name}: {size / 1e6:.1f} MB")
    assert size <= SIZES[name], f"{name} is larger than {SIZES[name] / 1e6:.0f} MB"


def check_glibc(binary):
    """The newest version of glibc that a program's symbols name is the oldest one that it runs with."""
    symbols = subprocess.run(["objdump", "-T", binary], check=True, capture_output=True, text=True).stdout
    version = max(tuple(map(int, found)) for found in re.findall(r"GLIBC_(\d+)\.(\d+)", symbols))
    print(f"  glibc {version[0]}.{version[1]}")
    assert version <= GLIBC, f"{binary} asks for glibc {version}"
