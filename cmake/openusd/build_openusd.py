#!/usr/bin/env python3
"""Build OpenUSD 20.08 with Hydra from package registries, once, into a cache folder.

No package index carries an OpenUSD with headers and Hydra, but the cargo package ``usd-cpp`` holds the whole source of
release 20.08 and the Python wheels ``tbb`` and ``tbb-devel`` hold the classic TBB it needs. This script fetches both,
drops what a headless Hydra host does not use, compiles the rest in unity batches (``unity.cmake`` says how) and
installs it into ``<cache>/openusd-20.08-<key>``; the key covers the recipe and the compiler. The cache folder is
``$HDSTF_CACHE_DIR``, else ``$XDG_CACHE_HOME/hdstf``, else ``~/.cache/hdstf``.

With ``--usdview`` it builds the same release once more, with the Python modules, GL, ``usdview`` and ``usdrecord``
(``unity_usdview.cmake``), into ``<cache>/openusd-20.08-usdview-<key>``.

The last line of output is the prefix. A run that was killed goes on where it stopped, runs at the same time wait for
each other, and a run that finds the finished prefix returns at once. Python 3.7 or later, standard library only.
"""

import argparse
import fcntl
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent

# Everything that decides what comes out. It is hashed, so a change here (or in unity.cmake) makes a new prefix, while
# a change to the code below does not throw away anybody's build.
RECIPE = {
    "version": "20.08",
    "crate": {
        "name": "usd-cpp",
        "version": "0.1.1",
        "sha256": "1f3194acfd59968ff88c03f6552196c74a7ade9e4f5582b00fae3a14e4ce4519",
    },
    # Exactly these: the absolute path of this TBB ends up in the installed targets and in every RUNPATH.
    "wheels": {
        "tbb==2020.0.133": "0e7b232098cc9a7bf86b08beb21ecbc5be2ba21d2e6f0d1ac6d2917e614335dc",
        "tbb-devel==2020.0.133": "1761afdd946982cfab1ca5bd3a3cb4ad4e9fbf8623aef58e108d04c55d842298",
    },
    # Lines taken out of CMakeLists.txt files: GPU libraries, and schemas and tools nothing here links.
    "drop": {
        "CMakeLists.txt": ["add_subdirectory(extras)"],
        "pxr/imaging/CMakeLists.txt": ["garch", "glf", "hgi", "hgiGL", "hgiMetal", "hgiInterop", "hdSt", "hdx", "plugin"],
        "pxr/usd/CMakeLists.txt": ["usdMedia", "usdRi", "usdSkel", "usdUI", "usdUtils", "plugin"],
        "pxr/usdImaging/CMakeLists.txt": ["usdImagingGL", "usdRiImaging", "usdSkelImaging", "usdAppUtils", "usdviewq", "bin"],
    },
    # (file, old, new)
    "replace": [
        # This header refuses to be seen twice by one translation unit; a unity batch only needs it once.
        ("pxr/base/tf/instantiateSingleton.h", "#ifdef PXR_BASE_TF_INSTANTIATE_SINGLETON_H",
         "#pragma once\n#ifdef PXR_BASE_TF_INSTANTIATE_SINGLETON_H"),
        # Quotes in the middle of arguments: paths with spaces would fail.
        ("cmake/macros/Private.cmake", '-Dinfile="${infile}" -Doutfile="${outfile}"',
         '"-Dinfile=${infile}" "-Doutfile=${outfile}"'),
        ("cmake/macros/copyHeaderForBuild.cmake", "file(TO_NATIVE_PATH  ${infile} INFILE)", 'set(INFILE "${infile}")'),
        ("cmake/macros/copyHeaderForBuild.cmake", "file(TO_NATIVE_PATH  ${outfile} OUTFILE)", 'set(OUTFILE "${outfile}")'),
        ("cmake/macros/copyHeaderForBuild.cmake", "#line 1 ${infile}", '#line 1 \\"${infile}\\"'),
    ],
    "options": {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_CXX_FLAGS_RELEASE": "-O2 -DNDEBUG",
        # The two headers mend arch/demangle.cpp under gcc 11 and later.
        "CMAKE_CXX_FLAGS": "-w -include cxxabi.h -include typeinfo -DTBB_SUPPRESS_DEPRECATED_MESSAGES=1",
        "CMAKE_INSTALL_LIBDIR": "lib",
        # Without this, configuring would enter the build folder in the user's package registry (~/.cmake/packages).
        "CMAKE_EXPORT_NO_PACKAGE_REGISTRY": "ON",
        "Boost_NO_BOOST_CMAKE": "ON",
        "PXR_ENABLE_PYTHON_SUPPORT": "OFF",
        "PXR_ENABLE_GL_SUPPORT": "OFF",
        "PXR_ENABLE_PTEX_SUPPORT": "OFF",
        "PXR_ENABLE_HDF5_SUPPORT": "OFF",
        "PXR_ENABLE_PRECOMPILED_HEADERS": "OFF",
        "PXR_BUILD_USDVIEW": "OFF",
        "PXR_BUILD_USD_TOOLS": "OFF",
        "PXR_BUILD_TESTS": "OFF",
        "PXR_BUILD_EXAMPLES": "OFF",
        "PXR_BUILD_TUTORIALS": "OFF",
    },
}

