"""The programs, as commands."""

import os
import signal
import sys
from pathlib import Path

from . import _carom, _mujoco


def carom() -> None:
    # Python's own handler would wait for the command to end.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_carom.main(sys.argv))


def strike() -> None:
    program = Path(__file__).parent / "bin" / "strike"
    before = os.environ.get("LD_LIBRARY_PATH")
    library = str(_mujoco.folder())
    path = library if not before else f"{library}:{before}"
    os.execve(program, ["strike", *sys.argv[1:]], {**os.environ, "LD_LIBRARY_PATH": path})
