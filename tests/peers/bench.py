"""`make bench`: carom and its peers in turn on the same strikes, and the page tests/BENCH.md.

What a part gave is kept, and measured again only if the part is named: the page can be made part by part.
"""

import argparse
import importlib.metadata
import json
import os
import platform
import subprocess
import sys

from measuring import CORES, HERE, ROOT
from parts import OUT, PARTS

PACKAGES = ("mujoco", "nlopt", "torch", "mcap", "mcap-ros2-support", "numpy")


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True).stdout.strip()


def table(*lines):
    head, *rest = lines
    return ["", *(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *rest))]


def page(results):
    """The page of all that was measured."""
    # What the small mode gave stands for itself, not for what is to be reached.
    rows = [
        line | {"met": None, "reach": ""} if "SMALL" in part["command"] else line
        for name in PARTS
        if (part := results.get(name))
        for line in part["rows"]
    ]
    met = {True: "yes", False: "**no**", None: ""}
    columns = ("what", "carom", "peer", "ratio", "reach", "met", "accuracy", "memory")
    cells = [[met[line[key]] if key == "met" else line[key] for key in columns] for line in rows]
    head = ("part", "carom", "peer", "ratio", "to reach", "reached", "accuracy: carom; peer", "peak memory")
    made = [(name, f"`{part['command']}`", part["commit"], f"{part['load']:.1f}") for name, part in results.items()]
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in PACKAGES)
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    missed = [f"{line['what']} ({line['ratio'] or line['carom']}, {line['reach']})" for line in rows if line["met"] is False]
    missing = [name for name in PARTS if name not in results or "SMALL" in results[name]["command"]]
    lines = [
        (HERE / "page.md").read_text().strip(),
        *table(head, *cells),
        "",
        f"Missed: {'; '.join(missed) or 'nothing'}." + (f" Not measured in full: {', '.join(missing)}." if missing else ""),
        *table(("part", "command", "commit", "load of the machine before"), *made),
        "",
        f"{CORES} cores ({platform.machine()}), {memory:.0f} GB of memory; {output('rustc', '--version').split(' (')[0]}; "
        f"Python {platform.python_version()}, {versions}.",
    ]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", help=f"measured anew; where none is named, all that are missing, of {', '.join(PARTS)}")
    parser.add_argument("--small", action="store_true", help="few strikes and runs, to try the harness, and a page of its own")
    args = parser.parse_args()
    if unknown := [name for name in args.parts if name not in PARTS]:
        parser.error(f"no part is called {', '.join(unknown)}; there are {', '.join(PARTS)}")
    kept = ROOT / OUT / ("small.json" if args.small else "outcomes.json")

    def known():
        return json.loads(kept.read_text()) if kept.exists() else {}

    for name in args.parts or [name for name in PARTS if name not in known()]:
        print(f"bench: {name}", file=sys.stderr, flush=True)
        load, commit = os.getloadavg()[0], output("git", "rev-parse", "--short", "HEAD")
        rows = PARTS[name](lambda full, small: small if args.small else full)
        command = f"make bench PARTS={name}" + " SMALL=1" * args.small
        part = {"rows": rows, "command": command, "commit": commit, "load": load}
        kept.write_text(json.dumps(known() | {name: part}, indent=1))
        for line in rows:
            print(
                "  " + "; ".join(filter(None, (line["what"], line["carom"], line["peer"], line["ratio"], line["reach"]))),
                file=sys.stderr,
            )
    (ROOT / (OUT / "small.md" if args.small else "tests/BENCH.md")).write_text(page(known()))


if __name__ == "__main__":
    main()
