#!/usr/bin/env python3
"""Writes generatedSchema.usda from schema.usda with usdGenSchema (Python packages: usd-core, jinja2).

Two things are added to what usdGenSchema writes: the documentation in full, which it shortens to one sentence, and
the list `appliedAPISchemas`, which OpenUSD before 21.08 reads to know that the schema is an applied one.
"""

import argparse
import inspect
import pathlib
import shutil
import subprocess
import sys
import tempfile

from pxr import Sdf, Usd, Vt

HERE = pathlib.Path(__file__).resolve().parent


def run_generator(folder):
    """Runs usdGenSchema on a copy of schema.usda in `folder`; returns the generated layer."""
    shutil.copy(HERE / "schema.usda", folder)
    generator = pathlib.Path(Usd.__file__).parent / "usdGenSchema.py"
    subprocess.run(
        [sys.executable, str(generator), "--quiet", "schema.usda", "."],
        cwd=folder,
        check=True,
        capture_output=True,
    )
    return Sdf.Layer.FindOrOpen(str(pathlib.Path(folder) / "generatedSchema.usda"))


def add_documentation(layer, source):
    """Copies the documentation of `source` in full and drops the one-sentence digest."""
    for prim in layer.rootPrims:
        for spec in [prim, *prim.properties]:
            documentation = source.GetObjectAtPath(spec.path).documentation
            spec.documentation = inspect.cleandoc(documentation)
            spec.ClearInfo("customData")


def generate():
    """Returns the text of generatedSchema.usda."""
    source = Sdf.Layer.FindOrOpen(str(HERE / "schema.usda"))
    with tempfile.TemporaryDirectory() as folder:
        layer = run_generator(folder)
        add_documentation(layer, source)
        applied = [prim.name for prim in layer.rootPrims]
        layer.customLayerData = {"appliedAPISchemas": Vt.StringArray(applied)}
        return layer.ExportToString()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare only; exit 1 if the committed file is stale")
    arguments = parser.parse_args()
    text = generate()
    target = HERE / "generatedSchema.usda"
    if arguments.check:
        if target.read_text() != text:
            sys.exit(f"{target} is stale: run {pathlib.Path(__file__).name}")
        return
    target.write_text(text)


if __name__ == "__main__":
    main()
