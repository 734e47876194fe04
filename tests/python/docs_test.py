"""The session in docs/python.md prints its comments; README's example runs."""

import contextlib
import io
import os
import re
import tempfile
import unittest

from support import SOURCE, synthesize

NUMBER = re.compile(r"\d+(?:\.\d+)?")


def expected(code):
    """Comments after print(...), and comment lines."""
    for line in code.splitlines():
        match = re.match(r"(?:print\(.*\) *)?# (.*)", line)
        if match:
            yield match.group(1)


def alike(said, printed):
    """Whether words are equal and numbers differ by at most two per cent; `said`, the
    comment, may be longer than the output."""
    words = NUMBER.sub("#", said).split()
    found = NUMBER.sub("#", printed).split()
    if [w.rstrip(":;") for w in words[: len(found)]] != found:
        return False
    return all(
        abs(float(a) - float(b)) <= 0.02 * max(float(a), float(b))
        for a, b in zip(NUMBER.findall(said), NUMBER.findall(printed))
    )


def code_of(page):
    """The first block of Python code on a page."""
    with open(os.path.join(SOURCE, page)) as file:
        return re.search(r"```python\n(.*?)```", file.read(), re.S).group(1)


@contextlib.contextmanager
def scene(*settings):
    """Changes to a temporary folder with the demo's scene in out/scene."""
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            synthesize("out/scene", *settings)
            yield
        finally:
            os.chdir(before)


class Session(unittest.TestCase):
    def test_alike_compares_words_and_numbers(self):
        self.assertTrue(alike("(5, 3): frames; metres", "(5, 3)"))
        self.assertTrue(alike("0.0162", "0.016201"))
        self.assertFalse(alike("0.0162", "0.0171"))
        self.assertFalse(alike("(5, 3): frames", "(5, 4)"))
        self.assertFalse(alike("raw 0.1", "batch 0.1"))

    def test_session_prints_its_comments(self):
        code = code_of("docs/python.md")
        printed = io.StringIO()
        with scene(), contextlib.redirect_stdout(printed):
            exec(compile(code, "docs/python.md", "exec"), {})
        lines = printed.getvalue().splitlines()
        said = list(expected(code))
        self.assertEqual(len(said), len(lines), (said, lines))
        for one, line in zip(said, lines):
            self.assertTrue(alike(one, line), f"says {one!r}, prints {line!r}")

    def test_readme_example_runs(self):
        names = {}
        with scene("scene.duration=2"):
            os.rename("out/scene/cameras.json", "calibration.json")
            os.rename("out/scene/detections.jsonl", "detections.jsonl")
            exec(compile(code_of("README.md"), "README.md", "exec"), names)
        self.assertEqual(names["tracks"].positions_m.shape[0], 50)


if __name__ == "__main__":
    unittest.main()
