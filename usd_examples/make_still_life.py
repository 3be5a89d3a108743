#!/usr/bin/env python3
"""Writes still_life.usda and textures/tiles.png: a slab of marble among other surfaces, to see them light each other.

A glossy floor with a texture, a ball of brushed metal, a red and a clear-coated ball, a fence with a cut-out texture
and a panel that shines. Units are millimetres.
"""

import pathlib
import sys

import numpy as np

import usda_text as usda
from make_wax_sphere import sphere

FLOOR = 400  # mm, half its width


def material(name, inputs, textures=""):
    lines = "\n            ".join(inputs)
    return f"""
    def Material "{name}Look"
    {{
        token outputs:surface.connect = </World/{name}Look/Surface.outputs:surface>

        def Shader "Surface"
        {{
            uniform token info:id = "UsdPreviewSurface"
            {lines}
            token outputs:surface
        }}
{textures}    }}
"""


def texture(material_name, name, file, wrap, outputs, transform=False):
    """A UsdUVTexture that reads `st`, through a UsdTransform2d where `transform` names its scale."""
    source = "Scaled.outputs:result" if transform else "Reader.outputs:result"
    scaled = f"""
        def Shader "Scaled"
        {{
            uniform token info:id = "UsdTransform2d"
            float2 inputs:in.connect = </World/{material_name}Look/Reader.outputs:result>
            float2 inputs:scale = {transform}
            float2 outputs:result
        }}
""" if transform else ""
    result = "\n            ".join(outputs)
    return f"""
        def Shader "Reader"
        {{
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }}
{scaled}
        def Shader "{name}"
        {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./textures/{file}@
            token inputs:wrapS = "{wrap}"
            token inputs:wrapT = "{wrap}"
            float2 inputs:st.connect = </World/{material_name}Look/{source}>
            {result}
        }}
"""


def ball(name, radius, position, material_name, color="(0.5, 0.5, 0.5)"):
    quads, points, _, _ = sphere(radius)
    return f"""
    def Mesh "{name}" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {{
        float3[] extent = {usda.numbers([points.min(0), points.max(0)])}
        int[] faceVertexCounts = {usda.numbers(np.full(len(quads), 4))}
        int[] faceVertexIndices = {usda.numbers(quads.ravel())}
        point3f[] points = {usda.numbers(points, 6)}
        color3f[] primvars:displayColor = [{color}]
        rel material:binding = </World/{material_name}Look>
        uniform token subdivisionScheme = "catmullClark"
        double3 xformOp:translate = {position}
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
"""


def quad(name, points, material_name, uvs="[(0, 0), (1, 0), (1, 1), (0, 1)]"):
    points = np.array(points, float)
    return f"""
    def Mesh "{name}" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {{
        float3[] extent = {usda.numbers([points.min(0), points.max(0)])}
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = {usda.numbers(points)}
        texCoord2f[] primvars:st = {uvs} (
            interpolation = "vertex"
        )
        rel material:binding = </World/{material_name}Look>
        uniform token subdivisionScheme = "none"
    }}
"""


def slab():
    """The slab of marble_slab.usda, smaller."""
    return """
    def "Slab" (
        prepend references = @./marble_slab.usda@</World/Slab>
    )
    {
        double3 xformOp:translate = (0, 0, 0)
        float3 xformOp:rotateXYZ = (0, 25, 0)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
    }
"""


def scene():
    tiles = texture("Floor", "Tiles", "tiles.png", "repeat", ["float3 outputs:rgb", "float outputs:a"], "(10, 10)")
    fence = texture("Fence", "Holes", "tiles.png", "repeat", ["float3 outputs:rgb", "float outputs:a"], "(2, 1)")
    f = FLOOR
    return f"""#usda 1.0
(
    doc = "A slab of marble among other surfaces. Written by make_still_life.py. Millimetres."
    defaultPrim = "World"
    metersPerUnit = 0.001
    upAxis = "Y"
)

def Xform "World"
{{
{slab()}{quad("Ground", [(-f, 0, f), (f, 0, f), (f, 0, -f), (-f, 0, -f)], "Floor")}{
    ball("Metal", 14, (-40, 14, -6), "Metal")}{ball("Red", 10, (36, 10, 14), "Red")}{
    ball("Coated", 9, (2, 9, 36), "Coated")}{
    quad("Fence", [(-46, 0, -40), (44, 0, -40), (44, 45, -40), (-46, 45, -40)], "Fence")}{
    quad("Panel", [(50, 2, 10), (60, 2, -40), (60, 42, -40), (50, 42, 10)], "Panel")}{
    material("Floor", ["color3f inputs:diffuseColor.connect = </World/FloorLook/Tiles.outputs:rgb>",
                       "float inputs:roughness = 0.15"], tiles)}{
    material("Metal", ["color3f inputs:diffuseColor = (0.95, 0.8, 0.55)", "float inputs:metallic = 1",
                       "float inputs:roughness = 0.25"])}{
    material("Red", ["color3f inputs:diffuseColor = (0.7, 0.04, 0.03)", "float inputs:roughness = 0.6"])}{
    material("Coated", ["color3f inputs:diffuseColor = (0.05, 0.2, 0.5)", "float inputs:clearcoat = 1",
                        "float inputs:roughness = 0.5"])}{
    material("Fence", ["color3f inputs:diffuseColor = (0.4, 0.5, 0.3)",
                       "float inputs:opacity.connect = </World/FenceLook/Holes.outputs:a>",
                       "float inputs:opacityThreshold = 0.5"], fence)}{
    material("Panel", ["color3f inputs:diffuseColor = (0, 0, 0)", "color3f inputs:emissiveColor = (0.6, 2.2, 1.2)"])}{
    usda.distant_light("Key", (-0.7, 0.9, 0.5), 2.2, "(1, 0.95, 0.88)", 3)}{
    usda.dome_light("Sky", 0.25, "(0.85, 0.92, 1)")}{
    usda.camera((30, 120, 215), (0, 10, 0), 45, (24, 16), "(10, 10000)")}}}
"""


def tiles(size=256):
    """Grey and blue tiles with a light joint; the alpha is 1 but for a round hole in each."""
    from PIL import Image

    y, x = np.mgrid[0:size, 0:size] + 0.5
    half = size // 2
    dark = (x < half) == (y < half)
    rgb = np.where(dark[..., None], (70, 80, 110), (190, 185, 175))
    joint = (np.minimum(x % half, half - x % half) < 4) | (np.minimum(y % half, half - y % half) < 4)
    rgb = np.where(joint[..., None], (225, 225, 220), rgb)
    hole = np.hypot(x % half - half / 2, y % half - half / 2) < 0.36 * half
    return Image.fromarray(np.dstack([rgb, np.where(hole, 0, 255)]).astype(np.uint8), "RGBA")


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).with_name("still_life.usda")
    target.write_text(scene())
    (target.parent / "textures").mkdir(exist_ok=True)
    tiles().save(target.parent / "textures" / "tiles.png", optimize=True)
