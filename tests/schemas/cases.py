"""The commands that tests/schemas/check_schemas.py runs, and the small inputs that it makes for them."""

import array
import ctypes
import ctypes.util
import dataclasses
import itertools
import json
import math
import struct


def make_block(title, size_mm, voxel_mm):
    x, y, z = size_mm
    return (f'title = "{title}"\n[bone]\nmodel = "block"\n[bone.block]\nsize_x_mm = {x}\nsize_y_mm = {y}\nsize_z_mm = {z}\n'
            f"voxel_mm = {voxel_mm}\n")


def make_disc(diameter_mm, thickness_mm, teeth):
    return f"[tool]\ndiameter_mm = {diameter_mm}\nthickness_mm = {thickness_mm}\nteeth = {teeth}\n"


def make_stroke(start_mm, end_mm, feed_mm_per_s):
    return (f"[[path.stroke]]\nstart_mm = {start_mm}\nend_mm = {end_mm}\nfeed_mm_per_s = {feed_mm_per_s}\n"
            "disc_normal = [1, 0, 0]\n")


NO_PICTURES = "[output]\npictures = false\n"

# A disc moves down into a block; all optional parts are off.
BLOCK = (make_block("Block", (6, 5, 6), 0.4) + make_stroke([0, 0, 12], [0, 0, 8], 20) + "[slab]\ndirection = [0, 0, -1]\n" +
         NO_PICTURES)

# A disc cuts a bar into two pieces and a crumb; with effects.
BAR = make_block("Bar", (8, 4, 3), 0.2) + make_disc(12, 0.5, 16) + "".join(
    itertools.starmap(make_stroke, [([3.55, 0, 9], [3.55, 0, 2.4], 10), ([0, 0, 6.5], [0, 0, 2.4], 10),
                                    ([0, 0, 2.4], [0, 0, 20], 40)])) + """[hand]
model = "H4"
[effects.fragments]
pieces = "moved"
dust_mm3 = 3
remove_dust = true
every_ms = 10
[effects.heat]
[effects.tangential_force]
""" + NO_PICTURES

DEGRADE = BAR + "[loop]\ndegrade = true\n"
SLAB = BLOCK.replace("end_mm = [0, 0, 8]", "end_mm = [0, 0, -2]") + '[simulation]\nmode = "slab"\n'
UNIFORM = BLOCK + '[material]\nkind = "uniform"\nE_GPa = 10\nnu = 0.3\n'
# A law whose parameters have intervals; one of them is set.
LAW = BLOCK + '[force]\nlaw = "edge_plus_chip"\nchip_N_per_mm2 = 400\n'
BALL = BLOCK.replace("[slab]\ndirection = [0, 0, -1]\n", "") + '[tool]\nshape = "ball"\n'
BUR = BALL.replace("ball", "bur")
RECIPROCATING = BALL.replace("ball", "reciprocating")
OSCILLATING = BALL.replace("ball", "oscillating")
PIEZO = BALL.replace("ball", "piezo")

# A hole through a plate.
HOLES = """[bone]
model = "block"
[bone.block]
size_x_mm = 8
size_y_mm = 8
size_z_mm = 4
voxel_mm = 0.3
[tool]
shape = "drill"
rpm = 8000
[device]
profile = "omega_6"
[hand]
model = "H4"
[exercise]
kind = "drill_holes"
start_mm = [0, 0, 0]
into = [0, 0, -1]
depth_mm = 4.8
feed_mm_per_s = 1
""" + make_stroke([0, 0, 3], [0, 0, 2], 2)

# A scene whose bone has CT numbers.
CT = """title = "CT"
[bone]
file = "ct.vdb"
[material]
kind = "ct"
ct_law = "mandible_matmap"
""" + make_stroke([0, 0, 25], [0, 0, 22], 20) + NO_PICTURES

PLAN = BAR + """[[plan.plane]]
name = "first"
point_mm = [0, 0, 0]
normal = [1, 0, 0]
[[plan.plane]]
name = "missed"
point_mm = [-3, 0, 0]
normal = [1, 0, 0]
[[plan.stop]]
name = "stop"
point_mm = [0, 0, 0]
direction = [0, 0, -1]
depth_mm = 1
[[plan.stop]]
name = "not reached"
point_mm = [-3, 0, 0]
direction = [0, 0, -1]
depth_mm = 1
[[bone.block.layer]]
thickness_mm = 2
region = 24
[[bone.block.layer]]  # a canal
thickness_mm = 1
region = 34
"""

