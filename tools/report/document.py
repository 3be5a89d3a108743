"""The report of what was found: numbers, pictures and the page."""

import base64
import json
import os
import pathlib

import jinja2
import numpy as np

import analysis
import figures
import image_error as errors
from as_json import plain
from perception import flip

ZOOM = 2  # of pictures
DIFFERENCE = 0.5  # full colour of a difference map, in units of the mean radiance


def _write(path, text):
    temporary = path.with_name(path.name + ".new")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


class Document:
    """`found` of a Measurement that has at least the first runs of both renderers."""

    def __init__(self, options, found):
        self.options, self.found, self.out = options, found, pathlib.Path(options.output)
        self.halves, self.half_samples = analysis.halves_of(found.reference)
        self.reference = 0.5 * (self.halves[0] + self.halves[1])
        self.masks = {"frame": errors.Blocks(analysis.frame_mask(self.reference))}
        shell = analysis.shell_mask(found.parts) if found.parts else np.zeros(1)
        if shell.any() and not shell.all():
            self.masks["shells"] = errors.Blocks(shell)
        self.main = "shells" if "shells" in self.masks else "frame"

    def numbers(self):
        """Everything that the page tells, without pictures."""
        found = self.found
        stf, extra = analysis.stf_rows(found, self.halves, self.masks)
        reference = analysis.unbiased_rows(found.reference, self.masks, self.reference)
        analysis.add_flip(stf, lambda n: [found.stf[n]], self.halves, self.masks["frame"], flip)
        analysis.add_flip(reference, lambda n: found.reference[n], self.halves, self.masks["frame"], flip)
        others = {"the reference": reference}
        if found.mitsuba and found.mitsuba.pairs:
            others["Mitsuba 3"] = analysis.unbiased_rows(found.mitsuba.pairs, self.masks, self.reference)
        told = {
            "scene": found.scene or self.options.scene.name, "width": self.reference.shape[1],
            "height": self.reference.shape[0], "cores": os.cpu_count(), "notes": found.notes,
            "messages": sorted({m for r in found.stf[1] for m in r.messages}),
            "reference": {"samples": 2 * self.half_samples,
                          "noise": {name: errors.reference_noise(self.halves, blocks)
                                    for name, blocks in self.masks.items()},
                          "rows": reference},
            "stf": {"rows": stf, "tables": extra, "cold": analysis.stage_seconds(found.cold)},
            "breakEven": {name: {what: analysis.break_even(stf, extra, analysis.unbiased_time(rows, self.main, what),
                                                           self.main, what) for what in ("wall", "cpu")}
                          for name, rows in others.items()},
            "mask": self.main,
        }
        if "Mitsuba 3" in others:
            told["mitsuba"] = {"rows": others["Mitsuba 3"], **self._agreement()}
        elif found.mitsuba:
            told["mitsuba"] = {"why": found.mitsuba.why}
        if found.sources:
            told["sources"] = {"limits": found.sources.limits, "leftOut": found.sources.left_out}
            rows, left = analysis.source_rows(found.sources, self.halves, self.masks[self.main])
            told["sources"].update(rows=rows, left=left)
        return told

    def _agreement(self):
        """How far Mitsuba's images and the reference agree: both have no bias where they show the same scene."""
        largest = max(self.found.mitsuba.pairs)
        images = [r.color() for r in self.found.mitsuba.pairs[largest][-1]]
        return {"agreement": errors.errors(images, self.halves, self.masks[self.main])}

    def curves(self, told):
        """SVG by name."""
        def lines(what, get):
            stf = told["stf"]["rows"]
            rows = {"STF, tables kept": (stf, "warm"), "STF, tables made": (stf, "cold"),
                    "reference": (told["reference"]["rows"], "warm")}
            if "rows" in told.get("mitsuba", {}):
                rows["Mitsuba 3"] = (told["mitsuba"]["rows"], "warm")
            return {name: [(r[state][what], get(r).value, get(r).error) for r in entries if get(r)]
                    for name, (entries, state) in rows.items()}

        def error(mask, key, scale=1.0):
            def get(row):
                e = row["errors"][mask][key]
                return errors.Estimate(scale * e.value, scale * e.error)
            return get

        def curve(what, get, label):
            return figures.curves(lines(what, get), label, f"seconds ({'clock' if what == 'wall' else 'CPU'})")

        relative = "RMSE, % of the mean radiance"
        svg = {f"RMSE over CPU time, {mask}": curve("cpu", error(mask, "rmse", 100), relative) for mask in self.masks}
        svg[f"RMSE over clock time, {self.main}"] = curve("wall", error(self.main, "rmse", 100), relative)
        svg[f"relMSE over CPU time, {self.main}"] = curve("cpu", error(self.main, "relMSE"), "relMSE")
        svg["FLIP over CPU time, frame"] = curve("cpu", lambda row: row.get("flip"),
                                                 "mean FLIP against half of the reference")
        svg[f"Bias and deviation of the STF, {self.main}"] = figures.bias_and_deviation(told["stf"]["rows"], self.main)
        return svg

    @staticmethod
    def summary(told):
        """What the page says first, a sentence for each renderer that the STF is compared with."""
        best = told["stf"]["rows"][-1]
        mask = told["mask"]
        e = best["errors"][mask]
        bias = f"a bias of {percent(e['bias'])}" if e["bias"].value > 2 * e["bias"].error else \
            f"no bias beyond its noise ({percent(e['bias'])})"
        text = [f"The STF with {samples(best)} has an RMSE of {percent(e['rmse'])} ({mask}): {bias} and a deviation of "
                f"{percent(e['deviation'])}. It takes {best['warm']['cpu']:.1f} CPU seconds with tables kept, "
                f"{best['cold']['cpu']:.1f} with tables made."]
        for name, by in told["breakEven"].items():
            if by["cpu"]:
                kept, made = (max(by["cpu"], key=lambda r: r[k]) for k in ("ratio", "ratioOfFrames"))
                text.append(f"To the same error {name} takes at most {kept['ratio']:.3g} ± {kept['ratioError']:.1g} "
                            f"times the CPU seconds of the STF with tables kept ({samples(kept)}, "
                            f"{100 * kept['error']:.1f} %), and {made['ratioOfFrames']:.3g} times with tables made "
                            f"within {analysis.FRAMES} frames "
                            f"({samples(made)}, {100 * made['error']:.1f} %).")
        return text

    def stage_bars(self, told):
        rows = {"STF, 1 sample, tables made": told["stf"]["cold"]}
        for r in told["stf"]["rows"]:
            rows[f"STF, {r['samples']} samples"] = r["stages"]
        for r in told["reference"]["rows"]:
            rows[f"reference, {r['samples']} samples"] = r["stages"]
        bars = {name: {**s, "other": max(0.0, s["total"] - sum(s[k] for k in figures.STAGES))}
                for name, s in rows.items()}
        return figures.stages(bars)

    def pictures(self, told):
        """Rows of named PNG files: images, differences, FLIP."""
        folder = self.out / "images"
        folder.mkdir(exist_ok=True)
        mean = float(self.reference.mean())
        samples = max(self.found.stf)
        shown = {"reference": self.reference, f"STF, {samples} samples": self.found.stf[samples][0].color()}
        seconds = told["stf"]["rows"][-1]["warm"]["cpu"]
        equal = [r["samples"] for r in told["reference"]["rows"] if r["warm"]["cpu"] <= seconds] or \
            [told["reference"]["rows"][0]["samples"]]
        shown[f"reference, {equal[-1]} samples (no more CPU time)"] = \
            self.found.reference[equal[-1]][0][0].color()
        if self.found.mitsuba and self.found.mitsuba.pairs:
            largest = max(self.found.mitsuba.pairs)
            shown[f"Mitsuba 3, {largest} samples"] = self.found.mitsuba.pairs[largest][-1][0].color()
        rows = []
        for name, image in shown.items():
            slug = "".join(c if c.isalnum() else "_" for c in name.split("(")[0].strip().lower())
            files = {"image": figures.display(image, 1.0)}
            if name != "reference":
                files["difference"] = figures.signed(image - self.reference, mean, DIFFERENCE)
                files["flip"] = figures.magma(flip(self.reference, image))
            for kind, pixels in files.items():
                figures.write_png(folder / f"{slug}_{kind}.png", pixels, ZOOM)
            rows.append({"name": name, **{kind: f"{slug}_{kind}.png" for kind in files}})
        return rows

    def write(self):
        """report.json, images and report.html; the path of the page."""
        told = self.numbers()
        _write(self.out / "report.json", json.dumps(plain(told), indent=1))
        pictures = self.pictures(told)

        def data(name):
            return "data:image/png;base64," + base64.b64encode((self.out / "images" / name).read_bytes()).decode()

        environment = jinja2.Environment(loader=jinja2.FileSystemLoader(pathlib.Path(__file__).parent),
                                         autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True,
                                         lstrip_blocks=True)
        environment.filters.update(percent=percent, number=number)
        page = environment.get_template("page.html.j2").render(
            told=told, curves=self.curves(told), stages=self.stage_bars(told), pictures=pictures, data=data,
            masks=list(self.masks), summary=self.summary(told), full=100 * DIFFERENCE, zoom=ZOOM)
        _write(self.out / "report.html", page)
        return self.out / "report.html"


def samples(row):
    return f"{row['samples']} sample{'s' if row['samples'] > 1 else ''}"


def number(estimate):
    """Value and standard error with the digits that mean something."""
    return f"{estimate.value:.3g} ± {estimate.error:.1g}"


def percent(estimate):
    digits = max(0, min(4, 1 - int(np.floor(np.log10(max(100 * estimate.error, 1e-4))))))
    return f"{100 * estimate.value:.{digits}f} ± {100 * estimate.error:.{digits}f} %"
