"""The installed package: `make wheel` runs this in an environment that has nothing but it."""

import json
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import carom

FROM = (0.30, 0.00)


def programs(name):
    return str(Path(sys.executable).parent / name)


@pytest.fixture(scope="session")
def run(tmp_path_factory):
    """A small run of the demo, made by the package itself."""
    folder = tmp_path_factory.mktemp("run")
    carom.command(["demo", "--strikes", "80", "--seed", "3", "--hide", "table_tilt=0.006,0.0", "--out", str(folder / "rig")])
    said = carom.run(folder / "rig/logs", rig=folder / "rig/rig.toml", out=folder / "out", seed=1)
    return folder, said


def test_a_run_says_what_the_command_says(run):
    folder, said = run
    assert said["strikes"] > 60 and said["outcome"] in ("done", "rejected")
    assert said["version"] == "v0001"
    assert (folder / "out/report.html").is_file()


def test_a_version_predicts_and_plans_what_the_programs_do(run):
    folder, _ = run
    version = carom.Version.load(folder / "out")
    assert version.name == "v0001" and version.manifest["schema"] >= 2
    said = version.predict(FROM, 0.8, 0.1)
    line = [programs("carom"), "predict", "--artifacts", folder / "out", "--from", "0.3", "0", "--speed", "0.8", "--angle", "0.1", "--json"]
    printed = json.loads(subprocess.run(line, check=True, capture_output=True, text=True).stdout)
    assert printed["stop"] == said["stop"] and printed["world"] == said["world"]

    strikes = np.asarray([[s["xf"], s["yf"]] for s in rows(version.strikes()) if s["xf"] is not None])
    target = tuple(np.median(strikes, axis=0))
    plan = version.plan(FROM, target)
    line = [programs("strike"), "--artifacts", folder / "out", "--from", "0.3", "0", "--to", *map(str, target), "--json", "--quiet"]
    printed = json.loads(subprocess.run(line, check=True, capture_output=True, text=True).stdout)
    assert (printed["speed"], printed["angle"]) == (plan["speed"], plan["angle"])


def rows(table):
    import pyarrow

    return pyarrow.table(table).to_pylist()


def test_tables_are_arrow_that_polars_and_pandas_read(run):
    import pandas
    import polars
    import pyarrow

    folder, said = run
    version = carom.Version.load(folder / "out")
    strikes = version.strikes()
    assert len(strikes) == said["strikes"] and "strike_id" in strikes.columns
    frame = polars.DataFrame(strikes)
    assert frame.equals(polars.read_parquet(folder / "out/strikes.parquet"))
    tracks = pyarrow.table(version.tracks())
    assert tracks.schema.field("x").metadata[b"unit"] == b"m"
    assert isinstance(tracks.to_pandas(), pandas.DataFrame) and tracks.num_rows == frame["frames"].sum()
    # Twice the same stream: a table is not used up.
    assert pyarrow.table(strikes).num_rows == len(strikes)


def test_a_world_strikes_forwards_and_backwards_and_opens_in_mujoco(run):
    import mujoco

    folder, _ = run
    world = carom.World.load(folder / "out")
    strike = world.simulate(FROM, 0.8, 0.1)
    assert isinstance(strike.t, np.ndarray) and strike.t.dtype == np.float64
    assert len(strike.t) == len(strike.x) == len(strike.y) and np.all(np.diff(strike.t) > 0)
    assert np.allclose([strike.x[-1], strike.y[-1]], strike.stop, atol=1e-3)
    solved = world.solve(FROM, strike.stop)
    assert solved["status"] == "solved" and abs(solved["speed"] - 0.8) < 0.01 and abs(solved["angle"] - 0.1) < 0.01
    starts = np.tile(FROM, (3, 1))
    stops = world.stops(starts, np.array([0.6, 0.8, 1.0]), np.full(3, 0.1))
    assert stops.shape == (3, 2) and np.allclose(stops[1], strike.stop)
    assert mujoco.MjModel.from_xml_string(world.mjcf()).nbody > 1
    friction = world.parameters["friction"]
    assert friction["low"] < friction["value"] < friction["high"]
    text = carom.World.load(folder / "out/world.toml", rig=folder / "rig/rig.toml")
    assert text.parameters == world.parameters and text.effects == world.effects


def test_the_diagnosis_names_the_tilt_that_was_hidden(run):
    folder, _ = run
    diagnosis = carom.Version.load(folder / "out").diagnosis
    assert diagnosis["verdict"] in ("named", "consistent", "unexplained")
    assert diagnosis == json.loads((folder / "out/diagnosis.json").read_text())


def test_errors_are_exceptions_with_the_programs_texts(run, tmp_path):
    folder, _ = run
    with pytest.raises(carom.InvalidInput, match="carom rig init"):
        carom.run(folder / "rig/logs", rig=tmp_path / "none.toml", out=tmp_path / "out")
    with pytest.raises(carom.Refused, match="off_table|outside"):
        carom.Version.load(folder / "out").plan(FROM, (50.0, 0.0))
    with pytest.raises(carom.InvalidInput, match="off the table"):
        carom.World.load(folder / "out").simulate((50.0, 0.0), 0.8, 0.0)
    with pytest.raises(carom.InvalidInput, match="above 0 m/s"):
        carom.World.load(folder / "out").simulate(FROM, -1.0, 0.0)
    with pytest.raises(carom.InvalidInput, match="its rig file"):
        carom.World.load(folder / "out/world.toml")
    with pytest.raises(carom.CaromError):
        carom.Version.load(tmp_path)
    with pytest.raises(carom.InvalidInput, match="unexpected argument|Usage"):
        carom.command(["run", "--no-such-flag"])


def test_the_interpreter_goes_on_while_something_is_computed(run):
    folder, _ = run
    world = carom.World.load(folder / "out")
    n = 3000
    starts, speeds, angles = np.tile(FROM, (n, 1)), np.linspace(0.5, 1.0, n), np.zeros(n)
    ticks, is_over = [], threading.Event()

    def tick():
        while not is_over.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    before = len(ticks)
    world.stops(starts, speeds, angles)
    during = len(ticks) - before
    is_over.set()
    thread.join()
    assert during > 1, "nothing else ran meanwhile"


def test_programs_run_with_an_empty_path(run):
    for name, said in [("carom", "engine: MuJoCo 3.17"), ("strike", "engine: MuJoCo 3.17")]:
        output = subprocess.run([programs(name), "--version"], env={"PATH": ""}, capture_output=True, text=True, cwd="/")
        assert output.returncode == 0 and said in output.stdout, (output.stdout, output.stderr)


def test_the_stubs_are_true():
    told = subprocess.run([sys.executable, "-m", "mypy.stubtest", "carom"], capture_output=True, text=True, cwd=Path(carom.__file__).parent)
    assert told.returncode == 0, told.stdout + told.stderr
