"""The example scenes: valid USD, the same in old and new OpenUSD, and cages that stand for the surface they should."""

import pathlib
import sys

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdLux, UsdValidation

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import catmull_clark  # noqa: E402

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "usd_examples"
NAMES = ["marble_slab", "marble_tile", "wax_sphere", "hero", "bending_body", "still_life", "backlit_dish"]


@pytest.fixture(params=NAMES)
def stage(request):
    yield Usd.Stage.Open(str(EXAMPLES / f"{request.param}.usda"))


def of_type(stage, schema):
    return [schema(prim) for prim in stage.Traverse() if prim.IsA(schema)]


def shells(stage):
    found = [mesh for mesh in of_type(stage, UsdGeom.Mesh) if mesh.GetPrim().HasAPI("StfShellAPI")]
    assert found
    return found


def shell_of(name):
    stage = Usd.Stage.Open(str(EXAMPLES / f"{name}.usda"))
    (mesh,) = shells(stage)
    geometry = [
        np.array(attribute.Get())
        for attribute in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr(), mesh.GetPointsAttr())
    ]
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    return stage, mesh, geometry, np.array(st.ComputeFlattened()) if st else None


def test_stage_metadata(stage):
    assert UsdGeom.StageHasAuthoredMetersPerUnit(stage)
    assert UsdGeom.GetStageMetersPerUnit(stage) in (0.01, 0.001)
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert stage.GetDefaultPrim()
    assert len(of_type(stage, UsdGeom.Camera)) == 1


def test_compliance(stage):
    """What usdchecker checks."""
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    failures = [f"{error.GetName()}: {error.GetMessage()}" for error in context.Validate(stage)]
    # The volumes are made by the build and are not beside the sources.
    assert [text for text in failures if "volumes/" not in text] == []


def test_lights_read_the_same_in_every_openusd(stage):
    lights = [prim for prim in stage.Traverse() if prim.HasAPI(UsdLux.LightAPI)]
    assert {light.GetTypeName() for light in lights} == {"DistantLight", "DomeLight"}
    for light in lights:
        names = {a.GetName() for a in light.GetAuthoredAttributes()}
        new = {name[len("inputs:") :] for name in names if name.startswith("inputs:")}
        assert "intensity" in new
        assert {name for name in names if not name.startswith(("inputs:", "xformOp"))} == new
        for name in new:
            assert light.GetAttribute(name).Get() == light.GetAttribute("inputs:" + name).Get()


def test_shell_properties_are_known_and_allowed(stage):
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("StfShellAPI")
    for mesh in shells(stage):
        for attribute in mesh.GetPrim().GetAuthoredAttributes():
            name = attribute.GetName()
            if not name.startswith("primvars:stf:"):
                continue
            assert name in definition.GetPropertyNames()
            spec = definition.GetSchemaPropertySpec(name)
            assert attribute.GetTypeName() == spec.typeName
            # What does not know the schema must still see a constant primvar.
            assert attribute.HasAuthoredMetadata("interpolation")
            allowed = definition.GetPropertyMetadata(name, "allowedTokens")
            assert not allowed or attribute.Get() in allowed
        path = mesh.GetPrim().GetAttribute("primvars:stf:baseVolume").Get().path
        assert path.startswith("./volumes/")
        assert pathlib.Path(path).name in (EXAMPLES / "make_volumes.sh").read_text()


def test_meshes_are_sound(stage):
    for mesh in of_type(stage, UsdGeom.Mesh):
        points = mesh.GetPointsAttr().Get()
        valid, reason = UsdGeom.Mesh.ValidateTopology(
            mesh.GetFaceVertexIndicesAttr().Get(), mesh.GetFaceVertexCountsAttr().Get(), len(points)
        )
        assert valid, reason
        assert np.all(np.isfinite(points))
        low, high = mesh.GetExtentAttr().Get()
        assert np.allclose(low, np.min(points, 0), atol=1e-4) and np.allclose(high, np.max(points, 0), atol=1e-4)
        for primvar in UsdGeom.PrimvarsAPI(mesh).GetPrimvarsWithAuthoredValues():
            if primvar.GetInterpolation() == "faceVarying":
                assert len(primvar.ComputeFlattened()) == len(mesh.GetFaceVertexIndicesAttr().Get())


@pytest.mark.parametrize("name", [name for name in NAMES if name != "marble_tile"])  # that one is flat
def test_shell_meshes_are_closed_and_face_outward(name):
    _, _, (counts, indices, points), _ = shell_of(name)
    catmull_clark.subdivide(counts, indices, points)
    assert catmull_clark.volume(counts, indices, points) > 0


def test_slab_maps_one_tile_of_40_mm():
    _, _, (counts, indices, points), st = shell_of("marble_slab")
    for face in range(len(counts)):
        corners = slice(4 * face, 4 * face + 4)
        lengths = np.linalg.norm(np.diff(points[indices[corners]], axis=0), axis=1)
        assert np.allclose(np.linalg.norm(np.diff(st[corners], axis=0), axis=1) * 40, lengths)


