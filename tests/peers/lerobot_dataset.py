"""The strikes of a run as LeRobot reads them: `lerobot_dataset.py CAROM RUN FOLDER`.

Has carom export RUN, opens it with LeRobot's own metadata and table readers (PyPI's `lerobot`), and holds it against the run's tables. torch, which makes
tensors of rows, is large and left out: names that are only imported stand for it. Exits with 1 and says what does not hold.
"""

import json
import shutil
import sys
from pathlib import Path
from unittest.mock import MagicMock

import datasets  # noqa: F401  before torch's name stands there, which it would believe
import numpy as np
from checking import call, check, finish

ABSENT = (
    "torch torch.nn torch.nn.functional torch.utils torch.utils.data torchvision torchvision.transforms torchvision.transforms.v2 torchvision.transforms.functional "
    "torchcodec torchcodec.decoders av accelerate draccus imageio cv2 deepdiff"
).split()
for name in ABSENT:
    sys.modules[name] = MagicMock(name=name)

from lerobot.datasets.lerobot_dataset import LeRobotDatasetMetadata  # noqa: E402
from lerobot.datasets.utils import get_hf_features_from_features, load_nested_dataset  # noqa: E402

for name in ABSENT:
    del sys.modules[name]

carom, run, folder = sys.argv[1], sys.argv[2], Path(sys.argv[3])

asked = "SELECT strike_id, x0, y0, xf, yf, speed, angle, split FROM strikes"
strikes = {row["strike_id"]: row for row in json.loads(call(carom, "query", run, asked, "--json").stdout)}
for fps in (None, 50):
    out = folder / f"dataset_{fps}"
    shutil.rmtree(out, ignore_errors=True)
    call(carom, "dataset", "export", run, "--lerobot", out, *(["--fps", fps] if fps else []))
    meta = LeRobotDatasetMetadata("carom/demo", root=out)
    rows = load_nested_dataset(out / "data", features=get_hf_features_from_features(meta.features)).with_format("numpy")[:]
    check(meta.total_episodes == len(strikes) == len(meta.episodes), f"{meta.total_episodes} episodes, {meta.total_frames} frames at {meta.fps} a second, {meta.total_tasks} tasks")
    check(len(rows["index"]) == meta.total_frames and (rows["index"] == np.arange(meta.total_frames)).all(), "frames are counted through")
    late = np.abs(rows["timestamp"] - rows["frame_index"] / meta.fps).max()
    check(late < 1e-4, f"stamps lie on the grid ({late:.1e} s; LeRobot asks for 1e-4)")
    far, off, parts = 0.0, 0.0, {}
    for episode in meta.episodes:
        begin, end = episode["dataset_from_index"], episode["dataset_to_index"]
        strike = strikes[episode["strike_id"]]
        state, action = rows["observation.state"][begin:end], rows["action"][begin:end]
        if end - begin != episode["length"] or set(rows["episode_index"][begin:end]) != {episode["episode_index"]}:
            check(False, f"episode {episode['episode_index']} has its own rows")
        far = max(far, np.abs(state[0, :2] - (strike["x0"], strike["y0"])).max())
        if strike["xf"] is not None:
            far = max(far, np.abs(state[-1, :2] - (strike["xf"], strike["yf"])).max())
        off = max(off, np.abs(action[0, :2] - (strike["speed"], strike["angle"])).max(), np.abs(action[1:]).max())
        parts.setdefault(strike["split"], []).append(episode["episode_index"])
        task = meta.tasks.iloc[rows["task_index"][begin]].name
        if [task] != list(episode["tasks"]) or meta.get_task_index(task) != rows["task_index"][begin]:
            check(False, f"episode {episode['episode_index']} has its task: {task}")
    check(far < 1e-6, f"episodes begin and end where the tables have their strikes ({far:.1e} m)")
    check(off < 1e-6, f"the first frame has the command, the others none ({off:.1e})")
    ranges = {split: f"{min(places)}:{max(places) + 1}" for split, places in parts.items()}
    check(ranges == meta.info["splits"], f"parts follow each other: {meta.info['splits']}")
    for name in ("observation.state", "action", "timestamp"):
        numbers, stats = np.asarray(rows[name], dtype=float).reshape(meta.total_frames, -1), meta.stats[name]
        own = {"min": numbers.min(0), "max": numbers.max(0), "mean": numbers.mean(0), "std": numbers.std(0), "q10": np.quantile(numbers, 0.1, 0), "q99": np.quantile(numbers, 0.99, 0)}
        worst = max(np.abs(stats[what] - value).max() for what, value in own.items())
        check(worst < 1e-6 and stats["count"] == [meta.total_frames], f"statistics of {name} are numpy's ({worst:.1e})")
    print(f"       a task: {task}")
call(carom, "dataset", "export", run, "--lerobot", out, expected=2)
finish()
