"""`make bench PARTS=track`: carom and OpenCV in turn on the same rendered frames, and the page tests/TRACK.md.

What a part gave is kept, and measured again only if the part is named: the page can be made part by part.
"""

import argparse
import importlib.metadata
import json
import math
import os
import platform
import statistics
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

from large import LOGS
from measuring import CORES, ROOT, in_turn, peer, run, spread

OUT = "artifacts/runs/bench/track"
FRAMES = "target/debug/examples/frames"
CAROM = "target/debug/carom"
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
SHAPES = ("cylinder", "box", "sphere")
# Kinds of scenes that should not be trusted, in the order in which they are rendered, and those with two objects.
HOSTILE = "no object", "a hand alone", "two objects", "two that touch", "the border", "a hand", "a grey arm", "an arm of its colour", "glare", "a hard shadow's edge"
TWO = HOSTILE[2:4]
WRONG = 3.0  # mm
FIRST = 800_000  # of the scenes that judge; those up to 10,000 and 700,000 to 700,200 were looked at while the marks were made
SEED = 31  # of the demo's strikes
BENCHES = 71  # seed of the benches that judge
MARKERS = 73  # seed of the logs with markers that judge
TARGETS = 400  # of the trials of both published models
STRIKES = int(os.environ.get("STRIKES", "500"))  # fewer where time is short: the page says how many
HEAD = """# Tracking from images, beside OpenCV

Made by `make bench PARTS=track`. Frames are rendered (`datasets/render`, which shares no code with the tracker): a disc or cylinder
60 mm wide under a camera 1.2 m over the table. carom and OpenCV are given the same files, in turn in one run, each in a process of its
own; the decoding of JPEG is included, the reading of files is not. OpenCV: a range in HSV, contours, moments (`hsv`); the same with
GrabCut about the object, five iterations (`grabcut`)."""
ABOUT = {
    "speed": "Median, and least to greatest of the runs. Two processes that share nothing show what the machine itself gives to two threads.",
    "accuracy": "1280 × 720, 1.2 mm a pixel. Of flat discs the rms of a coordinate against the centroid of what is seen; of the tall object the "
    "distance of its centre on the table.",
    "benches": "Logs of whole strikes, 30 frames a second, from a renderer of polygons (`tests/peers/benches.py`) that shares no code with the other one nor "
    "with the tracker: wood, cloth, lines, print, an arm that hides half of it at the impact, cables, JPEG 50, few pixels, blur. Errors are those at "
    "the stamp that carom gives a frame. z² is the squared error of a coordinate over the variance that is said of it; a wrong centre is marked where three of its deviations reach so far. The last ones are set up wrong: what is not told there is not noticed.",
    "markers": "Logs of whole strikes from the same renderer of polygons, an ArUco marker or an AprilTag of 32 to 36 mm on the object, drawn as OpenCV draws it; 1280 × 720, "
    "1.2 mm a pixel (`480`: 640 × 480, 2.4 mm a pixel). OpenCV has the same images, its detector with corners to a fraction of a pixel, then `solvePnP`, or its "
    "corners on the plane of the known height. Rms, and the worst in brackets. Frames without a yaw are those in which the marker is not read and the outline told the "
    "place. `tag_other_id`: another marker than the rig file's, no colour stated. z² as above, of place and of yaw.",
    "hostile": f"640 × 480, 2.4 mm a pixel, objects 40 mm tall and a ball: no object, a hand alone, two objects, two that touch, the border, a hand "
    f"and a grey arm over it, an arm of its colour, glare, the edge of a hard shadow. A centre that is given and farther than {WRONG:.0f} mm from the "
    f"object is wrong. Scenes {FIRST} and on, which took no part in making the marks. OpenCV's methods give a centre whenever something has the colour.",
    "strikes": "The demo's strikes as centroids (noise of 0.7 mm) and as images of its camera (640 × 480, JPEG), each through `carom run`. Stop error: "
    "mean and its standard error over the same fresh targets, each struck once by the published model (`carom trial`).",
    "memory": "`carom track` on logs of large messages (`tests/peers/large.py`), on two cores. What is held is a message, not a chunk; the pixels of as many images "
    "as fit into 44 MB, or of one; and in the beginning those of up to 20 images, 44 MB. An image whose pixels take more than 95 MB with what they are decoded from is refused: raw ones from 16 million pixels on, JPEG from 30, H.264 at 3840 × 2160 with more than one reference image, or in several slices.",
    "boards": "A ChArUco board that OpenCV draws, seen by a known camera (1280 × 720, plumb_bob lens) from known places, with blur, noise and JPEG 92: "
    "`carom camera calibrate` and OpenCV's detector with `calibrateCamera` on the same images. The pose is that of the camera that sees the board on "
    "the table.",
}
HEADS = {
    "speed": ("what", "carom", "peer", "ratio", "to reach", "reached"),
    "accuracy": ("case", "carom", "OpenCV hsv", "OpenCV grabcut", "to reach", "reached"),
    "hostile": ("what", "carom", "OpenCV hsv", "OpenCV grabcut", "to reach", "reached"),
    "benches": ("bench", "strikes kept", "frames with a centre", "wrong (> 3 mm), not marked", "mm: rms, at worst", "mean z²", "told"),
    "markers": ("log", "frames by marker, by outline", "place, mm", "yaw, degrees", "mean z²", "wrong (> 3 mm), not marked", "OpenCV: frames, mm and degrees by `solvePnP`", "at the known height"),
    "strikes": ("what", "from images", "from centroids", "ratio", "to reach", "reached"),
    "memory": ("log", "frames with a centre", "size", "carom, at most", "time", "to reach", "reached"),
    "boards": ("what", "carom", "OpenCV", "true"),
}
TITLES = {
    "speed": "Frames a second",
    "accuracy": "Accuracy",
    "benches": "Ordinary benches",
    "markers": "Markers on the object",
    "hostile": "Scenes that should not be trusted",
    "strikes": "Strikes from images",
    "memory": "Memory",
    "boards": "Calibration from a board",
}


