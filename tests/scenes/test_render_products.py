"""stfrecord renders the products of a RenderSettings prim: files, sizes, windows, layers, types, settings, messages.

STFRECORD names the program. Images are read back with OpenEXR and numpy.
"""

import json
import os
import subprocess

import numpy as np
import OpenEXR
import pytest

STFRECORD = os.environ["STFRECORD"]

SCENE = """#usda 1.0
(
    metersPerUnit = 0.01
    {metadata}
)
def Camera "Camera"
{{
    float horizontalAperture = 24
    float verticalAperture = 18
    float focalLength = 35
    double3 xformOp:translate = (0, 0, 6)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def DomeLight "Dome"
{{
    float intensity = 1
    float inputs:intensity = 1
}}
def Cube "Block"
{{
    double size = 1.2
}}
def "Render"
{{
    def RenderSettings "Settings"
    {{
        rel camera = </Camera>
        int2 resolution = (64, 48)
        rel products = [{products}]
        uniform int stf:samples = 8
        {settings}
    }}
    {prims}
    def RenderVar "Color"
    {{
        token dataType = "color4f"
        string sourceName = "color"
    }}
    def RenderVar "Half"
    {{
        token dataType = "color3h"
        string sourceName = "color"
    }}
    def RenderVar "Ids"
    {{
        token dataType = "int"
        string sourceName = "primId"
    }}
    def RenderVar "Alpha"
    {{
        token dataType = "half"
        string sourceName = "alpha"
    }}
    def RenderVar "Crypto"
    {{
        token dataType = "color4f"
        string sourceName = "cryptoObject"
        string driver:parameters:aov:name = "objects"
    }}
    def RenderVar "Lpe"
    {{
        token sourceType = "lpe"
        string sourceName = "C.*"
    }}
    def RenderVar "Unknown"
    {{
        string sourceName = "nothing"
    }}
}}
"""
METADATA = 'renderSettingsPrimPath = "/Render/Settings"'


def product(name, variables, more=""):
    paths = ", ".join(f"</Render/{v}>" for v in variables)
    return f"""
    def RenderProduct "{name}"
    {{
        token productName = "{name}.exr"
        rel orderedVars = [{paths}]
        {more}
    }}"""


@pytest.fixture
def record(tmp_path):
    def run(prims, *arguments, metadata=METADATA, settings="", names=("One",)):
        products = ", ".join(f"</Render/{n}>" for n in names)
        scene = SCENE.format(metadata=metadata, products=products, prims=prims, settings=settings)
        (tmp_path / "scene.usda").write_text(scene)
        command = [STFRECORD, "scene.usda", *arguments]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)

    return run


def header(path):
    return OpenEXR.InputFile(str(path)).header()


def channel(path, name, kind=np.float32):
    file = OpenEXR.InputFile(str(path))
    box = file.header()["dataWindow"]
    shape = (box.max.y - box.min.y + 1, box.max.x - box.min.x + 1)
    return np.frombuffer(file.channel(name), kind).reshape(shape)


def test_layers_and_their_types(record, tmp_path):
    done = record(product("One", ["Color", "Half", "Ids", "Alpha", "Crypto"]))
    assert done.returncode == 0, done.stderr
    image = tmp_path / "One.exr"
    kinds = {name: str(c.type) for name, c in header(image)["channels"].items()}
    crypto = {f"objects{i:02d}.{c}": "FLOAT" for i in range(3) for c in "RGBA"}
    assert kinds == {
        **dict.fromkeys("RGBA", "FLOAT"),
        **dict.fromkeys(["Half.R", "Half.G", "Half.B", "alpha.A"], "HALF"),
        "primId.id": "UINT",
        **crypto,
    }
    red, half = channel(image, "R"), channel(image, "Half.R", np.float16)
    assert red.shape == (48, 64)
    assert 0.3 < red[24, 32] < 1
    np.testing.assert_allclose(half, red, rtol=2**-10)
    # The dome covers what the block does not.
    ids = channel(image, "primId.id", np.uint32)
    assert ids[24, 32] != 0xFFFFFFFF and ids[0, 0] == 0xFFFFFFFF
    entries = {k: v.decode() for k, v in header(image).items() if k.startswith("cryptomatte/")}
    (name,) = [k for k, v in entries.items() if k.endswith("/name") and v == "objects"]
    manifest = json.loads(entries[name.replace("/name", "/manifest")])
    ranked = channel(image, "objects00.R", np.uint32)
    assert f"{ranked[24, 32]:08x}" == manifest["/Block"]
    assert channel(image, "objects00.G")[24, 32] == 1
    assert channel(image, "objects00.G")[0, 0] == 0


