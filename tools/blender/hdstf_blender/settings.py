# SPDX-License-Identifier: Apache-2.0
"""The renderer's settings as properties of scenes, made from what the renderer says it has."""

import bpy

from . import plugin

# Follows from the scene.
METERS = "stageMetersPerUnit"
_keys = {}
_groups = []


def _property(setting):
    """A property of the kind that the default is of."""
    default = setting["default"]
    # Blender ends tooltips with a full stop of its own.
    common = {"name": setting["name"], "description": setting["key"] + ": " + setting.get("description", "")}
    limits = {ours: type(default)(setting[theirs]) for ours, theirs in (("min", "least"), ("max", "most"))
              if theirs in setting}
    if isinstance(default, bool):
        return bpy.props.BoolProperty(default=default, **common)
    if isinstance(default, int):
        return bpy.props.IntProperty(default=default, **limits, **common)
    if isinstance(default, float):
        return bpy.props.FloatProperty(default=default, precision=4, **limits, **common)
    return bpy.props.StringProperty(default=default, **common)


def names():
    """Names of the properties, in the renderer's order."""
    return list(_keys)


def values(scene, group):
    """What the renderer is set to: {key: value}."""
    result = {key: getattr(group, name) for name, key in _keys.items()}
    result[METERS] = float(scene.unit_settings.scale_length)
    return result


def register():
    """Makes one group for pictures and one for viewports, which start with fewer samples."""
    listed = [s for s in plugin.settings() if s["key"] != METERS]
    _keys.update({s["key"].replace(":", "_"): s["key"] for s in listed})

    def group(name, samples=None):
        chosen = [dict(s, default=samples) if samples and s["key"] == "stf:samples" else s for s in listed]
        annotations = {s["key"].replace(":", "_"): _property(s) for s in chosen}
        return type(name, (bpy.types.PropertyGroup,), {"__annotations__": annotations})

    final, viewport = group("HdStfFinalSettings"), group("HdStfViewportSettings", 16)
    both = type("HdStfSceneSettings", (bpy.types.PropertyGroup,), {"__annotations__": {
        "final": bpy.props.PointerProperty(type=final), "viewport": bpy.props.PointerProperty(type=viewport)}})
    for cls in (final, viewport, both):
        bpy.utils.register_class(cls)
        _groups.append(cls)
    bpy.types.Scene.hdstf = bpy.props.PointerProperty(type=both)


def unregister():
    """Removes them."""
    del bpy.types.Scene.hdstf
    while _groups:
        bpy.utils.unregister_class(_groups.pop())
    _keys.clear()
