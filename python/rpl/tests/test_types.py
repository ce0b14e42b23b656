"""The package is typed: strictly, and its stubs say what the library has."""

import os
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).parent.parent


def said(folder, *words):
    environment = {**os.environ, "MYPY_CACHE_DIR": os.devnull}
    ended = subprocess.run([sys.executable, "-m", *words], cwd=folder, capture_output=True, text=True, env=environment)
    return ended.returncode, ended.stdout + ended.stderr


def test_the_types_hold():
    status, text = said(PACKAGE, "mypy", "-p", "rpl")
    assert status == 0, text


def test_the_stubs_are_what_the_library_has(tmp_path):
    # From elsewhere, so that it is the installed package.
    status, text = said(tmp_path, "mypy.stubtest", "rpl.rpl_native")
    assert status == 0, text
