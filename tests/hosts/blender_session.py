"""Inside Blender's Python (module bpy): a marble ball is rendered by Stf through the add-on hdstf_blender.

    blender_session.py SETTINGS.json

SETTINGS has addon (its folder's parent), volume, output, size and samples. Writes pictures and session.json into output.
"""

import json
import pathlib
import sys

import bpy

SETTINGS = json.loads(pathlib.Path(sys.argv[-1]).read_text())
OUTPUT = pathlib.Path(SETTINGS["output"])
sys.path.insert(0, SETTINGS["addon"])
import hdstf_blender  # noqa: E402  (the add-on's folder has to be known first)
from hdstf_blender import engine, plugin, shell  # noqa: E402


def make_scene():
    """A ball of 60 mm on a table, a lamp, a camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.05, 0.05, 0.05)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.03, location=(0, 0, 0.03))
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    bpy.ops.mesh.primitive_plane_add(size=1)
    bpy.ops.object.light_add(type="SUN", rotation=(0.7, 0.4, 0.3))
    bpy.context.object.data.energy = 3
    bpy.context.object.data.angle = 0.05
    bpy.ops.object.camera_add(location=(0.0, -0.16, 0.09), rotation=(1.2, 0, 0))
    scene.camera = bpy.context.object
    scene.camera.data.clip_start = 0.01
    scene.render.resolution_x, scene.render.resolution_y = SETTINGS["size"]
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format = "OPEN_EXR"
    return scene, ball


def render(scene, name):
    """Renders to output/name.exr and returns what was reported meanwhile."""
    reports = []
    original = engine.StfRenderEngine._report
    engine.StfRenderEngine._report = lambda self, messages: (reports.extend(messages), original(self, messages))
    scene.render.filepath = str(OUTPUT / (name + ".exr"))
    failed = ""
    try:
        bpy.ops.render.render(write_still=True)
    except RuntimeError as problem:  # errors that were reported
        failed = str(problem)
    finally:
        engine.StfRenderEngine._report = original
    return {"messages": reports, "raised": failed}


def main():
    """All of the session, in order."""
    for again in (hdstf_blender.register, hdstf_blender.unregister, hdstf_blender.register):
        again()
    seen = {"blender": bpy.app.version_string, "error": plugin.error}
    if not plugin.error:
        scene, ball = make_scene()
        scene.render.engine = "HDSTF"
        scene.hydra.export_method = "USD"
        final = scene.hdstf.final
        seen["settings"] = {s["key"]: [getattr(final, s["key"].replace(":", "_")), s["default"]]
                            for s in plugin.settings() if s["key"] != "stageMetersPerUnit"}
        seen["properties"] = list(shell.names())
        final.stf_samples = SETTINGS["samples"]
        final.stf_quality = 0.1
        seen["plain"] = render(scene, "plain")
        ball.hdstf.baseVolume = SETTINGS["volume"]
        ball.hdstf.mapping = "synthesize"
        ball.hdstf.coreMaterial = "marble"
        ball.hdstf.coreSigmaA = (0.002, 0.004, 0.007)
        ball.hdstf.thickness = 0.005
        seen["custom"] = {key: repr(ball[key]) for key in ball.keys() if key.startswith(shell.PREFIX)}
        seen["marble"] = render(scene, "marble")
        seen["status"] = plugin.status()
        ball.hdstf.baseVolume = str(OUTPUT / "none.vdb")
        seen["missing"] = render(scene, "missing")
        bpy.context.view_layer.objects.active = ball
        bpy.ops.hdstf.unset(name="thickness")
        seen["unset"] = [shell.is_set(ball, "thickness"), ball.hdstf.thickness]
    (OUTPUT / "session.json").write_text(json.dumps(seen, indent=1, default=str))


main()
