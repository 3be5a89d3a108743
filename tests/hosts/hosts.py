"""What the tests of hosts share: starting a program of OpenUSD on a screen in memory, and reading pictures."""

import os
import shutil
import subprocess
import sys

import numpy as np
import OpenEXR

# Of OpenUSD's diagnostics: what a delegate must not cause. "UI implementation": a setting that no panel can show.
COMPLAINTS = ("Coding Error", "Runtime Error", "Traceback", "ERROR", "UI implementation", "Segmentation")


def run(command, usd, plugin, cache, extra, log):
    """Runs a program of the OpenUSD in `usd` where there is no screen; its output goes to `log`, complaints fail."""
    environment = dict(os.environ, PXR_PLUGINPATH_NAME=str(plugin), PYTHONPATH=str(usd / "lib" / "python"),
                       HDSTF_CACHE_DIR=str(cache), HDSTF_STAGE_METERS_PER_UNIT="0.01", LC_ALL="C.UTF-8",
                       PYTHONDONTWRITEBYTECODE="1", **extra)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        environment.pop(name, None)
    screen = ["xvfb-run", "-a", "-s", "-screen 0 1600x1200x24"]
    with open(log, "w") as out:
        code = subprocess.call(screen + [str(part) for part in command], env=environment, stdin=subprocess.DEVNULL,
                               stdout=out, stderr=subprocess.STDOUT)
    lines = log.read_text(errors="replace").splitlines()
    found = [line for line in lines if any(word in line for word in COMPLAINTS)]
    if code != 0 or found:
        sys.exit("\n".join([f"{command[0]}: exit code {code}"] + (found or lines[-30:])))


def stfrecord(program, plugin, cache, scene, image, *options):
    """The same scene by the project's own recorder, as the hosts show it: subdivision level 0, purpose proxy."""
    command = [program, scene, image, "--quiet", "--complexity", "low", "--purposes", "default,proxy", *options]
    environment = dict(os.environ, PXR_PLUGINPATH_NAME=str(plugin), HDSTF_CACHE_DIR=str(cache))
    subprocess.run([str(part) for part in command], check=True, env=environment)


def read_channels(path):
    """Channels of an EXR by name: height x width, float64."""
    with OpenEXR.File(str(path), separate_channels=True) as image:
        return {name: np.asarray(channel.pixels, dtype=np.float64)
                for part in image.parts for name, channel in part.channels.items()}


def read_png(path, usd):
    """A PNG: height x width x 3, 0 to 255. Qt reads it, which every Python with usdview has."""
    code = ("import sys; from PySide2.QtGui import QImage; i = QImage(sys.argv[1]).convertToFormat(QImage.Format_RGBA8888); "
            "sys.stdout.buffer.write(b'%d %d\\n' % (i.width(), i.height()) + bytes(i.constBits()))")
    python = (usd / "bin" / "usdview").read_text().splitlines()[0][2:].split()
    size, raw = subprocess.run(python + ["-c", code, str(path)], check=True, stdout=subprocess.PIPE).stdout.split(b"\n", 1)
    width, height = map(int, size.split())
    return np.frombuffer(raw, dtype=np.uint8).reshape(height, width, 4)[..., :3].astype(np.float64)


def layer(channels, name, suffixes):
    """A layer of an EXR, channels last; the layer `color` may be the unnamed one."""
    for pattern in ([name + ".{}"] if name != "color" else ["{}", "color.{}"]):
        for names in (suffixes, suffixes.lower()):
            if all(pattern.format(s) in channels for s in names):
                return np.stack([channels[pattern.format(s)] for s in names], axis=2)
    raise KeyError(f"no layer {name} among {sorted(channels)}")


def to_srgb(linear):
    """Linear values as the 0 to 255 of a display, not rounded (IEC 61966-2-1)."""
    x = np.clip(linear, 0, 1)
    return 255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1 / 2.4) - 0.055)


def difference(image, expected):
    """How far two pictures of 0 to 255 are apart: mean, and share of the pixels that are off by more than 3."""
    off = np.abs(image - expected)
    return {"mean": round(float(off.mean()), 3), "off": round(float(np.mean(off.max(axis=2) > 3)), 4)}


def smooth(picture, side):
    """Each pixel gives the share `side` to either neighbour along both axes, as a window may on its way to the screen."""
    for axis in (0, 1):
        low, high = (np.take(picture, [end], axis=axis) for end in (0, -1))
        padded = np.concatenate([low, picture, high], axis=axis)
        before, after = (np.take(padded, range(start, start + picture.shape[axis]), axis=axis) for start in (0, 2))
        picture = side * before + (1 - 2 * side) * picture + side * after
    return picture


def fresh(folder):
    """An empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder
