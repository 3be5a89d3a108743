# SPDX-License-Identifier: Apache-2.0
"""The render engine: Blender's own for Hydra, with the renderer's settings and its messages."""

import bpy

from . import plugin, settings

SEVERITIES = {"error": "ERROR", "warning": "WARNING"}


class StfRenderEngine(bpy.types.HydraRenderEngine):
    """Stf in Blender. Progress is Blender's own: it asks the renderer how much is done."""

    bl_idname = "HDSTF"
    bl_label = "Stf"
    bl_info = "Shell Texture Functions: heterogeneous translucent objects"
    bl_delegate_id = "HdStfRendererPlugin"
    bl_use_preview = False
    bl_use_gpu_context = False
    bl_use_materialx = False

    def get_render_settings(self, engine_type):
        scene = bpy.context.scene
        groups = scene.hdstf
        result = settings.values(scene, groups.viewport if engine_type == "VIEWPORT" else groups.final)
        if engine_type != "VIEWPORT":
            result |= {"aovToken:Combined": "color", "aovToken:Depth": "depth"}
        return result

    def update_render_passes(self, scene, render_layer):
        if render_layer.use_pass_combined:
            self.register_pass(scene, render_layer, "Combined", 4, "RGBA", "COLOR")
        if render_layer.use_pass_z:
            self.register_pass(scene, render_layer, "Depth", 1, "Z", "VALUE")

    def render(self, depsgraph):
        super().render(depsgraph)
        if not self.engine_ptr:
            self.report({"ERROR"}, f"the renderer {self.bl_delegate_id} cannot be loaded")
            return
        self._report(plugin.status().get("messages", []))

    def view_draw(self, context, depsgraph):
        super().view_draw(context, depsgraph)
        said = getattr(self, "said", 0)
        messages = plugin.status().get("messages", [])
        self.said = len(messages)
        self._report(messages[said:])

    def _report(self, messages):
        """Shows what the renderer has to say of the scene; facts alone go to the console."""
        for message in messages:
            kind = SEVERITIES.get(message["severity"])
            if kind:
                self.report({kind}, message["text"])


def _panels():
    """Panels of Blender that fit any engine which has no materials of its own kind to show."""
    left_out = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_freestyle", "RENDER_PT_simplify"}
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        if "BLENDER_RENDER" in engines and panel.__name__ not in left_out:
            yield panel


def register():
    """Registers the engine, and its name with Blender's panels."""
    bpy.utils.register_class(StfRenderEngine)
    for panel in _panels():
        panel.COMPAT_ENGINES.add(StfRenderEngine.bl_idname)


def unregister():
    """Removes them."""
    for panel in _panels():
        panel.COMPAT_ENGINES.discard(StfRenderEngine.bl_idname)
    bpy.utils.unregister_class(StfRenderEngine)
