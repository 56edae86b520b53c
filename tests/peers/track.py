"""`make bench PARTS=track`: carom and OpenCV in turn on the same rendered frames, and the page tests/TRACK.md."""

import argparse
import importlib.metadata
import json
import os
import platform
import statistics
import subprocess

from measuring import CORES, ROOT, in_turn, peer, run, spread

OUT = "artifacts/runs/bench/track"
FRAMES = "target/debug/examples/frames"
CASES = {
    "clean": "clean",
    "noise": "noise of 2 levels",
    "gradient": "light that falls off by a third",
    "shadow": "a soft shadow of half the light, and the object's own",
    "blur": "1 m/s, 5 ms of exposure",
    "all": "all at once, JPEG 90, lens; a flat disc",
    "tall": "the same, 40 mm tall",
}
METHODS = ("hsv", "grabcut")
HEAD = """# Tracking from images, beside OpenCV

Made by `make bench PARTS=track`. Frames are rendered (`datasets/render`, which shares no code with the tracker): a disc or cylinder
60 mm wide under a camera 1.2 m over the table. carom and OpenCV are given the same files, in turn in one run, each in a process of its
own; the decoding of JPEG is included, the reading of files is not. OpenCV: a range in HSV, contours, moments (`hsv`); the same with
GrabCut about the object, five iterations (`grabcut`)."""


def rendered(case, width, height, count):
    folder = f"{OUT}/{case}_{width}_{count}"
    if not (ROOT / folder / "truth.json").exists():
        run(FRAMES, "render", folder, case, width, height, count)
    return folder


def rate(results):
    return [result["frames"] / result["seconds"] for result in results]


def errors(folder, found):
    """Rms of a coordinate in px against the centroid of what is seen; rms and worst distance in mm on the table; frames lost."""
    truth = json.loads((ROOT / folder / "truth.json").read_text())
    pairs = [(frame, seen) for frame, seen in zip(truth, found) if seen is not None]
    off = [[seen[0][i] - frame["pixel"][i] for i in (0, 1)] for frame, seen in pairs]
    far = [1e3 * sum((seen[1][i] - frame["place"][i]) ** 2 for i in (0, 1)) ** 0.5 for frame, seen in pairs]
    px = (sum(x * x + y * y for x, y in off) / (2 * len(off))) ** 0.5
    return px, (sum(mm * mm for mm in far) / len(far)) ** 0.5, max(far), len(truth) - len(pairs)


def said(px, mm, worst, lost, tall):
    text = f"{mm:.2f} mm rms, {worst:.2f} at worst" if tall else f"{px:.3f} px"
    return text + (f", {lost} lost" if lost else "")


def yes(met):
    return "yes" if met else "**no**"


def speed(count, rounds, runs):
    lines = []
    for width, height in ((1280, 720), (640, 480)):
        folder = rendered("tall", width, height, count)
        one, two, *peers = in_turn(
            runs,
            lambda: run(FRAMES, "track", folder, 1, rounds),
            lambda: run(FRAMES, "track", folder, 2, rounds),
            *(lambda method=method: peer("opencv", folder, method, rounds) for method in METHODS),
        )
        for method, results, least in zip(METHODS, peers, (1, 3)):
            ratios = [a / b for a, b in zip(rate(one), rate(results))]
            lines.append(
                (
                    f"{width} × {height}, one thread, over OpenCV's {method}",
                    spread(rate(one), "/s"),
                    spread(rate(results), "/s"),
                    spread(ratios, "×"),
                    f"≥ {least} ×",
                    yes(statistics.median(ratios) >= least),
                )
            )
        wall = [b / a for a, b in zip(rate(one), rate(two))]
        free = [2 * b["frames"] / b["cpu"] / (a["frames"] / a["cpu"]) for a, b in zip(one, two)]
        lines.append(
            (
                f"{width} × {height}, two threads over one",
                spread(rate(two), "/s"),
                f"by processor time, as if both cores were free: {spread(free, '×')}",
                spread(wall, "×"),
                "≥ 1.9 ×",
                yes(statistics.median(wall) >= 1.9),
            )
        )
    return lines


def accuracy(count):
    lines = []
    for case, what in CASES.items():
        folder, tall = rendered(case, 1280, 720, count), case == "tall"
        mine = errors(folder, run(FRAMES, "track", folder, CORES, 1)["found"])
        theirs = [errors(folder, peer("opencv", folder, method, 1)["found"]) for method in METHODS]
        px, mm, worst, lost = mine
        if tall:
            met, reach = mm <= 0.5 and worst <= 1.0, "≤ 0.5 mm rms, ≤ 1 at worst"
        else:
            most = 0.08 if case == "all" else 0.03
            met, reach = px <= most, f"≤ {most} px"
        lines.append((what, said(*mine, tall), *(said(*other, tall) for other in theirs), reach, yes(met and not lost)))
    return lines


def table(head, lines):
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *lines))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--small", action="store_true", help="few frames, to try the harness, and a page of its own")
    args = parser.parse_args()
    load = os.getloadavg()[0]
    lines = speed(*((40, 2, 2) if args.small else (60, 5, 5)))
    cases = accuracy(10 if args.small else 100)

    def output(*command):
        return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True).stdout.strip()

    page = "\n\n".join(
        (
            HEAD,
            "## Frames a second",
            table(("what", "carom", "peer", "ratio", "to reach", "reached"), lines),
            "Median, and least to greatest of the runs.",
            "## Accuracy, 1280 × 720, 1.2 mm a pixel",
            f"{10 if args.small else 100} frames a case. Of flat discs the rms of a coordinate against the centroid of what is seen; of the tall "
            "object the distance of its centre on the table.",
            table(("case", "carom", "OpenCV hsv", "OpenCV grabcut", "to reach", "reached"), cases),
            f"Commit {output('git', 'rev-parse', '--short', 'HEAD')}; load of the machine before: {load:.1f}; {CORES} cores ({platform.machine()}); "
            f"{output('rustc', '--version').split(' (')[0]}; Python {platform.python_version()}, "
            f"opencv-python-headless {importlib.metadata.version('opencv-python-headless')}.",
        )
    )
    (ROOT / (f"{OUT}/small.md" if args.small else "tests/TRACK.md")).write_text(page + "\n")
    print(page)


if __name__ == "__main__":
    main()
