"""StfShellAPI as an installed usd-core sees it: registration, fallbacks, inheritance, round trip.

PXR_PLUGINPATH_NAME names the folder `plugin` of the build; without it the schema is read from the source tree.
"""

import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
os.environ.setdefault("PXR_PLUGINPATH_NAME", str(ROOT / "schemas"))

import pytest  # noqa: E402
from pxr import Gf, Plug, Sdf, Tf, Usd, UsdGeom, Vt  # noqa: E402

NAME = "StfShellAPI"

# property: type, fallback, interpolation, allowed tokens. The delegate holds the same fallbacks.
PROPERTIES = {
    "baseVolume": ("asset", None, "constant", None),
    "thickness": ("float", 0.0, "constant", None),
    "scale": ("float", 1.0, "constant", None),
    "mapping": ("token", "auto", "constant", ["auto", "uv", "synthesize", "blend"]),
    "coreMaterial": ("token", None, "constant", None),
    "coreSigmaA": ("color3f", None, "constant", None),
    "coreSigmaSPrime": ("color3f", None, "constant", None),
    "coreModel": ("token", "auto", "constant", ["auto", "dipole", "walk", "none"]),
    "rest": ("point3f[]", None, "vertex", None),
    "transport": ("token", "dE1", "constant", ["dE1", "classic"]),
    "quality": ("float", pytest.approx(0.02), "constant", None),
    "seed": ("int", 0, "constant", None),
    "orientation": ("vector3f[]", None, "vertex", None),
}

AUTHORED = {
    "baseVolume": Sdf.AssetPath("./volumes/marble.vdb"),
    "thickness": 0.25,
    "scale": 2.0,
    "mapping": "uv",
    "coreMaterial": "Marble",
    "coreSigmaA": Gf.Vec3f(0.25, 0.5, 0.75),
    "coreSigmaSPrime": Gf.Vec3f(1, 2, 3),
    "coreModel": "dipole",
    "rest": Vt.Vec3fArray([(0, 0, 0), (1, 0, 0), (0, 1, 0)]),
    "transport": "classic",
    "quality": 0.5,
    "seed": 7,
    "orientation": Vt.Vec3fArray([(1, 0, 0)] * 3),
}


