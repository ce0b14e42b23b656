"""The packages are typed strictly."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGES = Path(__file__).parent.parent


def test_the_types_hold():
    pytest.importorskip("mypy")
    environment = {**os.environ, "MYPY_CACHE_DIR": os.devnull, "MYPYPATH": "tests"}
    words = ["-m", "mypy", "rpl_host", "rpl_module", "tests/test_host.py", "tests/test_worlds.py"]
    ended = subprocess.run([sys.executable, *words], cwd=PACKAGES, capture_output=True, text=True, env=environment)
    assert ended.returncode == 0, ended.stdout + ended.stderr
