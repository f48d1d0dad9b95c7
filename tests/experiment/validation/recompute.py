#!/usr/bin/python3
"""Recomputes every figure of `kerf validate` from volumes/measured and the formulas of docs/validation.md.

    recompute.py KERF MEASURED_FOLDER [PAGE]

Shares no code with kerf: reads the sets with tomllib and the laws' parameters from the JSON. PAGE (docs/validation.md)
must be the report, with the figures in the folder validation/. Exit code 1 if a figure differs, 77 (skipped) if Python
has no tomllib.
"""

import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

try:
    import tomllib
except ModuleNotFoundError:
    sys.exit(77)

# Both programs evaluate the same formulas in double precision; the JSON has nine digits.
FORMULA = 2e-8
# A cut in the voxel model: the bite falls by 0.13 % towards the ends of the rib, the force by 1.5 times as much.
CUT = 0.005
BITE_OF_CUT = 0.02

STEEL = (205000, 0.28)
BONE = (19300, 0.28)
RATIO = 1.6
DISC = (22, 24)  # mm, teeth


def reduced_modulus(density):
    return 1 / ((1 - STEEL[1] ** 2) / STEEL[0] + (1 - BONE[1] ** 2) / (BONE[0] * density ** 1.93))  # E follows the density, docs/physics.md


def hertz_chip(p, tool, bite, density):
    radius = p["contact_radius_mm"] or tool[0] / 2
    return 4 / 3 * reduced_modulus(density) * math.sqrt(radius) * bite ** 1.5, None


def hertz_constant_bite(p, tool, bite, density):
    radius = p["contact_radius_mm"] or tool[0] / 2
    contact = p["contact_share_of_pitch"] * math.pi * tool[0] / tool[1]
    return 4 / 3 * reduced_modulus(density) * contact ** 3 / radius, None


def edge_plus_chip(p, tool, bite, density):
    return (p["edge_N_per_mm"] + p["chip_N_per_mm2"] * bite) * tool[2] * reduced_modulus(density) / p["reference_E_star_MPa"], None


def two_component(p, tool, bite, density):
    """In cortical bone. The edge terms grow from 0 up to a bite of crossover_share x edge radius (8 um)."""
    crossover = p["crossover_share"] * 0.008
    edge = min(1, bite / crossover) if crossover > 0 else 1
    return (tool[2] * (p["thrust_edge_N_per_mm"] * edge + p["thrust_chip_N_per_mm2"] * bite),
            tool[2] * (p["cutting_edge_N_per_mm"] * edge + p["cutting_chip_N_per_mm2"] * bite))


def tabulated(p, tool, bite, density):
    """In cortical bone: linear between the rows, falling to 0 below the first, extended beyond the last."""
    forces = []
    for column in ("thrust_N_per_mm", "cutting_N_per_mm"):
        points = [(0.0, 0.0)] + [(float(row["bite_um"]) / 1000, float(row[column])) for row in FORCE_TABLE]
        first = next((i for i in range(1, len(points)) if bite < points[i][0]), len(points) - 1)
        (x0, y0), (x1, y1) = points[first - 1], points[first]
        forces.append(p["scale"] * tool[2] * max(0, y0 + (y1 - y0) * (bite - x0) / (x1 - x0)))
    return tuple(forces)


FORCE_TABLE = []  # rows of cortical bone
LAWS = {"hertz_chip": hertz_chip, "hertz_constant_bite": hertz_constant_bite, "edge_plus_chip": edge_plus_chip,
        "two_component": two_component, "tabulated": tabulated}


class Law:
    def __init__(self, entry):
        self.name, self.parameters = entry["law"], entry["parameters"]
        self.has_cutting = entry["has_cutting_force"]

    def forces(self, tool, bite, density=1):
        """Thrust and cutting force in N on a tooth of `tool`: diameter in mm, number of teeth, width in mm."""
        thrust, cutting = LAWS[self.name](self.parameters, tool, bite, density)
        return thrust, thrust / RATIO if cutting is None else cutting


