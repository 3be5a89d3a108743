# SPDX-License-Identifier: Apache-2.0
"""The renderer's library: where it is, and what it tells by C functions (hdStf/hostInterface.h)."""

import ctypes
import json
import os
import pathlib
import sys

import bpy

error = ""
_library = None
_folder = None


def _folders(folder):
    """Folders that may hold hdStf.so: the one given, else those of PXR_PLUGINPATH_NAME."""
    if folder:
        return [pathlib.Path(bpy.path.abspath(folder))]
    return [pathlib.Path(p) for p in os.environ.get("PXR_PLUGINPATH_NAME", "").split(os.pathsep) if p]


def _make_known(folder):
    """Tells OpenUSD of the folder, where its Python modules are there; else PXR_PLUGINPATH_NAME must name it."""
    if hasattr(bpy.utils, "expose_bundled_modules"):
        bpy.utils.expose_bundled_modules()
    try:
        from pxr import Plug
    except ImportError:
        return folder in _folders("")
    Plug.Registry().RegisterPlugins(str(folder) + "/")
    return True


def load(folder):
    """Loads the library. False, with a sentence in `error`, where that fails."""
    global error, _library, _folder
    error = ""
    name = "hdStf.dylib" if sys.platform == "darwin" else "hdStf.so"
    found = next((f.resolve() for f in _folders(folder) if (f / name).is_file()), None)
    if not found:
        error = f"no {name} in the add-on's plugin folder or in PXR_PLUGINPATH_NAME"
        return False
    if not _make_known(found):
        error = (f"this Blender has no Python modules of OpenUSD: start it with PXR_PLUGINPATH_NAME={found} "
                 "(an absolute path)")
        return False
    try:
        library = ctypes.CDLL(str(found / name))
        for function in (library.hdStfSettingsJson, library.hdStfStatusJson):
            function.argtypes = (ctypes.c_char_p, ctypes.c_size_t)
            function.restype = ctypes.c_size_t
    except (OSError, AttributeError) as problem:
        error = f"{found / name} is not for this Blender's OpenUSD: {problem}"
        return False
    _library, _folder = library, found
    return True


def _call(function):
    """The JSON a C function gives; asked again where it grew in between."""
    size = function(None, 0)
    while size:
        buffer = ctypes.create_string_buffer(size)
        needed = function(buffer, size)
        if needed <= size:
            return json.loads(buffer.value.decode()) if needed else None
        size = needed
    return None


def settings():
    """The renderer's settings: a list of {"key", "name", "default", "description", ..}."""
    return _call(_library.hdStfSettingsJson) or []


def status():
    """What the renderer that was started last is doing: {"annotation", "percentDone", "messages"}, or {}."""
    return _call(_library.hdStfStatusJson) or {}


def schema_text():
    """The text of the schema StfShellAPI, which is installed beside the renderer."""
    return (_folder / "stfSchemas" / "resources" / "schema.usda").read_text()
