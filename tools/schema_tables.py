#!/usr/bin/env python3
"""Writes the tables of JSON keys in docs/formats.md and docs/json.md, which describe the schemas of docs/schemas.

    tools/schema_tables.py [--check]

A section <!-- keys of NAME --> ... <!-- end --> shows the keys of docs/schemas/NAME.schema.json. Every schema must have one
section, that of the common parts in docs/json.md. The keys of an object with the $comment "columns of TABLE" are those that
docs/formats.md describes as columns of that table; they are not repeated. --check only compares, and exits with 1 if a
section is missing or differs. `tools/docs --pages` also writes the tables.
"""

import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCHEMAS = ROOT / "docs/schemas"
PAGES = [ROOT / "docs/formats.md", ROOT / "docs/json.md"]
END = ".schema.json"
WORDS = {"string": ("text", "texts"), "number": ("number", "numbers"), "integer": ("whole number", "whole numbers"),
         "boolean": ("true or false", "true or false"), "object": ("object", "objects")}


def load_schemas():
    return {path.name[:-len(END)]: json.loads(path.read_text(encoding="utf-8")) for path in sorted(SCHEMAS.glob("*" + END))}


def make_anchor(title):
    return re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-")


def list_words(values):
    words = [f"`{json.dumps(value) if not isinstance(value, str) else value}`" for value in values if value is not None]
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " or " + words[-1]


class Tables:
    """Formats one schema. `common`: the common parts, to which others refer; `page`: page with their descriptions."""

    def __init__(self, schema, common, page=""):
        self.schema, self.common, self.page = schema, common, page

    def find(self, reference):
        """Returns the definition that a reference names."""
        name = reference.split("/")[-1]
        return (self.common if reference.startswith("common") else self.schema)["$defs"][name]

    def describe_reference(self, reference, several):
        target = self.find(reference)
        if target.get("type", "object") != "object":
            return plural(target["title"]) if several else target["title"]
        if self.schema.get("$ref") == reference:
            return "objects like this one" if several else "object like this one"
        title = target["title"]
        text = title if title[1].isupper() else title[0].lower() + title[1:]
        page = self.page if reference.startswith("common") else ""
        link = f"[{text}]({page}#{make_anchor(title)})"
        return f"{link} objects" if several else link

    def describe_type(self, node, several=False):
        if "$ref" in node:
            return self.describe_reference(node["$ref"], several)
        if "anyOf" in node:
            return f"{self.describe_type(node['anyOf'][0], several)} or null"
        if "const" in node:
            return f"`{json.dumps(node['const'])}`"
        types = node.get("type", "object")
        types = [types] if isinstance(types, str) else types
        texts = []
        for kind in types:
            if kind == "null":
                continue
            if kind == "array":
                item = node.get("items", {})
                nullable = "null" in item.get("type", ()) or "anyOf" in item  # "number or null" reads as the whole list
                count = node["minItems"] if node.get("minItems") and node.get("minItems") == node.get("maxItems") else None
                items = f"({self.describe_type(item, True)})" if nullable else self.describe_type(item, True)
                of = f"{count} {items}" if count else f"list of {items}"
                texts.append("list" if not item else of if not several else f"lists of {of.removeprefix('list of ')}")
            elif kind == "object" and isinstance(node.get("additionalProperties"), dict):
                texts.append(f"map of {self.describe_type(node['additionalProperties'], True)}")
            elif "enum" in node:
                texts.append("words" if several else "word")
            elif kind == "integer" and node.get("minimum") == 0:
                texts.append("counts" if several else "count")
            else:
                texts.append(WORDS[kind][several])
        text = " or ".join(texts)
        return text if "null" not in types else "true, false or null" if text == WORDS["boolean"][0] else f"{text} or null"

    def list_rows(self, node, prefix=""):
        """Yields (key, type, meaning) of an object's keys, each followed by those within it."""
        for key, value in node.get("properties", {}).items():
            kind = self.describe_type(value) + ("" if key in node.get("required", []) else ", optional")
            meaning = value["description"]
            inner, path = value, prefix + key
            while inner.get("type") in ("array", ["array", "null"]) and "items" in inner:
                inner, path = inner["items"], path + "[]"
            if "enum" in inner:
                meaning += ("; " if set(meaning) & set(":;") else ": ") + list_words(inner["enum"])
            comment = inner.get("$comment", "")
            yield prefix + key, kind, meaning + describe_columns(comment)
            if not comment:
                yield from self.list_rows(inner, path + ".")
        for part in node.get("allOf", []):
            yield from Tables(self.common, self.common, self.page).list_rows(self.find(part["$ref"]), prefix)

    def format_table(self, node):
        rows = [("key", "type", "meaning"), ("---", "---", "---")]
        rows += [(f"`{key}`", kind, link_pages(meaning).replace("|", "\\|")) for key, kind, meaning in self.list_rows(node)]
        return "".join(f"| {' | '.join(row)} |\n" for row in rows)

    def format_definition(self, node):
        """Returns the description of a part, and its keys."""
        text = f"{link_pages(sentence(node['description']))}\n\n"
        for variant in node.get("oneOf", []):
            key, value = next((key, value["const"]) for key, value in variant["properties"].items() if "const" in value)
            text += f"`{key}` is `{value}`:\n\n{self.format_table(variant)}\n"
        return text + (self.format_table(node) + "\n" if "properties" in node else "")


