from os import PathLike
from typing import Any, Sequence, TypedDict, final

import numpy as np
from numpy.typing import NDArray

_Path = str | PathLike[str]
_Point = tuple[float, float]

__all__ = [
    "Busy",
    "CaromError",
    "Failed",
    "InvalidInput",
    "Refused",
    "Strike",
    "Table",
    "Version",
    "World",
    "__version__",
    "about",
    "command",
    "main",
    "run",
]

__version__: str

class CaromError(Exception):
    """What a command or a call did not do; its text is the programs'."""

class InvalidInput(CaromError):
    """What was given cannot be worked with (exit code 2)."""

class Refused(CaromError):
    """A gate or a safety limit said no (exit code 4)."""

class Busy(CaromError):
    """Another run works in the folder (exit code 75)."""

class Failed(CaromError):
    """The work itself failed (exit code 1)."""

class _Estimate(TypedDict):
    value: float
    low: float | None
    """Lower end of the 95 % interval; none where it was not identified."""
    high: float | None
    unit: str

class _Solution(TypedDict):
    speed: float
    angle: float
    miss: float | None
    """In m; none where nothing came to rest."""
    evaluations: int
    status: str

def run(
    logs: _Path | Sequence[_Path],
    rig: _Path,
    out: _Path,
    *,
    seed: int = 0,
    without_effects: bool = False,
    key: _Path | None = None,
    quiet: bool = True,
) -> dict[str, Any]:
    """`carom run`: the whole pipeline. What `--json` prints, and `outcome`: "done", "rejected" or "refused"."""

def command(arguments: Sequence[str]) -> Any:
    """Any command of `carom`, such as ["check", "logs/", "--rig", "rig.toml"]: what `--json` prints."""

def main(arguments: Sequence[str]) -> int:
    """The program: its name and its words; gives the exit code."""

def about() -> str:
    """Version, commit, engine and formats of this build."""

@final
class Strike:
    """A simulated strike, as the camera would see it, from touch to rest."""

    @property
    def t(self) -> NDArray[np.float64]:
        """Seconds since touch."""
    @property
    def x(self) -> NDArray[np.float64]: ...
    @property
    def y(self) -> NDArray[np.float64]: ...
    @property
    def stop(self) -> _Point:
        """Where the object comes to rest, in m."""
    @property
    def rest_time(self) -> float:
        """Seconds from touch to rest."""

@final
class World:
    """The MuJoCo world of a set-up, with the effects that were named."""

    @staticmethod
    def load(path: _Path, rig: _Path | None = None, version: str | None = None) -> World:
        """The world in use of a run's folder (of its latest version, or the one named), or a world.toml with its rig.toml."""
    def simulate(self, start: _Point, speed: float, angle: float, session: str = "", order: float = 0.0) -> Strike:
        """One strike: where the object rests in m, commanded speed in m/s and angle in rad.

        `session` and `order` (strikes before it, as in the table of strikes) matter to effects that differ by session or drift."""
    def stops(
        self, starts: NDArray[np.float64], speeds: NDArray[np.float64], angles: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Stops of many strikes, n × 2 in m, on all cores; not a number where one does not come to rest. `starts` is n × 2."""
    def solve(self, start: _Point, target: _Point) -> _Solution:
        """The command that brings the object from start to rest at target, and how near (status, miss in m)."""
    def mjcf(self) -> str:
        """The world as MJCF, which MuJoCo's own package and viewer open."""
    @property
    def parameters(self) -> dict[str, _Estimate]:
        """Every parameter: identified, or nominal without an interval."""
    @property
    def effects(self) -> dict[str, dict[str, _Estimate]]:
        """The effects that were named, with their parameters."""

@final
class Table:
    """A table as Arrow: polars, pandas, pyarrow and duckdb read it through `__arrow_c_stream__`, without a copy."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    def __len__(self) -> int: ...
    @property
    def columns(self) -> list[str]: ...

@final
class Version:
    """A published version, every part of which is checked as it is loaded."""

    @staticmethod
    def load(folder: _Path, version: str | None = None) -> Version:
        """The latest version in a run's folder, or the one named."""
    @property
    def name(self) -> str: ...
    @property
    def model(self) -> str:
        """The model that it plans with unless another is asked for."""
    @property
    def manifest(self) -> dict[str, Any]: ...
    @property
    def diagnosis(self) -> dict[str, Any] | None:
        """What the run said is missing (diagnosis.json of the folder); none where there is none."""
    def world(self) -> World: ...
    def predict(self, start: _Point, speed: float, angle: float) -> dict[str, Any]:
        """`carom predict`: the track and the stop that the version expects."""
    def plan(self, start: _Point, target: _Point, model: str | None = None) -> dict[str, Any]:
        """The command that strikes at a target, within every limit; raises Refused with the reason otherwise."""
    def strikes(self) -> Table:
        """The strikes that were kept (strikes.parquet of the folder)."""
    def tracks(self) -> Table:
        """Their tracks, a row a frame (tracks.parquet of the folder)."""