# The same release with usdview: what differs from RECIPE. "drop" replaces, the others add.
USDVIEW = {
    "drop": {
        "CMakeLists.txt": ["add_subdirectory(extras)"],
        "pxr/usd/CMakeLists.txt": ["usdMedia", "usdRi", "usdSkel", "usdUI", "plugin"],
        "pxr/usdImaging/CMakeLists.txt": ["usdRiImaging", "usdSkelImaging"],
        # Not in the crate: the texture of Storm's own dome light, and Python files of tests.
        "pxr/imaging/hdx/CMakeLists.txt": ["textures/StinsonBeach.exr"],
        "pxr/base/tf/CMakeLists.txt": ["testenv/__init__.py"] + [
            f"testenv/testTfScriptModuleLoader_{name}.py"
            for name in ("AAA_RaisesError", "DepLoadsAll", "LoadsAll", "LoadsUnknown", "Other", "Test", "Unknown")],
    },
    "replace": [
        # Today's pyside2-uic is Qt's own uic.
        ("cmake/macros/Private.cmake", "ARGS -o ${outFilePath}", "ARGS -g python -o ${outFilePath}"),
        # Frames are opaque from Python 3.11 on; the function is there from 3.9 on.
        ("pxr/base/tf/pyTracing.cpp", "frame->f_code->co_name", "PyFrame_GetCode(frame)->co_name"),
        ("pxr/base/tf/pyTracing.cpp", "frame->f_code->co_filename", "PyFrame_GetCode(frame)->co_filename"),
        ("pxr/base/tf/pyTracing.cpp", "frame->f_code->co_firstlineno", "PyFrame_GetCode(frame)->co_firstlineno"),
        # Mesa's compiler holds shaders of this version without the word to the core profile, which has no gl_FragColor.
        *((f"pxr/imaging/hdx/shaders/{file}.glslfx", f"-- glsl {shader}\n{line}#version 450",
           f"-- glsl {shader}\n{line}#version 450 compatibility")
          for file, shader, line in (("fullscreen", "Composite.FragmentNoDepth", "\n"),
                                     ("fullscreen", "Composite.FragmentWithDepth", "\n"),
                                     ("outline", "Outline.Fragment", ""))),
        # That texture is not in the crate; without it Storm's own dome light is plain.
        ("pxr/imaging/hdx/package.cpp", 'TF_VERIFY(!path.empty(), "Could not find texture: %s\\n", texture);', ""),
        # Nor are usdview's icons.
        ("pxr/usdImaging/usdviewq/CMakeLists.txt",
         "install(DIRECTORY\n    icons\n    DESTINATION lib/python/pxr/Usdviewq\n)", ""),
    ],
    "options": {
        "CMAKE_CXX_FLAGS_RELEASE": "-O1 -DNDEBUG",
        # unity_usdview.cmake adds what RECIPE includes here.
        "CMAKE_CXX_FLAGS": "-w -DTBB_SUPPRESS_DEPRECATED_MESSAGES=1",
        "PXR_ENABLE_PYTHON_SUPPORT": "ON",
        "PXR_USE_PYTHON_3": "ON",
        "PXR_ENABLE_GL_SUPPORT": "ON",
        "PXR_BUILD_USDVIEW": "ON",
    },
}

