#!/usr/bin/env python3
"""Show the colour of an EXR as an 8-bit sRGB PNG: exr_to_png.py IN.exr OUT.png [EXPOSURE in stops]."""

import struct
import sys
import zlib

import numpy as np
import OpenEXR


def read_colour(path):
    """Height x width x 3 (or 4, with alpha) array of the first part that has colour channels."""
    with OpenEXR.File(path) as image:
        for part in image.parts:
            for name in ("RGBA", "RGB", "color", "color.RGBA", "color.RGB", "C"):
                if name in part.channels and part.channels[name].pixels.ndim == 3:
                    return np.asarray(part.channels[name].pixels, dtype=np.float64)
    raise SystemExit(f"{path}: no colour channels, only {', '.join(n for p in image.parts for n in p.channels)}")


def to_srgb(linear):
    """sRGB transfer curve, clipped to 0..1; a pixel that is not a number becomes black."""
    linear = np.clip(np.nan_to_num(linear, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def write_png(path, pixels):
    """Write an 8-bit height x width x 3 array."""
    height, width, _ = pixels.shape

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                  + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def main():
    """Read, expose, encode, write."""
    if len(sys.argv) not in (3, 4):
        raise SystemExit(__doc__)
    exposure = float(sys.argv[3]) if len(sys.argv) == 4 else 0.0
    colour = read_colour(sys.argv[1])[:, :, :3] * 2.0 ** exposure
    write_png(sys.argv[2], np.round(to_srgb(colour) * 255).astype(np.uint8))


if __name__ == "__main__":
    main()
