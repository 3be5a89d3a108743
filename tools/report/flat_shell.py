"""Scenes that Mitsuba 3 can show too: one flat shell of index 1 over nothing, under distant lights and an even dome.

They are told in the tile's own millimetres: x along u, y along v, z outward from the surface."""

import numpy as np
from pxr import Gf, Usd, UsdGeom

MARGIN = 6  # thicknesses between what the camera sees and the rim, which Mitsuba's endless tile has not
MOST_ANGLE = 1.0  # degrees of a distant light that counts as parallel


class NotComparable(Exception):
    """A scene that Mitsuba cannot be given; the text says why."""


def need(condition, why):
    if not condition:
        raise NotComparable(why)


def light_value(light, name, default):
    """A light's attribute in the spelling of any OpenUSD."""
    for spelling in (f"inputs:{name}", name):
        attribute = light.GetAttribute(spelling)
        if attribute and attribute.HasAuthoredValue():
            return attribute.Get()
    return default


class Tile:
    """Where the tile of a flat mesh lies: from world space to tile millimetres."""

    def __init__(self, prim, mm_per_unit):
        mesh = UsdGeom.Mesh(prim)
        points = np.array(mesh.GetPointsAttr().Get(), float)
        to_world = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
        points = points @ to_world[:3, :3] + to_world[3, :3]
        st = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
        need(st and st.GetInterpolation() in ("vertex", "varying") and len(st.ComputeFlattened()) == len(points),
             "the shell has no texture coordinates for each point")
        uv = np.array(st.ComputeFlattened(), float)
        rows = np.column_stack([uv, np.ones(len(uv))])
        fit, _, rank, _ = np.linalg.lstsq(rows, points, rcond=None)
        size = np.ptp(points, axis=0).max()
        need(rank == 3 and np.abs(rows @ fit - points).max() < 1e-5 * size,
             "the shell is not flat with texture coordinates that go evenly along it")
        u, v = (np.linalg.norm(fit[i]) for i in (0, 1))
        self.axes = np.stack([fit[0] / u, fit[1] / v, np.cross(fit[0] / u, fit[1] / v)])
        need(np.allclose(self.axes @ self.axes.T, np.eye(3), atol=1e-5), "u and v are not at right angles")
        first = np.array(mesh.GetFaceVertexIndicesAttr().Get())[:3]
        edges = points[first[1]] - points[first[0]], points[first[2]] - points[first[0]]
        outward = np.cross(*edges) * (-1 if mesh.GetOrientationAttr().Get() == "leftHanded" else 1)
        outward *= np.sign(np.linalg.det(to_world[:3, :3]))
        need(outward @ self.axes[2] > 0, "texture coordinates are mirrored")
        self.origin, self.mm_per_unit = fit[2], mm_per_unit
        local = self.point(points)
        self.low, self.high = local.min(axis=0)[:2], local.max(axis=0)[:2]
        need(np.isclose(np.prod(self.high - self.low), _area(local, mesh), rtol=1e-4),
             "the shell is not a rectangle along its texture coordinates")

    def point(self, p):
        return (np.asarray(p) - self.origin) @ self.axes.T * self.mm_per_unit

    def direction(self, d):
        return np.asarray(d) @ self.axes.T


def _area(points, mesh):
    """Of all faces, by fans."""
    counts, indices = np.array(mesh.GetFaceVertexCountsAttr().Get()), np.array(mesh.GetFaceVertexIndicesAttr().Get())
    area, first = 0.0, 0
    for n in counts:
        p = points[indices[first:first + n]]
        area += 0.5 * np.linalg.norm(np.cross(p[1:-1] - p[0], p[2:] - p[0]).sum(axis=0))
        first += n
    return area


