#!/usr/bin/env python3
"""Checks that every folder includes only what its layer may use.

The table says for each module which others it may include; "util" may be used by all. The headers directly in a
module's folder are its public face: other modules include only those, and they include no header of a sub-folder. Also:
heavy third-party headers stay out of our headers, so that a change of library touches one .cc file. Prints each offence as file:line and exits
with 1 if there is one.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

STAGES = {"stereo", "surface", "refinement", "texturing"}
ALGORITHMS = STAGES | {"partition", "merging", "evaluation"}
DATA = {"geometry", "image", "scene", "mesh"}

MAY_USE = {
    "util": set(),
    "geometry": set(),
    "graph": set(),
    "image": {"geometry"},
    "scene": {"geometry", "image"},
    "mesh": {"geometry", "graph", "image"},
    "stereo": {"scene", "image", "geometry"},
    "surface": {"scene", "mesh", "image", "geometry", "graph"},
    "refinement": {"scene", "mesh", "image", "geometry", "texturing"},  # colours its vertices
    "texturing": {"scene", "mesh", "image", "geometry", "graph"},
    "partition": {"scene", "mesh", "image", "geometry"},
    "merging": {"surface", "scene", "mesh", "partition", "image", "geometry", "graph"},
    "evaluation": {"scene", "mesh", "image", "geometry"},
    "exporting": {"evaluation", "mesh", "image", "geometry"},
    "execution": set(),
    "program": {"execution"},
    "pipeline": ALGORITHMS | DATA | {"execution"},
    "report": {"evaluation", "exporting", "texturing", "scene", "mesh", "image", "geometry"},
    "colmap_adapter": DATA,
    "workflow": ALGORITHMS | DATA | {"execution", "program", "exporting", "pipeline", "report", "colmap_adapter"},
    "cli": {"execution", "program", "workflow", "colmap_adapter"},
}

# Third-party headers that only .cc files may include.
HEAVY = re.compile(r'#include [<"](CGAL|boost|embree[34]|sqlite3|nlohmann|CLI|ceres|tbb|opencv2|glog|hwy)[/.]')
HEAVY_ALLOWED = {"opencv2": {"image", "stereo"}, "embree4": {"evaluation"}, "embree3": {"evaluation"}, "hwy": {"stereo", "refinement", "image"}}
OURS = re.compile(r'#include "lsmvs/([a-z_]+)/(.*)"')


def module_folders():
    yield "colmap_adapter", ROOT / "colmap_adapter"
    for folder in sorted((ROOT / "src").iterdir()):
        if folder.is_dir():
            yield folder.name, folder


def is_public(path):
    return path.suffix == ".h" and path.parent.name in MAY_USE


def offences_in(module, path):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        used = OURS.match(line)
        if used and used[1] not in MAY_USE[module] | {module, "util"}:
            yield number, f"{module} may not include {used[1]}"
        if used and "/" in used[2] and (used[1] != module or is_public(path)):
            yield number, f"{used[1]}/{used[2]} lies inside its module; include what lies on the doorstep"
        heavy = HEAVY.match(line)
        if heavy and path.suffix == ".h" and module not in HEAVY_ALLOWED.get(heavy[1], set()):
            yield number, f"{heavy[1]} belongs into a .cc file"
        if re.match(r'#include "(?!lsmvs/)', line):
            yield number, 'include our headers as "lsmvs/<module>/<file>.h"'


def main():
    count = 0
    for module, folder in module_folders():
        if module not in MAY_USE:
            print(f"{folder}: unknown module {module}; add it to the table in {__file__}")
            count += 1
            continue
        for path in sorted(folder.rglob("*")):
            if path.suffix not in (".h", ".cc"):
                continue
            for number, message in offences_in(module, path):
                print(f"{path.relative_to(ROOT)}:{number}: {message}")
                count += 1
    print(f"layers: {count} offence(s)")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
