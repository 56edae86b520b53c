"""MuJoCo's library, from the `mujoco` package, wherever that is installed."""

import ctypes
import importlib.util
from pathlib import Path

LIBRARY = "libmujoco.so.3.17.0"


def folder() -> Path:
    """The folder of the library; an ImportError says what is missing."""
    package = importlib.util.find_spec("mujoco")
    if package is None or package.origin is None:
        raise ImportError("carom needs the package mujoco, version 3.17.0: pip install mujoco==3.17.0")
    folder = Path(package.origin).parent
    if not (folder / LIBRARY).is_file():
        raise ImportError(f"carom needs {LIBRARY}, and {folder} has another version: pip install mujoco==3.17.0")
    return folder


def load() -> None:
    """Loads it, so that what links it finds it."""
    ctypes.CDLL(str(folder() / LIBRARY), mode=ctypes.RTLD_GLOBAL)
