"""The command `rpl`, which the package has in it, in a process of its own.

What it does takes the signals of its process and keeps in mind the files it has read, so it is no function of this one.
Run as a module, this file is that process.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Sequence

from .rpl_native import command

#: What the command ends with if it has done what it was asked for. 1 says that runs have failed.
DONE = (0, 1)


class CommandError(Exception):
    """Something cannot be done: what the command says of it."""


def output_of(words: Sequence[str], folder: str | None = None, threads: int | None = None) -> str:
    """What the command writes to standard output.

    It ends when this process does, however that ends: it holds the other end of a pipe.

    One run has as many threads as there are cores, or as many as are given.

    Raises CommandError with what it says of what is wrong.
    """
    environment = os.environ if threads is None else {**os.environ, "RAYON_NUM_THREADS": str(threads)}
    theirs, ours = os.pipe()
    try:
        ended = subprocess.run(
            [sys.executable, "-m", __name__, *words],
            cwd=folder,
            env=environment,
            stdin=theirs,
            capture_output=True,
            text=True,
            encoding="utf-8",
        )
    finally:
        os.close(theirs)
        os.close(ours)
    if ended.returncode not in DONE:
        raise CommandError(ended.stderr.strip() or f"rpl has ended with {ended.returncode}")
    return ended.stdout


def _end_with_parent() -> None:
    os.read(0, 1)
    os._exit(2)


if __name__ == "__main__":
    threading.Thread(target=_end_with_parent, daemon=True).start()
    sys.exit(command(["rpl", *sys.argv[1:]]))
