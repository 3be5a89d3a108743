"""Numbers of a report as JSON."""

import dataclasses
import pathlib


def plain(value):
    """Dicts, lists, numbers and text of anything that a report holds."""
    if dataclasses.is_dataclass(value):
        return plain(dataclasses.asdict(value))
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, pathlib.PurePath):
        return value.name
    if hasattr(value, "item"):  # of numpy
        return value.item()
    return value
