#!/usr/bin/env python3
"""How stop errors fall with the number of strikes learnt from, and that few strikes do no harm: writes tests/LEARNING.md.

Runs `carom demo`, `carom run` and `carom score` for each number of strikes and seed; all versions are judged by the same strikes, which
none of them learnt from. Needs nothing but Python and a built `carom`.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

# Number of strikes, and seeds of each.
SIZES = {10: 5, 20: 5, 35: 5, 50: 5, 100: 3, 200: 2, 500: 1}
# The judges: strikes of another seed.
JUDGES, JUDGES_SEED = 100, 9001
MODELS = ["nominal", "sysid", "sysid_residual", "effect", "effect_residual"]
TABLES = {
    "": ("the demo's mixture of seven effects", 500),
    "none": ("nothing hidden: a residual has nothing to learn", 50),
}


def carom(program, *words):
    done = subprocess.run([program, *words, "--json", "--quiet"], capture_output=True, text=True)
    # Of few strikes a version is a candidate (4).
    if done.returncode not in (0, 3, 4):
        raise SystemExit(f"{' '.join(words)}: {done.stderr}")
    return json.loads(done.stdout)


def demo(program, folder, strikes, seed, hide):
    hidden = ["--hide", hide] if hide else []
    carom(program, "demo", "--strikes", str(strikes), "--seed", str(seed), *hidden, "--out", str(folder))
    return [str(folder / "logs"), "--rig", str(folder / "rig.toml")]


def measure(program, strikes, seed, hide, judges):
    """Mean stop error in m of each model on the judges; a model that the version does not hold is the world alone."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        logs = demo(program, folder / "rig", strikes, seed, hide)
        carom(program, "run", *logs, "--out", str(folder / "run"))
        score = carom(program, "score", judges, "--artifacts", str(folder / "run"), "--version", "v0001")
    means = {model: score[model]["mean"] for model in MODELS if isinstance(score.get(model), dict)}
    means.setdefault("effect", means["sysid"])
    added = "sysid_residual" in means
    means.setdefault("sysid_residual", means["sysid"])
    means.setdefault("effect_residual", means["effect"])
    return means, added


def table(program, hide, most):
    with tempfile.TemporaryDirectory() as folder:
        judges = demo(program, pathlib.Path(folder), JUDGES, JUDGES_SEED, hide)[0]
        rows = []
        for strikes, seeds in SIZES.items():
            if strikes > most:
                continue
            found = [measure(program, strikes, seed, hide, judges) for seed in range(1, seeds + 1)]
            cells = [f"{100 * statistics.mean(means[model] for means, _ in found):.2f}" for model in MODELS]
            worst = max(means["sysid_residual"] / means["sysid"] for means, _ in found)
            added = sum(added for _, added in found)
            rows.append(f"| {strikes} | {seeds} | {' | '.join(cells)} | {worst:.2f} | {added} |")
            print(rows[-1], flush=True)
    head = f"| strikes | seeds | {' | '.join(f'`{model}`' for model in MODELS)} | worst `sysid_residual` × `sysid` | residual added to `sysid` |"
    return "\n".join([head, "|---|" * 1 + "---|" * (len(MODELS) + 3), *rows])


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--carom", default="target/debug/carom")
    options.add_argument("--page", default="tests/LEARNING.md")
    options = options.parse_args()
    text = (
        "# Learning curve\n\nMade by `make curve`. Mean stop error in cm, over seeds, on "
        f"{JUDGES} strikes of the embedded rig that no version learnt from. Where the choice is to add nothing, a model with the residual "
        "is the world alone.\n"
    )
    for hide, (what, most) in TABLES.items():
        text += f"\n## {what[0].upper()}{what[1:]}\n\n{table(options.carom, hide, most)}\n"
    pathlib.Path(options.page).write_text(text)


main()
