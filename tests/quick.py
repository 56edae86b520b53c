"""`make quick`: the tests of the crates that a change touches, and those of the house's structure.

A change is what differs from the commit at which this branch left BASE (`main`), or what is not committed yet. Everything is built as
`make test` builds it, so that neither compiles anything for the other; what uses a changed crate is left to `make test`.
"""

import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def lines(*command):
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()


def changed(base):
    """Names of files that differ from where this branch left `base`, those that git does not know yet among them."""
    start = lines("git", "merge-base", "HEAD", base)[0]
    return [*lines("git", "diff", "--name-only", start), *lines("git", "ls-files", "--others", "--exclude-standard")]


def main(base):
    metadata = json.loads("".join(lines("cargo", "metadata", "--no-deps", "--locked", "--format-version", "1")))
    folders = {str(pathlib.Path(p["manifest_path"]).parent.relative_to(ROOT)): p for p in metadata["packages"]}
    touched = set()
    for name in changed(base):
        # `tests/arm/…` is of the crate there, not of `tests`.
        of = [folder for folder in folders if name.startswith(folder + "/")]
        touched.update(sorted(of, key=len)[-1:])
    print("changed:", ", ".join(sorted(touched)) or "no crate")
    targets = [t for folder in touched for t in folders[folder]["targets"]]
    # Of the whole, the structure alone: the rest takes minutes, and is its own crate's where that is changed.
    words = {"--test=" + t["name"] for t in targets if "test" in t["kind"]} | {"--test=whole"}
    if any("lib" in t["kind"] for t in targets):
        words.add("--lib")
    build = ["cargo", "test", "--workspace", "--locked", "--no-run", "--message-format=json-render-diagnostics", *sorted(words)]
    built = subprocess.run(build, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if built.returncode:
        return built.returncode
    failed = []
    for made in map(json.loads, built.stdout.splitlines()):
        if not made.get("executable") or not made["profile"]["test"]:
            continue
        folder = pathlib.Path(made["manifest_path"]).parent
        name = str(folder.relative_to(ROOT))
        structure = ["circles", "floors", "rows"] if made["target"]["name"] == "whole" else []
        if name not in touched and not structure:
            continue
        environment = os.environ | {"CARGO_MANIFEST_DIR": str(folder)}
        if subprocess.run([made["executable"], "--quiet", *structure], cwd=folder, env=environment).returncode:
            failed.append(f"{name} ({made['target']['name']})")
    print("failed:", ", ".join(failed)) if failed else print("all passed; `make test` has the rest")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else "main"))
