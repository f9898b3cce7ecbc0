"""Runs a notebook with the Python that runs this: notebook.py NOTEBOOK. 77: what it needs is not here."""

import sys

try:
    import ipykernel  # noqa: F401
    import matplotlib  # noqa: F401
    import nbclient
    import nbformat
except ImportError as error:
    print(f"not run: {error}")
    sys.exit(77)

notebook = nbformat.read(sys.argv[1], as_version=4)
nbformat.validate(notebook)
nbclient.NotebookClient(notebook, timeout=60, kernel_name="python3").execute()
pictures = sum("image/png" in o.get("data", {}) for cell in notebook.cells for o in cell.get("outputs", ()))
print(f"{pictures} pictures")
if len(sys.argv) > 2:
    nbformat.write(notebook, sys.argv[2])
sys.exit(pictures != 3)
