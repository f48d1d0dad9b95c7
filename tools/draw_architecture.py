#!/usr/bin/env python3
"""Draws docs/layers.txt: the groups of src (docs/architecture.svg), and the folders of each group (docs/architecture/GROUP.svg).

    tools/draw_architecture.py            writes the pictures
    tools/draw_architecture.py --table    prints the rows of the tables in docs/architecture.md, src/README.md and each src/GROUP/README.md
    tools/draw_architecture.py --check    exits with 1 if a picture or a table is out of date (a test)
"""

import pathlib
import sys
import textwrap
from xml.sax.saxutils import escape

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools"))
from check_layers import read_table  # noqa: E402

GAP_X, GAP_Y, MARGIN, TOP, LINE = 30, 48, 24, 64, 16
SHOWN = {"zlib": "zlib", "bzip2": "bzip2", "openvdb": "OpenVDB", "vtk": "VTK", "itk": "ITK, GDCM", "toml": "toml++", "cli": "CLI11", "sndfile": "libsndfile", "glfw": "GLFW",
         "sqlite": "SQLite", "zip": "libzip", "alsa": "ALSA", "tbb": "TBB", "hwy": "Highway", "eigen": "Eigen", "embree": "Embree", "json": "nlohmann-json", "usb": "libusb",
         "boost": "Boost", "zstd": "Zstandard", "sodium": "libsodium", "sleef": "SLEEF", "x11": "Xlib",
         "imgui": "Dear ImGui"}
PURE, IMPURE, EDGE, TEXT, NOTE = "#dcebf7", "#f4e9d8", "#8a949e", "#1c2733", "#5b6670"


class Box:
    def __init__(self, pure, libraries, notes):
        self.pure, self.lines = pure, [(text, "italic") for text in libraries] + [(text, "normal") for text in notes]


def direct_uses(table):
    """Removes dependencies that an entry also has through another one: the pictures show only the necessary ones."""
    return {name: {u for u in entry.uses if not any(u in table[v].uses for v in entry.uses)} for name, entry in table.items()}


def is_pure(folder):
    return not folder.system - {"threads"}


def place(names, uses, width):
    """Returns each box's row (0 at the bottom) and centre, and each arrow as the list of places it passes. An arrow that spans
    several rows has a place (from, to, row) in each row between, so that no box is in its way."""
    # Boxes without arrows are alone in the lowest row.
    row_of, alone = {}, [name for name in names if not uses[name] and not any(name in uses[other] for other in names)]
    for name in names:
        row_of[name] = 0 if name in alone else 1 + max((row_of[used] for used in uses[name]), default=0 if alone else -1)
    rows = [[name for name in names if row_of[name] == row] for row in range(max(row_of.values()) + 1)]
    arrows = []
    for name in names:
        for used in sorted(uses[name]):
            between = [(name, used, row) for row in range(row_of[name] - 1, row_of[used], -1)]
            for passed in between:
                rows[passed[2]].append(passed)
            arrows.append([name, *between, used])
    joined = {spot: [] for row in rows for spot in row}
    for arrow in arrows:
        for above, below in zip(arrow, arrow[1:]):
            joined[above].append(below)
            joined[below].append(above)
    middle = {spot: (i - len(row) / 2) * width for row in rows for i, spot in enumerate(row)}
    for turn in range(200):
        for row in rows[::-1] if turn % 2 else rows:
            wish = {spot: sum(middle[o] for o in joined[spot] or [spot]) / max(len(joined[spot]), 1) for spot in row}
            row.sort(key=lambda spot: (wish[spot], str(spot)))
            at = [wish[spot] for spot in row]
            # Each box is as near to its wanted position as possible without overlap: neighbours in conflict share the
            # difference.
            for _ in range(200):
                for i in range(len(row) - 1):
                    boxes = isinstance(row[i], str) + isinstance(row[i + 1], str)
                    short = boxes * width / 2 + GAP_X - (at[i + 1] - at[i])
                    if short > 0:
                        at[i] -= short / 2
                        at[i + 1] += short / 2
            middle.update(zip(row, at))
    # From left to right, closes any gap that goes through all rows.
    reach, shift = -GAP_X, min(middle.values()) - width
    for spot in sorted((spot for spot in middle if spot not in alone), key=middle.get):
        half = width / 2 if isinstance(spot, str) else 0
        shift = max(shift, middle[spot] - half - reach - GAP_X)
        middle[spot] -= shift
        reach = max(reach, middle[spot] + half)
    for i, name in enumerate(alone):
        middle[name] = (reach - len(alone) * (width + GAP_X) + GAP_X + width) / 2 + i * (width + GAP_X)
    left = min(at - (width / 2 if isinstance(spot, str) else 0) for spot, at in middle.items())
    return row_of, {spot: middle[spot] - left + MARGIN for spot in middle}, arrows


