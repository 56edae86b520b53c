"""`make pages`: which pages under tests/ are older than what they measure.

A page is older where commits since the one that made it (a row of BENCH.md names its own) changed a crate that it measures. Whether
that changed a figure, the page alone says once it is made anew.
"""

import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).parent.parent
WORLD = ["artifacts/world", "datasets/values"]
FITS = [*WORLD, "stages/fit", "stages/sysid", "stages/diagnose"]
READS = ["datasets/logs", "datasets/values", "stages/ingest"]
RUNS = [*FITS, *READS, "stages/check", "stages/judge", "stages/train", "stages/stage", "pipeline/carom"]
STRIKES = ["artifacts/world", "artifacts/store", "datasets/logs", "pipeline/strike"]
# What a page measures, and how it is made.
PAGES = {
    "ARM": ("make arm", [*STRIKES, "tests/arm"]),
    "BLIND": ("make blind", [*FITS, "datasets/rig", "tests/src/blind"]),
    "CLUSTER": ("make cluster", ["datasets/durable", "stages/stage", "pipeline/carom"]),
    "FAULTS": ("make test", ["datasets/durable", "stages/stage", "artifacts/store", "pipeline/carom"]),
    "FIRST_DAY": ("make first-day", [*READS, "stages/check", "pipeline/carom"]),
    "HARD": ("make blind HARD=1", [*FITS, "datasets/rig", "tests/src/blind"]),
    "KUKA": ("make kuka", [*FITS, "stages/judge", "stages/train", "tests/src/kuka"]),
    "LEARNING": ("make curve", RUNS),
    "LIVING": ("make living", [*RUNS, *STRIKES, "tests/src/living"]),
    "LOOP": ("make loop", [*RUNS, *STRIKES, "tests/arm"]),
    "LOOP_UR": ("make loop", [*RUNS, *STRIKES, "tests/arm"]),
    "STRANGER": ("make stranger", [*RUNS, "pipeline/strike", "pipeline/python", "pipeline/dist"]),
    "TRACK": ("make bench PARTS=track", ["stages/track", "datasets/render"]),
}
# What a part of BENCH.md measures.
PARTS = {
    "step": WORLD,
    "solve": [*WORLD, "stages/judge"],
    "train": ["stages/train"],
    "ingest": READS,
    "strike": STRIKES,
    "diagnose": FITS,
    "sysid": [*WORLD, "stages/fit", "stages/sysid"],
    "pipeline": RUNS,
    "nightly": RUNS,
    "growth": RUNS,
}


def git(*command):
    return subprocess.run(["git", *command], capture_output=True, text=True, cwd=ROOT, check=True).stdout.strip()


def changes(since, paths):
    """Crates that changed since a commit, each with its number of commits."""
    count = {path: int(git("rev-list", "--count", f"{since}..HEAD", "--", path)) for path in paths}
    return ", ".join(f"{path} ({commits})" for path, commits in count.items() if commits)


def measured():
    """Each page or row, how it is made, the commit that it is of, and what it measures."""
    for name, (command, paths) in PAGES.items():
        yield f"{name}.md", command, git("log", "-1", "--format=%h", "--", f"tests/{name}.md"), paths
    of_part = re.findall(r"^\| (\w+) \| `make bench.*?` \| (\w+) \|", (ROOT / "tests/BENCH.md").read_text(), re.M)
    for part, commit in of_part:
        yield f"BENCH.md, {part}", f"make bench PARTS={part}", commit, PARTS[part]


def main():
    unknown = {page.stem for page in (ROOT / "tests").glob("*.md")} - PAGES.keys() - {"BENCH"}
    if unknown:
        raise SystemExit(f"pages: say in tests/pages.py what these measure: {', '.join(sorted(unknown))}")
    for name, command, commit, paths in measured():
        # A history that was cut off, or rewritten, says nothing.
        known = subprocess.run(["git", "merge-base", "--is-ancestor", commit, "HEAD"], cwd=ROOT, capture_output=True)
        if known.returncode:
            print(f"{name:<20} older    of {commit}, which this history does not hold: `{command}`")
        elif changed := changes(commit, paths):
            print(f"{name:<20} older    of {commit}; since then {changed}: `{command}`")
        else:
            print(f"{name:<20} of today, {commit}")


if __name__ == "__main__":
    main()
