# SPDX-License-Identifier: GPL-3.0-or-later
"""What independent readers find in scan files: run by ``make scan-files`` in an environment of its own.

    python independent.py SOURCES OUT

SOURCES holds unpacked source packages with the files of instruments; further files are written here by
independent packages, and by the writers of the tests for formats of which no file can be had. For each file
OUT gets a copy and an .npz: heights in metres with the bottom row first, NaN where a point is missing, and
the sides in metres; ``cases.json`` says which reader said so and who wrote the file. It imports nothing of the
project but the tests' writers.
"""

import json
import shutil
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.support import more_scan_files, scan_files

SOURCES, OUT = Path(sys.argv[1]), Path(sys.argv[2])
OUT.mkdir(parents=True, exist_ok=True)
CASES = {}
METRES = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "um": 1e-6, "nm": 1e-9, "Å": 1e-10, "pm": 1e-12}


def surface():
    """Without any symmetry, 23 x 31 pixels, with two missing points; top row first, micrometres."""
    y, x = np.mgrid[0:23, 0:31]
    heights = 0.4 + 0.05 * np.sin(0.3 * x + 0.1 * y) + 0.003 * x - 0.002 * y + 0.001 * ((x * y) % 7)
    gaps = heights.copy()
    gaps[3, 5] = gaps[20, 11] = np.nan
    return heights, gaps


def keep(name, path, heights, size, reader, writer, channel=None):
    """A case; heights with the bottom row first."""
    if Path(path) != OUT / name:
        shutil.copyfile(path, OUT / name)
    np.savez(OUT / f"{name}.npz", heights=np.asarray(heights, float), size=np.asarray(size, float))
    CASES[name] = {"reader": reader, "writer": writer, "channel": channel}


def by_surface_topography(path, number=None):
    """Heights and sides of SurfaceTopography, whose first index is x and whose rows begin at the top."""
    from SurfaceTopography.IO import open_topography

    topography = open_topography(str(path)).topography(channel_index=height_channel(path) if number is None else number)
    factor = METRES[topography.unit]
    heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan).T[::-1] * factor
    return heights, np.asarray(topography.physical_sizes) * factor


def by_surfalize(path):
    """Heights and sides of surfalize, in micrometres, the top row first."""
    from surfalize import Surface

    found = Surface.load(path)
    rows, cols = found.data.shape
    return found.data[::-1] * 1e-6, np.array([cols * found.step_x, rows * found.step_y]) * 1e-6


def instruments():
    """Files of instruments in the source packages of AFMReader and TopoStats."""
    for path in sorted(SOURCES.glob("*/tests/resources/*")):
        package = path.parts[len(SOURCES.parts)].rsplit("-", 1)[0].lower()
        name = f"{package}_{path.name}"
        if path.suffix == ".h5-jpk":
            from AFMReader.h5_jpk import load_h5jpk

            frames, step, _ = load_h5jpk(path, "height_trace", flip_image=True)
            side = frames.shape[2] * step * 1e-9
            keep(name, path, frames[0][::-1] * 1e-9, (side, side), "AFMReader", package, "Height (trace) frame 1")
        elif path.suffix in (".stp", ".top"):
            keep(name, path, *by_surface_topography(path), "SurfaceTopography", package)
        elif path.suffix in (".ibw", ".gwy", ".spm", ".jpk", ".jpk-qi-image"):
            index = height_channel(path)
            found = by_surface_topography(path, index)
            # The two name channels differently, in the same order.
            number = str(index) if path.suffix in (".ibw", ".spm") else channel_names(path)[index]
            keep(name, path, *found, "SurfaceTopography", package, number)


def channel_names(path):
    from SurfaceTopography.IO import open_topography

    return [found.name for found in open_topography(str(path)).channels]


def height_channel(path):
    """Number of a channel of heights by its name, else the first."""
    names = channel_names(path)
    for word in ("HeightTrace", "HeightRetrace", "Height (measured)", "ZSensor", "Topography", "Height"):
        for number, name in enumerate(names):
            if name.startswith(word):
                return number
    return 0


