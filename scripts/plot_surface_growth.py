#!/usr/bin/env python3
"""Draws the CPU time of surfaces over the number of points, both logarithmic, as SVG.

  scripts/plot_surface_growth.py tests/bench/surface_growth.json growth.svg

Prints the exponent of growth between each two runs that follow each other, and over all of a line.
"""

import json
import math
import pathlib
import sys

WIDTH, HEIGHT, MARGIN = 640, 420, 60
COLORS = ["#1b6ca8", "#c0392b", "#2e8b57", "#8e44ad"]


def lines_of(runs):
    """Runs with the same kind of memory limit: in memory, or with a scratch file."""
    lines = {}
    for run in runs:
        name = "with a scratch file" if run["scratch_bytes"] else "in memory"
        lines.setdefault(name, []).append(run)
    for line in lines.values():
        line.sort(key=lambda run: run["points"])
    return lines


def exponent(a, b):
    return math.log(b["cpu_seconds"] / a["cpu_seconds"]) / math.log(b["points"] / a["points"])


class Axis:
    """Logarithmic; whole decades."""

    def __init__(self, values, begin, end):
        self.low = math.floor(math.log10(min(values)))
        self.high = math.ceil(math.log10(max(values)))
        self.begin, self.end = begin, end

    def at(self, value):
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)

    def decades(self):
        return [10.0**k for k in range(self.low, self.high + 1)]


def number(value):
    for factor, unit in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if value >= factor:
            return f"{value / factor:g}{unit}"
    return f"{value:g}"


def draw(lines):
    runs = [run for line in lines.values() for run in line]
    x = Axis([run["points"] for run in runs], MARGIN, WIDTH - MARGIN)
    y = Axis([run["cpu_seconds"] for run in runs], HEIGHT - MARGIN, MARGIN / 2)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
             'font-family="sans-serif" font-size="12">',
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']

    def text(px, py, what, anchor="middle", color="black"):
        parts.append(f'<text x="{px:.1f}" y="{py:.1f}" text-anchor="{anchor}" fill="{color}">'
                     f"{what}</text>")

    def segment(x0, y0, x1, y1, style):
        parts.append(f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" {style}/>')

    for value in x.decades():
        segment(x.at(value), y.begin, x.at(value), y.end, 'stroke="#ddd"')
        text(x.at(value), y.begin + 18, number(value))
    for value in y.decades():
        segment(x.begin, y.at(value), x.end, y.at(value), 'stroke="#ddd"')
        text(x.begin - 8, y.at(value) + 4, number(value), "end")
    text((x.begin + x.end) / 2, HEIGHT - 14, "points")
    text(x.begin, y.end - 4, "CPU seconds", "start")
    # Linear growth, from the first run.
    first = min(runs, key=lambda run: run["points"])
    last = max(run["points"] for run in runs)
    ideal = first["cpu_seconds"] * last / first["points"]
    segment(x.at(first["points"]), y.at(first["cpu_seconds"]), x.at(last),
            y.at(min(ideal, 10.0**y.high)), 'stroke="#999" stroke-dasharray="4 4"')
    for (name, line), color in zip(lines.items(), COLORS):
        points = [(x.at(run["points"]), y.at(run["cpu_seconds"])) for run in line]
        path = " ".join(f"{px:.1f},{py:.1f}" for px, py in points)
        parts.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="2"/>')
        for px, py in points:
            parts.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" r="3.5" fill="{color}"/>')
    for i, (name, color) in enumerate(zip([*lines, "linear"], [*COLORS[: len(lines)], "#999"])):
        text(x.begin + 12, y.end + 16 + 16 * i, name, "start", color)
    return "\n".join([*parts, "</svg>", ""])


def main():
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    lines = lines_of(json.loads(pathlib.Path(sys.argv[1]).read_text()))
    for name, line in lines.items():
        for a, b in zip(line, line[1:]):
            print(f"{name}: {number(a['points'])} to {number(b['points'])}: "
                  f"n^{exponent(a, b):.2f}")
        if len(line) > 2:
            print(f"{name}: all: n^{exponent(line[0], line[-1]):.2f}")
    pathlib.Path(sys.argv[2]).write_text(draw(lines))


if __name__ == "__main__":
    main()
