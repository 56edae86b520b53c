"""README's first commands on machines that have nothing else: `stranger.py FOLDER WHEEL ARCHIVE PAGE`.

Unpacks two releases of Debian below FOLDER (needs root and debootstrap): 12, with its Python, for the wheel, and 11, with glibc 2.31 and without Python,
for the archive. Runs each command of README's first block there, in an empty home, and writes what came of it on PAGE. Ends with 1 where one fails.
"""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

from checking import check, finish

ROOT = Path(__file__).resolve().parents[2]
folder, wheel, archive, page = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), Path(sys.argv[3]).resolve(), Path(sys.argv[4])
# Lines of an answer that are kept at its beginning and its end.
KEPT = 3
HOME = "home/stranger"

block = re.search(r"```\n(pip install carom.*?)```", (ROOT / "README.md").read_text(), re.S)[1]
commands = [line.split("#")[0].strip() for line in block.splitlines()]


def machine(suite, *packages):
    """A fresh machine: the root folder of a Debian release, with an empty home."""
    root = folder / suite
    if not (root / "ready").exists():
        shutil.rmtree(root, ignore_errors=True)
        line = ["debootstrap", "--variant=minbase", *packages, suite, root]
        subprocess.run(line, check=True, stdout=subprocess.DEVNULL)
        (root / "ready").touch()
    shutil.rmtree(root / HOME, ignore_errors=True)
    (root / HOME).mkdir(parents=True)
    return root


def say(root, command, path, **environment):
    """Runs one command in a machine; returns how it went for the page."""
    begin = time.monotonic()
    # With its own /proc: a program finds its libraries by it.
    inside = [shutil.which("unshare"), "--mount", "--pid", "--fork", f"--mount-proc={root}/proc", shutil.which("chroot"), root, "/bin/sh", "-c", f"cd /{HOME} && {command}"]
    done = subprocess.run(inside, capture_output=True, text=True, env={"PATH": path, "HOME": f"/{HOME}", **environment})
    took = time.monotonic() - begin
    check(done.returncode == 0, f"{command} ({took:.0f} s)")
    lines = (done.stdout if done.returncode == 0 else done.stdout + done.stderr).rstrip().splitlines()
    if len(lines) > 2 * KEPT:
        lines = [*lines[:KEPT], f"… {len(lines) - 2 * KEPT} lines …", *lines[-KEPT:]]
    return [f"$ {command}    # {took:.0f} s", *lines]


def system(root):
    name = re.search(r'PRETTY_NAME="(.*)"', (root / "etc/os-release").read_text())[1]
    glibc = subprocess.run(["chroot", root, "/usr/bin/ldd", "--version"], capture_output=True, text=True).stdout.split("\n")[0].split()[-1]
    return f"{name}, glibc {glibc}"


def transcript(title, lines):
    return ["", f"## {title}", "", "```", *lines, "```"]


folder.mkdir(parents=True, exist_ok=True)
root = machine("bookworm", "--include=python3-venv")
shutil.copy(wheel, root / HOME)
# What pip takes from PyPI is fetched outside: inside there is no network.
packages = root / "packages"
shutil.rmtree(packages, ignore_errors=True)
subprocess.run([sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--python-version", "3.11", "--only-binary", ":all:", "--dest", packages, wheel], check=True)
(packages / wheel.name).unlink(missing_ok=True)
offline = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": "/packages", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
path = f"/{HOME}/venv/bin"
lines = say(root, "python3 -m venv venv", "/usr/bin:/bin")
for command in [*commands, "carom --version"]:
    lines += say(root, command, path, **offline)
written = transcript(f"The wheel, {wheel.stat().st_size / 1e6:.1f} MB, on {system(root)}", lines)

root = machine("bullseye")
# Debian's tar and gzip unpack it; carom runs with itself alone on the PATH.
shutil.copy(archive, root / HOME)
name = archive.name.removesuffix(".tar.gz")
lines = say(root, f"tar -xf {archive.name}", "/usr/bin:/bin")
for command in [*commands[1:], "carom --version"]:
    lines += say(root, command, f"/{HOME}/{name}/bin")
written += transcript(f"The archive, {archive.stat().st_size / 1e6:.1f} MB, on {system(root)}", lines)

commit = subprocess.run(["git", "describe", "--always", "--dirty", "--abbrev=9", "--exclude=*"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
head = [
    "# A stranger's first commands",
    "",
    f"Made by `make stranger` at {commit}: README's first block, line by line, on {os.cpu_count()} cores, in machines that debootstrap makes (`minbase`: neither Rust nor a",
    "compiler, nor Python in the second one) with nothing of carom on the `PATH` but what was installed. Long answers are cut in their middle.",
]
page.write_text("\n".join([*head, *written]) + "\n")
finish()