# For each of a Python's modules that usdview imports, and each header, the Debian package that has it.
USDVIEW_MODULES = {
    "PySide2.QtOpenGL": "python3-pyside2.qtopengl",
    "PySide2.QtWidgets": "python3-pyside2.qtwidgets",
    "OpenGL.GL": "python3-opengl",
}
USDVIEW_HEADERS = {
    "boost/python.hpp": "libboost-python-dev",
    "GL/glew.h": "libglew-dev",
    "GL/gl.h": "libgl-dev",
    "X11/Xlib.h": "libx11-dev",
}

MARKER = "hdstf-complete.json"

# How long a batch of a library takes, roughly, in units of the small ones: only for the time that is left.
BATCH_COST = {"usd": 7, "sdf": 5, "usdImaging": 5, "pcp": 3, "usdGeom": 3, "hd": 2}


class BuildError(Exception):
    """A failure with a message that says what to do about it."""


def say(text):
    """Print at once: CMake and CI logs read this through a pipe."""
    print("[openusd] " + text, flush=True)


def clock(seconds):
    """Seconds as people read them: 4.2 s, 3:07 min."""
    return f"{seconds:.1f} s" if seconds < 60 else f"{int(seconds) // 60}:{int(seconds) % 60:02d} min"


class Step:
    """A named step of the build, printed with the time it took."""

    def __init__(self, name):
        self.name = name

    def __enter__(self):
        self.start = time.monotonic()
        return self

    def __exit__(self, kind, value, trace):
        took = clock(time.monotonic() - self.start)
        say(f"{self.name}: {took}" if kind is None else f"{self.name}: failed after {took}")


def cache_folder():
    """The folder for everything hdStf keeps between builds."""
    own, xdg = os.environ.get("HDSTF_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME")
    return Path(os.path.abspath(own or (os.path.join(xdg, "hdstf") if xdg else os.path.expanduser("~/.cache/hdstf"))))


def output_of(command, **more):
    """Standard output of a command, or None where it cannot be run or fails."""
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              universal_newlines=True, **more)
    except OSError:
        return None
    return done.stdout if done.returncode == 0 else None


def find_compiler(wanted):
    """Path of the C++ compiler and a text that names it and its version."""
    for name in [wanted] if wanted else [os.environ.get("CXX"), "c++", "g++", "clang++"]:
        path = name and shutil.which(name)
        if not path:
            continue
        version = output_of([path, "-dumpfullversion", "-dumpversion"])
        machine = output_of([path, "-dumpmachine"])
        if version and machine:
            family = "clang" if "clang" in (output_of([path, "--version"]) or "") else "gcc"
            return path, f"{family} {version.strip()} {machine.strip()}"
    raise BuildError(f"no C++ compiler{' ' + wanted if wanted else ''} found: install the Debian package build-essential")


class Flavour:
    """One of the two builds: what it is made of, and where it belongs."""

    def __init__(self, compiler_version):
        self.recipe, self.tuning, self.python = RECIPE, ["unity.cmake"], None
        self.prefix = self._prefix("", compiler_version)

    def _prefix(self, name, *more):
        """The cache folder whose name covers all that decides its content."""
        tuning = "".join(line for file in self.tuning for line in (HERE / file).read_text().splitlines(True)
                         if not line.lstrip().startswith("#"))
        key = hashlib.sha256(json.dumps([self.recipe, tuning, *more], sort_keys=True).encode()).hexdigest()[:12]
        return cache_folder() / f"openusd-{RECIPE['version']}-{name}{key}"

    def check_prerequisites(self):
        """Fail early, with the package's name, on anything the build would miss after minutes."""
        check_prerequisites({"boost/version.hpp": "libboost-dev", "opensubdiv/version.h": "libosd-dev"})

    def options(self):
        """Options for CMake that depend on this machine."""
        return {}

    def check(self, prefix, log):
        """What the check of the installed libraries does not cover."""


