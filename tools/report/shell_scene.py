"""Scenes whose shells are drawn in another way: a layer over the scene, with opinions about its shells alone."""

import pathlib

from pxr import Sdf, Tf, Usd, UsdGeom

OVERRIDES = {"quality": Sdf.ValueTypeNames.Float, "transport": Sdf.ValueTypeNames.Token,
             "coreModel": Sdf.ValueTypeNames.Token}
DEFAULTS = {"quality": 0.02, "transport": "dE1", "coreModel": "auto"}  # of the schema
# Of the root layer alone: OpenUSD does not take them from a sublayer.
METADATA = ("metersPerUnit", "upAxis", "startTimeCode", "endTimeCode", "timeCodesPerSecond", "framesPerSecond",
            "defaultPrim")


class ShellScene:
    """The shells of a USD file. ValueError where the file cannot be opened."""

    def __init__(self, path):
        self.path = pathlib.Path(path).resolve()
        if not self.path.is_file():
            raise ValueError(f"{path}: no such file")
        try:
            self.stage = Usd.Stage.Open(str(self.path))
        except Tf.ErrorException as error:
            raise ValueError(f"{path} is no USD file that can be read: "
                             f"{str(error).split(' : ')[-1].strip()}") from None
        # Those of native instances are no prims that a layer could hold opinions about; they stay as they are.
        self.shells = [p for p in self.stage.Traverse() if p.IsA(UsdGeom.Mesh) and self.primvar(p, "baseVolume")]

    @staticmethod
    def primvar(prim, name):
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(f"stf:{name}")
        value = primvar.Get() if primvar else None
        return round(value, 6) if isinstance(value, float) else value  # a float of 32 bits, as it was written

    def values(self, name):
        """What the shells say, each value once, the schema's default where one says nothing."""
        found = [self.primvar(p, name) for p in self.shells]
        return list(dict.fromkeys(DEFAULTS[name] if v is None else v for v in found))

    def write(self, path, **values):
        """A layer over the scene in which all shells have these values of OVERRIDES."""
        layer = Sdf.Layer.CreateAnonymous(".usda")
        layer.subLayerPaths.append(str(self.path))
        root = self.stage.GetRootLayer().pseudoRoot
        for key in METADATA:
            if root.HasInfo(key):
                layer.pseudoRoot.SetInfo(key, root.GetInfo(key))
        for prim in self.shells:
            over = Sdf.CreatePrimInLayer(layer, prim.GetPath())
            for name, value in values.items():
                attribute = Sdf.AttributeSpec(over, f"primvars:stf:{name}", OVERRIDES[name])
                attribute.default = value
                attribute.SetInfo("interpolation", "constant")
        # A file of another content would make every run that used it be made again.
        text = layer.ExportToString()
        path = pathlib.Path(path)
        if not path.exists() or path.read_text() != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return path