def tooth_quantity(quantity, thrust, cutting, width, bite):
    return {"thrust_N": thrust, "cutting_N": cutting, "resultant_N": math.hypot(thrust, cutting),
            "thrust_per_cutting": thrust / cutting, "energy_J_per_mm3": cutting / (width * bite) / 1000}[quantity]


def simulate_tooth(law, tool, quantity, at):
    if "bite_um" not in at:
        return None
    width, bite = tool["width_mm"], at["bite_um"] / 1000
    return tooth_quantity(quantity, *law.forces((*DISC, width), bite, at.get("density", 1)), width, bite)


def simulate_drill(law, tool, quantity, at):
    if "rpm" not in at or "feed_mm_per_min" not in at:
        return None
    diameter = tool["diameter_mm"]
    sine = math.sin(math.radians(tool["point_deg"] / 2))
    turns_per_s, feed = at["rpm"] / 60, at["feed_mm_per_min"] / 60
    bite = feed / turns_per_s / 2 * sine
    thrust, cutting = law.forces((diameter, 2, diameter / 2 / sine), bite, at.get("density", 1))
    # The chisel edge, a fifth of the tip's radius, bears 45 % of the thrust; its torque is at half that fifth.
    chisel = 0.45 / 0.55
    force = 2 * thrust * sine * (1 + chisel)
    torque = 2 * cutting * diameter / 4 + 2 * cutting * chisel * diameter / 2 * 0.2 / 2
    power = torque * 2 * math.pi * turns_per_s + force * feed
    return {"thrust_N": force, "torque_Nmm": torque,
            "energy_J_per_mm3": power / (math.pi / 4 * diameter ** 2 * feed) / 1000}[quantity]


def simulate_blade_force(law, tool, quantity, at):
    def thrust(bite):
        return tool["teeth"] * law.forces((*DISC, tool["width_mm"]), bite, at.get("density", 1))[0]
    if thrust(1) <= thrust(1e-6):
        return None
    low, high = 0.0, 1.0
    if thrust(1e-6) < at["force_N"]:
        for _ in range(200):
            middle = (low + high) / 2
            low, high = (low, middle) if thrust(middle) > at["force_N"] else (middle, high)
    return low * tool["width_mm"] * tool["teeth"] * at["speed_mm_per_s"]


def simulate_blade_feed(law, tool, quantity, at, middle):
    bite_um = (middle["bite_um"] * at["feed_mm_per_min"] / middle["feed_mm_per_min"] * middle["cycles_per_min"] /
               at["cycles_per_min"])
    tooth = {"bite_um": bite_um, "density": at.get("density", 1)}
    if quantity == "temperature_rise":
        return simulate_tooth(law, tool, "energy_J_per_mm3", tooth) * math.sqrt(at["feed_mm_per_min"])
    return simulate_tooth(law, tool, quantity, tooth)


CONDITIONS = ("bite_um", "speed_mm_per_s", "rpm", "feed_mm_per_min", "cycles_per_min", "force_N", "density")


def simulate(law, measured, row, changed=None):
    if row.get("material", "cortical") != "cortical":
        return None
    if row["quantity"] == "thrust_per_cutting" and not law.has_cutting:
        return None
    middle = measured.get("conditions", {})
    at = {**middle, **{key: row[key] for key in CONDITIONS if key in row}, **(changed or {})}
    tool = measured["tool"]
    if tool["kind"] == "blade_feed":
        return simulate_blade_feed(law, tool, row["quantity"], at, middle)
    return {"tooth": simulate_tooth, "drill": simulate_drill,
            "blade_force": simulate_blade_force}[tool["kind"]](law, tool, row["quantity"], at)


class Checker:
    def __init__(self):
        self.figures = 0
        self.faults = []

    def equal(self, where, what, printed, expected):
        self.figures += 1
        if printed != expected:
            self.faults.append(f"{where}: {what} is {printed}, must be {expected}")

    def near(self, where, what, printed, expected, tolerance):
        self.figures += 1
        if printed is None or expected is None:
            if printed is not expected:
                self.faults.append(f"{where}: {what} is {printed}, must be {expected}")
        elif not abs(printed - expected) <= tolerance * abs(expected):
            self.faults.append(f"{where}: {what} is {printed}, must be {expected} within {tolerance:g} of it")


