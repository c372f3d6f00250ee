"""The page docs/how-to/python.md runs as written, and names, types and docstrings are complete."""

import ast
import contextlib
import inspect
import io
import os
import re
import unittest

import powbench
from fixture import SOURCE, folder

BLOCK = re.compile(r"^```(python|text)\n(.*?)^```$", re.M | re.S)


class PageTest(unittest.TestCase):
    def test_the_page_runs_as_written_and_prints_what_it_shows(self):
        place = folder() / "page"
        place.mkdir()
        before, names, said, blocks = os.getcwd(), {}, "", 0
        os.chdir(place)
        try:
            for kind, text in BLOCK.findall((SOURCE / "docs" / "how-to" / "python.md").read_text()):
                if kind == "text":
                    self.assertEqual([line.rstrip() for line in said.splitlines()], text.splitlines())
                    continue
                out = io.StringIO()
                with contextlib.redirect_stdout(out):
                    exec(compile(text, "docs/how-to/python.md", "exec"), names)  # noqa: S102
                said, blocks = out.getvalue(), blocks + 1
        finally:
            os.chdir(before)
        self.assertGreater(blocks, 5)


class TypesTest(unittest.TestCase):
    def test_the_stub_names_what_the_module_has(self):
        package = os.path.dirname(powbench.__file__)
        self.assertTrue(os.path.exists(os.path.join(package, "py.typed")))
        with open(os.path.join(package, "_native.pyi"), encoding="utf-8") as stub:
            tree = ast.parse(stub.read())
        native = powbench._native
        there = {n for n in dir(native) if not n.startswith("_") or n == "__version__"}
        said = {n.name: n for n in tree.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
        named = set(said) | {n.target.id for n in tree.body if isinstance(n, ast.AnnAssign)}
        self.assertEqual(there, named)
        for name, node in said.items():
            if not isinstance(node, ast.ClassDef) or issubclass(getattr(native, name), Exception):
                continue
            members = {m.name for m in node.body if isinstance(m, ast.FunctionDef) and not m.name.startswith("__")}
            public = {m for m in dir(getattr(native, name)) if not m.startswith("_")}
            self.assertEqual(public, members, name)

    def test_every_public_name_is_explained(self):
        for name in powbench.__all__:
            thing = getattr(powbench, name)
            if name == "__version__":
                continue
            self.assertTrue(inspect.getdoc(thing), name)
            if not inspect.isclass(thing) or issubclass(thing, Exception):
                continue
            for member, value in vars(thing).items():
                if not member.startswith("_") and member != "path":
                    self.assertTrue(inspect.getdoc(value), f"{name}.{member}")
