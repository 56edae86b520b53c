"""`notices.py TARGET`: notices of what is linked. Prints name, version, licence and licence text of every crate that the Python package, and with it carom and
strike, is built from, and of MuJoCo and uPlot. Asks cargo, reads the sources that cargo unpacked, fetches nothing; MuJoCo's
licences are those of its installed package."""

import importlib.metadata
import json
import subprocess
import sys
from pathlib import Path

NAMES = ("license", "licence", "copying", "notice", "unlicense")


def linked_packages(target):
    """Names and versions of what is linked: no build scripts, no macros, no tests."""
    command = ["cargo", "tree", "--locked", "--offline", "--package", "carom-python", "--features", "extension", "--target", target]
    command += ["--edges", "normal,no-proc-macro", "--prefix", "none", "--format", "{p}"]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    return {tuple(line.split(" ")[:2]) for line in lines if line}


def main(target):
    # Of this platform alone: what only others are built from is nowhere on this computer.
    command = ["cargo", "metadata", "--locked", "--offline", "--format-version", "1", "--features", "carom-python/extension", "--filter-platform", target]
    metadata = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    known = {(p["name"], "v" + p["version"]): p for p in metadata["packages"]}
    texts = {}
    for key in sorted(linked_packages(target)):
        package = known[key]
        if package["source"] is None:
            continue
        folder = Path(package["manifest_path"]).parent
        files = sorted(f for f in folder.iterdir() if f.is_file() and f.name.lower().startswith(NAMES))
        text = "\n\n".join(f.read_text(errors="replace").strip() for f in files) or "(the package holds no licence text; its manifest names the licence)"
        texts.setdefault(text, []).append(f'{key[0]} {key[1][1:]}: {package["license"] or "see text"}')
    print("carom is licensed under MIT or Apache 2.0, as you choose. Its programs are linked with what follows.\n")
    print("MuJoCo 3.17.0: Apache-2.0, © DeepMind Technologies Limited; its library is used unchanged.\nNLopt: MIT (LGPL for its Luksan solvers); SQLite: public domain; zstd: BSD-3-Clause; lz4: BSD-2-Clause.\n\nuPlot, in every report: MIT, © Leon Sorokin.\n")
    for file in importlib.metadata.files("mujoco"):
        if "licenses" in file.parts:
            texts[file.read_text()] = [f"MuJoCo 3.17.0: {file.name}"]
    for text, names in sorted(texts.items(), key=lambda item: item[1]):
        print("=" * 100, *names, "-" * 100, text, "", sep="\n")


main(sys.argv[1])