def describe_columns(comment):
    """Returns a link to the section of docs/formats.md with the columns that the $comment of an object names."""
    if not comment:
        return ""
    text = PAGES[0].read_text(encoding="utf-8")
    heading = re.findall(r"^#+ (.+)$", text[:text.index(f"<!-- {comment} -->")], re.M)[-1]
    return f"; its keys are the {comment.split(' of ')[0]} of `{comment.split(' of ')[1]}` in [{heading}](formats.md#{make_anchor(heading)})"


def plural(title):
    first = title.split(" ")[0]
    return title.replace(first, {"matrix": "matrices"}.get(first, first + ("es" if first.endswith("sh") else "s")), 1)


def sentence(text):
    return text[0].upper() + text[1:] + "."


def link_pages(text):
    return re.sub(r"\bdocs/([a-z_]+\.md)", r"[\1](\1)", text)


def format_common(common):
    """Returns the section of the common parts: the simple types in one table, then each object."""
    tables = Tables(common, common)
    simple = {name: node for name, node in common["$defs"].items() if node.get("type", "object") != "object"}
    text = "| type | meaning |\n| --- | --- |\n"
    for node in simple.values():
        words = f": {list_words(node['enum'])}" if "enum" in node else ""
        text += f"| {node['title']} | {link_pages(node['description'])}{words} |\n"
    for name, node in common["$defs"].items():
        if name not in simple:
            text += f"\n### {node['title']}\n\n{tables.format_definition(node)}".rstrip("\n") + "\n"
    return text


def format_section(name, schemas, page):
    if name == "common":
        return format_common(schemas["common"])
    schema, common = schemas[name], schemas["common"]
    tables = Tables(schema, common, page)
    text = f"{link_pages(sentence(schema['description']))} Schema: [{name}{END}](schemas/{name}{END}).\n\n"
    definitions = dict(schema.get("$defs", {}))
    if schema.get("type") == "array":
        text += f"The document is a list of objects with these keys:\n\n{tables.format_table(schema['items'])}"
    elif "$ref" in schema:
        text += tables.format_definition(definitions.pop(schema["$ref"].split("/")[-1]))
    else:
        text += tables.format_table(schema)
    for node in definitions.values():
        text = text.rstrip("\n") + f"\n\n#### {node['title']}\n\n{tables.format_definition(node)}"
    return text.rstrip("\n") + "\n"


def fill_pages():
    """Returns [(page, text before, text with all sections)]. Exits if a schema does not have one section, or vice versa."""
    schemas, found, filled = load_schemas(), [], []
    for page in PAGES:
        before = page.read_text(encoding="utf-8")
        common_page = "" if page.name == "json.md" else "json.md"

        def fill(match, common_page=common_page):
            found.append(match[1])
            if match[1] not in schemas:
                sys.exit(f"tools/schema_tables.py: there is no docs/schemas/{match[1]}{END}")
            return f"<!-- keys of {match[1]} -->\n\n{format_section(match[1], schemas, common_page)}\n<!-- end -->\n"
        text = re.sub(r"^<!-- keys of (\S+) -->\n.*?^<!-- end -->\n", fill, before, flags=re.S | re.M)
        filled.append((page, before, text))
    for name in schemas:
        if found.count(name) != 1:
            sys.exit(f"tools/schema_tables.py: there are {found.count(name)} sections \"<!-- keys of {name} -->\" instead of one")
    return filled


def write_tables():
    """Called by tools/docs."""
    for page, _, text in fill_pages():
        page.write_text(text, encoding="utf-8")


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        print(__doc__.strip())
        return 0 if sys.argv[1] in ("-h", "--help") else 2
    if not sys.argv[1:]:
        write_tables()
        return 0
    differ = [page.name for page, before, text in fill_pages() if before != text]
    for name in differ:
        print(f"docs/{name}: the tables of JSON keys differ from docs/schemas; run tools/schema_tables.py")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
