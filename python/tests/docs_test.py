"""The session in docs/python.md prints what its comments say."""

import contextlib
import io
import os
import re
import subprocess
import tempfile
import unittest

SOURCE = os.environ["KINEGRAPH_SOURCE"]
APPS = os.environ["KINEGRAPH_APPS"]
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def expected(code):
    """Comments after print(...), and lines that are a comment alone."""
    for line in code.splitlines():
        match = re.match(r"(?:print\(.*\) *)?# (.*)", line)
        if match:
            yield match.group(1)


def alike(said, printed):
    """The same words; numbers within two per cent. A comment may go on."""
    words = NUMBER.sub("#", said).split()
    found = NUMBER.sub("#", printed).split()
    if [w.rstrip(":;") for w in words[: len(found)]] != found:
        return False
    return all(
        abs(float(a) - float(b)) <= 0.02 * max(float(a), float(b))
        for a, b in zip(NUMBER.findall(said), NUMBER.findall(printed))
    )


class Session(unittest.TestCase):
    def test_alike(self):
        self.assertTrue(alike("(5, 3): frames; metres", "(5, 3)"))
        self.assertTrue(alike("0.0162", "0.016201"))
        self.assertFalse(alike("0.0162", "0.0171"))
        self.assertFalse(alike("(5, 3): frames", "(5, 4)"))
        self.assertFalse(alike("raw 0.1", "batch 0.1"))

    def test_prints_what_it_says(self):
        with open(os.path.join(SOURCE, "docs", "python.md")) as file:
            code = re.search(r"```python\n(.*?)```", file.read(), re.S).group(1)
        printed = io.StringIO()
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                subprocess.run(
                    [
                        os.path.join(APPS, "kinegraph-synthesize"),
                        "--config=" + SOURCE + "/configs/synthetic/demo.toml",
                        "--out=out/scene",
                    ],
                    check=True,
                    stdout=subprocess.DEVNULL,
                )
                with contextlib.redirect_stdout(printed):
                    exec(compile(code, "docs/python.md", "exec"), {})
            finally:
                os.chdir(before)
        lines = printed.getvalue().splitlines()
        said = list(expected(code))
        self.assertEqual(len(said), len(lines), (said, lines))
        for one, line in zip(said, lines):
            self.assertTrue(alike(one, line), f"says {one!r}, prints {line!r}")


if __name__ == "__main__":
    unittest.main()