class UsdviewFlavour(Flavour):
    """With Python, GL, usdview and usdrecord."""

    def __init__(self, compiler_version):
        self.recipe = dict(RECIPE, drop=USDVIEW["drop"], replace=RECIPE["replace"] + USDVIEW["replace"],
                           options=dict(RECIPE["options"], **USDVIEW["options"]))
        self.tuning = ["unity.cmake", "unity_usdview.cmake"]
        self.python, version = find_usdview_python()
        self.prefix = self._prefix("usdview-", compiler_version, self.python, version)

    def check_prerequisites(self):
        check_prerequisites(dict(USDVIEW_HEADERS, **{"opensubdiv/version.h": "libosd-dev"}))
        need_tool("uic", "qtbase5-dev-tools")
        for module, package in USDVIEW_MODULES.items():
            if output_of([self.python, "-c", f"import {module}"]) is None:
                raise BuildError(f"{self.python} has no module {module}: install the Debian package {package}")
        if not all(os.path.exists(path) for path in self._python_files()):
            raise BuildError(f"{self.python} has no header files: install the Debian package python3-dev")

    def _python_files(self):
        """Include folder and library of this Python; CMake by itself might find those of another."""
        code = ("import os, sysconfig as s; v = s.get_config_var; "
                "print(s.get_path('include'), os.path.join(v('LIBDIR'), v('LDLIBRARY')), sep='\\n')")
        return (output_of([self.python, "-c", code]) or "").splitlines()

    def options(self):
        include, library = self._python_files()
        return {"PYTHON_EXECUTABLE": self.python, "PYTHON_INCLUDE_DIR": include, "PYTHON_LIBRARY": library,
                "PYSIDEUICBINARY": need_tool("uic", "qtbase5-dev-tools")}

    def check(self, prefix, log):
        environment = dict(os.environ, PYTHONPATH=str(prefix / "lib" / "python"), QT_QPA_PLATFORM="offscreen")
        run_logged([self.python, "-c", "from pxr import UsdAppUtils, UsdImagingGL, UsdLux, UsdVol, Usdviewq"], log,
                   "importing usdview's modules", env=environment)


def find_usdview_python():
    """Path and version of a Python that Debian's PySide2 and boost.python are for."""
    for name in ("/usr/bin/python3", "python3"):
        path = shutil.which(name)
        version = path and output_of([path, "-c", "import PySide2, sys; print(sys.version)"])
        if version:
            return path, version.strip()
    raise BuildError("no Python with PySide2: install the Debian packages "
                     + " ".join(sorted(set(USDVIEW_MODULES.values()))))


def is_complete(prefix):
    """Whether a finished build lies in prefix, and was made there: its paths are absolute, it cannot be moved."""
    try:
        return json.loads((prefix / MARKER).read_text())["prefix"] == str(prefix)
    except (OSError, ValueError, KeyError, TypeError):
        return False


def need_tool(name, package):
    """Path of a program, or a message naming the Debian package that has it."""
    path = shutil.which(name)
    if not path:
        raise BuildError(f"{name} is missing: install the Debian package {package}")
    return path


def need_cargo():
    """A cargo that reads today's registries (1.70 or later; Debian 12's plain ``cargo`` is older)."""
    hint = "install the Debian package cargo-web (or a Rust toolchain by rustup)"
    version = re.search(r"cargo (\d+)\.(\d+)", output_of(["cargo", "--version"]) or "")
    if not version:
        raise BuildError(f"cargo is missing or has no toolchain: {hint}")
    if (int(version.group(1)), int(version.group(2))) < (1, 70):
        raise BuildError(f"{version.group(0)} is too old, 1.70 or later is needed: {hint}")
    return "cargo"


def need_pip():
    """A Python that has pip: this one, or the system's."""
    for python in (sys.executable, "python3", "/usr/bin/python3"):
        if python and output_of([python, "-m", "pip", "--version"]):
            return python
    raise BuildError("Python has no pip: install the Debian package python3-pip")


def check_prerequisites(headers):
    """Fail early on missing tools and headers; headers maps each to its Debian package."""
    if not (sys.platform.startswith("linux") and os.uname().machine == "x86_64"):
        raise BuildError("this build is for Linux on x86_64 (there is no other wheel of the classic TBB): "
                         "build OpenUSD yourself and give its prefix as -DPXR_ROOT=<prefix>")
    need_tool("cmake", "cmake")
    need_tool("ninja", "ninja-build")
    need_cargo()
    need_pip()
    for header, package in headers.items():
        if not any((Path(root) / header).is_file() for root in ("/usr/include", "/usr/local/include")):
            raise BuildError(f"{header} is missing: install the Debian package {package}")


