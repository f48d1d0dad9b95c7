#!/usr/bin/env python3
"""Draws docs/architecture.svg from docs/layers.txt: a box for each folder, an arrow to each folder that it includes.

    tools/draw_architecture.py            writes the picture
    tools/draw_architecture.py --table    prints the rows of the table in docs/architecture.md
    tools/draw_architecture.py --check    exit 1 when the picture or the table in docs/architecture.md is old (a test)
"""

import pathlib
import sys
from xml.sax.saxutils import escape

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools"))
from check_layers import read_table  # noqa: E402

BOX_W, BOX_H, GAP_X, GAP_Y, MARGIN, TOP = 128, 50, 34, 62, 28, 64
SHOWN = {"openvdb": "OpenVDB", "vtk": "VTK", "itk": "ITK, GDCM", "toml": "toml++", "cli": "CLI11", "sndfile": "libsndfile", "glfw": "GLFW",
         "sqlite": "SQLite", "alsa": "ALSA"}
PURE, IMPURE, EDGE, TEXT, NOTE = "#dcebf7", "#f4e9d8", "#8a949e", "#1c2733", "#5b6670"


def direct_uses(folders):
    """Without what a folder reaches through another one: the picture shows only what it must."""
    return {name: {u for u in f.uses if not any(u in folders[v].uses for v in f.uses)} for name, f in folders.items()}


def rank_of(folders):
    rank = {}
    for name, folder in folders.items():
        rank[name] = 1 + max((rank[u] for u in folder.uses), default=-1)
    return rank


def columns_of(folders, uses, rank):
    """Where each box stands in its row, in boxes: each near the middle of what it is joined to, none over another."""
    rows = {}
    for name in folders:
        rows.setdefault(rank[name], []).append(name)
    widest = max(len(row) for row in rows.values())
    joined = {name: set(uses[name]) | {other for other in folders if name in uses[other]} for name in folders}
    column = {name: (i + 0.5) * widest / len(row) for row in rows.values() for i, name in enumerate(row)}
    for turn in range(200):
        for level in sorted(rows, reverse=turn % 2 == 1):
            row = rows[level]
            wish = {name: sum(column[o] for o in joined[name]) / max(len(joined[name]), 1) for name in row}
            row.sort(key=lambda name: (wish[name], name))
            # As near to the wishes as boxes that don't touch can be: neighbours in conflict share the difference.
            place = [wish[name] for name in row]
            for _ in range(200):
                for i in range(len(row) - 1):
                    short = 1 - (place[i + 1] - place[i])
                    if short > 0:
                        place[i] -= short / 2
                        place[i + 1] += short / 2
            for name, at in zip(row, place):
                column[name] = at
    left = min(column.values())
    return {name: round(at - left, 2) for name, at in column.items()}


def draw():
    folders = read_table((ROOT / "docs/layers.txt").read_text(encoding="utf-8"))
    uses, rank = direct_uses(folders), rank_of(folders)
    x = {name: round(at * (BOX_W + GAP_X)) for name, at in columns_of(folders, uses, rank).items()}
    top_rank = max(rank.values())
    width = max(x.values()) + BOX_W + 2 * MARGIN
    height = TOP + (top_rank + 1) * BOX_H + top_rank * GAP_Y + MARGIN

    def corner(name):
        return MARGIN + x[name], TOP + (top_rank - rank[name]) * (BOX_H + GAP_Y)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
           'font-family="DejaVu Sans, Helvetica, Arial, sans-serif">',
           '<!-- Drawn by tools/draw_architecture.py from docs/layers.txt. -->',
           f'<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
           f'<path d="M0,0 L8,4 L0,8 z" fill="{EDGE}"/></marker></defs>',
           f'<rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{MARGIN}" y="26" font-size="15" fill="{TEXT}">The folders of src. An arrow goes to what a folder includes.</text>']
    for i, (colour, text) in enumerate([(PURE, "pure: no file, clock, window or device"), (IMPURE, "reads and writes files, or talks to people")]):
        out.append(f'<rect x="{MARGIN + i * 300}" y="36" width="14" height="14" rx="3" fill="{colour}" stroke="{EDGE}"/>'
                   f'<text x="{MARGIN + 20 + i * 300}" y="48" font-size="12" fill="{NOTE}">{text}</text>')
    for name in folders:
        for used in sorted(uses[name]):
            (x1, y1), (x2, y2) = corner(name), corner(used)
            # Ends spread over the edge of the box, in the order of what they go to.
            a = x1 + BOX_W * (0.5 + max(-0.35, min(0.35, (x2 - x1) / 900)))
            b = x2 + BOX_W * (0.5 + max(-0.35, min(0.35, (x1 - x2) / 900)))
            start, end = y1 + BOX_H, y2 - 2
            bend = (end - start) * 0.5
            out.append(f'<path d="M{a:.0f},{start} C{a:.0f},{start + bend:.0f} {b:.0f},{end - bend:.0f} {b:.0f},{end}" fill="none" '
                       f'stroke="{EDGE}" stroke-width="1.3" marker-end="url(#tip)"/>')
    for name, folder in folders.items():
        left, top = corner(name)
        libraries = ", ".join(SHOWN[library] for library in sorted(folder.libraries) if library in SHOWN)
        middle = left + BOX_W / 2
        pure = not folder.system - {"threads"}
        out.append(f'<rect x="{left}" y="{top}" width="{BOX_W}" height="{BOX_H}" rx="8" fill="{PURE if pure else IMPURE}" '
                   f'stroke="{EDGE}"/>')
        out.append(f'<text x="{middle:.0f}" y="{top + (22 if libraries else 31)}" font-size="16" font-weight="bold" fill="{TEXT}" '
                   f'text-anchor="middle">{escape(name)}</text>')
        if libraries:
            out.append(f'<text x="{middle:.0f}" y="{top + 40}" font-size="12" fill="{NOTE}" text-anchor="middle">{escape(libraries)}</text>')
    out.append("</svg>")
    return "\n".join(out) + "\n"


def purposes():
    """A row of the table in docs/architecture.md for each folder."""
    rows = []
    for line in (ROOT / "docs/layers.txt").read_text(encoding="utf-8").splitlines():
        if line.strip() and not line.startswith("#"):
            cells = [cell.strip() for cell in line.split("|")]
            rows.append(f"| `{cells[0]}` | {cells[5]} |")
    return rows


def main(arguments):
    picture = ROOT / "docs/architecture.svg"
    if arguments == ["--check"]:
        same = picture.is_file() and picture.read_text(encoding="utf-8") == draw()
        print("docs/architecture.svg is " + ("that of docs/layers.txt" if same else "old: run tools/draw_architecture.py"))
        document = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
        old = [line for line in purposes() if line not in document]
        print(*(f"docs/architecture.md lacks: {line}" for line in old), sep="\n", end="")
        return 0 if same and not old else 1
    if arguments == ["--table"]:
        print("\n".join(purposes()))
        return 0
    picture.write_text(draw(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
