#!/usr/bin/env python3
"""Headers of an OpenUSD that another program brings along as one library, from OpenUSD's source tree of the same version.

    openusd_headers.py --source OPENUSD --library libusd_ms.so --output FOLDER

A source tree has everything but two headers that are made when OpenUSD is built: pxr/pxr.h, with the version, which is the
tree's, and with the namespace and the support of Python, which are read from the library; and from 25.08 on
pxr/base/work/impl.h, which says what runs threads: TBB, as in every build that says nothing else. Nothing is built. FOLDER is for
HDSTF_OPENUSD_HEADERS (docs/hosts.md). Exits with 1 and a sentence where the tree and the library do not fit.
"""

import argparse
import pathlib
import re
import shutil
import sys


def version_of(source):
    """Major, minor and patch version of the source tree."""
    path = source / "cmake" / "defaults" / "Version.cmake"
    found = dict(re.findall(r'set\(PXR_(\w+)_VERSION "(\d+)"\)', path.read_text()))
    return int(found["MAJOR"]), int(found["MINOR"]), int(found["PATCH"])


def namespace_of(library):
    """The internal namespace, without its ending, and the library's bytes."""
    data = library.read_bytes()
    found = re.search(rb"N\d+(pxr\w+?)__pxrReserved__16HdRenderDelegateE", data)
    if not found:
        raise ValueError(f"{library} has no class HdRenderDelegate: not an OpenUSD with Hydra")
    return found.group(1).decode(), data


def values_of(version, namespace, data):
    """What the headers that are made ask for. How fast or safe the library was built changes nothing that its users see."""
    major, minor, patch = version
    return {
        "PXR_MAJOR_VERSION": major, "PXR_MINOR_VERSION": minor, "PXR_PATCH_VERSION": patch,
        "PXR_VERSION": 10000 * major + 100 * minor + patch,
        "PXR_USE_NAMESPACES": 1, "PXR_EXTERNAL_NAMESPACE": "pxr", "PXR_INTERNAL_NAMESPACE": namespace,
        "PXR_PYTHON_SUPPORT_ENABLED": int(b"TfPyObjWrapper" in data),
        "PXR_USE_INTERNAL_BOOST_PYTHON": int(b"9pxr_boost6python" in data),
        "PXR_PREFER_SAFETY_OVER_SPEED": 1, "PXR_ARCH_PREFER_TSC_TIMING": 0,
        "AR_VERSION": 2 if version >= (0, 21, 11) else 1,
        "PXR_WORK_IMPL_HEADER": '"pxr/base/work/workTBB/impl.h"',
    }


def filled(template, values):
    """The text of a header that is made from a template."""
    text = template.read_text()
    for name, value in values.items():
        text = text.replace(f"@{name}@", str(value))
    left = re.search(r"@\w+@", text)
    if left:
        raise ValueError(f"{template} asks for {left.group()}, which this script does not know")
    return text


def main():
    """Copies the headers and writes pxr.h last, so that a folder without it is one that was not finished."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("source", "library", "output"):
        parser.add_argument("--" + name, required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    try:
        version = version_of(arguments.source)
        namespace, data = namespace_of(arguments.library)
        # A namespace that ends with a version ends with the library's: _v0_24, _v25_02.
        said = re.search(r"_v(\d+)_(\d+)$", namespace)
        wrong = said and int(said[1]) and (int(said[1]), int(said[2])) != version[1:]
        wrong = wrong or (said and not int(said[1]) and int(said[2]) != version[1])
        if wrong:
            raise ValueError(f"{arguments.source} is OpenUSD {version[1]}.{version[2]:02d}, but the library's namespace "
                             f"is {namespace}")
        values = values_of(version, namespace, data)
        text = filled(arguments.source / "pxr" / "pxr.h.in", values)
        count = 0
        for path in sorted((arguments.source / "pxr").rglob("*")):
            target = arguments.output / path.relative_to(arguments.source)
            made = path.name.endswith(".h.in") and path.name != "pxr.h.in"
            if not made and path.suffix not in (".h", ".hpp", ".ipp"):
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            if made:
                target.with_suffix("").write_text(filled(path, values))
            else:
                shutil.copyfile(path, target)
            count += 1
        (arguments.output / "pxr" / "pxr.h").write_text(text)
    except (OSError, KeyError, ValueError) as error:
        sys.exit(f"openusd_headers.py: {error}")
    print(f"{count} headers of OpenUSD {version[1]}.{version[2]:02d}, namespace {namespace}: {arguments.output}")


if __name__ == "__main__":
    main()
