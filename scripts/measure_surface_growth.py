#!/usr/bin/env python3
"""Meshes generated towns of growing size and writes what that took as JSON.

  scripts/measure_surface_growth.py --output growth.json 1e6 3e6 1e7 3e7
  scripts/measure_surface_growth.py --output growth.json --max_memory 450MB 1e7

Each run is appended to the file; scripts/plot_surface_growth.py draws it. Needs about 60 bytes of
disk a point for the cloud, and with --max_memory 130 more for the scratch file.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

BIN = pathlib.Path(__file__).resolve().parent.parent / "build" / "release" / "bin"


def run(arguments):
    """The CPU seconds and the highest resident size of a program that succeeds."""
    process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(map(str, arguments))}: failed")
    return usage.ru_utime + usage.ru_stime, 1024 * usage.ru_maxrss


def measure(folder, num_points, max_memory):
    town = folder / "town"
    run([BIN / "make_large_cloud", "--output", town, "--num_points", str(int(num_points))])
    command = [BIN / "lsmvs", "visibility_mesher", "--input_path", town, "--output_path",
               town / "mesh.ply"]
    if max_memory:
        command += ["--max_memory", max_memory]
    cpu_seconds, peak_bytes = run(command)
    record = json.loads((town / "lsmvs" / "run.json").read_text())
    (group,) = record["stages"]["visibility_mesher"]
    counts = group["counts"]
    shutil.rmtree(town)
    return {
        "points": int(counts["points"]),
        "vertices": int(counts["delaunay_vertices"]),
        "faces": int(counts["faces"]),
        "max_memory": max_memory or "",
        "cpu_seconds": round(cpu_seconds, 2),
        "peak_bytes": peak_bytes,
        "scratch_bytes": int(counts.get("scratch_bytes", 0)),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("points", nargs="+", type=float)
    parser.add_argument("--output", type=pathlib.Path, required=True)
    parser.add_argument("--max_memory", default="")
    parser.add_argument("--folder", help="where clouds and meshes go meanwhile")
    options = parser.parse_args()
    runs = json.loads(options.output.read_text()) if options.output.exists() else []
    for num_points in options.points:
        with tempfile.TemporaryDirectory(dir=options.folder) as folder:
            runs.append(measure(pathlib.Path(folder), num_points, options.max_memory))
        options.output.write_text(json.dumps(runs, indent=1) + "\n")
        print(runs[-1])


if __name__ == "__main__":
    main()