def by_other_packages():
    """Files that surfalize, sdfio, RosettaSciIO and SurfaceTopography write."""
    from surfalize import Surface

    heights, gaps = surface()
    for name, values in (("whole", heights), ("gaps", gaps)):
        for ending in (".sdf", ".sur", ".x3p", ".al3d"):
            path = OUT / f"surfalize_{name}{ending}"
            Surface(values, 0.25, 0.5).save(path)
            # SurfaceTopography takes surfalize's micrometres for another unit in .sur, and knows no mark in .sdf.
            reader = by_surfalize if ending in (".sdf", ".sur") else by_surface_topography
            keep(path.name, path, *reader(path), reader.__name__[3:], "surfalize")
    import sdfio

    for revision in sdfio.Revision:
        for kind, file_format in ((sdfio.DataType.INT16, "ASCII"), (sdfio.DataType.BINARY64, "BINARY")):
            path = OUT / f"sdfio_{revision.value}_{kind.name}_{file_format}.sdf"
            sdfio.write(
                path, gaps * 1e-6, x_scale=0.25e-6, y_scale=0.5e-6, format=sdfio.FileFormat[file_format],
                metadata=sdfio.Metadata(revision=revision, data_type=kind),
            )  # fmt: skip
            found = sdfio.read(path)
            # sdfio counts y from the first profile of ISO files, which others draw at the top, and reverses BCR files.
            values = found.data if revision is sdfio.Revision.BCR_1_0 else found.data[::-1]
            keep(path.name, path, values, (31 * 0.25e-6, 23 * 0.5e-6), "sdfio", "sdfio")
    from rsciio.digitalsurf import file_reader, file_writer

    for packed in (False, True):
        path = OUT / f"rosettasciio_{'packed' if packed else 'plain'}.sur"
        axes = [
            {"name": "Y", "size": 23, "offset": 0.0, "scale": 0.5, "units": "µm", "navigate": False},
            {"name": "X", "size": 31, "offset": 0.0, "scale": 0.25, "units": "µm", "navigate": False},
        ]
        metadata = {"Signal": {"quantity": "Height (µm)"}, "General": {}}
        file_writer(
            str(path), {"data": heights, "axes": axes, "metadata": metadata, "original_metadata": {}},
            compressed=packed, object_name="Height",
        )  # fmt: skip
        (found,) = file_reader(str(path))
        steps = {axis["name"][0]: axis["scale"] * METRES[axis["units"]] for axis in found["axes"]}
        unit = found["metadata"]["Signal"]["quantity"].split("(")[-1].rstrip(")")
        sides = 31 * steps["X"], 23 * steps["Y"]
        keep(path.name, path, found["data"][::-1] * METRES[unit], sides, "rosettasciio", "rosettasciio")
    from SurfaceTopography import Topography

    for name, values in (("whole", heights), ("gaps", gaps)):
        masked = np.ma.masked_invalid(values)
        topography = Topography(masked if name == "gaps" else values, (23 * 0.5, 31 * 0.25), unit="µm")
        for ending in (".txt", ".gwy", ".x3p"):
            path = OUT / f"surfacetopography_{name}{ending}"
            writer = {".txt": "to_matrix", ".gwy": "to_gwy", ".x3p": "to_x3p"}[ending]
            if hasattr(topography, writer):
                getattr(topography, writer)(str(path))
                keep(path.name, path, *by_surface_topography(path), "SurfaceTopography", "SurfaceTopography")


#: Reader, writer and channel.
ONE_MODULE = {"sm4": ("spym", "tests", "Topography (forward)"), "ardf": ("magic-afm", "tests", "HeightTrace")}


def module(name, inside):
    """A file of a package without what the package wants around it."""
    import importlib.util

    folder = Path(importlib.util.find_spec(name).submodule_search_locations[0])
    spec = importlib.util.spec_from_file_location(f"only_{name}", folder / inside)
    found = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = found
    spec.loader.exec_module(found)
    return found


def by_spym(path):
    """The third page; its first row is the top."""
    page = module("spym", "io/rhksm4/_sm4.py").RHKsm4(path)[2]
    data = page.data.reshape(23, 31)  # it takes columns for rows, which only square images forgive
    return data[::-1] * float(page.attrs["RHK_Zscale"]) + float(page.attrs["RHK_Zoffset"])


def by_magic_afm(path):
    """The second image."""
    readers = module("magic_afm", "data_readers.py")
    data = path.read_bytes()
    _, (_, pointer) = readers.ARDFTableOfContents.unpack(readers.ARDFHeader.unpack(data, 16)).entries
    image = readers.ARDFImage.parse_imag(readers.ARDFHeader.unpack(data, pointer))
    box = readers.ARDFHeader.unpack(data, image.ibox_offset)
    _, lines, stride = readers.TOC_STRUCT.unpack_from(data, box.offset + 16)
    start = box.offset + box.size + 16
    return np.ndarray((lines, (stride - 16) // 4), "<f4", data, start, (stride, 4))


def by_the_tests():
    """Formats of which no file can be had: what the tests write, as others read it."""
    heights, _ = surface()
    heights = heights[::-1] * 1e-6
    size = (31 * 0.25e-6, 23 * 0.25e-6)
    for module in (scan_files, more_scan_files):
        for name, (writer, extension, _) in {**module.WRITERS, **getattr(module, "HDF", {})}.items():
            path = OUT / f"tests_{name}{extension}"
            path.write_bytes(writer(heights, size))
            found = False
            for reader in (by_surface_topography, by_surfalize):
                try:
                    values, sides = reader(path)
                except Exception as error:
                    print(path.name, reader.__name__, type(error).__name__, str(error)[:100])
                    continue
                if not found:
                    keep(path.name, path, values, sides, reader.__name__[3:], "tests")
                    found = True
            if name in ("sm4", "ardf"):
                keep(path.name, path, (by_spym if name == "sm4" else by_magic_afm)(path), size, *ONE_MODULE[name])
            if name == "nhf":
                from nanosurf.utils.io.nhf_reader import NHFFileReader

                file = NHFFileReader(path)
                file.read()
                segment = next(iter(file.measurement.values())).segments[0]
                data = segment.channel["Topography"]
                data.read_data()
                values = np.asarray(data.dataset).reshape(heights.shape)
                keep(path.name, path, values, size, "nanosurf", "tests", "Topography (Forward)")


def main():
    for step in (instruments, by_other_packages, by_the_tests):
        step()
    (OUT / "cases.json").write_text(json.dumps(CASES, indent=1) + "\n")
    print(f"{len(CASES)} files in {OUT}")


if __name__ == "__main__":
    main()
