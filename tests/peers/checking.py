"""What scripts share that check something: each check is said, and the last line and exit code say whether all hold."""

import subprocess
import sys

wrong = []


def check(holds, what):
    print(("ok     " if holds else "WRONG  ") + what, flush=True)
    if not holds:
        wrong.append(what)


def call(*command, expected=0):
    """A finished command; its exit code is checked."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=600)
    if done.returncode != expected:
        check(False, f"{' '.join(map(str, command))} ends with {expected}: {done.returncode} {done.stderr[-500:]}")
    return done


def finish():
    print(f"{len(wrong)} do not hold" if wrong else "all of this holds")
    sys.exit(bool(wrong))
