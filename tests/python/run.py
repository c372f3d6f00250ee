"""Tests written in Python: run.py TESTS PACKAGE_FOLDER PROGRAM SOURCE_FOLDER [NAME...]

TESTS: folder with files test_*.py. Closes with `N passed, N failed`; each failed test is named on a line of its own. NAME: only the
tests whose name holds it.
"""

import pathlib
import sys
import unittest

import fixture


def main() -> int:
    tests, package, program, source = sys.argv[1:5]
    sys.path.insert(0, package)
    fixture.PROGRAM, fixture.SOURCE = program, pathlib.Path(source).resolve()
    loader = unittest.defaultTestLoader
    loader.testNamePatterns = [f"*{name}*" for name in sys.argv[5:]] or None
    suite = loader.discover(tests, pattern="test_*.py")
    result = unittest.TextTestRunner(verbosity=2, stream=sys.stdout).run(suite)
    bad = result.failures + result.errors + [(t, "") for t in result.unexpectedSuccesses]
    for test, _ in bad:
        print("failed:", getattr(test, "_testMethodName", test))
    print(f"{result.testsRun - len(bad)} passed, {len(bad)} failed")
    return 0 if result.testsRun and not bad else 1


if __name__ == "__main__":
    sys.exit(main())
