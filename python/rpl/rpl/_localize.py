"""The filter on recorded drives."""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ._command import output_of


@dataclass(frozen=True)
class RecordedDrive:
    """How well the filter found the robot on a recorded drive; notebooks show the map with both paths."""

    #: Every figure of it (docs/json.md).
    figures: dict[str, Any]
    #: The map with the corrected path and the estimated one, as SVG.
    paths_svg: str
    #: The errors over the way, as SVG.
    errors_svg: str

    @property
    def found(self) -> int:
        """In how many windows the robot was found."""
        return int(self.figures["found"]["count"])

    @property
    def of(self) -> int:
        """How many windows there are."""
        return int(self.figures["found"]["of"])

    def __repr__(self) -> str:
        return f"<RecordedDrive: found in {self.found} of {self.of} windows>"

    def _repr_svg_(self) -> str:
        return self.paths_svg


def localize(
    map: str | Path,
    log: str | Path,
    *,
    windows: int | None = None,
    window_length_m: float | None = None,
    phase: float | None = None,
    beams: int | None = None,
    field_of_view_deg: float | None = None,
    parameters: str | Path | None = None,
    from_truth: bool = False,
) -> RecordedDrive:
    """Runs the filter on a log of CARMEN over a ROS map, as `rpl localize` does (docs/localize.md).

    Raises CommandError with what is wrong with the files.
    """
    words = ["localize", "--map", str(map), "--log", str(log), "--json"]
    options = {
        "--windows": windows,
        "--window-length": window_length_m,
        "--phase": phase,
        "--beams": beams,
        "--field-of-view": field_of_view_deg,
        "--parameters": parameters,
    }
    for option, value in options.items():
        words += [] if value is None else [option, str(value)]
    words += ["--from-truth"] if from_truth else []
    with tempfile.TemporaryDirectory(prefix="rpl-") as folder:
        figures = json.loads(output_of([*words, "--figures", folder]))
        paths, errors = (Path(folder, name).read_text(encoding="utf-8") for name in ("paths.svg", "errors.svg"))
    return RecordedDrive(figures, paths, errors)
