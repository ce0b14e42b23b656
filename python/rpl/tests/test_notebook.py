"""The notebook does what it says."""

from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).parent.parent / "examples" / "missions.ipynb"


def test_the_notebook_runs_from_the_first_cell_to_the_last():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(notebook, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    drawings = [output for output in outputs if "image/svg+xml" in output.get("data", {})]
    assert len(drawings) == 2, "the mission and the recorded drive"
    assert any("succeeded" in output.get("text", "") for output in outputs)
