# SPDX-License-Identifier: Apache-2.0
"""Panels: the renderer's settings beside the scene's other render settings, shells beside an object's other properties."""

import bpy

from . import settings, shell
from .engine import StfRenderEngine


class _Panel(bpy.types.Panel):
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {StfRenderEngine.bl_idname}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class HDSTF_PT_final(_Panel):
    """Settings of pictures"""

    bl_label = "Stf: Render"
    bl_context = "render"
    group = "final"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        if context.scene.hydra.export_method != "USD":
            layout.label(text="Hydra export loses shells: choose USD", icon="ERROR")
        layout.prop(context.scene.hydra, "export_method")
        for name in settings.names():
            layout.prop(getattr(context.scene.hdstf, self.group), name)


class HDSTF_PT_viewport(HDSTF_PT_final):
    """Settings of viewports"""

    bl_label = "Stf: Viewport"
    bl_options = {"DEFAULT_CLOSED"}
    group = "viewport"


class HDSTF_PT_shell(_Panel):
    """The shell of the active mesh"""

    bl_label = "Stf: Shell"
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.object and context.object.type == "MESH"

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        for name in shell.names():
            row = self.layout.row(align=True)
            row.prop(context.object.hdstf, name)
            if shell.is_set(context.object, name):
                row.operator("hdstf.unset", text="", icon="X").name = name


register, unregister = bpy.utils.register_classes_factory((HDSTF_PT_final, HDSTF_PT_viewport, HDSTF_PT_shell))