@pytest.fixture
def mesh():
    """A mesh with the schema applied, on a stage of its own, which lives as long as the test."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/Parent")
    mesh = UsdGeom.Mesh.Define(stage, "/Parent/Mesh")
    mesh.GetPrim().ApplyAPI(NAME)
    yield mesh


def test_plugin_comes_from_the_search_path():
    plugin = Plug.Registry().GetPluginWithName("stfSchemas")
    assert plugin
    assert plugin.isResource
    root = pathlib.Path(os.environ["PXR_PLUGINPATH_NAME"]).resolve()
    assert root in pathlib.Path(plugin.path, "x").resolve().parents


def test_registry_knows_it():
    registry = Usd.SchemaRegistry()
    schema_type = Tf.Type.FindByName("UsdStfShellAPI")
    assert schema_type.IsA(Tf.Type(Usd.APISchemaBase))
    assert registry.IsAppliedAPISchema(schema_type)
    assert not registry.IsMultipleApplyAPISchema(schema_type)
    assert registry.GetSchemaTypeName(schema_type) == NAME
    definition = registry.FindAppliedAPIPrimDefinition(NAME)
    assert sorted(definition.GetPropertyNames()) == sorted("primvars:stf:" + name for name in PROPERTIES)


def test_can_be_applied_and_removed(mesh):
    prim = mesh.GetPrim()
    assert prim.HasAPI(NAME)
    assert prim.GetAppliedSchemas() == [NAME]
    prim.RemoveAPI(NAME)
    assert not prim.GetAttribute("primvars:stf:scale").IsValid()


@pytest.mark.parametrize("name", PROPERTIES)
def test_fallbacks(mesh, name):
    type_name, fallback, interpolation, tokens = PROPERTIES[name]
    attribute = mesh.GetPrim().GetAttribute("primvars:stf:" + name)
    assert attribute.IsDefined() and not attribute.IsAuthored() and not attribute.IsCustom()
    assert str(attribute.GetTypeName()) == type_name
    assert attribute.Get() == fallback
    assert UsdGeom.Primvar(attribute).GetInterpolation() == interpolation
    allowed = attribute.GetMetadata("allowedTokens")
    assert (list(allowed) if allowed else None) == tokens
    assert attribute.GetDisplayGroup() and attribute.GetDisplayName()
    assert attribute.GetDocumentation()


@pytest.mark.parametrize("name", PROPERTIES)
def test_authored_values_round_trip(mesh, name, tmp_path):
    prim = mesh.GetPrim()
    prim.GetAttribute("primvars:stf:" + name).Set(AUTHORED[name])
    for suffix in (".usda", ".usdc"):
        path = str(tmp_path / ("scene" + suffix))
        prim.GetStage().Export(path)
        stage = Usd.Stage.Open(path)
        read = stage.GetPrimAtPath("/Parent/Mesh")
        assert read.HasAPI(NAME)
        value = read.GetAttribute("primvars:stf:" + name).Get()
        if isinstance(value, Sdf.AssetPath):
            value, expected = value.path, AUTHORED[name].path
        else:
            expected = AUTHORED[name]
        assert value == expected


def test_constant_properties_inherit(mesh):
    stage = mesh.GetPrim().GetStage()
    parent = stage.GetPrimAtPath("/Parent")
    parent.ApplyAPI(NAME)
    parent.GetAttribute("primvars:stf:scale").Set(3.0)
    primvar = UsdGeom.PrimvarsAPI(mesh).FindPrimvarWithInheritance("stf:scale")
    assert primvar.GetAttr().GetPath() == "/Parent.primvars:stf:scale"
    assert primvar.Get() == 3.0
    mesh.GetPrim().GetAttribute("primvars:stf:scale").Set(2.0)
    assert UsdGeom.PrimvarsAPI(mesh).FindPrimvarWithInheritance("stf:scale").Get() == 2.0


def test_generated_file_agrees_with_its_source():
    source_layer = Sdf.Layer.FindOrOpen(str(ROOT / "schemas" / "schema.usda"))
    source = source_layer.GetPrimAtPath("/" + NAME)
    layer = Sdf.Layer.FindOrOpen(str(ROOT / "schemas" / "generatedSchema.usda"))
    generated = layer.GetPrimAtPath("/" + NAME)
    assert list(layer.customLayerData["appliedAPISchemas"]) == [NAME]
    assert set(generated.properties.keys()) == set(source.properties.keys())
    for attribute in source.properties:
        twin = generated.properties[attribute.name]
        assert twin.typeName == attribute.typeName
        assert twin.default == attribute.default
        for key in ("interpolation", "allowedTokens", "displayGroup", "displayName"):
            assert twin.GetInfo(key) == attribute.GetInfo(key)
        assert twin.documentation.split() == attribute.documentation.split()


def test_generated_file_is_what_the_generator_writes():
    pytest.importorskip("jinja2")
    subprocess.run([sys.executable, str(ROOT / "schemas" / "generate.py"), "--check"], check=True)


def test_documentation_lists_every_property():
    text = (ROOT / "docs" / "schema.md").read_text()
    for name in PROPERTIES:
        assert f"`primvars:stf:{name}`" in text


if __name__ == "__main__":
    sys.exit(pytest.main([__file__, "-q", *sys.argv[1:]]))


def test_the_shader_node_has_the_inputs_of_the_api():
    from pxr import Sdr

    result = {**vars(Sdr)}.get("NodeDiscoveryResult") or getattr(Sdr, "ShaderNodeDiscoveryResult", None)
    registry = Sdr.Registry()
    path = str(ROOT / "schemas" / "StfShell.usda")
    version = Sdr.Version().GetAsDefault()
    registry.AddDiscoveryResult(result("StfShell", version, "StfShell", "StfShell", "usda", "stf", path, path))
    node = registry.GetShaderNodeByIdentifier("StfShell")
    assert node and node.IsValid()
    constant = {name for name, (_, _, interpolation, _) in PROPERTIES.items() if interpolation == "constant"}
    assert set(node.GetShaderInputNames()) == constant
    assert node.GetShaderOutputNames() == ["surface"]
    for name in constant:
        kind, fallback, _, tokens = PROPERTIES[name]
        property_ = node.GetShaderInput(name)
        sdf_type = property_.GetTypeAsSdfType()
        assert (sdf_type.GetSdfType() if hasattr(sdf_type, "GetSdfType") else sdf_type[0]) in (
            Sdf.ValueTypeNames.Find(kind),
            Sdf.ValueTypeNames.Find({"token": "string"}.get(kind, kind)),
        ), name
        if fallback is not None:
            assert property_.GetDefaultValue() == fallback, name
        if tokens:
            assert [option[0] for option in property_.GetOptions()] == tokens
