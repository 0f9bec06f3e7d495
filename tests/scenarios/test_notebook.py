"""The notebook of the Python interface, executed by a kernel of Jupyter."""

import pytest
from support.optional import need

need("dev", "nbformat", "nbclient")

import nbformat
from nbclient import NotebookClient
from support.paths import ROOT

NOTEBOOK = ROOT / "docs" / "examples" / "first_run.ipynb"
TIMEOUT_S = 600


@pytest.mark.slow
def test_the_notebook_runs_and_shows_its_results(tmp_path):
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    cells = {cell.id: cell for cell in notebook.cells if cell.cell_type == "code"}
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells.values())  # as committed
    resources = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, timeout=TIMEOUT_S, kernel_name="python3", resources=resources).execute()
    shown = {
        name: [output.data for output in cell.outputs] for name, cell in cells.items()
    }  # neither streams nor errors
    assert {name: len(data) for name, data in shown.items()} == dict.fromkeys(cells, 1)
    assert "truck-shadow-1s, seed 1, 75 frames" in shown["run"][0]["text/html"]
    assert shown["metrics"][0]["text/plain"].startswith("Metric(value=0.")
    assert "l_shape" in shown["tables"][0]["text/html"]
    assert "track.hota" in shown["compare"][0]["text/html"].replace("<wbr>", "")
    assert list(tmp_path.iterdir()) == []
