#!/usr/bin/env python3
"""Checks docs/schemas against the documents that kerf writes.

    tests/schemas/check_schemas.py KERF [--bridge PROGRAM] [--only GROUP ...]
    tests/schemas/check_schemas.py --self-test

Runs the commands of cases.py on small inputs and validates each document that they print or write. Reports a document
that does not match its schema (a missing or additional key, a wrong type), a property without a description, a property
that no document contains, a schema that no case uses, and a command with the option --json that has no case. PROGRAM is
tools/bridge/example.c, compiled; without it, no device is tested. A case that needs a part of kerf that was not built is
skipped. --self-test plants one fault of each kind and checks that it is reported.
"""

import argparse
import collections
import concurrent.futures
import contextlib
import copy
import fnmatch
import json
import os
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time

import cases

try:
    import jsonschema
except ImportError:
    # tools/setup installs the module for Debian's Python, which need not be the first on the PATH.
    if (sys.prefix, sys.base_prefix) != ("/usr", "/usr") and os.path.exists("/usr/bin/python3"):
        os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv])
    print("tests/schemas/check_schemas.py: the Python module jsonschema is missing; install it with tools/setup --tests")
    sys.exit(77)  # ctest: skipped

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FOLDER = ROOT / "docs/schemas"
END = ".schema.json"
LIMIT_S = 1800  # of a command; validate takes three minutes on an idle machine
NOT_BUILT = "this kerf was built without"

# Commands and schemas without a case, with the reason.
NO_CASE = {"kerf rehearse": "rehearse", "kerf device test": "device_test"}
NEEDS = {"rehearse": "a display, and a user who closes the window", "device_test": "a device, or --bridge"}
# Properties that no document of the cases contains: pattern of the name -> reason.
UNSEEN = {
    "bench_tick.cases[].targets[].at_least": "only in the case memory, which takes a minute",
    "devices.devices[].*": "a connected device",
    "loop.served.*": "a device, or --bridge",
    "tune.candidate.why_not": "settings with which a tick fails",
    "pieces.actions[].piece": "an action in the window",
    "pieces.actions[].transform": "an action in the window",
    "replay.divergence*": "a recording of a version of kerf that computes other forces",
}


def load_schemas():
    return {path.name[:-len(END)]: json.loads(path.read_text(encoding="utf-8")) for path in sorted(FOLDER.glob("*" + END))}


def bundle(schemas):
    """Returns one schema that contains all, so that references need no resolution of files."""
    def rewrite(node, name):
        if isinstance(node, list):
            return [rewrite(item, name) for item in node]
        if not isinstance(node, dict):
            return node
        node = {key: rewrite(value, name) for key, value in node.items() if key not in ("$id", "$schema")}
        if isinstance(node.get("$ref"), str):
            file, place = node["$ref"].split("#")
            node["$ref"] = f"#/$defs/{file[:-len(END)] if file else name}{place}"
        return node
    return {"$defs": {name: rewrite(schema, name) for name, schema in schemas.items()}}


def subschemas(node, name):
    """Yields (name, schema) of a schema and of all that it contains; name: "loop.ticks.count"."""
    yield name, node
    for key, value in node.get("properties", {}).items():
        yield from subschemas(value, f"{name}.{key}")
    for key, value in node.get("$defs", {}).items():
        yield from subschemas(value, f"{name}.{key}")
    if isinstance(node.get("additionalProperties"), dict):
        yield from subschemas(node["additionalProperties"], f"{name}.*")
    if isinstance(node.get("items"), dict):
        yield from subschemas(node["items"], f"{name}[]")
    for part in ("allOf", "anyOf", "oneOf"):
        for value in node.get(part, []):
            yield from subschemas(value, name)


def list_properties(schemas):
    return {f"{owner}.{key}" for name, schema in schemas.items() for owner, node in subschemas(schema, name)
            for key in node.get("properties", {})}