# The stability of a small loop; a low rate has few ticks.
STABILITY = (make_block("Small block", (3, 3, 3), 0.5) + make_disc(6, 0.6, 8) + make_stroke([0, 0, 4], [0, 0, 2], 20) +
             '[force]\nlaw = "hertz_chip"\n[loop]\nrate_hz = 250\n[device]\nprofile = "touch"\n[hand]\nmodel = "H2"\n')

# A disc cuts through a small block.
THROUGH = make_block("Through", (3, 3, 1.5), 0.4) + make_disc(6, 0.6, 8) + make_stroke([0, 0, 3.5], [0, 0, 0], 20)

# The path "ct" is omitted, because its data are missing.
STUDY = """title = "Two paths"
[study]
paths = ["ct"]
holdings = ["path"]
ticks_per_case = 1000
ticks_of_defaults = 1000
reference_tolerance = 1e-1
[base]
voxel_mm = 0.4
[[knob]]
name = "heat_grid_mm"
values = [0, 2]
[[scene]]
name = "through"
file = "through.toml"
"""


# Measured forces with weights, speeds and specimens; and torques that determine less.
FORCES = "specimen,bite_mm,width_mm,speed_mm_per_s,thrust_N,thrust_sd_N,cutting_N\n" + "".join(
    f"{specimen},{bite_mm},0.5,{1000 + 100 * i * i},{5 + 200 * bite_mm + 0.1 * (i % 3)},0.1,{3 + 100 * bite_mm}\n"
    for i, (specimen, bite_mm) in enumerate(itertools.product("ABC", (0.003, 0.006, 0.009))))
TORQUES = "bite_mm,width_mm,torque_N_mm,radius_mm\n0.003,0.5,8,2\n0.006,0.5,7,2\n"


@dataclasses.dataclass
class Case:
    """A command of kerf, and the documents that it writes.

    `schema`: of what it prints; "" if that is not JSON. `files`: pattern of a file's path -> its schema. `codes`: the
    expected exit codes; several if the result depends on times. `before`: called with the folder before the command.
    `interrupt_s`: if set, the command is interrupted after this time, as by Ctrl-C; if it has printed nothing, it is
    repeated with more time. `recording`: a recording that it writes, whose blocks of JSON are documents too.
    """
    arguments: str
    schema: str = ""
    files: dict = dataclasses.field(default_factory=dict)
    codes: tuple = (0,)
    before: object = None
    interrupt_s: float = 0
    recording: str = ""


def write_segmentation(folder):
    """Writes a segmentation with a tooth and a canal in a ball of bone, as 3D Slicer does."""
    size, spacing = 40, 0.5
    labels = bytearray()
    for z, y, x in itertools.product(range(size), repeat=3):
        p = [spacing * (v - size / 2 + 0.5) for v in (x, y, z)]
        label = 1 if math.hypot(*p) < 8 else 0
        if label and math.dist(p, (0, 0, 5)) < 2.5:
            label = 2
        if label and math.hypot(p[1], p[2] + 3) < 1.5:
            label = 3
        labels.append(label)
    header = (f"NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: {size} {size} {size}\n"
              f"space directions: ({spacing},0,0) (0,{spacing},0) (0,0,{spacing})\nkinds: domain domain domain\n"
              "encoding: raw\nspace origin: (-9.75,-9.75,0.25)\n")
    for i, name in enumerate(("Mandible", "Tooth 36", "Left mandibular canal")):
        header += f"Segment{i}_Name:={name}\nSegment{i}_LabelValue:={i + 1}\nSegment{i}_Layer:=0\n"
    (folder / "mask.seg.nrrd").write_bytes(header.encode() + b"\n" + labels)


