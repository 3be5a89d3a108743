"""Curves as SVG text, images as PNG files."""

import io

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "stf report"  # the same numbers give the same file
matplotlib.rcParams["svg.fonttype"] = "none"
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: E402

STAGES = ("load", "precompute", "synthesis", "shell", "core", "indirect", "render")
COLORS = {"STF, tables kept": "#1f77b4", "STF, tables made": "#7fb2d9", "reference": "#d62728",
          "Mitsuba 3": "#2ca02c"}


def _svg(figure):
    text = io.StringIO()
    figure.savefig(text, format="svg", bbox_inches="tight", metadata={"Date": None, "Creator": None})
    plt.close(figure)
    return text.getvalue()[text.getvalue().index("<svg"):]


def _plain_numbers(axis):
    for a in (axis.xaxis, axis.yaxis):
        a.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        a.set_minor_formatter(NullFormatter())
    axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.grid(True, which="major", alpha=0.3)


def curves(lines, ylabel, xlabel="seconds (clock)", floor=None):
    """Error over time. `lines`: by name, lists of (seconds, error, its standard error); not positive errors are left
    out of a logarithmic plot. `floor`: a named level."""
    figure, axis = plt.subplots(figsize=(5.6, 3.8))
    for name, points in lines.items():
        points = [p for p in points if p[1] > 0]
        if points:
            x, y, e = np.array(points).T
            axis.errorbar(x, y, yerr=np.minimum(e, 0.9 * y), marker="o", markersize=3.5, capsize=2, label=name,
                          color=COLORS.get(name))
    if floor:
        axis.axhline(floor[1], color="#888888", linestyle=":", label=floor[0])
    axis.set_xscale("log")
    axis.set_yscale("log")
    _plain_numbers(axis)
    axis.set_xlabel(xlabel)
    axis.set_ylabel(ylabel)
    axis.legend(fontsize=8)
    return _svg(figure)


def bias_and_deviation(rows, mask):
    """Bias, deviation and their sum over samples."""
    figure, axis = plt.subplots(figsize=(5.6, 3.8))
    for key, label, color in (("rmse", "RMSE", "#1f77b4"), ("bias", "bias", "#d62728"),
                              ("deviation", "deviation", "#2ca02c")):
        points = [(r["samples"], 100 * r["errors"][mask][key].value, 100 * r["errors"][mask][key].error) for r in rows]
        points = [p for p in points if p[1] > 0]
        if points:
            x, y, e = np.array(points).T
            axis.errorbar(x, y, yerr=np.minimum(e, 0.9 * y), marker="o", markersize=3.5, capsize=2, label=label,
                          color=color)
    axis.set_xscale("log", base=2)
    axis.set_yscale("log")
    _plain_numbers(axis)
    axis.xaxis.set_major_locator(LogLocator(base=2))
    axis.set_xlabel("samples per pixel")
    axis.set_ylabel("% of the mean radiance")
    axis.legend(fontsize=8)
    return _svg(figure)


def stages(rows):
    """Where the time goes: stacked bars, one for each named row of stage seconds; what no stage counts is `other`."""
    figure, axis = plt.subplots(figsize=(8.6, 0.6 + 0.32 * len(rows)))
    names = list(rows)
    left = np.zeros(len(names))
    for stage in STAGES + ("other",):
        values = np.array([rows[n][stage] for n in names])
        axis.barh(names, values, left=left, label=stage, height=0.7)
        left += values
    axis.invert_yaxis()
    axis.set_xlabel("seconds (clock)")
    axis.legend(fontsize=8, ncols=8, loc="lower center", bbox_to_anchor=(0.5, 1))
    axis.grid(True, axis="x", alpha=0.3)
    return _svg(figure)


def display(linear, scale):
    """8-bit sRGB of linear radiance times `scale`."""
    x = np.clip(linear * scale, 0, 1)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9)**(1 / 2.4) - 0.055)
    return (255 * encoded + 0.5).astype(np.uint8)


def signed(difference, scale, most):
    """Mean of the channels of a difference over `scale`, blue to red at -most to +most."""
    values = difference.mean(axis=2) / scale
    return (255 * matplotlib.colormaps["RdBu_r"](0.5 + 0.5 * np.clip(values / most, -1, 1))[..., :3]).astype(np.uint8)


def write_png(path, pixels, zoom):
    """Each pixel as a square of `zoom`."""
    plt.imsave(path, np.repeat(np.repeat(pixels, zoom, axis=0), zoom, axis=1))


def magma(values):
    """8-bit colours of a map of 0 to 1."""
    return (255 * matplotlib.colormaps["magma"](np.clip(values, 0, 1))[..., :3]).astype(np.uint8)