def draw(title, boxes, uses, width):
    row_of, middle, arrows = place(list(boxes), uses, width)
    heights = [max(34 + LINE * len(boxes[name].lines) for name in boxes if row_of[name] == row) for row in range(max(row_of.values()) + 1)]
    top = [TOP + sum(h + GAP_Y for h in heights[row + 1:]) for row in range(len(heights))]
    right = max([middle[name] + width / 2 for name in boxes] + list(middle.values())) + MARGIN
    legend = [(PURE, "pure: no file, clock, window or device"), (IMPURE, "touches the system: files, clock, ...")]
    right, bottom = max(right, MARGIN + 290 * len(legend), 2 * MARGIN + 8.5 * len(title)), top[0] + heights[0] + MARGIN
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {right:.0f} {bottom}" width="{right:.0f}" height="{bottom}" '
           'font-family="DejaVu Sans, Helvetica, Arial, sans-serif">',
           '<!-- Drawn by tools/draw_architecture.py from docs/layers.txt. -->',
           f'<rect width="{right:.0f}" height="{bottom}" fill="white"/>',
           f'<text x="{MARGIN}" y="26" font-size="15" fill="{TEXT}">{escape(title)}</text>']
    for i, (colour, text) in enumerate(legend):
        out.append(f'<rect x="{MARGIN + i * 290}" y="36" width="14" height="14" rx="3" fill="{colour}" stroke="{EDGE}"/>'
                   f'<text x="{MARGIN + 20 + i * 290}" y="48" font-size="12" fill="{NOTE}">{text}</text>')

    def end_of(arrow, ends):
        """Spreads the arrows of a box over its edge, in the order of their targets."""
        near, far = arrow[ends[0]], arrow[ends[1]]
        others = sorted(middle[a[ends[1]]] for a in arrows if a[ends[0]] == near)
        return middle[near] + width * ((others.index(middle[far]) + 1) / (len(others) + 1) - 0.5)

    for arrow in arrows:
        x, y = end_of(arrow, (0, 1)), top[row_of[arrow[0]]] + heights[row_of[arrow[0]]]
        path = f"M{x:.0f},{y}"
        for spot in arrow[1:]:
            last = isinstance(spot, str)
            row = row_of[spot] if last else spot[2]
            to_x, to_y = (end_of(arrow, (-1, -2)), top[row] - 7) if last else (middle[spot], top[row])
            path += f" C{x:.0f},{(y + to_y) // 2} {to_x:.0f},{(y + to_y) // 2} {to_x:.0f},{to_y}"
            x, y = to_x, to_y if last else to_y + heights[row]
            path += "" if last else f" L{x:.0f},{y}"
        out.append(f'<path d="{path}" fill="none" stroke="{EDGE}" stroke-width="1.3"/>'
                   f'<path d="M{x - 4:.0f},{y} L{x + 4:.0f},{y} L{x:.0f},{y + 7} z" fill="{EDGE}"/>')
    for name, box in boxes.items():
        row, at = row_of[name], middle[name]
        out.append(f'<rect x="{at - width / 2:.0f}" y="{top[row]}" width="{width}" height="{heights[row]}" rx="8" '
                   f'fill="{PURE if box.pure else IMPURE}" stroke="{EDGE}"/>')
        y = top[row] + 22 + (heights[row] - 34 - LINE * len(box.lines)) / 2
        out.append(f'<text x="{at:.0f}" y="{y:.0f}" font-size="16" font-weight="bold" fill="{TEXT}" text-anchor="middle">{name}</text>')
        for i, (text, style) in enumerate(box.lines, 1):
            out.append(f'<text x="{at:.0f}" y="{y + 2 + LINE * i:.0f}" font-size="12" font-style="{style}" fill="{NOTE}" '
                       f'text-anchor="middle">{escape(text)}</text>')
    return "\n".join(out + ["</svg>", ""])