def run_logged(command, log, what, tries=1, **more):
    """Run a command with its output in the log; what it printed last is shown if it fails."""
    for attempt in range(1, tries + 1):
        with open(log, "ab") as out:
            out.write(("\n$ " + " ".join(map(str, command)) + "\n").encode())
            out.flush()
            start = out.tell()
            code = subprocess.call([str(c) for c in command], stdin=subprocess.DEVNULL, stdout=out,
                                   stderr=subprocess.STDOUT, **more)
        if code == 0:
            return
        if attempt < tries:
            say(f"{what} failed, trying again")
            time.sleep(5 * attempt)
    with open(log, "rb") as text:
        text.seek(start)
        tail = text.read().decode(errors="replace").strip().splitlines()[-25:]
    raise BuildError(f"{what} failed (exit code {code}):\n  " + "\n  ".join(tail) + f"\nThe whole log: {log}")


def fetch_source(work, log):
    """Let cargo bring the crate and return the folder of OpenUSD's source in cargo's registry."""
    crate = RECIPE["crate"]
    project = work / "crate"
    (project / "src").mkdir(parents=True, exist_ok=True)
    (project / "src" / "lib.rs").write_text("")
    (project / "Cargo.toml").write_text(
        '[package]\nname = "fetch-openusd"\nversion = "0.1.0"\nedition = "2018"\n\n'
        f'[dependencies]\n{crate["name"]} = "={crate["version"]}"\n\n[workspace]\n')
    run_logged(["cargo", "fetch"], log, f"fetching the cargo package {crate['name']}", tries=3, cwd=project)
    # cargo has checked the download against the lock file; this checks the lock file against the recipe.
    if f'checksum = "{crate["sha256"]}"' not in (project / "Cargo.lock").read_text():
        raise BuildError(f"the cargo package {crate['name']} {crate['version']} is not the one this recipe was made for "
                         f"(checksum differs, see {project / 'Cargo.lock'})")
    listing = output_of(["cargo", "metadata", "--format-version", "1", "--offline"], cwd=project)
    for package in json.loads(listing)["packages"] if listing else []:
        source = Path(package["manifest_path"]).parent / "thirdparty" / "USD"
        if package["name"] == crate["name"] and (source / "CMakeLists.txt").is_file():
            return source
    raise BuildError(f"cargo fetched {crate['name']} but its source was not found")


def fetch_tbb(work, target, log):
    """Unpack headers and the two release libraries of classic TBB into target, its final place."""
    wheels = work / "wheels"
    wheels.mkdir(exist_ok=True)
    wanted = work / "wheels.txt"
    wanted.write_text("".join(f"{name} --hash=sha256:{sha}\n" for name, sha in RECIPE["wheels"].items()))
    run_logged([need_pip(), "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps",
                "--only-binary=:all:", "--require-hashes", "--dest", wheels, "-r", wanted],
               log, "downloading the wheels of classic TBB", tries=3)
    for wheel in sorted(wheels.glob("*.whl")):
        if hashlib.sha256(wheel.read_bytes()).hexdigest() not in RECIPE["wheels"].values():
            raise BuildError(f"{wheel} has a wrong checksum: delete it and run again")
        with zipfile.ZipFile(wheel) as archive:
            for name in archive.namelist():
                inside = re.search(r"\.data/data/(include/tbb/.+[^/]|lib/libtbb(?:malloc)?\.so(?:\.2)?)$", name)
                if inside:
                    path = target / inside.group(1)
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.write_bytes(archive.read(name))
    # The wheel's libtbb.so is a linker script; a link also serves tools that open it as a library.
    for library in ("libtbb", "libtbbmalloc"):
        if not (target / "lib" / f"{library}.so.2").is_file():
            raise BuildError(f"the wheels hold no {library}.so.2")
        plain = target / "lib" / f"{library}.so"
        if plain.exists() or plain.is_symlink():
            plain.unlink()
        plain.symlink_to(f"{library}.so.2")


def copy_source(source, target, recipe):
    """Copy the source and take out of it what is not built."""
    if target.exists():
        shutil.rmtree(target)
    shutil.copytree(source, target)
    for name, lines in recipe["drop"].items():
        path = target / name
        text = path.read_text().splitlines(True)
        kept = [line for line in text if line.strip() not in lines]
        if len(text) - len(kept) != len(lines):
            raise BuildError(f"{name} is not as expected: cannot drop {', '.join(lines)}")
        path.write_text("".join(kept))
    for name, old, new in recipe["replace"]:
        path = target / name
        text = path.read_text()
        if text.count(old) != 1:
            raise BuildError(f"{name} is not as expected: cannot replace {old}")
        path.write_text(text.replace(old, new))