def agrees(row, value):
    if value is None:
        return None
    if "sd" in row:
        return abs(value - row["value"]) <= 2 * row["sd"]
    if "low" in row:
        return 0.995 * row["low"] <= value <= 1.005 * row["high"]
    return None


def check_values(check, document, sets, laws):
    for printed in document["values"]:
        if printed["law"] not in laws:
            continue
        measured = sets[printed["set"]]
        row = measured["value"][printed["row"] - 1]
        where = f"{printed['set']} value {printed['row']} {printed['law']}"
        value = simulate(laws[printed["law"]], measured, row)
        check.near(where, "law_value", printed["law_value"], value, FORMULA)
        check.near(where, "simulated", printed["simulated"], value, CUT if measured["tool"]["kind"] == "tooth" else FORMULA)
        for key in ("low", "high", "sd"):
            check.equal(where, key, printed[key], row.get(key))
        check.equal(where, "measured", printed["measured"], row.get("value"))
        check.equal(where, "agrees", printed["agrees"], agrees(row, printed["simulated"]))
        if "sd" in row and value is not None:
            # Six digits are printed; a difference that is almost 0 has fewer.
            expected = (printed["simulated"] - row["value"]) / row["sd"]
            check.near(where, "difference_sd", printed["difference_sd"], expected, 1e-5)
        check.equal(where, "use", printed["use"], "calibration" if printed["law"] in measured["calibrated"] else "validation")


def sign_of(ratio, tolerance):
    return "constant" if abs(ratio - 1) <= tolerance else "rises" if ratio > 1 else "falls"


def check_trends(check, document, sets, laws):
    for printed in document["trends"]:
        if printed["law"] not in laws:
            continue
        measured = sets[printed["set"]]
        row = measured["trend"][printed["row"] - 1]
        where = f"{printed['set']} trend {printed['row']} {printed['law']}"
        against = row["against"]
        nominal = 1 if against == "density" else measured.get("conditions", {}).get(against)
        start, end = row.get("from", nominal), row["to"] if "to" in row else 2 * nominal
        check.near(where, "from", printed["from"], start, 1e-8)
        check.near(where, "to", printed["to"], end, 1e-8)
        first = simulate(laws[printed["law"]], measured, row, {against: start})
        last = simulate(laws[printed["law"]], measured, row, {against: end})
        ratio = last / first if first else None
        check.near(where, "ratio", printed["ratio"], ratio, FORMULA)
        if ratio is not None:
            sign = sign_of(ratio, 0.1 if row["sign"] == "constant" else 0.001)
            check.equal(where, "sign", printed["sign"], sign)
            check.equal(where, "right", printed["right"], sign == row["sign"])


def check_teeth(check, document, laws):
    for printed in document["teeth"]:
        if printed["law"] not in laws:
            continue
        where = f"tooth {printed['bite_um']} um {printed['law']}"
        thrust, _ = laws[printed["law"]].forces((*DISC, printed["width_mm"]), printed["bite_um"] / 1000)
        check.near(where, "law_N", printed["law_N"], thrust, FORMULA)
        check.near(where, "thrust_N", printed["thrust_N"], thrust, CUT)
        check.near(where, "removed_bite_um", printed["removed_bite_um"], printed["bite_um"], BITE_OF_CUT)


def mean_thrust(law, tool, bite_mm):
    """Mean over time of the thrust of a reciprocating tooth, whose bite has this mean over its way."""
    pitch = 2 * tool["pitch_mm"] / tool["stroke_mm"]
    first = math.acos(1 - pitch)
    per_rad = bite_mm * tool["stroke_mm"] / tool["pitch_mm"] / math.pi
    steps = 2000
    angles = [math.pi * (i + 0.5) / steps for i in range(steps)]
    since = [2 * a if a < first else a - math.acos(math.cos(a) + pitch) for a in angles]
    return sum(law.forces((*DISC, tool["width_mm"]), per_rad * s, 1)[0] for s in since) / steps


