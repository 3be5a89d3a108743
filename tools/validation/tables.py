"""Markdown tables of docs/validation.md."""


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def percent(d):
    """A difference in percent; of what is nothing but for rounding, none."""
    return "" if d["percent"] is None else f"{d['percent']:+.2f} %"


def with_sigmas(d):
    """Difference and its size in standard errors."""
    if d["percent"] is None:
        return f"{d['value']:.1e}"
    return f"{percent(d)} ({d['sigmas']:+.1f})"


def medium(row):
    return [f"{row['tau']:g}", f"{row['albedo']:g}", f"{row['g']:g}", f"{row['n']:g}", row["incidence"]]


def walks(rows):
    head = ["tau", "albedo", "g", "index", "light", "R exact", "R walks", "(sigmas)", "T walks", "(sigmas)", "s"]
    return table(head, [
        [*medium(r), f"{r['walk']['R']['exact']:.6f}", percent(r["walk"]["R"]), f"{r['walk']['R']['sigmas']:+.1f}",
         percent(r["walk"]["T"]), f"{r['walk']['T']['sigmas']:+.1f}", f"{r['walk']['seconds']:.1f}"] for r in rows])


def chi_square(rows):
    """Mean of the squared sigmas of R, and the largest."""
    sigmas = [r["walk"]["R"]["sigmas"] for r in rows if r["walk"]["R"]["exact"] > 1e-6]
    return (f"{sum(s * s for s in sigmas) / len(sigmas):.2f} over {len(sigmas)} cases, the largest "
            f"deviation {max(map(abs, sigmas)):.1f} standard errors")


def forms(rows):
    rows = [r for r in rows if "dE1" in r]
    return table(["tau", "albedo", "g", "index", "light", "R exact", "R dE1", "R classic", "T dE1", "T classic",
                  "s dE1"],
                 [[*medium(r), f"{r['dE1']['R']['exact']:.6f}",
                   *(with_sigmas(r[form][k]) for k in "RT" for form in ("dE1", "classic")),
                   f"{r['dE1']['seconds']:.1f}"] for r in rows])


def layers(rows):
    return table(["layers", "light", "R exact", "walks", "dE1", "classic"],
                 [[r["name"], r["incidence"], f"{r['walk']['R']['exact']:.6f}",
                   *(with_sigmas(r[m]["R"]) for m in ("walk", "dE1", "classic"))] for r in rows])


def profiles(rows):
    return table(["tau", "albedo", "g", "method", "I_m", "(sigmas)", "I_b", "(sigmas)"],
                 [[f"{r['tau']:g}", f"{r['albedo']:g}", f"{r['g']:g}", r["method"],
                   *(text for k in ("I_m", "I_b")
                     for text in (f"{r[k]['percent']:.2f} %", f"{r[k]['sigmas']:.1f}"))] for r in rows])


def over_g(rows):
    return table(["tau", "g", "R walks", "dE1", "classic"],
                 [[f"{r['tau']:g}", f"{r['g']:g}", f"{r['R']:.5f} +- {r['stderr']:.5f}", with_sigmas(r["dE1"]),
                   with_sigmas(r["classic"])] for r in rows])


def quality(rows):
    return table(["asked for", "R", "(sigmas)", "s"],
                 [[f"{100 * r['quality']:g} %", percent(r["R"]), f"{r['R']['sigmas']:+.1f}", f"{r['seconds']:.1f}"]
                  for r in rows])


def table_costs(rows):
    out = []
    for r in rows:
        asked = f"{100 * r['quality']:g} %"
        if "skipped" in r:
            out.append([r["volume"], asked, f"left out: {r['skipped']}", "", "", "", "", ""])
            continue
        out.append([r["volume"], asked, f"{100 * r['relativeError']:.1f} %", f"{r['photons'] / 1e6:.2f}",
                    str(r["rank"]), f"{r['bytes'] / 1e6:.1f}", f"{r['fileBytes'] / 1e6:.1f}", f"{r['seconds']:.1f}"])
    return table(["volume", "asked for", "reached", "million photons", "rank", "MB", "MB on disk", "s"], out)


def walk_costs(rows):
    return table(["volume", "mean optical depth", "collisions a photon", "million collisions a second and core"],
                 [[r["volume"], f"{r['tau']:g}", f"{r['collisions'] / r['photons']:.1f}",
                   f"{r['collisionsPerSecond'] / 1e6:.2f}"] for r in rows])


def mitsuba(rows):
    return table(["case", "R hdStf", "R Mitsuba", "sigmas apart", "clock", "processor time"],
                 [[r["case"], f"{r['R']:.6f}", f"{r['mitsubaR']:.6f}", f"{r['sigmas']:+.1f}",
                   f"{r['secondsToSameError']:.2f}", f"{r['cpuToSameError']:.2f}"] for r in rows])


def _percent_and_error(row):
    return f"{row['percent']:+.2f} +- {row['percentStderr']:.2f} %"


def views(rows):
    """Index of refraction by view cosine: difference with its standard error."""
    cosines = list(dict.fromkeys(r["mu"] for r in rows))
    body = []
    for index in dict.fromkeys(r["n"] for r in rows):
        mine = {r["mu"]: r for r in rows if r["n"] == index}
        body.append([f"{index:g}", *(_percent_and_error(mine[mu]) for mu in cosines)])
    return table(["index", *(f"cosine {mu:g}" for mu in cosines)], body)


def reciprocity(rows):
    return table(["index", "cosines", "there", "back", "difference"],
                 [[f"{r['n']:g}", f"{r['other']:g}, {r['mu']:g}", f"{r['value']:.5f}", f"{r['exact']:.5f}",
                   _percent_and_error(r)] for r in rows])


def scene_tiles(rows):
    return table(["tile", "wanted", "mean", "rms over the mean", "rms, relative to each pixel", "noise", "border"],
                 [[r["case"], f"{100 * r['allowed']:g} %", f"{100 * r['meanDifference']:+.2f} %",
                   f"{100 * r['rms']:.2f} %", f"{100 * r['relative']:.2f} %", f"{100 * r['noise']:.2f} %",
                   f"{r['borders']:+.1f}"] for r in rows])