def test_metadata_says_how_it_was_made(record, tmp_path):
    record(product("One", ["Color"]))
    head = {k: v.decode() for k, v in header(tmp_path / "One.exr").items() if isinstance(v, bytes)}
    assert "stf:samples=8" in head["renderSettings"]
    assert head["samplesPerPixel"] == "8"
    assert any(entry["stage"] == "lights" for entry in json.loads(head["renderPlan"]))
    assert json.loads(head["renderTimes"])["total"] > 0
    assert 0 < float(head["estimatedError"]) < 1
    assert head["hdStfVersion"] and head["openusdVersion"]
    assert head["renderProduct"] == "One"


def test_each_product_has_its_frame_and_settings(record, tmp_path):
    more = """
        int2 resolution = (32, 48)
        float pixelAspectRatio = 2
        float4 dataWindowNDC = (0.25, 0, 1, 0.5)
        uniform int stf:samples = 3"""
    done = record(
        product("One", ["Color"]) + product("Two", ["Color"], more) + product("Three", ["Color"]),
        names=("One", "Two", "Three"),
    )
    assert done.returncode == 0, done.stderr
    head = header(tmp_path / "Two.exr")
    assert head["pixelAspectRatio"] == 2
    assert (head["displayWindow"].max.x, head["displayWindow"].max.y) == (31, 47)
    box = head["dataWindow"]
    assert (box.min.x, box.min.y, box.max.x, box.max.y) == (8, 24, 31, 47)
    assert b"stf:samples=3" in head["renderSettings"]
    assert b"stf:samples=8" in header(tmp_path / "Three.exr")["renderSettings"]
    # Pixels twice as wide show what two of the first do.
    one, two = channel(tmp_path / "One.exr", "A"), channel(tmp_path / "Two.exr", "A")
    assert one.shape == (48, 64) and two.shape == (24, 24)
    wide = channel(tmp_path / "One.exr", "R").reshape(48, 32, 2).mean(2)[24:, 8:]
    assert np.abs(channel(tmp_path / "Two.exr", "R") - wide).mean() < 0.05


@pytest.mark.parametrize(
    "policy, inside",
    [("expandAperture", True), ("cropAperture", False), ("adjustApertureHeight", False), ("adjustApertureWidth", True)],
)
def test_aperture_conforms(record, tmp_path, policy, inside):
    # A frame wider than the aperture: more is seen at the sides, or less above and below.
    more = f'int2 resolution = (96, 48)\n token aspectRatioConformPolicy = "{policy}"'
    record(product("One", ["Ids"], more))
    hit = channel(tmp_path / "One.exr", "primId.id", np.uint32) != 0xFFFFFFFF
    height = hit.any(1).sum()
    # The block's front, at distance 5.4; the aperture is 18 or 12 high, the focal length is 35.
    seen = 48 * (1.2 / 5.4) * 35 / (18 if inside else 12)
    assert abs(height - seen) <= 1, (height, seen)


def test_what_cannot_be_done_is_said_once(record, tmp_path):
    done = record(
        product("One", ["Color", "Lpe", "Unknown"])
        + product("Deep", ["Color"], 'token productType = "deepRaster"')
        + product("Void", ["Lpe"]),
        names=("One", "Deep", "Void", "Missing"),
        settings='uniform token[] materialBindingPurposes = ["preview"]\n uniform int stf:nonsense = 1',
    )
    assert done.returncode == 1
    for text in (
        "render var /Render/Lpe: sources of type lpe are not rendered",
        'the renderer has no AOV "nothing"',
        "/Render/Deep: products of type deepRaster are not rendered",
        "/Render/Void: it has no render var that can be rendered",
        "/Render/Missing is no RenderProduct",
        "materialBindingPurposes are not read",
        "the renderer has no setting stf:nonsense",
    ):
        assert done.stderr.count(text) == 1, (text, done.stderr)
    assert sorted(p.name for p in tmp_path.glob("*.exr")) == ["One.exr"]


def test_which_settings_are_taken(record, tmp_path):
    one = product("One", ["Color"])
    assert record(one, "--settings", "/Render/Settings", metadata="").returncode == 0
    assert (tmp_path / "One.exr").exists()
    none = record(one, "--settings", "/Render/None")
    assert none.returncode == 64 and "no RenderSettings prim /Render/None" in none.stderr
    assert record(one, metadata="").returncode == 64  # the image has no name
    assert record(one, "--settings", "/Render/Settings", "--imageWidth", "7").returncode == 64
    # What describes an image by itself goes before the stage's settings.
    assert record(one, "own.exr", "--imageWidth", "20", "--samples", "1").returncode == 0
    assert channel(tmp_path / "own.exr", "R").shape[1] == 20
    assert record(one, "named.exr", "--samples", "2").returncode == 0
    assert channel(tmp_path / "named.exr", "R").shape == (48, 64)
    assert b"stf:samples=2" in header(tmp_path / "named.exr")["renderSettings"]