def write_image(folder):
    """Writes a CT of a ball with a dense shell, as NRRD, and a DICOM slice of it."""
    size, spacing = 40, 0.5
    values = array.array("h")
    for z, y, x in itertools.product(range(size), repeat=3):
        radius = spacing * math.dist((x, y, z), [size / 2 - 0.5] * 3)
        dense = 1200 / (1 + math.exp((radius - 7) / 0.25))  # a blurred edge, as of a scanner
        values.append(round(-100 + dense - 700 / (1 + math.exp((radius - 5) / 0.25))))
    header = (f"NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {size} {size} {size}\n"
              f"space directions: ({spacing},0,0) (0,{spacing},0) (0,0,{spacing})\nkinds: domain domain domain\n"
              "endian: little\nencoding: raw\nspace origin: (-9.75,-9.75,0.25)\n\n")
    (folder / "ct.nrrd").write_bytes(header.encode() + values.tobytes())

    def element(group, number, kind, value):
        if isinstance(value, str):
            value = value.encode() + b" " * (len(value) % 2)
        long = kind in ("OB", "OW")
        return struct.pack("<HH2s", group, number, kind.encode()) + struct.pack("<2xI" if long else "<H", len(value)) + value
    uid, short = "1.2.3.4", struct.Struct("<H").pack
    (folder / "dicom").mkdir(exist_ok=True)
    for i in range(3):
        meta = element(2, 0x10, "UI", "1.2.840.10008.1.2.1\0")
        data = b"".join([
            element(0x08, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2\0"), element(0x08, 0x18, "UI", f"{uid}.{i}\0"),
            element(0x08, 0x60, "CS", "CT"), element(0x08, 0x103e, "LO", "ball"), element(0x20, 0x0e, "UI", uid + "\0"),
            element(0x20, 0x32, "DS", f"0\\0\\{i}"), element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"),
            element(0x28, 0x02, "US", short(1)), element(0x28, 0x04, "CS", "MONOCHROME2"),
            element(0x28, 0x10, "US", short(2)), element(0x28, 0x11, "US", short(2)), element(0x28, 0x30, "DS", "1\\1"),
            element(0x28, 0x100, "US", short(16)), element(0x28, 0x101, "US", short(16)),
            element(0x28, 0x102, "US", short(15)), element(0x28, 0x103, "US", short(1)),
            element(0x28, 0x1052, "DS", "0"), element(0x28, 0x1053, "DS", "1"),
            element(0x7fe0, 0x10, "OW", array.array("h", [0, 0, 0, 0]).tobytes())])
        (folder / f"dicom/{i}.dcm").write_bytes(bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) +
                                                meta + data)


# Kinds of blocks of a recording that contain JSON, and their schemas (docs/formats.md).
JSON_BLOCKS = {1: "recording_header", 5: "recording_event", 6: "recording_end", 7: "recording_seal"}


def read_json_blocks(path):
    """Yields (schema, text) for each block of JSON in a recording."""
    data, zstd = path.read_bytes(), ctypes.CDLL(ctypes.util.find_library("zstd"))
    zstd.ZSTD_decompress.restype = ctypes.c_size_t
    at = data.index(b"KBLK")
    while at < len(data):
        kind, packed, unpacked = struct.unpack_from("<4xBII", data, at)
        content = data[at + 54:at + 54 + packed]
        at += 54 + packed
        if kind in JSON_BLOCKS:
            text = ctypes.create_string_buffer(unpacked)
            size = zstd.ZSTD_decompress(text, ctypes.c_size_t(unpacked), content, ctypes.c_size_t(packed))
            if size != unpacked:
                raise ValueError(f"{path.name}: a block of kind {kind} can't be unpacked")
            yield JSON_BLOCKS[kind], text.raw.decode()


