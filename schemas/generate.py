#!/usr/bin/env python3
"""Writes generatedSchema.usda from schema.usda with usdGenSchema (Python packages: usd-core, jinja2), and StfShell.usda,
the definition of a surface node with the same inputs.

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

from pxr import Sdf, Usd, UsdShade, Vt

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


def shader():
    """Returns the text of StfShell.usda: the constant properties of StfShellAPI as inputs of a shader."""
    layer = Sdf.Layer.FindOrOpen(str(HERE / "schema.usda"))
    source = layer.GetPrimAtPath("/StfShellAPI")
    stage = Usd.Stage.CreateInMemory()
    node = UsdShade.Shader.Define(stage, "/StfShell")
    node.GetPrim().SetDocumentation(
        "A heterogeneous translucent shell with surface relief, as the surface of a material: what StfShellAPI says on "
        "a mesh. Properties of the API on the mesh go before these inputs."
    )
    node.CreateIdAttr("StfShell")
    node.CreateImplementationSourceAttr(UsdShade.Tokens.sourceAsset)
    # There is no code to point to: the renderer knows the node.
    asset = node.GetPrim().CreateAttribute("info:stf:sourceAsset", Sdf.ValueTypeNames.Asset, custom=False)
    asset.SetVariability(Sdf.VariabilityUniform)
    asset.Set(Sdf.AssetPath("./StfShell.usda"))
    output = node.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    output.SetSdrMetadataByKey("renderType", "terminal surface")
    for spec in source.properties:
        if spec.GetInfo("interpolation") != "constant":
            continue  # it belongs to points, of which a material has none
        value = node.CreateInput(spec.name.split(":")[-1], spec.typeName)
        value.SetConnectability(UsdShade.Tokens.interfaceOnly)
        attribute = value.GetAttr()
        if spec.default is not None:
            attribute.Set(spec.default)
        attribute.SetDocumentation(inspect.cleandoc(spec.documentation))
        attribute.SetDisplayGroup(spec.displayGroup)
        value.SetSdrMetadataByKey("label", spec.displayName)
        value.SetSdrMetadataByKey("page", spec.displayGroup)
        if spec.allowedTokens:
            value.SetSdrMetadataByKey("options", "|".join(spec.allowedTokens))
    return stage.GetRootLayer().ExportToString()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare only; exit 1 if the committed file is stale")
    arguments = parser.parse_args()
    for name, text in (("generatedSchema.usda", generate()), ("StfShell.usda", shader())):
        target = HERE / name
        if not arguments.check:
            target.write_text(text)
        elif target.read_text() != text:
            sys.exit(f"{target} is stale: run {pathlib.Path(__file__).name}")


if __name__ == "__main__":
    main()
