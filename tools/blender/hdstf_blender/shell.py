# SPDX-License-Identifier: Apache-2.0
"""Shells as properties of objects: `object.hdstf.thickness` and so on, made from the schema StfShellAPI.

Values live in custom properties `primvars:stf:*`, which Blender's USD export writes as they are called and the renderer
reads: as double and string where the schema has float, token and asset. A property that is not set is not there, and the
renderer's default holds."""

import re

import bpy

from . import plugin

PREFIX = "primvars:stf:"
_registered = []
_names = []


def _schema():
    """The properties of StfShellAPI that are single values: (name, type, default, allowed, documentation)."""
    text = plugin.schema_text()
    pattern = re.compile(r"^    (?:uniform )?(\w+) primvars:stf:(\w+)(?: = ([^\n(]+))? \(\n(.*?)^    \)", re.M | re.S)
    for kind, name, default, body in pattern.findall(text):
        documentation = re.search(r'doc = """(.*?)"""', body, re.S) or re.search(r'doc = "(.*?)"', body)
        allowed = re.search(r"allowedTokens = \[(.*?)\]", body)
        yield (name, kind, default.strip().strip('"'), re.findall(r'"(\w+)"', allowed[1]) if allowed else [],
               re.sub(r"\s+", " ", documentation[1]).strip() if documentation else "")


def _property(name, kind, default, allowed, documentation):
    """A typed property that keeps its value in the custom property of the schema's name."""
    key = PREFIX + name
    label = re.sub(r"(?<!^)(?=[A-Z])", " ", name).capitalize()
    common = {"name": label, "description": documentation[:1000]}

    def getter(fallback):
        return lambda self: self.id_data.get(key, fallback)

    def setter(self, value):
        self.id_data[key] = value

    if kind == "asset":
        def set_path(self, value):
            self.id_data[key] = bpy.path.abspath(value)
        return bpy.props.StringProperty(subtype="FILE_PATH", get=getter(""), set=set_path, **common)
    if allowed:
        items = [(token, token, "") for token in allowed]

        def get_token(self):
            token = self.id_data.get(key, default)
            return allowed.index(token) if token in allowed else 0

        def set_token(self, index):
            self.id_data[key] = allowed[index]
        return bpy.props.EnumProperty(items=items, get=get_token, set=set_token, **common)
    if kind == "float":
        return bpy.props.FloatProperty(get=getter(float(default or 0)), set=setter, precision=4, **common)
    if kind == "int":
        return bpy.props.IntProperty(get=getter(int(default or 0)), set=setter, **common)
    if kind == "color3f":
        def set_color(self, value):
            self.id_data[key] = [float(v) for v in value]
        return bpy.props.FloatVectorProperty(size=3, min=0, precision=4, set=set_color,
                                             get=lambda self: tuple(self.id_data.get(key, (0.0, 0.0, 0.0))), **common)
    if kind in ("token", "string"):
        return bpy.props.StringProperty(get=getter(default), set=setter, **common)
    return None


def names():
    """Names of the properties, in the schema's order."""
    return _names


def is_set(obj, name):
    """Whether the object says anything of that name."""
    return PREFIX + name in obj.keys()


class HDSTF_OT_unset(bpy.types.Operator):
    """Back to the renderer's default"""

    bl_idname = "hdstf.unset"
    bl_label = "Unset"
    bl_options = {"UNDO", "INTERNAL"}

    name: bpy.props.StringProperty()

    def execute(self, context):
        context.object.pop(PREFIX + self.name, None)
        context.object.update_tag()
        return {"FINISHED"}


def register():
    """Makes the group and hangs it on objects."""
    annotations = {}
    for name, *rest in _schema():
        made = _property(name, *rest)
        if made is not None:
            annotations[name] = made
            _names.append(name)
    group = type("HdStfShell", (bpy.types.PropertyGroup,), {"__annotations__": annotations})
    for cls in (group, HDSTF_OT_unset):
        bpy.utils.register_class(cls)
        _registered.append(cls)
    bpy.types.Object.hdstf = bpy.props.PointerProperty(type=group)


def unregister():
    """Removes them; custom properties stay with their objects."""
    del bpy.types.Object.hdstf
    while _registered:
        cls = _registered.pop()
        bpy.utils.unregister_class(cls)
        if cls is not HDSTF_OT_unset:
            # Blender keeps the class. What its annotations have are functions of this module, which keep it and with it
            # the module bpy: Blender 4.2 as a module would then end after Python, in a crash.
            cls.__annotations__.clear()
    _names.clear()
