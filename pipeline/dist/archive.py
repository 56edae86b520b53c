"""`archive.py PROGRAMS LIBRARY NOTICES TARGET OUT [EMULATOR RUN BIN]`: packs the programs of a folder, MuJoCo's library beside them, completions,
manual pages and notices as OUT/carom-VERSION-TARGET.tar.gz, unpacks it into an empty folder, and runs what is in it there with an empty PATH.

Programs of another architecture run in EMULATOR, and what they answer about the published RUN is compared with what this machine's own, in BIN, do."""

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


# Plans of two architectures differ by no more.
ALIKE = 1e-12
EMULATOR = []


def here(program, *arguments, check=True, **more):
    """Runs a program as on a machine that has nothing else."""
    # The emulator is a script of the shell: it finds itself with whole paths.
    return subprocess.run([*EMULATOR, program, *arguments], check=check, capture_output=True, text=True, env={"PATH": ""}, **more)


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


def numbers(value, path=""):
    """All numbers of an answer, by where they are; other values stay as they are."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from numbers(inner, f"{path}.{key}")
    elif isinstance(value, list):
        for place, inner in enumerate(value):
            yield from numbers(inner, f"{path}[{place}]")
    else:
        yield path, value


def compare(archive, run, own):
    """That programs of another architecture plan and predict as this machine's do."""
    with tempfile.TemporaryDirectory() as empty:
        with tarfile.open(archive) as packed:
            packed.extractall(empty, filter="data")
        (unpacked,) = Path(empty).iterdir()
        for name in PROGRAMS:
            for line in here(unpacked / "bin" / name, "--version").stdout.splitlines():
                print(" ", line)
        here(unpacked / "bin/carom", "demo", "--strikes", "5", "--seed", "1", "--out", "rig", cwd=empty)
        run = str(Path(run).resolve())
        asked = []
        for place in range(24):
            x, y = 0.45 + 0.05 * (place % 6), -0.12 + 0.08 * (place // 6)
            asked.append(("strike", ["--artifacts", run, "--from", "0.30", "0.00", "--to", f"{x:.3f}", f"{y:.3f}", "--json", "--quiet"]))
        for speed in ("0.5", "0.8"):
            asked.append(("carom", ["predict", "--artifacts", run, "--from", "0.3", "0", "--speed", speed, "--angle", "0.1", "--json"]))
        planned, far = 0, 0.0
        for name, arguments in asked:
            there = here(unpacked / "bin" / name, *arguments, check=False)
            this = subprocess.run([Path(own) / name, *arguments], capture_output=True, text=True)
            assert there.returncode == this.returncode, (arguments, there.returncode, this.returncode, there.stderr)
            if this.returncode != 0:
                continue
            planned += 1
            theirs, ours = (dict(numbers(json.loads(answer.stdout))) for answer in (there, this))
            assert theirs.keys() == ours.keys(), arguments
            for path, value in ours.items():
                if isinstance(value, float):
                    far = max(far, abs(value - theirs[path]) / max(1.0, abs(value)))
                else:
                    assert value == theirs[path], (arguments, path, value, theirs[path])
        print(f"  {planned} of {len(asked)} plans and predictions, the others refused by both: they differ by {far:.1e} at the most")
        assert planned > len(asked) // 2 and far <= ALIKE


def main(programs, library, notices, target, out, emulator=None, run=None, own=None):
    if emulator:
        EMULATOR.append(str(Path(emulator).resolve()))
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
    if emulator:
        compare(archive, run, own)
    else:
        try_out(archive)


main(*sys.argv[1:])