def damage(folder):
    """Damages a block in the middle of a recording."""
    data = bytearray((folder / "bar.kerf").read_bytes())
    data[len(data) // 2] ^= 1
    (folder / "damaged.kerf").write_bytes(data)


def move_pieces(folder):
    """Moves and hides pieces in pieces.json, as the window does, and adds a checkpoint."""
    file = folder / "assessed/pieces.json"
    pieces = json.loads(file.read_text())
    pieces["checkpoints"] = [{"name": "before", "pieces": json.loads(json.dumps(pieces["pieces"]))}]
    pieces["pieces"][0]["transform"][3] = 1.5
    (folder / "moved.json").write_text(json.dumps(pieces))


SCENES = {"block.toml": BLOCK, "bar.toml": BAR, "degrade.toml": DEGRADE, "slab.toml": SLAB, "uniform.toml": UNIFORM,
          "ball.toml": BALL, "bur.toml": BUR, "reciprocating.toml": RECIPROCATING,
          "oscillating.toml": OSCILLATING, "piezo.toml": PIEZO,
          "holes.toml": HOLES,
          "law.toml": LAW, "ct.toml": CT, "plan.toml": PLAN, "stability.toml": STABILITY, "study.toml": STUDY,
          "through.toml": THROUGH, "forces.csv": FORCES, "torque.csv": TORQUES}

# Each group runs in its own folder, one command after another; two groups run at a time, longest first. If a command needs a
# part of kerf that was not built, the rest of its group is skipped too.
GROUPS = {
    "undo bench": [Case("bench undo --rounds 1 --voxel 1 --json", "bench_undo")],
    "stability": [
        Case("stability stability.toml --quick -o out --json", "stability", {"out/stability.json": "stability"},
             codes=(0, 1))],
    "study": [
        Case("study study.toml --dry-run --json", "study_plan"),
        Case("study study.toml -o out --data none --shard 0/2 --json", "study_shard"),
        Case("study study.toml -o out --data none --shard 1/2 --json", "study_shard"),
        Case("study --merge -o out --json", "study_results",
             {"out/study.json": "study", "out/plan.json": "study_folder", "out/shard-*/plan.json": "study_folder",
              "out/cases/*.json": "study_record", "out/references/*.json": "study_reference"})],
    "profiles": [Case("stability stability.toml --profiles --json", "stability_profiles", codes=(0, 1), interrupt_s=6)],
    "practise": [
        Case("practise --list --json", "exercises"),
        Case("practise --agent expert --exercise groove --record a.kerf"),
        Case("practise --hand-in a.kerf --student Ann --json", "score"),
        Case("practise --agent expert --exercise groove --seconds 1 --record b.kerf"),
        Case("score b.kerf --json", "score"),
        Case("practise --hand-in b.kerf --student Bob --json", "score"),
        Case("practise --history --json", "history"),
        Case("practise --agent expert --exercise holes.toml --record holes.kerf"),
        Case("score holes.kerf --json", "score")],
    "tune": [
        # The scene's own voxel size of 0.4 mm has an error of 2.5 %, 0.2 mm of 0.4 %: the settings change in any case.
        Case("tune block.toml --budget-us 1000000 --error 1% --ticks 1000 --voxels 0.2 --seconds 0.2 --in-place --json",
             "tune", {"block.tune.json": "tune"}),
        Case("tune bar.toml --budget-us 1 --ticks 1000 --voxels 0.2 --seconds 0.2 --dry-run --json", "tune", codes=(1,))],
    "view bench": [Case("bench view --frames 5 --voxel 1 --cut 1 --width 320 --height 240 --json", "bench_view")],
    "benches": [
        Case("bench tick --case disc-0.2,idle --ticks 1 --json", "bench_tick"),
        Case("bench devices --rounds 10 --models-only --json", "bench_devices")],
    "loop": [
        Case("loop bar.toml --virtual --seconds 3 --record bar.kerf -o out --full --do 0.1:checkpoint=a --do 0.2:undo --json",
             "loop", {"out/loop.json": "loop"}, recording="bar.kerf"),
        Case("loop block.toml --seconds 0.5 --costs --do 0.1:checkpoint=a --do 0.2:undo --json", "loop"),
        Case("loop degrade.toml --seconds 1 --burn-us 5000 --json", "loop"),
        Case("replay bar.kerf --json", "replay"),
        Case("log bar.kerf --json", "log"),
        Case("replay damaged.kerf -o replayed --json", "replay", {"replayed/loop.json": "loop"}, codes=(3,), before=damage),
        Case("log damaged.kerf --json", "log", codes=(3,)),
        Case("score bar.kerf --json", "score"),
        Case("log --make-key"),
        Case("run slab.toml -o slab --record slab.kerf --json", "run_slab", {"slab/summary.json": "run_slab"},
             recording="slab.kerf"),
        Case("log slab.kerf --json", "log")],
    "run": [
        Case("run bar.toml -o bar --costs --json", "run", {"bar/summary.json": "run"}),
        Case("run ball.toml -o ball --json", "run"),
        Case("run uniform.toml -o uniform --json", "run"),
        Case("run law.toml --uncertain 3 -o band --json", "uncertain", {"band/uncertain.json": "uncertain"}),
        Case("run law.toml --uncertain 3 -o parts_of_band --shard 0/2 --json", "uncertain_shard",
             {"parts_of_band/shard-0-of-2/samples.json": "uncertain_samples"}),
        Case("run law.toml --uncertain 3 -o parts_of_band --merge --json", "uncertain", codes=(1,)),
        Case("info bar/bone.vdb --json", "info"),
        Case("export bar/bone.vdb -o bone.stl --pieces --triangles 500 --min-piece 3 --json", "export"),
        Case("export bar/bone.vdb -o whole.stl --json", "export"),
        Case("export bar/bone.vdb --seg whole.seg.nrrd --json", "export"),
        Case("model block -o block.vdb --voxel 0.5 --size 6,5,6 --json", "model"),
        Case("model plate -o plate.vdb --voxel 1 --json", "model"),
        Case("model mandible -o mandible.vdb --voxel 1 --json", "model"),
        Case("slab block.vdb -o parts --plane 0,0,-3,1,0,0 --thickness 0.5 --no-picture --json", "parts",
             {"parts/parts.json": "parts"}),
        Case("import whole.stl -o imported.vdb --voxel 0.4 --units mm --json", "import")],
    "plan": [
        Case("loop plan.toml --virtual --seconds 2 --record plan.kerf"),
        Case("assess plan.kerf -o assessed --no-pictures --smallest-piece 0.2 --json", "assessment",
             {"assessed/assessment.json": "assessment", "assessed/pieces.json": "pieces",
              "assessed/transforms.json": "transforms", "assessed/*.mrk.json": "markups"}),
        Case("assess plan.kerf -o moved --no-pictures --smallest-piece 0.2 --pieces moved.json --json", "assessment",
             {"moved/pieces.json": "pieces", "moved/transforms.json": "transforms"}, before=move_pieces)],
    "experiments": [
        Case("effects --json", "effects"),
        Case("effects heat --json", "effects"),
        Case("effects bar.toml --seconds 0.1 --passes 1 --json", "effect_costs"),
        Case("stability stability.toml --sweep --keys coupling.damping --pairs 0 --case-seconds 0.1 --json",
             "stability_sweep"),
        Case("calibrate forces.csv -o calibrated --bootstrap 200 --json", "calibrate",
             {"calibrated/calibrate.json": "calibrate"}),
        Case("calibrate torque.csv --bootstrap 0 --json", "calibrate"),
        Case("compare block.toml -o compare --repeat 1 --depth-step 1 --json", "compare",
             {"compare/compare.json": "compare"}),
        Case("validate -o validate --json", "validate", {"validate/validate.json": "validate"})],
    "import": [
        Case("import ct.nrrd -o ct.vdb --no-isolate --voxel 0.5 --keep-hu --json", "import", before=write_image),
        Case("import --mask mask.seg.nrrd -o mask.vdb --voxel 0.5 --json", "import", before=write_segmentation),
        Case("import dicom --list --json", "import_list"),
        Case("info ct.vdb --json", "info"),
        Case("check ct.toml --json", "check")],
    "devices": [Case("devices --json", "devices")],
    "rest": [
        Case("check block.toml --json", "check"),
        Case("check slab.toml --json", "check"),
        Case("check ball.toml --json", "check"),
        Case("check bur.toml --json", "check"),
        Case("check reciprocating.toml --json", "check"),
        Case("check oscillating.toml --json", "check"),
        Case("check piezo.toml --json", "check"),
        Case("check uniform.toml --json", "check"),
        Case("check bar.toml --json", "check"),
        Case("devices --profiles --json", "device_profiles"),
        Case("materials --json", "materials"),
        Case("paper --json", "paper"),
        Case("reference --json", "reference")],
}


def make_device_group(where):
    """Returns the cases with the simulated device of tools/bridge/example.c, which listens at `where`."""
    bridge = f"bridge --bridge {where}"
    return [Case(f"device test {bridge} --circle 2 --buttons 0 --json", "device_test", codes=(0, 1)),
            Case(f"loop block.toml --device {bridge} --profile touch --seconds 0.5 --json", "loop", codes=(0, 1))]
