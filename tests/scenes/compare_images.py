#!/usr/bin/env python3
"""Compares two EXR images by numbers that mean the same for every scene, and shows where they differ.

    compare_images.py IMAGE.exr REFERENCE.exr [--tolerance 0.05] [--diff DIFF.png]
"""

import argparse
import json
import struct
import zlib

import numpy as np
import OpenEXR

# The colour layer may be the unnamed one or carry the AOV's name.
COLOUR = [("R", "G", "B"), ("color.R", "color.G", "color.B"), ("color.r", "color.g", "color.b")]


def read_rgb(path):
    """The colour of an EXR: height x width x 3, float64."""
    with OpenEXR.File(str(path), separate_channels=True) as image:
        for part in image.parts:
            for names in COLOUR:
                if all(name in part.channels for name in names):
                    planes = [np.asarray(part.channels[name].pixels, dtype=np.float64) for name in names]
                    return np.stack(planes, axis=2)
        found = [name for part in image.parts for name in part.channels]
    raise ValueError(f"{path}: no colour channels among {found}")


def write_rgb_half(path, pixels):
    """Writes the colour as 16-bit floats, compressed: small enough to be stored with the sources."""
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": np.ascontiguousarray(pixels, dtype=np.float16)}) as image:
        image.write(str(path))


def compare(image, reference, tolerance):
    """Numbers on the difference of two images of equal size.

    rmse: root mean square error over the mean of the reference. mean: relative difference of the means, which tells a
    bias from noise. outliers: per cent of pixels whose worst channel is off by more than `tolerance`, relative to the
    pixel plus the image's mean (so that dark pixels do not count more than they show).
    """
    if image.shape != reference.shape:
        raise ValueError(f"sizes differ: {image.shape[1::-1]} and {reference.shape[1::-1]}")
    if not np.all(np.isfinite(image)):
        raise ValueError(f"{np.count_nonzero(~np.isfinite(image))} values are not finite")
    scale = max(reference.mean(), 1e-6)
    difference = image - reference
    relative = np.max(np.abs(difference) / (np.abs(reference) + scale), axis=2)
    return {
        "rmse": float(np.sqrt(np.mean(difference**2)) / scale),
        "mean": float(difference.mean() / scale),
        "outliers": float(100 * np.mean(relative > tolerance)),
        "worst": float(relative.max()),
    }


def to_display(linear):
    """sRGB bytes of linear values."""
    linear = np.clip(np.nan_to_num(linear), 0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(255 * encoded).astype(np.uint8)


def write_png(path, pixels):
    """Writes height x width x 3 bytes."""
    height, width, _ = pixels.shape

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        file.write(chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)))
        file.write(chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_difference(path, image, reference):
    """Image, reference and their difference (five times, grey where equal) side by side."""
    scale = 1 / max(np.percentile(reference, 99), 1e-6)
    panels = [image * scale, reference * scale]
    if image.shape == reference.shape:
        panels.append(0.2 + 5 * scale * (image - reference))
    height = max(panel.shape[0] for panel in panels)
    panels = [np.pad(panel, ((0, height - panel.shape[0]), (0, 0), (0, 0))) for panel in panels]
    write_png(path, to_display(np.concatenate(panels, axis=1)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("image")
    parser.add_argument("reference")
    parser.add_argument("--tolerance", type=float, default=0.05)
    parser.add_argument("--diff", help="PNG: image, reference, difference")
    arguments = parser.parse_args()
    image, reference = read_rgb(arguments.image), read_rgb(arguments.reference)
    if arguments.diff:
        write_difference(arguments.diff, image, reference)
    print(json.dumps(compare(image, reference, arguments.tolerance), indent=2))


if __name__ == "__main__":
    main()
