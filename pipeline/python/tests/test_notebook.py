"""The notebook runs from its first cell to its last, and draws what it says."""

import os
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).parent.parent / "first_strikes.ipynb"


def test_the_notebook_runs_and_draws_its_pictures(tmp_path):
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(notebook, timeout=1800, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pictures = [output["data"]["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == 2 and min(map(len, pictures)) > 10_000
    said = "".join(output.get("text", "") for output in outputs)
    assert "strikes," in said and "refused:" in said, said
    # For whoever looks at them.
    if folder := os.environ.get("CAROM_NOTEBOOK"):
        nbformat.write(notebook, Path(folder) / NOTEBOOK.name)