def pictures(groups, folders):
    uses = direct_uses(groups)
    boxes = {name: Box(all(is_pure(f) for f in folders.values() if f.group == name), [], textwrap.wrap(group.purpose, 52))
             for name, group in groups.items()}
    drawn = {"docs/architecture.svg": draw("The groups of src. An arrow goes to what a group includes.", boxes, uses, 370)}
    uses = direct_uses(folders)
    for group in groups:
        inside = {name: folder for name, folder in folders.items() if folder.group == group}
        boxes = {}
        for name, folder in inside.items():
            libraries = textwrap.wrap(", ".join(SHOWN[library] for library in sorted(folder.libraries)), 28)
            lower = []
            for other in groups:
                used = [u for u in folders if u in uses[name] and folders[u].group == other != group]
                lower += textwrap.wrap(f"{other}: {', '.join(used)}", 28) if used else []
            boxes[name] = Box(is_pure(folder), libraries, lower)
        inner = direct_uses({name: type(folder)(group, name, folder.uses & set(inside), *[None] * 4) for name, folder in inside.items()})
        title = f"The folders of src/{group}: libraries in italics, then what each uses of lower groups."
        drawn[f"docs/architecture/{group}.svg"] = draw(title, boxes, inner, 200)
    return drawn


def tables(groups, folders):
    """Returns the rows of each document's table."""
    rows = {"docs/architecture.md": [f"| [`{name}`](../src/{name}/README.md) | {group.purpose} |" for name, group in groups.items()]}
    rows["src/README.md"] = [f"| [`{name}`]({name}/README.md) | {group.purpose} |" for name, group in groups.items()]
    for group in groups:
        rows[f"src/{group}/README.md"] = [f"| `{name}` | {f.purpose} |" for name, f in folders.items() if f.group == group]
    return rows


def main(arguments):
    if arguments in (["-h"], ["--help"]):
        print(__doc__)
        return 0
    if arguments not in ([], ["--table"], ["--check"]):
        print("usage: tools/draw_architecture.py [--table | --check]", file=sys.stderr)
        return 2
    table = read_table((ROOT / "docs/layers.txt").read_text(encoding="utf-8"))
    drawn, rows = pictures(*table), tables(*table)
    if arguments == ["--table"]:
        for document in rows:
            print(document, *rows[document], "", sep="\n")
        return 0
    if arguments == ["--check"]:
        def text_of(path):
            return (ROOT / path).read_text(encoding="utf-8") if (ROOT / path).is_file() else ""
        faults = [f"{path} is out of date: run tools/draw_architecture.py" for path, text in drawn.items() if text_of(path) != text]
        faults += [f"{path} lacks this row: {row}" for path in rows for row in rows[path] if row not in text_of(path).splitlines()]
        print(*faults, f"draw_architecture: {len(faults)} faults against docs/layers.txt", sep="\n")
        return 1 if faults else 0
    for path, text in drawn.items():
        (ROOT / path).parent.mkdir(exist_ok=True)
        (ROOT / path).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