def job_count():
    """Compilers at a time: a processor and about 1.2 GB of free memory for each."""
    asked = os.environ.get("HDSTF_JOBS")
    if asked and asked.isdigit() and int(asked) > 0:
        return int(asked)
    jobs = len(os.sched_getaffinity(0))
    try:
        free = re.search(r"MemAvailable:\s+(\d+) kB", Path("/proc/meminfo").read_text())
        jobs = min(jobs, int(free.group(1)) // 1200000)
    except (OSError, AttributeError):
        pass
    return max(jobs, 1)


def compile_errors(log_text):
    """The lines of a compiler log that say what went wrong."""
    lines = log_text.splitlines()
    start = max((i for i, line in enumerate(lines) if line.startswith("FAILED:")), default=max(0, len(lines) - 25))
    after = lines[start:]
    errors = [line for line in after if re.search(r"\berror\b|undefined reference|Killed|No space left", line)]
    return "\n  ".join([after[0]] + (errors or after[1:])[:20]) if after else ""


def compile_cost(line):
    """What a line of ninja's output counts for in the progress: nothing, unless it is the compilation of a batch."""
    batch = re.search(r"Building CXX object .*?([^/]+)/CMakeFiles/", line)
    return BATCH_COST.get(batch.group(1), 1) if batch else 0


def compile_all(build, log, lock):
    """Run ninja with progress: a live line on a terminal, a line every 5 % elsewhere."""
    costs = [compile_cost(line) for line in (output_of(["ninja", "-C", str(build), "-n"]) or "").splitlines()]
    total = max(sum(costs), 1)
    jobs, live, start = job_count(), sys.stdout.isatty() and not os.environ.get("CI"), time.monotonic()
    say(f"compiling {len([c for c in costs if c])} batches, {jobs} at a time (log: {log})")
    done, shown = 0, 0
    with open(log, "ab") as out:
        begin = out.tell()
        # The compilers inherit the lock: if this script is killed, another run waits until they have ended as well.
        ninja = subprocess.Popen(["ninja", "-C", str(build), f"-j{jobs}"], stdin=subprocess.DEVNULL,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, pass_fds=(lock.fileno(),))
        try:
            for raw in ninja.stdout:
                out.write(raw)
                cost = compile_cost(raw.decode(errors="replace"))
                if not cost:
                    continue
                done = min(done + cost, total)
                elapsed = time.monotonic() - start
                percent = 100 * done // total
                text = f"{percent:3d} %  {clock(elapsed)} elapsed, about {clock(elapsed / done * (total - done))} left"
                if live:
                    print(f"\r[openusd] {text}\033[K", end="", flush=True)
                elif percent >= shown + 5 or done == total:
                    shown = percent
                    say(text)
            code = ninja.wait()
        except BaseException:
            ninja.terminate()
            ninja.wait()
            raise
        finally:
            if live and done:
                print(flush=True)
    if code != 0:
        with open(log, "rb") as text:
            text.seek(begin)
            what = compile_errors(text.read().decode(errors="replace"))
        raise BuildError(f"compiling OpenUSD failed (exit code {code}):\n  {what}\nThe whole log: {log}\n"
                         "If memory ran out, set HDSTF_JOBS=1 and run again: what is compiled stays.")


def check(prefix, work, compiler, log):
    """Compile, link and run a small program against the installed libraries."""
    folder = work / "check"
    if folder.exists():
        shutil.rmtree(folder)
    run_logged(["cmake", "-S", HERE / "check", "-B", folder, "-G", "Ninja", f"-Dpxr_DIR={prefix}",
                f"-DCMAKE_CXX_COMPILER={compiler}"], log, "configuring the check")
    run_logged(["cmake", "--build", folder], log, "building the check")
    run_logged([folder / "check"], log, "running the check")


def build(flavour, work, compiler, lock):
    """All steps from nothing to the installed prefix; each is skipped if an earlier run has finished it."""
    log, prefix = work / "build.log", flavour.prefix
    source, folder, tbb = work / "src", work / "build", prefix / "tbb"
    started = time.monotonic()
    flavour.check_prerequisites()
    if prefix.exists() and not work.exists():
        shutil.rmtree(prefix)  # the rest of something else, or of a prefix that was moved
    work.mkdir(parents=True, exist_ok=True)
    prefix.mkdir(parents=True, exist_ok=True)

    def once(name, action):
        stamp = work / f"{name.replace(' ', '-')}.done"
        if not stamp.exists():
            with Step(name):
                action()
            stamp.write_text("")

    once("fetch classic TBB", lambda: fetch_tbb(work, tbb, log))

    def take_source():
        copy_source(fetch_source(work, log), source, flavour.recipe)

    once("fetch source", take_source)

    def configure():
        for name in flavour.tuning:
            shutil.copyfile(HERE / name, work / name)
        options = dict(flavour.recipe["options"], **flavour.options(), CMAKE_CXX_COMPILER=compiler,
                       CMAKE_INSTALL_PREFIX=prefix, TBB_ROOT_DIR=tbb,
                       CMAKE_PROJECT_usd_INCLUDE=work / flavour.tuning[-1])
        run_logged(["cmake", "-S", source, "-B", folder, "-G", "Ninja"] + [f"-D{k}={v}" for k, v in options.items()],
                   log, "configuring OpenUSD")

    once("configure", configure)
    with Step("compile"):
        compile_all(folder, log, lock)
    with Step("install"):
        run_logged(["cmake", "--install", folder], log, "installing OpenUSD")
    with Step("check the installation"):
        check(prefix, work, compiler, log)
        flavour.check(prefix, log)
    seconds = round(time.monotonic() - started, 1)
    partial = prefix / (MARKER + ".part")
    partial.write_text(json.dumps({"prefix": str(prefix), "seconds": seconds}) + "\n")
    partial.replace(prefix / MARKER)
    shutil.rmtree(work)
    say(f"OpenUSD {RECIPE['version']} is built: {clock(seconds)}")


def take_lock(path):
    """Hold an exclusive lock; say so if somebody else has it and wait."""
    lock = open(path, "a+")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        say("another run is building this OpenUSD: waiting for it")
        fcntl.flock(lock, fcntl.LOCK_EX)
    return lock


def main():
    """Parse the command line, build what is missing, print the prefix."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cxx", help="C++ compiler (default: $CXX, c++)")
    parser.add_argument("--usdview", action="store_true", help="with Python, GL, usdview and usdrecord")
    parser.add_argument("--query", action="store_true",
                        help="build nothing: print the prefix; exit code 0 if it is complete, 3 if not")
    args = parser.parse_args()
    # Being told to end is an interruption like Ctrl-C: ninja is ended in good order.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.default_int_handler)
    os.environ["LC_ALL"] = "C.UTF-8"
    # Somebody else's flags, prefixes or TBB must not get into the build; the key would not know of them.
    for name in ("CXXFLAGS", "CPPFLAGS", "LDFLAGS", "CPATH", "CPLUS_INCLUDE_PATH", "CMAKE_PREFIX_PATH",
                 "CMAKE_GENERATOR", "CMAKE_BUILD_TYPE", "TBB_INSTALL_DIR", "TBBROOT", "DESTDIR", "NINJA_STATUS"):
        os.environ.pop(name, None)
    try:
        compiler, version = find_compiler(args.cxx)
        flavour = (UsdviewFlavour if args.usdview else Flavour)(version)
        prefix = flavour.prefix
        if args.query:
            print(prefix)
            return 0 if is_complete(prefix) else 3
        if not is_complete(prefix):
            prefix.parent.mkdir(parents=True, exist_ok=True)
            with take_lock(f"{prefix}.lock") as lock:
                if not is_complete(prefix):
                    say(f"building OpenUSD {RECIPE['version']} with {version}, once, in {prefix}")
                    build(flavour, Path(f"{prefix}.work"), compiler, lock)
        print(prefix)
        return 0
    except BuildError as error:
        print(f"[openusd] error: {error}", file=sys.stderr, flush=True)
    except OSError as error:
        print(f"[openusd] error: {error}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("[openusd] interrupted: the next run goes on from here", file=sys.stderr, flush=True)
        return 130
    return 1


if __name__ == "__main__":
    sys.exit(main())
