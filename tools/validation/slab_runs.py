"""Runs of `stf slab` beside the numbers they should give."""

import json
import pathlib
import subprocess

FORMS = ("dE1", "classic")


class Slab:
    """`stf slab` of a build folder; walks run until an error or a time is reached. Every table has a seed of its own:
    with one for all, rows and points of a plot would share their noise and look like a bias."""

    def __init__(self, build, stderr, seconds, quality):
        self.program = pathlib.Path(build) / "bin" / "stf"
        self.stderr, self.seconds, self.quality = stderr, seconds, quality
        self.tables = 0

    def __call__(self, *words):
        command = [str(w) for w in (self.program, "slab", *words, "--json")]
        done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)}\n{done.stderr}")
        return json.loads(done.stdout)

    def make(self, *words):
        """A base volume by `stf make`."""
        subprocess.run([str(w) for w in (self.program, "make", *words)], check=True, stdin=subprocess.DEVNULL,
                       stdout=subprocess.DEVNULL)

    def walk(self, *words):
        """Photons by a pilot: as many as the error asks for and the time allows."""
        pilot_photons = 4000
        pilot = self(*words, "--photons", pilot_photons)
        worst = max(pilot["R"]["stderr"], pilot["T"]["stderr"])
        wanted = pilot_photons * (worst / self.stderr)**2
        allowed = pilot_photons * self.seconds / max(pilot["seconds"], 1e-4)
        photons = int(max(pilot_photons, min(wanted, allowed)))
        return self(*words, "--photons", photons, "--seed", 1)

    def table(self, form, *words, quality=None, photons=40000):
        self.tables += 1
        return self(*words, "--method", "stf", "--form", form, "--quality", quality or self.quality, "--photons",
                    photons, "--seed", self.tables)


def slab_words(tau, albedo, g, ior, incidence):
    return ["--tau", tau, "--albedo", albedo, "--g", g, "--ior", ior, "--incidence", incidence]


def deviation(measured, exact, exact_error=0.0):
    """Value, difference in percent of the exact one (of 1 where that is nearly 0), and in standard errors."""
    difference = measured["total"] - exact
    # A standard error of nothing scattered is nothing: the last digit of the reference is the scale then.
    sigma = max((measured["stderr"]**2 + exact_error**2)**0.5, 5e-7)
    return {"value": measured["total"], "stderr": measured["stderr"], "exact": exact,
            "percent": 100 * difference / exact if exact > 1e-6 else None, "sigmas": difference / sigma}


def homogeneous(slab, cases, log):
    """All cases of slab_cases.json by walks and by both forms of tables."""
    rows = []
    for case in cases:
        for incidence in ("normal", "diffuse"):
            words = slab_words(case["tau"], case["albedo"], case["g"], case["n"], incidence)
            exact = case[incidence]
            row = {"tau": case["tau"], "albedo": case["albedo"], "g": case["g"], "n": case["n"],
                   "incidence": incidence}
            # Tables of hardly any and of endless scattering take minutes and tell nothing of the forms.
            tables = FORMS if incidence == "normal" and 1 <= case["tau"] <= 400 else ()
            runs = [("walk", slab.walk(*words))] + [(form, slab.table(form, *words)) for form in tables]
            for method, r in runs:
                row[method] = {"R": deviation(r["R"], exact["R_total"]), "T": deviation(r["T"], exact["T_total"]),
                               "seconds": r["seconds"], "photons": r["photons"]}
            rows.append(row)
            log(f"slab tau {case['tau']} albedo {case['albedo']} g {case['g']} n {case['n']} {incidence}")
    return rows


def layered(slab, cases, log):
    """Layers, and shells over a core."""
    rows = []
    for case in cases:
        core = case["n"] == 1
        shell = case["layers"][:-1] if core else case["layers"]
        words = ["--ior", case["n"]]
        for key in ("tau", "albedo", "g"):
            words += [f"--{key}", ",".join(str(layer[key]) for layer in shell)]
        if core:
            words += ["--core-albedo", case["layers"][-1]["albedo"], "--core-g", case["layers"][-1]["g"]]
        for incidence in ("normal", "diffuse"):
            row = {"name": case["name"], "incidence": incidence}
            for method in ("walk", *FORMS):
                run = slab.walk if method == "walk" else lambda *w, form=method: slab.table(form, *w)
                r = run(*words, "--incidence", incidence)
                row[method] = {"R": deviation(r["R"], case[f"R_total_{incidence}"]),
                               "T": deviation(r["T"], case[f"T_total_{incidence}"]), "seconds": r["seconds"]}
            rows.append(row)
            log(f"layers {case['name']} {incidence}")
    return rows


def profiles(slab, cases, log):
    """Fluence by depth: root mean square of the deviations, in percent and in standard errors."""
    rows = []
    for case in cases:
        depths = ",".join(str(r["depth"]) for r in case["rows"])
        words = [*slab_words(case["tau"], case["albedo"], case["g"], case["n"], "normal"), "--profile", depths]
        for method in ("walk", "dE1") if case["g"] == 0 else ("walk",):
            r = slab.walk(*words) if method == "walk" else slab.table(method, *words)
            row = {"tau": case["tau"], "albedo": case["albedo"], "g": case["g"], "method": method,
                   "seconds": r["seconds"]}
            # On the faces light along them weighs much: they say little of a profile.
            pairs = list(zip(r["profile"], case["rows"]))[1:-1]
            for name in ("I_m", "I_b"):
                percent = [100 * (p[name] / e[name] - 1) for p, e in pairs]
                sigmas = [(p[name] - e[name]) / max(p[f"stderr_{name}"], 1e-9) for p, e in pairs]
                row[name] = {"percent": (sum(x * x for x in percent) / len(percent))**0.5,
                             "sigmas": (sum(x * x for x in sigmas) / len(sigmas))**0.5}
            rows.append(row)
        log(f"profile tau {case['tau']} albedo {case['albedo']} g {case['g']}")
    return rows


def forms_over_g(slab, quick, log):
    """Errors of R by both forms over g and optical depth, against walks in the true medium."""
    rows = []
    for tau in (2, 10):
        for g in (0, 0.5, 0.8, 0.9) if quick else (-0.5, 0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95):
            words = slab_words(tau, 0.99, g, 1, "normal")
            exact = slab.walk(*words)["R"]
            row = {"tau": tau, "g": g, "R": exact["total"], "stderr": exact["stderr"]}
            for form in FORMS:
                row[form] = deviation(slab.table(form, *words)["R"], exact["total"], exact["stderr"])
            rows.append(row)
            log(f"forms tau {tau} g {g}")
    return rows


def quality(slab, case, quick, log):
    """Error of R over the quality asked for; isotropic, so that only the table's errors are left."""
    rows = []
    words = slab_words(case["tau"], case["albedo"], case["g"], case["n"], "normal")
    for asked in (0.2, 0.1, 0.05) if quick else (0.2, 0.1, 0.05, 0.02, 0.01, 0.005):
        r = slab.table("dE1", *words, quality=asked, photons=400000)
        rows.append({"quality": asked, "R": deviation(r["R"], case["normal"]["R_total"]), "seconds": r["seconds"]})
        log(f"quality {asked}")
    return rows