def rendered(case, width, height, count):
    folder = f"{OUT}/{case}_{width}_{count}"
    if not (ROOT / folder / "truth.json").exists():
        run(FRAMES, "render", folder, case, width, height, count)
    return folder


def rate(results):
    return [result["frames"] / result["seconds"] for result in results]


def truth_of(folder):
    return json.loads((ROOT / folder / "truth.json").read_text())


def errors(folder, found):
    """Rms of a coordinate in px against the centroid of what is seen; rms and worst distance in mm on the table; frames lost."""
    truth = truth_of(folder)
    pairs = [(frame, seen) for frame, seen in zip(truth, found) if seen is not None]
    off = [[seen[0][i] - frame["pixel"][i] for i in (0, 1)] for frame, seen in pairs]
    far = [1e3 * distance(frame, seen) for frame, seen in pairs]
    px = (sum(x * x + y * y for x, y in off) / (2 * len(off))) ** 0.5
    return px, (sum(mm * mm for mm in far) / len(far)) ** 0.5, max(far), len(truth) - len(pairs)


def distance(frame, seen):
    return sum((seen[1][i] - frame["place"][i]) ** 2 for i in (0, 1)) ** 0.5


def said(px, mm, worst, lost, tall):
    text = f"{mm:.2f} mm rms, {worst:.2f} at worst" if tall else f"{px:.3f} px"
    return text + (f", {lost} lost" if lost else "")


def yes(met):
    return "yes" if met else "**no**"


def at_once(*words):
    with ThreadPoolExecutor(2) as pool:
        return [one.result() for one in [pool.submit(run, *words) for _ in range(2)]]


