# SPDX-License-Identifier: Apache-2.0
"""Blender add-on: the renderer Stf, its settings in the render panel, and shells in the object panel (docs/hosts.md)."""

bl_info = {
    "name": "Stf (hdStf)",
    "author": "hdStf",
    "version": (0, 1, 0),
    "blender": (4, 2, 0),
    "description": "Shell Texture Functions: heterogeneous translucent objects, through Hydra",
    "category": "Render",
}

import atexit

import bpy

from . import engine, plugin, settings, shell, ui

MODULES = (settings, shell, engine, ui)
_registered = []


class HdStfPreferences(bpy.types.AddonPreferences):
    """Where the renderer is."""

    bl_idname = __package__

    folder: bpy.props.StringProperty(
        name="Plugin folder", subtype="DIR_PATH",
        description="The folder `plugin` of a build of hdStf for this Blender (empty: that of PXR_PLUGINPATH_NAME)")

    def draw(self, context):
        self.layout.prop(self, "folder")
        self.layout.label(text="Takes effect when the add-on is enabled anew, or Blender is started anew")
        if plugin.error:
            self.layout.label(text=plugin.error, icon="ERROR")


def register():
    """Registers what there is; without the renderer the preferences only, which then say why."""
    bpy.utils.register_class(HdStfPreferences)
    _registered.append(HdStfPreferences)
    addon = bpy.context.preferences.addons.get(__package__)
    if not plugin.load(addon.preferences.folder if addon and addon.preferences else ""):
        print(f"hdstf_blender: {plugin.error}")
        return
    for module in MODULES:
        module.register()
        _registered.append(module)
    # A class of an engine that is still registered when Blender ends can crash it.
    atexit.register(unregister)


def unregister():
    """Undoes register, in the opposite order; again is no error."""
    atexit.unregister(unregister)
    while _registered:
        last = _registered.pop()
        if last is HdStfPreferences:
            bpy.utils.unregister_class(last)
        else:
            last.unregister()
