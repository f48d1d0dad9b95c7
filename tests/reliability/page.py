"""The page with the results of these tests."""

import pathlib

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/reliability.md"


def write_results(mark, text):
    """Replaces the results on the page between `<!-- mark -->` and `<!-- end -->`."""
    before, rest = PAGE.read_text(encoding="utf-8").split(f"<!-- {mark} -->\n", 1)
    PAGE.write_text(before + f"<!-- {mark} -->\n" + text + "<!-- end -->" + rest.split("<!-- end -->", 1)[1], encoding="utf-8")