def _lights(stage, tile):
    told = []
    for prim in stage.Traverse():
        kind = prim.GetTypeName()
        if not kind.endswith("Light"):
            continue
        color = np.array(light_value(prim, "color", (1, 1, 1)), float)
        color *= light_value(prim, "intensity", 1.0) * 2.0**light_value(prim, "exposure", 0.0)
        if kind == "DistantLight":
            angle = light_value(prim, "angle", 0.53)
            need(angle <= MOST_ANGLE, f"{prim.GetPath()} is wider than {MOST_ANGLE:g} degree")
            if not light_value(prim, "normalize", False) and angle > 0:
                color *= np.pi * np.sin(np.radians(angle / 2))**2
            matrix = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
            shines = tile.direction(matrix.TransformDir(Gf.Vec3d(0, 0, -1)).GetNormalized())
            need(shines[2] < 0, f"{prim.GetPath()} shines from below")
            told.append({"type": "directional", "direction": list(shines), "irradiance": list(color)})
        else:
            need(kind == "DomeLight" and not light_value(prim, "texture:file", None),
                 f"{prim.GetPath()} is no distant light and no even dome")
            told.append({"type": "constant", "radiance": list(color)})
    need(told, "the scene has no light")
    return told


def _camera(stage, name, tile, depth, size):
    cameras = [p for p in stage.Traverse() if p.IsA(UsdGeom.Camera) and name in (None, p.GetName(), str(p.GetPath()))]
    need(cameras, "the scene has no such camera")
    camera = UsdGeom.Camera(cameras[0]).GetCamera(Usd.TimeCode.Default())
    need(camera.horizontalApertureOffset == 0 == camera.verticalApertureOffset, "the camera's film is off its middle")
    need(camera.fStop == 0 or camera.focusDistance == 0, "the camera has a lens")
    need(camera.projection == Gf.Camera.Perspective, "the camera is not a perspective one")
    matrix = camera.transform
    origin = tile.point(matrix.ExtractTranslation())
    forward, right, up = (tile.direction(matrix.TransformDir(Gf.Vec3d(*d)).GetNormalized())
                          for d in ((0, 0, -1), (1, 0, 0), (0, 1, 0)))
    half = 0.5 * camera.horizontalAperture / camera.focalLength
    for x in (-half, half):
        for y in (-half * size[1] / size[0], half * size[1] / size[0]):
            ray = forward + x * right + y * up
            need(origin[2] > 0 > ray[2], "the camera sees more than the shell")
            at = (origin - ray * origin[2] / ray[2])[:2]
            need(np.all(at > tile.low + MARGIN * depth) and np.all(at < tile.high - MARGIN * depth),
                 f"the camera sees the shell nearer to its rim than {MARGIN} thicknesses")
    return {"origin": list(origin), "target": list(origin + forward), "up": list(up), "width": size[0],
            "height": size[1], "fov": float(np.degrees(2 * np.arctan(half)))}


def describe(shells, volume, camera, size):
    """The scene for mitsuba_image.py as JSON would have it, without the tile; NotComparable where it cannot be told.
    `volume`: what `stf inspect --raw` said of the base volume; `size`: pixels of the image."""
    stage = shells.stage
    need(len(shells.shells) == 1, "it has not one shell alone")
    meshes = [p for p in stage.Traverse() if p.IsA(UsdGeom.Gprim)]
    need(meshes == shells.shells, "there are other surfaces than the shell")
    need(shells.values("coreModel") == ["none"], "there is a core below the shell")
    need("surface" not in volume["grids"] and "emission" not in volume["grids"], "the sample has relief or shines")
    shell = shells.shells[0]
    for name in ("thickness", "scale"):
        value = shells.primvar(shell, name)
        need(value in (None, {"thickness": 0, "scale": 1}[name]), f"stf:{name} is set")
    need(shells.primvar(shell, "mapping") == "uv", "stf:mapping is not uv")
    tile = Tile(shell, 1000 * UsdGeom.GetStageMetersPerUnit(stage))
    depth = volume["size"][2] * volume["voxelMm"][2]
    return {"lights": _lights(stage, tile), "camera": _camera(stage, camera, tile, depth, size)}