def speed(small):
    count, rounds, runs = (40, 2, 2) if small else (60, 5, 5)
    longer = 5 * rounds  # carom is the faster: its runs take seconds too, beside which the beginning of threads is nothing
    lines = []
    for width, height in ((1280, 720), (640, 480)):
        folder = rendered("tall", width, height, count)
        log, rig, out = (f"{OUT}/speed{end}" for end in (".mcap", ".toml", "_tracked"))
        run(FRAMES, "log", folder, log, rig, longer * sum(file.stat().st_size for file in (ROOT / folder).glob("*.jpg")))

        def whole(threads):
            words = ("track", log, "--rig", rig, "--out", out, "--json", "--quiet")
            result = run("env", f"RAYON_NUM_THREADS={threads}", CAROM, *words)
            return {"frames": result["tracked"][0]["frames"]["frames"], "seconds": result["wall"]}

        one, two, both, whole_one, whole_two, *peers = in_turn(
            runs,
            lambda: run(FRAMES, "track", folder, 1, longer),
            lambda: run(FRAMES, "track", folder, 2, longer),
            lambda: at_once(FRAMES, "track", folder, 1, longer),
            lambda: whole(1),
            lambda: whole(2),
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
        alone = [b / a for a, b in zip(rate(one), map(sum, map(rate, both)))]
        processes = f"two processes of one thread at once, over one: {spread(alone, '×')}"
        for what, slow, fast, beside in (
            ("two threads over one", one, two, processes),
            ("`carom track` on a log, reading and writing included, two threads over one", whole_one, whole_two, f"one thread: {spread(rate(whole_one), '/s')}"),
        ):
            ratios = [b / a for a, b in zip(rate(slow), rate(fast))]
            reached = yes(statistics.median(ratios) >= 1.9)
            lines.append((f"{width} × {height}, {what}", spread(rate(fast), "/s"), beside, spread(ratios, "×"), "≥ 1.9 ×", reached))
        subprocess.run(["rm", "-rf", log, rig, out], cwd=ROOT, check=True)
    return lines


def accuracy(small):
    lines = []
    for case, what in CASES.items():
        folder, tall = rendered(case, 1280, 720, 10 if small else 100), case == "tall"
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


def hostile(small):
    count = 2 if small else 20
    scenes, wrong, given, worst = 0, [0, 0, 0], [0, 0, 0], [0.0, 0.0, 0.0]
    seen_of, found_of, z2, why = {kind: 0 for kind in HOSTILE}, {kind: 0 for kind in HOSTILE}, [], {}
    for shape in SHAPES:
        folder = f"{OUT}/hostile_{shape}_{FIRST}_{count}"
        if not (ROOT / folder / "truth.json").exists():
            run(FRAMES, "hostile", folder, shape, FIRST, count)
        truth = truth_of(folder)
        scenes += len(truth)
        answer = run(FRAMES, "track", folder, CORES, 1)
        mine = answer["found"]
        for frame, found, said in zip(truth, mine, answer["said"]):
            kind = HOSTILE[int(frame["file"].split("_")[0])]
            is_seen = frame["seen"] >= 0.5
            seen_of[kind] += is_seen
            found_of[kind] += is_seen and found is not None
            if found is not None:
                z2.append(0.5 * (distance(frame, found) / said["deviation"]) ** 2)
            elif is_seen:
                why.setdefault(kind, []).append(said["reason"])
        for which, found in enumerate((mine, *(peer("opencv", folder, method, 1)["found"] for method in METHODS))):
            far = [1e3 * distance(frame, seen) for frame, seen in zip(truth, found) if seen is not None]
            given[which] += len(far)
            wrong[which] += sum(mm > WRONG for mm in far)
            worst[which] = max(worst[which], *(mm for mm in far if mm < 1e3), 0.0)
    one = [kind for kind in HOSTILE if kind not in TWO]
    found, seen = sum(found_of[kind] for kind in one), sum(seen_of[kind] for kind in one)
    both = sum(found_of.values()), sum(seen_of.values())

    def of_kind(kind):
        reasons = ", ".join(f"{why[kind].count(reason)} {reason}" for reason in sorted(set(why.get(kind, []))))
        return f"{found_of[kind]} of {seen_of[kind]}" + (f"; {reasons}" if reasons else "")

    return [
        (f"wrong and not marked, of {scenes}", *map(str, wrong), "0 of ≥ 500", yes(wrong[0] == 0 and scenes >= 500)),
        ("centres given", *map(str, given), "", ""),
        ("of those in which one object is there and half of it is seen", f"{found} of {seen}, {100 * found / seen:.0f} %", "", "", "≥ 60 %", yes(found >= 0.6 * seen)),
        ("the same, those with two objects alike included, which one image cannot tell apart", f"{both[0]} of {both[1]}, {100 * both[0] / both[1]:.0f} %", "", "", "", ""),
        *((f"{kind}: given, and why not", of_kind(kind), "", "", "", "") for kind in HOSTILE if seen_of[kind]),
        ("mean z² of those given", f"{statistics.mean(z2):.2f}", "", "", "0.8 to 1.3", yes(0.8 <= statistics.mean(z2) <= 1.3)),
        ("farthest off of those given where there is an object", *(f"{mm:.1f} mm" for mm in worst), "", ""),
    ]


def benches(small):
    """Of every bench: strikes and frames kept, centres that are wrong and not marked, how far off, and whether deviations are what they say."""
    folder, out = f"{OUT}/benches_{BENCHES}_{2 if small else 4}", f"{OUT}/bench_tracked.mcap"
    known = peer("benches", folder, BENCHES, 2 if small else 4, *(("clean", "half", "pushed") if small else ()))
    lines, sums, squares, ends = [], [0] * 5, [], ([], [])
    for name in known["frames"]:
        answer = run(FRAMES, "strikes", f"{folder}/{name}/log.mcap", f"{folder}/{name}/rig.toml", out)
        truth = json.loads((ROOT / folder / name / "truth.json").read_text())
        places = [place(truth["frames"], number, seen["stamp"]) for number, seen in enumerate(answer["frames"])]
        pairs = [(seen, at) for seen, at in zip(answer["frames"], places) if seen["x"] is not None]
        far = [[1e3 * (seen[axis] - at[i]) for i, axis in enumerate("xy")] for seen, at in pairs]
        off = [(x * x + y * y) ** 0.5 for x, y in far]
        z2 = [0.5e-6 * mm * mm / seen["deviation"] ** 2 for mm, (seen, _) in zip(off, pairs)]
        far_off = [mm <= 3e3 * seen["deviation"] for mm, (seen, _) in zip(off, pairs) if mm > WRONG]
        wide, wrong, frames = sum(far_off), len(far_off) - sum(far_off), len(truth["frames"])
        kept, of = len(answer["strikes"]), truth["strikes"]
        rms = f"{(sum(mm * mm for mm in off) / len(off)) ** 0.5:.2f}, {max(off):.2f}" if off else "-"
        told = "; ".join(note.split(":")[0] for note in answer["outcome"]["notes"])
        lines.append((name, f"{kept} of {of}", f"{len(pairs)} of {frames}", f"{wrong}; {wide} marked" if wide else str(wrong), rms, f"{statistics.mean(z2):.2f}" if z2 else "-", told))
        if name in known["ordinary"]:
            sums = [a + b for a, b in zip(sums, (kept, of, len(pairs), frames, wrong))]
            squares += z2
            for strike in answer["strikes"]:
                own = min(range(of), key=lambda k: abs(min(f["stamp"] for f in truth["frames"] if f["strike"] == k) * 1e-9 + 0.75 - strike["t"]))
                shots = [frame["at"] for frame in truth["frames"] if frame["strike"] == own]
                for end, seen, at in zip(ends, (strike["start"], strike["stop"]), (shots[0], shots[-1])):
                    end.append(1e6 * sum((seen[i] - at[i]) ** 2 for i in (0, 1)))
    share = 100 * sums[0] / sums[1], 100 * sums[2] / sums[3]
    rms = [(sum(end) / max(len(end), 1)) ** 0.5 for end in ends]
    met = yes(min(share) >= 97 and sums[4] == 0)
    whole = f"{sums[0]} of {sums[1]}, {share[0]:.1f} %", f"{sums[2]} of {sums[3]}, {share[1]:.1f} %"
    said = f"start {rms[0]:.2f}, stop {rms[1]:.2f}"
    lines.insert(0, ("**all ordinary ones**", *whole, str(sums[4]), said, f"{statistics.mean(squares):.2f}", f"≥ 97 %, 0 wrong: {met}"))
    return lines


def place(frames, number, stamp):
    """Where the object was at the stamp (ns) that is said of a frame."""
    frame = frames[number]
    late = 1e-9 * (stamp - frame["stamp"]) - frame["delay"]
    near = [other for other in frames[max(number - 1, 0) : number + 2] if other["strike"] == frame["strike"]]
    seconds = 1e-9 * (near[-1]["stamp"] - near[0]["stamp"]) + near[-1]["delay"] - near[0]["delay"]
    return [at + late * (b - a) / seconds for at, a, b in zip(frame["at"], near[0]["at"][:2], near[-1]["at"])]


def markers(small):
    """Place and yaw by a marker, beside OpenCV's detector on the same frames."""
    folder, out = f"{OUT}/markers_{MARKERS}", f"{OUT}/marker_tracked.mcap"
    known = peer("benches", folder, MARKERS, 1, *(("tag36h11", "tag_other_id") if small else ("marked",)))
    lines, all_off, all_yaw, all_z, wrong_of_all, frames_of_all = [], [], [], [], 0, 0
    for name in known["marked"]:
        answer = run(FRAMES, "strikes", f"{folder}/{name}/log.mcap", f"{folder}/{name}/rig.toml", out)
        theirs = peer("aruco", ROOT / folder / name)["found"]
        truth = json.loads((ROOT / folder / name / "truth.json").read_text())["frames"]
        off, yaw, z2, wrong, outline = [], [], ([], []), 0, 0
        for seen, frame in zip(answer["frames"], truth):
            if seen["x"] is None:
                continue
            mm = 1e3 * ((seen["x"] - frame["at"][0]) ** 2 + (seen["y"] - frame["at"][1]) ** 2) ** 0.5
            wrong += mm > WRONG
            if seen["yaw"] is None:
                outline += 1
                continue
            turn = turned(seen["yaw"], frame["at"][2])
            off.append(mm)
            yaw.append(turn)
            z2[0].append(0.5e-6 * mm * mm / seen["deviation"] ** 2)
            z2[1].append((turn / degrees(seen["yaw_deviation"])) ** 2)
        others = [[], []], [[], []]
        for seen, frame in zip(theirs, truth):
            for (mm, turn), pose in zip(others, seen or ()):
                mm.append(1e3 * ((pose[0] - frame["at"][0]) ** 2 + (pose[1] - frame["at"][1]) ** 2) ** 0.5)
                turn.append(turned(pose[2], frame["at"][2]))
        all_off, all_yaw, all_z = all_off + off, all_yaw + yaw, [a + b for a, b in zip(all_z or ([], []), z2)]
        wrong_of_all, frames_of_all = wrong_of_all + wrong, frames_of_all + len(truth)
        z = ", ".join(f"{statistics.mean(part):.2f}" if part else "-" for part in z2)
        peers = [f"{scatter(mm)}, {scatter(turn)}" for mm, turn in others]
        lines.append((name, f"{len(off)}, {outline} of {len(truth)}", scatter(off), scatter(yaw), z, str(wrong), f"{len(others[0][0])}: {peers[0]}", peers[1]))
    met = yes(rms(all_off) <= 0.5 and rms(all_yaw) <= 0.3 and wrong_of_all == 0)
    z = ", ".join(f"{statistics.mean(part):.2f}" for part in all_z)
    whole = f"{scatter(all_off)}; ≤ 0.5 rms", f"{scatter(all_yaw)}; ≤ 0.3 rms"
    lines.insert(0, ("**all**", f"{len(all_off)} by marker of {frames_of_all}", *whole, z, f"{wrong_of_all}; reached: {met}", "", ""))
    return lines


def degrees(radians):
    return radians * 180 / math.pi


def turned(a, b):
    """The angle between two, in degrees, without a sign."""
    return abs(degrees((a - b + math.pi) % (2 * math.pi) - math.pi))


def rms(numbers):
    return (sum(number * number for number in numbers) / max(len(numbers), 1)) ** 0.5


def scatter(numbers):
    return f"{rms(numbers):.2f} ({max(numbers):.2f})" if numbers else "-"


def strikes(small):
    count = 40 if small else STRIKES
    kept, stop = {}, {}
    for kind, words in {"centroids": (), "pixels": ("--camera",)}.items():
        folder = f"{OUT}/strikes_{kind}_{SEED}_{count}"
        if not (ROOT / folder / "rig" / "truth.json").exists():
            run(CAROM, "demo", "--strikes", count, "--seed", SEED, *words, "--out", f"{folder}/rig", "--json", "--quiet")
        answer = run(CAROM, "run", f"{folder}/rig/logs", "--rig", f"{folder}/rig/rig.toml", "--out", f"{folder}/run", "--json", "--quiet")
        kept[kind] = answer["strikes"]
        words = ("--artifacts", f"{folder}/run", "--robot", f"sim:{folder}/rig", "--repeats", 1, "--sessions", 1, "--seed", SEED)
        tried = run(CAROM, "trial", *words, "--targets", TARGETS if not small else 20, "--json", "--quiet")
        version = (ROOT / folder / "run" / "latest").read_text().strip()
        model = find(json.loads((ROOT / folder / "run" / "versions" / version / "manifest.json").read_text()), "default_model")
        stop[kind] = tried[model]["mean"], tried[model]["sd"] / tried[model]["n"] ** 0.5, tried[model]["n"], model
    share = kept["pixels"] / kept["centroids"]
    ratio = stop["pixels"][0] / stop["centroids"][0]
    shown = {kind: f"{1e3 * mean:.2f} ± {1e3 * error:.2f} mm ({n} strikes of `{model}`)" for kind, (mean, error, n, model) in stop.items()}
    return [
        (f"kept of {count} demo strikes", str(kept["pixels"]), str(kept["centroids"]), f"{100 * share:.1f} %", "≥ 99 %", yes(share >= 0.99)),
        ("stop error of the published model", shown["pixels"], shown["centroids"], f"{ratio:.2f} ×", "≤ 1.1 ×", yes(ratio <= 1.1)),
    ]


def find(tree, key):
    if isinstance(tree, dict):
        return tree[key] if key in tree else next(filter(None, (find(value, key) for value in tree.values())), None)
    return None


def memory(small):
    lines, out = [], f"{OUT}/large_tracked"

    def peak(what, log, rig, size):
        subprocess.run(["rm", "-rf", out], cwd=ROOT, check=True)
        result = run(CAROM, "track", log, "--rig", rig, "--out", out, "--json", "--quiet")
        (frames,) = (one["frames"] for one in result["tracked"])
        subprocess.run(["rm", "-rf", out, log], cwd=ROOT, check=True)
        megabytes = result["memory"] / 1e6
        seen = f"{frames['centroids']:,} of {frames['frames']:,}"
        lines.append((what, seen, f"{size / 1e6:,.0f} MB", f"{megabytes:.0f} MB", f"{result['wall']:.0f} s", "≤ 128 MB", yes(megabytes <= 128)))

    for name in list(LOGS)[: 2 if small else None]:
        folder = f"{OUT}/large"
        peer("large", folder, name)
        peak(name, f"{folder}/log.mcap", f"{folder}/rig.toml", (ROOT / folder / "log.mcap").stat().st_size)
    size = 50_000_000 if small else 2_000_000_000
    log, rig = f"{OUT}/large.mcap", f"{OUT}/large.toml"
    run(FRAMES, "log", rendered("tall", 1280, 720, 40 if small else 60), log, rig, size)
    peak("JPEG 1280 × 720, a long log", log, rig, size)
    return lines


def boards(small):
    folder = f"{OUT}/boards"
    views = 6 if small else 15
    theirs = peer("charuco", folder, views)
    images = [f"{folder}/view_{number:02}.jpg" for number in range(views)]
    words = ("--board", "5x7", "--square", 0.04, "--marker", 0.028, "--dictionary", "DICT_5X5_100")
    corners = ",".join(str(part) for corner in theirs["corners"] for part in corner)
    table = ("--table", f"{folder}/table.jpg", "--corners", corners)
    mine = run(CAROM, "camera", "calibrate", *images, *words, *table, "--rig", f"{folder}/rig.toml", "--json")
    truth = theirs["truth"]

    def off(numbers, known):
        return sum((a - b) ** 2 for a, b in zip(numbers, known)) ** 0.5

    def listed(numbers, digits):
        return ", ".join(f"{number:.{digits}f}" for number in numbers)

    return [
        ("images, corners used", f"{views}, {mine['lens']['corners']}", f"{views}, {theirs['used']}", ""),
        ("reprojection error", f"{mine['lens']['reprojection_error']:.3f} px", f"{theirs['error']:.3f} px", ""),
        ("fx, fy, cx, cy in px", listed(mine["matrix"], 2), listed(theirs["matrix"], 2), listed(truth["matrix"], 2)),
        ("k1, k2, p1, p2", listed(mine["distortion"][:4], 4), listed(theirs["distortion"][:4], 4), listed(truth["distortion"][:4], 4)),
        ("camera's place, mm off", f"{1e3 * off(mine['position'], truth['position']):.2f}", f"{1e3 * off(theirs['position'], truth['position']):.2f}", ""),
    ]


PARTS = {"speed": speed, "accuracy": accuracy, "benches": benches, "markers": markers, "hostile": hostile, "strikes": strikes, "memory": memory, "boards": boards}


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True).stdout.strip()


