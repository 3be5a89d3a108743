"""What a measurement found, as a file: the page can be written again from it, without a run."""

import json

from as_json import plain
from measurement import Found
from mitsuba_runs import Mitsuba
from recorder import Run
from sources import Source, Sources


def save(found, path):
    path.write_text(json.dumps(plain(found), indent=1))


def load(path, folder):
    """`folder`: where the images are. ValueError where there is no such file or it is of another version."""
    def run(told):
        return Run(**{**told, "image": folder / told["image"]}) if told else None

    def runs(told):
        return [run(t) for t in told] if told is not None else None

    try:
        told = json.loads(path.read_text())
        found = Found(told.get("scene", ""), cold=runs(told["cold"]), parts=run(told["parts"]), notes=told["notes"],
                      stf={int(n): runs(pair) for n, pair in told["stf"].items()},
                      reference={int(n): [runs(p) for p in pairs] for n, pairs in told["reference"].items()})
        if told["sources"]:
            s = told["sources"]
            rows = [Source(**{**r, "changed": runs(r["changed"]), "limit": runs(r["limit"])}) for r in s["rows"]]
            found.sources = Sources(s["limits"], runs(s["limit"]), rows, s["left_out"])
        if told["mitsuba"]:
            m = told["mitsuba"]
            found.mitsuba = Mitsuba({int(n): [runs(p) for p in pairs] for n, pairs in m["pairs"].items()}, m["why"])
        return found
    except (OSError, KeyError, TypeError, json.JSONDecodeError) as error:
        raise ValueError(f"{path}: nothing to write a page from ({error})") from None
