"""Plots of docs/validation.md."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

plt.rcParams.update({"svg.hashsalt": "hdStf", "svg.fonttype": "path", "font.size": 9, "axes.grid": True,
                     "grid.alpha": 0.3, "figure.constrained_layout.use": True, "figure.facecolor": "white"})


def save(figure, path):
    # Without a date: the same numbers give the same file.
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None, dpi=120)
    plt.close(figure)


def error_against_time(tables, path):
    figure, axes = plt.subplots(figsize=(5.5, 3.6))
    for name in dict.fromkeys(t["volume"] for t in tables):
        rows = [t for t in tables if t["volume"] == name and "seconds" in t]
        axes.loglog([r["seconds"] for r in rows], [100 * r["relativeError"] for r in rows], "o-", label=name)
    axes.set(xlabel="seconds", ylabel="estimated error of the table, %")
    axes.legend()
    save(figure, path)


def forms(rows, path):
    """Logarithmic outside of +-1 %: the two forms are decades apart."""
    figure, axes = plt.subplots(figsize=(6, 3.8))
    for form, colour in (("classic", "C3"), ("dE1", "C0")):
        for tau, line in ((2, "-o"), (10, "--s")):
            mine = [r for r in rows if r["tau"] == tau]
            bars = [100 * np.hypot(r[form]["stderr"], r["stderr"]) / r["R"] for r in mine]
            axes.errorbar([r["g"] for r in mine], [r[form]["percent"] for r in mine], bars, fmt=line, color=colour,
                          markersize=4, capsize=2, label=f"{form}, optical depth {tau}")
    axes.axhline(0, color="black", linewidth=0.8)
    axes.set_yscale("symlog", linthresh=1)
    axes.set_yticks([-10, -1, 0, 1, 10, 100], ["-10", "-1", "0", "1", "10", "100"])
    axes.set_ylim(-30, 600)
    axes.set(xlabel="mean cosine g of the phase function", ylabel="error of the reflectance, %")
    axes.legend()
    save(figure, path)


def quality(rows, path):
    figure, axes = plt.subplots(figsize=(5.5, 3.6))
    asked = [100 * r["quality"] for r in rows]
    axes.errorbar(asked, [r["R"]["percent"] for r in rows],
                  [100 * r["R"]["stderr"] / r["R"]["exact"] for r in rows], fmt="o", capsize=3)
    axes.axhline(0, color="black", linewidth=0.8)
    axes.set_xscale("log")
    axes.minorticks_off()
    axes.set_xticks(asked, [f"{a:g}" for a in asked])
    axes.set(xlabel="quality asked for, %", ylabel="error of the reflectance, %")
    save(figure, path)


def tile(maps, path):
    """Walks, Mitsuba and dE1 side by side, and what is between them."""
    walk = maps["walk"]
    scale = walk.mean()
    sigma = np.hypot(maps["walk_stderr"], maps["mitsuba_stderr"])
    panels = [("walks", walk / scale, "gray", None), ("Mitsuba 3", maps["mitsuba"] / scale, "gray", None),
              ("dE1 table", maps["dE1"] / scale, "gray", None),
              ("(walks - Mitsuba) / sigma", (walk - maps["mitsuba"]) / sigma, "RdBu", 4),
              ("(dE1 - walks), % of the mean", 100 * (maps["dE1"] - walk) / scale, "RdBu", None),
              ("(classic - walks), % of the mean", 100 * (maps["classic"] - walk) / scale, "RdBu", None)]
    grey = (min(m.min() for _, m, c, _ in panels if c == "gray"), max(m.max() for _, m, c, _ in panels if c == "gray"))
    figure, axes = plt.subplots(2, 3, figsize=(9, 5.6))
    for axis, (title, values, colours, limit) in zip(axes.flat, panels):
        bound = limit or np.abs(values).max()
        low, high = grey if colours == "gray" else (-bound, bound)
        shown = axis.imshow(values, cmap=colours, vmin=low, vmax=high, origin="lower", interpolation="nearest")
        axis.set_title(title, fontsize=9)
        axis.set_xticks([])
        axis.set_yticks([])
        axis.grid(False)
        figure.colorbar(shown, ax=axis, shrink=0.85)
    save(figure, path)


def scene_tiles(maps, cases, path):
    """Rendered image, Mitsuba's, and their difference, a row for each tile."""
    figure, axes = plt.subplots(len(cases), 3, figsize=(7, 2.3 * len(cases)), squeeze=False)
    for row, case in zip(axes, cases):
        ours, theirs = (np.clip(maps[f"{case}|{who}"], 0, None) for who in ("ours", "mitsuba"))
        brightest = np.percentile(theirs, 99.5)
        for axis, values, title in ((row[0], ours, f"hdStf: {case}"), (row[1], theirs, "Mitsuba 3")):
            shown = np.clip(values / brightest, 0, 1)**(1 / 2.2)
            axis.imshow(np.broadcast_to(shown, (*shown.shape[:2], 3)), origin="lower", interpolation="nearest")
            axis.set_title(title, fontsize=8)
        difference = 100 * (ours - theirs).mean(axis=2)
        bound = np.percentile(np.abs(difference), 99.5)
        shown = row[2].imshow(difference, cmap="RdBu", vmin=-bound, vmax=bound, origin="lower", interpolation="nearest")
        row[2].set_title("difference, % of the mean", fontsize=8)
        figure.colorbar(shown, ax=row[2], shrink=0.85)
        for axis in row:
            axis.set_xticks([])
            axis.set_yticks([])
            axis.grid(False)
    save(figure, path)