def check_blades(check, document, sets, laws):
    check.equal("blades", "number", len(document["blades"]) > 0, True)
    for printed in document["blades"]:
        if printed["law"] not in laws:
            continue
        tool, trend = sets[printed["set"]]["tool"], sets[printed["set"]]["trend"][printed["row"] - 1]
        where = f"blade {printed['set']} {printed['row']} {printed['law']}"
        if tool["kind"] == "tooth":
            for end in ("from", "to"):
                bite = trend[end] if trend["against"] == "bite_um" else sets[printed["set"]]["conditions"]["bite_um"]
                thrust = mean_thrust(laws[printed["law"]], tool, bite / 1000)
                check.near(where, f"thrust_{end}_N", printed[f"thrust_{end}_N"], thrust, BITE_OF_CUT)
                check.near(where, f"bite_{end}_um", printed[f"bite_{end}_um"], bite, BITE_OF_CUT)
        else:
            of = ("rise_{}_K" if trend["quantity"] == "temperature_rise" else "rate_{}_mm3_per_s").format
            ratio = printed[of("to")] / printed[of("from")]
            check.near(where, "ratio", printed["ratio"], ratio, 1e-4)
        sign = sign_of(printed["ratio"], 0.1 if trend["sign"] == "constant" else 0.001)
        check.equal(where, "sign", printed["sign"], sign)
        check.equal(where, "right", printed["right"], sign == trend["sign"])


def check_counts(check, document, sets):
    """Every row of the sets must be in the document, and the counts must be those of the rows."""
    for counts in document["counts"]:
        law = counts["law"]
        for kind, key, prefix in (("values", "value", ""), ("trends", "trend", "")):
            rows = [row for row in document[kind] if row["law"] == law]
            check.equal(law, f"number of {kind}", len(rows), sum(len(s.get(key, [])) for s in sets.values()))
            verdict = "agrees" if kind == "values" else "right"
            for use, prefix in (("validation", ""), ("calibration", "calibration_")):
                judged = [row[verdict] for row in rows if row["use"] == use and row[verdict] is not None and
                          (kind == "trends" or row["obtained"] != "derived")]
                check.equal(law, prefix + kind, counts[prefix + kind], len(judged))
                good = f"{prefix}{kind}_{'agree' if kind == 'values' else 'right'}"
                check.equal(law, good, counts[good], sum(judged))


def main():
    kerf, folder = sys.argv[1:3]
    sets = {path.stem: tomllib.loads(path.read_text(encoding="utf-8")) for path in pathlib.Path(folder).glob("*.toml")}
    with tempfile.TemporaryDirectory() as out:
        done = subprocess.run([kerf, "validate", "--json", "-o", out], capture_output=True, text=True, check=True)
        report = (pathlib.Path(out) / "report.md").read_text(encoding="utf-8")
    document = json.loads(done.stdout)
    table = pathlib.Path(folder).parent / "force_table.csv"
    if table.exists():
        lines = [line for line in table.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
        FORCE_TABLE.extend(row for row in csv.DictReader(lines) if row["tissue"] == "cortical")
    laws = {}
    check = Checker()
    for entry in document["laws"]:
        if entry["law"] in LAWS:
            laws[entry["law"]] = Law(entry)
        else:
            check.faults.append(f"recompute.py has no formula of the law {entry['law']}")
    check.equal("document", "sets", [s["set"] for s in document["sets"]], sorted(sets))
    check_values(check, document, sets, laws)
    check_trends(check, document, sets, laws)
    check_teeth(check, document, laws)
    check_blades(check, document, sets, laws)
    check_counts(check, document, sets)
    if len(sys.argv) > 3:
        page = re.sub(r"\]\((\w+\.png)\)", r"](validation/\1)", report)
        check.equal(sys.argv[3], "the text (written by tools/figures)",
                    pathlib.Path(sys.argv[3]).read_text(encoding="utf-8") == page, True)
    for fault in check.faults:
        print(fault, file=sys.stderr)
    print(f"{check.figures} figures of {len(laws)} laws and {len(sets)} sets recomputed, {len(check.faults)} faults")
    sys.exit(1 if check.faults or check.figures < 500 else 0)


if __name__ == "__main__":
    main()
