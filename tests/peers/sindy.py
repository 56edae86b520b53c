"""A SINDy-like peer of `make blind`: which term of a sparse regression explains the accelerations along the tracks?

Reads a set of strikes a line from standard input, {"id", "tracks": [{"t", "x", "y"}], "order": [...], "session": [...]}, and
writes {"id", "named"} a line. Accelerations come from a smoothed derivative of each track; the library of terms is made of
the slide's effects, and pysindy's sequentially thresholded least squares (Brunton, Proctor and Kutz 2016) keeps few of
them. Terms are put in units of their own size, so that one threshold serves all: the largest that predicts every second track,
held out, within one standard error of the best. Names are in the order of what is lost without them. What an impact or a camera does
is no acceleration: such effects it cannot name.
"""

import json
import sys

import numpy as np
import pysindy as ps

# Of the largest term's size; a term below it is dropped.
THRESHOLDS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5)
# Frames of the smoothing window (Savitzky and Golay).
WINDOW = 9
# In m/s: slower frames have no direction.
SLOWEST = 0.1


def rows(case):
    """Places, velocities, accelerations and conditions of all frames that slide."""
    smooth = ps.SmoothedFiniteDifference(
        smoother_kws={"window_length": WINDOW, "polyorder": 3}
    )
    found = []
    for number, (track, order, session) in enumerate(
        zip(case["tracks"], case["order"], case["session"])
    ):
        t = np.asarray(track["t"])
        p = np.column_stack([track["x"], track["y"]])
        if len(t) < 2 * WINDOW or np.any(np.diff(t) <= 0):
            continue
        even = np.linspace(t[0], t[-1], len(t))
        p = np.column_stack([np.interp(even, t, p[:, i]) for i in range(2)])
        v = smooth._differentiate(p, even)
        a = smooth._differentiate(v, even)
        # Ends are smoothed from one side alone; at rest there is no friction to estimate.
        still = np.nonzero(np.hypot(*v.T) < SLOWEST)[0]
        last = (still[still > WINDOW][:1].tolist() or [len(t)])[0] - WINDOW // 2
        for i in range(WINDOW // 2, last):
            found.append((*p[i], *v[i], *a[i], order, session, number))
    return np.asarray(found)


def library(data):
    """Columns of acceleration by name of effect, each for x and y stacked; dry friction is the first."""
    p, v, order, session = data[:, :2], data[:, 2:4], data[:, 6], data[:, 7]
    speed = np.linalg.norm(v, axis=1, keepdims=True)
    along = v / speed
    middle = p - p.mean(axis=0)
    spread = max(np.ptp(order), 1.0)
    one, zero = np.ones(len(p)), np.zeros(len(p))
    terms = [
        ("friction", -along),
        ("viscous_drag", -v),
        ("quadratic_drag", -speed * v),
        ("speed_weakening_friction", -along * np.exp(-((speed / 0.3) ** 2))),
        ("anisotropic_friction", along * [1.0, -1.0]),
        ("anisotropic_friction", along[:, ::-1]),
        ("table_tilt", np.column_stack([one, zero])),
        ("table_tilt", np.column_stack([zero, one])),
        ("table_bowl", -middle),
        ("friction_drift", -along * ((order - order.mean()) / spread)[:, None]),
    ]
    terms += [
        ("friction_by_session", -along * (session == s)[:, None])
        for s in np.unique(session)[1:]
    ]
    cells = np.floor(p / 0.12).astype(int)
    for cell in np.unique(cells, axis=0):
        inside = np.all(cells == cell, axis=1)
        if inside.sum() >= 40:
            terms.append(("friction_patch", -along * inside[:, None]))
    return [name for name, _ in terms], np.column_stack([c.T.ravel() for _, c in terms])


def left_without(theta, target, kept):
    """Sum of squares left by the terms kept."""
    if not len(kept):
        return float(target @ target)
    coefficients = np.linalg.lstsq(theta[:, kept], target, rcond=None)[0]
    return float(((target - theta[:, kept] @ coefficients) ** 2).sum())


def named(case):
    data = rows(case)
    if len(data) < 50:
        return []
    names, theta = library(data)
    target = data[:, 4:6].T.ravel()
    theta = theta / np.sqrt((theta**2).mean(axis=0))
    track = np.tile(data[:, 8], 2)
    learns = track % 2 == 0
    tried = []
    for threshold in THRESHOLDS:
        fit = ps.STLSQ(threshold=threshold * np.abs(target).mean(), alpha=1e-6)
        fit.fit(theta[learns], target[learns][:, None])
        off = (target - theta @ fit.coef_[0]) ** 2
        judged = [off[track == t].mean() for t in np.unique(track[~learns])]
        error = np.std(judged) / np.sqrt(len(judged))
        tried.append((np.mean(judged), error, np.nonzero(fit.coef_[0])[0]))
    best, error, _ = min(tried, key=lambda one: one[0])
    kept = [k for mean, _, k in tried if mean <= best + error][-1]
    lost = {k: left_without(theta, target, [j for j in kept if j != k]) for k in kept}
    order = sorted(kept, key=lambda k: -lost[k])
    return list(dict.fromkeys(names[k] for k in order if names[k] != "friction"))


for line in sys.stdin:
    case = json.loads(line)
    print(json.dumps({"id": case["id"], "named": named(case)}), flush=True)
