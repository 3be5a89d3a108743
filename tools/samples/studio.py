"""The light of the pictures of samples: a lat-long image of soft boxes in a dark room, as EXR."""

import numpy as np
import OpenEXR

WIDTH, HEIGHT = 256, 128
# Direction (y up, the camera looks along -z), half width and height in degrees, radiance, colour.
BOXES = (
    ((-0.78, 0.62, 0.38), 18, 24, 8.0, (1.0, 0.95, 0.87)),  # key, from the left
    ((0.80, 0.42, -0.72), 12, 28, 11.0, (0.88, 0.94, 1.0)),  # rim, from behind on the right
    ((0.10, 1.00, -0.15), 24, 24, 1.8, (1.0, 1.0, 1.0)),  # top
)
ROOM = 0.05


def edge(degrees, half, width):
    """1 inside of `half`, falling to 0 within `width` degrees about it."""
    t = np.clip((half - np.abs(degrees)) / width + 0.5, 0, 1)
    return t * t * (3 - 2 * t)


def image(soft):
    """`soft`: edges so wide that no mirror image of a box shows. Linear rgb, rows from the zenith down; the middle column is +z for OpenUSD's lat-long domes, columns go to -x."""
    v, u = np.meshgrid((np.arange(HEIGHT) + 0.5) / HEIGHT, (np.arange(WIDTH) + 0.5) / WIDTH, indexing="ij")
    polar, turn = np.pi * v, 2 * np.pi * (u - 0.5)
    direction = np.stack([-np.sin(polar) * np.sin(turn), np.cos(polar), np.sin(polar) * np.cos(turn)], axis=-1)
    # A little lighter above than below.
    result = ROOM * (0.6 + 0.4 * direction[..., 1:2]) * np.ones(3)
    for toward, half_width, half_height, radiance, color in BOXES:
        front = np.array(toward) / np.linalg.norm(toward)
        right = np.cross((0, 1, 0) if abs(front[1]) < 0.95 else (0, 0, 1), front)
        right /= np.linalg.norm(right)
        up = np.cross(front, right)
        ahead = direction @ front
        across = np.degrees(np.arctan2(direction @ right, ahead))
        along = np.degrees(np.arctan2(direction @ up, np.hypot(ahead, direction @ right)))
        width = 70 if soft else 5
        shape = edge(across, half_width, width) * edge(along, half_height, width) * (ahead > 0)
        # As much light as from the sharp box.
        result += shape[..., None] * np.array(color) * radiance * (0.9 if soft else 1.0)
    return result.astype(np.float32)


def write(path, soft=False):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": image(soft)}) as file:
        file.write(str(path))