def test_wax_sphere_is_a_sphere_of_25_mm():
    _, _, geometry, _ = shell_of("wax_sphere")
    for _ in range(3):
        geometry = catmull_clark.subdivide(*geometry)
    radii = np.linalg.norm(catmull_clark.limit(*geometry), axis=1)
    assert np.abs(radii / 2.5 - 1).max() < 2e-3


def test_wax_sphere_charts_match_along_edges():
    """On every edge of the cube both charts count the same quarters, forwards or backwards."""
    _stage, _, (_, indices, _), st = shell_of("wax_sphere")
    charts = np.repeat(np.arange(6), len(indices) // 6)
    per_vertex = {}
    for vertex, chart, uv in zip(indices, charts, st):
        per_vertex.setdefault(vertex, {})[chart] = uv
    seams = [list(uvs.values()) for uvs in per_vertex.values() if len(uvs) > 1]
    assert len(seams) == 8 + 12 * 3
    for uvs in seams:
        uvs = np.array(uvs)
        assert np.allclose(4 * uvs, np.round(4 * uvs))
        # Distances to the nearest border, in any order: equal up to the symmetries of a square.
        folded = np.sort(np.minimum(uvs, 1 - uvs), axis=1)
        assert np.allclose(folded[:, 0], 0) and np.allclose(folded, folded[0])


def test_hero_is_a_thin_vase_of_the_right_size():
    _stage, mesh, geometry, st = shell_of("hero")
    for _ in range(2):
        geometry = catmull_clark.subdivide(*geometry)
    limit = catmull_clark.limit(*geometry)
    height = np.ptp(limit[:, 1])
    assert 12 < height < 14
    assert abs(limit[:, 1].min()) < 0.05
    # Around mid-height there is an outside and an inside, a wall apart; the shell fits twice.
    band = limit[np.abs(limit[:, 1] - 9) < 0.3]
    radii = np.hypot(band[:, 0], band[:, 2])
    outside, inside = radii[radii > 3.1], radii[radii <= 3.1]
    assert len(outside) and len(inside)
    wall = outside.mean() - inside.mean()
    shell = mesh.GetPrim().GetAttribute("primvars:stf:thickness").Get()
    assert 2 * shell / 0.9 <= wall + 0.05 < 0.7
    assert st[:, 0].min() == 0 and st[:, 0].max() == 1


@pytest.mark.parametrize("script", ["make_hero", "make_wax_sphere", "make_still_life", "make_backlit_dish"])
def test_committed_scene_is_what_its_script_writes(script, monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    module = __import__(script)
    written = Sdf.Layer.CreateAnonymous(".usda")
    assert written.ImportFromString(module.scene())
    stored = Sdf.Layer.FindOrOpen(str(EXAMPLES / f"{script[len('make_'):]}.usda"))
    for path in (Sdf.Path(p) for p in ("/World/Vase", "/World/Sphere") if stored.GetPrimAtPath(p)):
        for name in ("points", "primvars:st"):
            ours, theirs = (
                np.array(layer.GetAttributeAtPath(path.AppendProperty(name)).default) for layer in (written, stored)
            )
            # Another version of numpy may round the last digit differently.
            assert np.allclose(ours, theirs, atol=2e-4)
    assert [p.name for p in written.rootPrims] == [p.name for p in stored.rootPrims]


if __name__ == "__main__":
    sys.exit(pytest.main([__file__, "-q", *sys.argv[1:]]))


def test_bending_body_rests_in_its_first_frame_and_keeps_its_length():
    stage, mesh, (_, _, points), _ = shell_of("bending_body")
    rest = np.array(mesh.GetPrim().GetAttribute("primvars:stf:rest").Get())
    first, last = int(stage.GetStartTimeCode()), int(stage.GetEndTimeCode())
    assert last - first + 1 == 24
    axis = np.argsort(rest[-2:, 1])  # the middles of base and tip
    base, tip = (len(rest) - 2 + i for i in axis)
    for frame in range(first, last + 1):
        posed = np.array(mesh.GetPointsAttr().Get(frame))
        low, high = mesh.GetExtentAttr().Get(frame)
        assert np.allclose(low, posed.min(0), atol=1e-4) and np.allclose(high, posed.max(0), atol=1e-4)
        if frame == first:
            assert np.allclose(posed, rest) and np.allclose(points, rest)
        # The chord of an arc that turns by twice the angle between chord and start has the rest's length.
        chord = posed[tip] - posed[base]
        half = np.arctan2(chord[0], chord[1])
        length = np.linalg.norm(chord) * (half / np.sin(half) if abs(half) > 1e-6 else 1)
        assert np.isclose(length, np.linalg.norm(rest[tip] - rest[base]), rtol=1e-3)
