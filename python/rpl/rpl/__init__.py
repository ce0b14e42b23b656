"""Missions and experiments in RPL, the reactive plan language.

>>> import rpl
>>> mission = rpl.Mission("(go-to 'table-side)", world="test-room", seed=1)
>>> mission.run()
't'

A mission is a value: it can be stepped, forked, saved and gone on with. `experiment` runs a plan over many seeds, here
or on a cluster; `localize` runs the filter on a recorded drive.
"""

from ._command import CommandError
from ._experiment import Experiment, Progress, experiment
from ._localize import RecordedDrive, localize
from ._mission import Figure, Finding, Mission, Plan, PlanFailed, TimeUp
from .rpl_native import BUILD, Robot, SetUpError, World

__all__ = [
    "BUILD",
    "CommandError",
    "Experiment",
    "Figure",
    "Finding",
    "Mission",
    "Plan",
    "PlanFailed",
    "Progress",
    "RecordedDrive",
    "Robot",
    "SetUpError",
    "TimeUp",
    "World",
    "experiment",
    "localize",
]