def check_texts(schemas):
    """Yields the faults of the schemas themselves."""
    # Parts of objects, which permit other keys; the objects that include them do not.
    parts = {part["$ref"].split("/")[-1] for name, schema in schemas.items() for _, node in subschemas(schema, name)
             for part in node.get("allOf", [])}
    for name, schema in schemas.items():
        try:
            jsonschema.Draft202012Validator.check_schema(schema)
        except jsonschema.SchemaError as error:
            yield f"{name}: {error.message}"
        for key in ("$schema", "$id", "title", "description"):
            if not schema.get(key):
                yield f"{name}: has no {key}"
        for owner, node in subschemas(schema, name):
            for key, value in node.get("properties", {}).items():
                if not value.get("description"):
                    yield f"{owner}.{key}: has no description"
            for key in node.get("required", []):
                if key not in node.get("properties", {}):
                    yield f"{owner}.{key}: is required, but not described"
            is_closed = False in (node.get("additionalProperties"), node.get("unevaluatedProperties"))
            if "properties" in node and not is_closed and owner.split(".")[-1] not in parts:
                yield f"{owner}: permits keys without a description"


class Checker:
    """Validates documents, and notes which properties they contain."""

    def __init__(self, schemas):
        self.bundle = bundle(schemas)
        self.validator = jsonschema.Draft202012Validator(self.bundle)
        self.seen = set()

    def check(self, name, document):
        """Returns the faults of a document, each as "place: message"."""
        schema = {"$ref": f"#/$defs/{name}"}
        faults = []
        for error in self.validator.evolve(schema=schema).iter_errors(document):
            error = jsonschema.exceptions.best_match([error])
            place = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in error.absolute_path)
            faults.append(f"{name}{place}: {error.message[:300]}")
        if not faults:
            self.note(schema, name, document)
        return faults

    def note(self, node, name, value):
        while "$ref" in node:
            parts = node["$ref"].split("/")[2:]
            name = ".".join(part for part in parts if part != "$defs")
            node = self.bundle["$defs"][parts[0]]
            for part in parts[1:]:
                node = node[part]
        for part in ("allOf", "anyOf", "oneOf"):
            for branch in node.get(part, []):
                if self.validator.evolve(schema=branch).is_valid(value):
                    self.note(branch, name, value)
        if isinstance(value, dict):
            for key, item in value.items():
                if key in node.get("properties", {}):
                    self.seen.add(f"{name}.{key}")
                    self.note(node["properties"][key], f"{name}.{key}", item)
                elif isinstance(node.get("additionalProperties"), dict):
                    self.note(node["additionalProperties"], f"{name}.*", item)
        if isinstance(value, list) and isinstance(node.get("items"), dict):
            for item in value:
                self.note(node["items"], f"{name}[]", item)

    def find_unseen(self, schemas, left_out):
        """Yields the properties that no document contains, and exceptions that match nothing. `left_out`: schemas."""
        properties = list_properties(schemas)
        for name in sorted(properties - self.seen):
            if re.split(r"[.\[]", name)[0] not in left_out and not any(fnmatch.fnmatchcase(name, escape(p)) for p in UNSEEN):
                yield f"{name}: no document contains it"
        for pattern in UNSEEN:
            if not fnmatch.filter(properties, escape(pattern)):
                yield f"{pattern}: is an exception of check_schemas.py, but no property"


def escape(pattern):
    return pattern.replace("[]", "[[]]")


def list_commands(command):
    """Yields the names of the commands that have the option --json."""
    if any("--json" in option["names"] for option in command["options"]):
        yield command["name"]
    for child in command["commands"]:
        yield from list_commands(child)


def list_schemas(group):
    return {schema for case in group
            for schema in (case.schema, *case.files.values(), *(cases.JSON_BLOCKS.values() if case.recording else ()))}


def check_cases(commands, schemas, groups, no_case):
    """Yields the commands and the schemas that no case uses. `no_case`: command -> schema."""
    every = [case for group in groups.values() for case in group]
    for command in commands:
        prefix = command.removeprefix("kerf ") + " "
        has_case = any(case.arguments.startswith(prefix) and "--json" in case.arguments for case in every)
        if command not in no_case and not has_case:
            yield f"{command} --json: has no case"
    used = {"common", *no_case.values()} | list_schemas(every)
    for name in sorted(schemas.keys() - used):
        yield f"{name}: no case uses this schema"
    for name in sorted(used - schemas.keys() - {""}):
        yield f"{name}: there is no such schema"