def table(head, lines):
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *lines))


def measured(text):
    """The results that a page holds, each with what it was measured of."""

    def rows(title):
        part = text.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
        cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines() if line.startswith("|")]
        return cells[2:]

    made = rows("How it was made")
    return {name: {"lines": rows(TITLES[name]), "tree": tree, "load": float(load)} for name, tree, load in made}


def page(results):
    parts = [HEAD]
    for name in PARTS:
        if part := results.get(name):
            parts += [f"## {TITLES[name]}", ABOUT[name], table(HEADS[name], part["lines"])]
    made = [(name, results[name]["tree"], f"{results[name]['load']:.1f}") for name in PARTS if name in results]
    missing = [name for name in PARTS if name not in results]
    parts += [
        "## How it was made",
        table(("part", "git tree of stages/track", "load of the machine before"), made) + (f"\n\nNot measured: {', '.join(missing)}." if missing else ""),
        f"{CORES} cores ({platform.machine()}); {output('rustc', '--version').split(' (')[0]}; Python {platform.python_version()}, "
        f"opencv-python-headless {importlib.metadata.version('opencv-python-headless')}.",
    ]
    return "\n\n".join(parts) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", help=f"measured anew; where none is named, all that are missing, of {', '.join(PARTS)}")
    parser.add_argument("--small", action="store_true", help="few frames, to try the harness, and a page of its own")
    args = parser.parse_args()
    if unknown := [name for name in args.parts if name not in PARTS]:
        parser.error(f"no part is called {', '.join(unknown)}; there are {', '.join(PARTS)}")
    kept = ROOT / (f"{OUT}/small.md" if args.small else "tests/TRACK.md")
    kept.parent.mkdir(parents=True, exist_ok=True)
    known = measured(kept.read_text()) if kept.exists() else {}
    for name in args.parts or [name for name in PARTS if name not in known]:
        print(f"bench: track {name}", file=sys.stderr, flush=True)
        load, tree = os.getloadavg()[0], output("git", "rev-parse", "--short", "HEAD:stages/track")
        part = {"lines": PARTS[name](args.small), "tree": tree, "load": load}
        known[name] = part
        kept.write_text(page(known))
        for line in part["lines"]:
            print("  " + "; ".join(filter(None, line)), file=sys.stderr)


if __name__ == "__main__":
    main()
