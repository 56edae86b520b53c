"""From strike logs to a robot that strikes. See `carom.run`, `carom.World` and `carom.Version`."""

from . import _mujoco

_mujoco.load()

from ._carom import (  # noqa: E402
    Busy,
    CaromError,
    Failed,
    InvalidInput,
    Refused,
    Strike,
    Table,
    Version,
    World,
    __version__,
    about,
    command,
    run,
)

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
    "run",
]
