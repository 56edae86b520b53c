"""`archive.py PROGRAMS LIBRARY NOTICES TARGET OUT`: packs the programs of a folder, MuJoCo's library beside them, completions, manual pages and
notices as OUT/carom-VERSION-TARGET.tar.gz, unpacks it into an empty folder, and runs what is in it there with an empty PATH."""

import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from pathlib import Path

from promised import check_glibc, check_size

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ["carom", "strike"]
COMPLETIONS = [("bash", "bash-completion/completions", "{}"), ("zsh", "zsh/site-functions", "_{}"), ("fish", "fish/vendor_completions.d", "{}.fish")]


def here(program, *arguments, **more):
    """Runs a program as on a machine that has nothing else."""
    return subprocess.run([program, *arguments], check=True, capture_output=True, text=True, env={"PATH": ""}, **more)


def fill(folder, programs, library, notices):
    lib = folder / "lib/carom"
    lib.mkdir(parents=True)
    (folder / "bin").mkdir()
    check_glibc(shutil.copy(library, lib))
    for name in PROGRAMS:
        shutil.copy(programs / name, lib)
        (folder / "bin" / name).symlink_to(f"../lib/carom/{name}")
        check_size(name, (lib / name).stat().st_size)
        check_glibc(lib / name)
    carom = folder / "bin/carom"
    for shell, place, name in COMPLETIONS:
        for program in PROGRAMS:
            script = folder / "share" / place / name.format(program)
            script.parent.mkdir(parents=True, exist_ok=True)
            script.write_text(here(carom, "completions", shell, "--program", program).stdout)
    here(carom, "manual", "--out", folder / "share/man/man1")
    doc = folder / "share/doc/carom"
    doc.mkdir(parents=True)
    for name in ["LICENSE-APACHE", "LICENSE-MIT", "README.md", "CHANGELOG.md"]:
        shutil.copy(ROOT / name, doc)
    shutil.copy(notices, doc / "NOTICES")


def try_out(archive):
    """From the archive to a strike that is planned, in an empty folder."""
    with tempfile.TemporaryDirectory() as empty:
        with tarfile.open(archive) as packed:
            packed.extractall(empty, filter="data")
        (unpacked,) = Path(empty).iterdir()
        carom, strike = unpacked / "bin/carom", unpacked / "bin/strike"
        for line in here(carom, "--version").stdout.splitlines() + here(strike, "--version").stdout.splitlines():
            print(" ", line)
        here(carom, "demo", "--strikes", "100", "--seed", "1", "--hide", "table_tilt=0.006,0.003", "--out", "rig", cwd=empty)
        ran = json.loads(here(carom, "run", "rig/logs", "--rig", "rig/rig.toml", "--out", "run", "--json", "--quiet", cwd=empty).stdout)
        print(f'  carom run: {ran["version"]}, {[effect["name"] for effect in ran["diagnosis"]["effects"]]}')
        plan = json.loads(here(strike, "--artifacts", "run", "--to", "0.62", "0.06", "--json", cwd=empty).stdout)
        print(f'  strike: {plan["speed"]:.3f} m/s at {plan["angle"]:.3f} rad')


def main(programs, library, notices, target, out):
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    name = f"carom-{version}-{target}"
    archive = Path(out) / f"{name}.tar.gz"
    archive.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder) / name
        fill(folder, Path(programs), library, notices)
        with tarfile.open(archive, "w:gz") as packed:
            packed.add(folder, name)
    print(f"{archive}: {archive.stat().st_size / 1e6:.1f} MB")
    try_out(archive)


main(*sys.argv[1:])
