"""A scene of the gallery: an object of a sample on a table, between soft boxes. Millimetres, y up."""

import numpy as np
import trimesh
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, Vt

VIEW = np.array((0.25, 0.30, 1.0))  # from the object to the camera
FIELD = 24.0  # degrees, vertical


def read_object(path, turn, height_mm):
    """The mesh, turned (degrees about x, then y, then z), standing on y = 0 with its middle over the origin."""
    mesh = trimesh.load(path, process=False)
    for degrees, axis in zip(turn, np.eye(3)):
        mesh.apply_transform(trimesh.transformations.rotation_matrix(np.radians(degrees), axis))
    low, high = mesh.bounds
    mesh.apply_translation(-np.array(((low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2)))
    mesh.apply_scale(height_mm / (high[1] - low[1]))
    return mesh


def _look_at(eye, target):
    return Gf.Matrix4d().SetLookAt(Gf.Vec3d(*map(float, eye)), Gf.Vec3d(*map(float, target)), Gf.Vec3d(0, 1, 0)).GetInverse()


def _light_input(light, name, kind, value):
    """In both spellings: OpenUSD before 21.02 reads `intensity`, later versions `inputs:intensity`."""
    for spelling in (name, f"inputs:{name}"):
        light.GetPrim().CreateAttribute(spelling, kind).Set(value)


def _add_object(stage, mesh, volume):
    shape = UsdGeom.Mesh.Define(stage, "/World/Object")
    shape.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(mesh.vertices.astype(np.float32)))
    shape.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(mesh.faces), 3, np.int32)))
    shape.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(mesh.faces.astype(np.int32).ravel()))
    shape.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.loop)
    shape.CreateExtentAttr([Gf.Vec3f(*map(float, row)) for row in mesh.bounds])
    if volume:
        shape.GetPrim().AddAppliedSchema("StfShellAPI")
        primvar = UsdGeom.PrimvarsAPI(shape).CreatePrimvar("stf:baseVolume", Sdf.ValueTypeNames.Asset)
        primvar.Set(Sdf.AssetPath(volume))


def _add_table(stage, radius):
    turn = np.linspace(0, 2 * np.pi, 97)[:-1]
    ring = np.stack([np.cos(turn), 0 * turn, -np.sin(turn)], axis=1) * radius
    table = UsdGeom.Mesh.Define(stage, "/World/Table")
    table.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.vstack([np.zeros((1, 3)), ring]).astype(np.float32)))
    near = np.arange(96)
    faces = np.stack([0 * near, near + 1, (near + 1) % 96 + 1], axis=1)
    table.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(96, 3, np.int32)))
    table.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.astype(np.int32).ravel()))
    table.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    table.CreateDisplayColorAttr([Gf.Vec3f(0.10, 0.095, 0.09)])


def write(path, mesh, volume, studio, light):
    """`volume`, `studio`: names of files beside the scene; without a volume the object is grey."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 0.001)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    _add_object(stage, mesh, volume)
    size = mesh.bounds[1] - mesh.bounds[0]
    reach = float(np.linalg.norm(size)) / 2
    _add_table(stage, 60 * reach)

    dome = UsdLux.DomeLight.Define(stage, "/World/Studio")
    _light_input(dome, "intensity", Sdf.ValueTypeNames.Float, float(light))
    _light_input(dome, "texture:file", Sdf.ValueTypeNames.Asset, Sdf.AssetPath(studio))
    _light_input(dome, "texture:format", Sdf.ValueTypeNames.Token, "latlong")

    target = np.array((0, 0.5 * size[1], 0))
    distance = 0.88 * reach / np.sin(np.radians(FIELD / 2))
    eye = target + VIEW / np.linalg.norm(VIEW) * distance
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTransformOp().Set(_look_at(eye, target))
    camera.CreateFocalLengthAttr(10 / np.tan(np.radians(FIELD / 2)))
    camera.CreateHorizontalApertureAttr(20.0)
    camera.CreateVerticalApertureAttr(20.0)
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.1 * reach, 1000 * reach))
    stage.Export(str(path))