def run_command(kerf, case, folder, environment):
    """Returns the finished process; an interrupted command is repeated with more time if it printed nothing."""
    for factor in (1, 4, 16):
        process = subprocess.Popen([kerf, *shlex.split(case.arguments)], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        try:
            out, err = process.communicate(timeout=factor * case.interrupt_s or LIMIT_S)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)
            try:
                out, err = process.communicate(timeout=LIMIT_S)
            except subprocess.TimeoutExpired:
                process.kill()
                out, err = process.communicate()
        finally:
            process.kill()
        if out or not case.interrupt_s or process.returncode == 0:
            break
    return process.returncode, out.decode(errors="replace"), err.decode(errors="replace")


def run_group(kerf, group, folder):
    """Runs the commands of a group. Returns [(whether a part of kerf was not built, faults, documents)] of each;
    documents: [(place, schema, JSON)]."""
    folder.mkdir()
    for name, text in cases.SCENES.items():
        (folder / name).write_text(text)
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    environment |= {"HOME": str(folder), "XDG_DATA_HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
    results = []
    for case in group:
        command = f"kerf {case.arguments}"
        if case.before:
            case.before(folder)
        code, out, err = run_command(kerf, case, folder, environment)
        is_absent = code != 0 and NOT_BUILT in err
        if is_absent or code not in case.codes:
            fault = f"{command}: exit code {code}, expected {case.codes}: {err.strip()[-600:]}"
            results.append((is_absent, [err.strip() if is_absent else fault], []))
            break  # the following commands may need its results
        faults, documents = [], [(command, case.schema, out)] if case.schema else []
        for pattern, schema in case.files.items():
            files = sorted(folder.glob(pattern))
            if not files:
                faults.append(f"{command}: wrote no {pattern}")
            documents += [(f"{command}: {file.relative_to(folder)}", schema, file.read_text(encoding="utf-8")) for file in files]
        if case.recording:
            documents += [(f"{command}: {case.recording}", schema, text)
                          for schema, text in cases.read_json_blocks(folder / case.recording)]
        parsed = []
        for place, schema, text in documents:
            try:
                parsed.append((place, schema, json.loads(text)))
            except ValueError as error:
                faults.append(f"{place}: not JSON: {error}")
        results.append((False, faults, parsed))
    return results


class Bridge:
    """tools/bridge/example.c at a free port."""

    def __init__(self, program):
        self.process = subprocess.Popen([program, "0"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        where = re.search(r"127\.0\.0\.1:\d+", self.process.stdout.readline())
        if not where:
            sys.exit(f"tests/schemas/check_schemas.py: {program} prints no address")
        self.where = where[0]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


def check_example(document):
    """Runs the program of docs/json.md, which validates a document, on kerf reference --json and on one without a key."""
    program = re.search(r"^```py\n(.*?)^```", (ROOT / "docs/json.md").read_text(encoding="utf-8"), re.M | re.S)[1]
    wrong = {key: value for key, value in document.items() if key != "commands"}
    for given, expected in ((document, True), (wrong, False)):
        done = subprocess.run([sys.executable, "-W", "ignore", "-c", program, "reference"], cwd=ROOT, input=json.dumps(given),
                              capture_output=True, text=True)
        if (done.returncode == 0) != expected:
            yield f"docs/json.md: the program finds the document {'wrong' if expected else 'right'}: {done.stderr.strip()[-200:]}"


def check(kerf, bridge, only):
    """Checks all commands; `bridge` may be None. Returns the exit code."""
    schemas = load_schemas()
    faults = list(check_texts(schemas))
    checker = Checker(schemas)
    groups, no_case = dict(cases.GROUPS), dict(NO_CASE)
    if bridge:
        groups = {"device": cases.make_device_group(bridge.where), **groups}
        del no_case["kerf device test"]
    reference = json.loads(subprocess.run([kerf, "reference", "--json"], capture_output=True, check=True).stdout)
    faults += [*check_cases(list_commands(reference), schemas, groups, no_case), *check_example(reference)]
    groups = {name: group for name, group in groups.items() if not only or name in only}
    left_out, count = set(no_case.values()), collections.Counter()
    with tempfile.TemporaryDirectory(prefix="kerf_schemas_") as name, concurrent.futures.ThreadPoolExecutor(2) as pool:
        def run(title):
            began = time.monotonic()
            results = run_group(kerf, groups[title], pathlib.Path(name) / title.replace(" ", "_"))
            print(f"{time.monotonic() - began:6.1f} s  {title}", flush=True)
            return results
        for title, results in zip(groups, pool.map(run, groups)):
            for is_absent, found, documents in results:
                if is_absent:
                    print(f"skipped: {title}: {found[0]}")
                    left_out |= {"common"} | list_schemas(groups[title])
                    continue
                faults += found
                for place, schema, document in documents:
                    count[schema] += 1
                    faults += [f"{place}\n    {fault}" for fault in checker.check(schema, document)]
    if not only and not faults:  # otherwise documents are missing
        faults += checker.find_unseen(schemas, left_out)
    for schema in sorted(set(no_case.values())):
        print(f"not checked: {schema}: needs {NEEDS[schema]}")
    print(*faults, sep="\n", end="\n" if faults else "")
    print(f"{sum(count.values())} documents, {len(count)} of {len(schemas) - 1} schemas, {len(faults)} faults")
    return 1 if faults else 0


def self_test():
    """Plants a fault of each kind. Returns 1 if one of them is not reported."""
    schemas = load_schemas()
    document = {"schema": 1, "shard": "0/2", "kept": 0, "made": 2, "failed": 0, "omitted": 0}
    shard = copy.deepcopy(schemas)
    del shard["study_shard"]["properties"]["made"]["description"]
    more = copy.deepcopy(schemas)
    more["study_shard"]["properties"]["never"] = {"description": "never written", "type": "string"}
    open_object = copy.deepcopy(schemas)
    del open_object["study_shard"]["additionalProperties"]
    wrong = copy.deepcopy(schemas)
    wrong["study_shard"]["properties"]["made"]["type"] = "whole"
    checker = Checker(more)
    checker.check("study_shard", document)
    two = {name: schemas[name] for name in ("common", "study_shard")}
    group = {"shard": [cases.Case("study --json", "study_shard")]}
    machine = {"cpu": "", "cores": 2, "load_before": 0, "core": None, "realtime": False, "vector_width": None}
    run = {"kerf": "", "commit": "", "compiler": "", "machine": machine, "schema": 1, "exchanges": []}
    unplanted = [*check_texts(schemas), *Checker(schemas).check("study_shard", document),
                 *Checker(schemas).check("bench_devices", run)]
    planted = {
        "a key is missing": Checker(schemas).check("study_shard", {k: v for k, v in document.items() if k != "made"}),
        "a key is not described": Checker(schemas).check("study_shard", document | {"more": 1}),
        "a key is not described, next to an included part": Checker(schemas).check("bench_devices", run | {"more": 1}),
        "a type is wrong": Checker(schemas).check("study_shard", document | {"made": "2"}),
        "null is not permitted": Checker(schemas).check("study_shard", document | {"made": None}),
        "a count is negative": Checker(schemas).check("study_shard", document | {"made": -1}),
        "a property has no description": list(check_texts(shard)),
        "an object permits other keys": list(check_texts(open_object)),
        "a schema is invalid": list(check_texts(wrong)),
        "no document contains a property": [
            fault for fault in checker.find_unseen(more, schemas.keys() - {"study_shard"}) if "study_shard.never" in fault],
        "a command has no case": list(check_cases(["kerf study", "kerf new"], two, group, {})),
        "a schema has no case": list(check_cases(["kerf study"], two | {"new": {}}, group, {})),
    }
    for title, found in planted.items():
        print(f"{title}: {found[0] if found else 'NOT REPORTED'}")
    print(*unplanted, sep="\n", end="\n" if unplanted else "")
    return 1 if unplanted or not all(planted.values()) else 0


def main():
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored after nohup; the commands would inherit that
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kerf", type=pathlib.Path, nargs="?")
    parser.add_argument("--bridge", type=pathlib.Path, help="the compiled tools/bridge/example.c")
    parser.add_argument("--only", action="append", choices=["device", *cases.GROUPS], help="only this group of cases, such as loop; no check for unseen properties")
    parser.add_argument("--self-test", action="store_true")
    arguments = parser.parse_args()
    if arguments.self_test:
        return self_test()
    if arguments.kerf is None:
        parser.error("give the program")
    with Bridge(arguments.bridge) if arguments.bridge else contextlib.nullcontext() as bridge:
        return check(arguments.kerf.resolve(), bridge, arguments.only)


if __name__ == "__main__":
    sys.exit(main())
