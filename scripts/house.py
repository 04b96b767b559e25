#!/usr/bin/env python3
"""The rules of the house that no other tool checks: prints its numbers, then what breaks a rule.

  scripts/house.py        exit status 1 when a rule is broken

Layers and circles of imports are lint-imports' part.
"""

import ast
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("runtime", "models", "hil_sim")
FILE_LINES = 350  # the aim is 300
FUNCTION_LINES = 45  # the aim is 40
# Beside the mirrored tree: the whole system, the documents' own commands, stand-ins, reference
# files; and what holds for all tests.
ONLY_IN_TESTS = frozenset({"whole", "docs", "doubles", "refs"})
# A path of one machine; of a user's own machine, examples such as /opt/models are none.
MACHINE_PATH = re.compile(r"(?<![\w.~$}>)-])/(?:(?:work|root|farm)/|home/\w)")
FILE_METHODS = frozenset({"open", "read_text", "read_bytes", "write_text", "write_bytes"})
FILE_FUNCTIONS = {
    "np": frozenset({"load", "save", "savez", "savez_compressed", "loadtxt", "savetxt"})
    | {"genfromtxt", "fromfile", "memmap"},
    "cv2": frozenset({"imread", "imwrite", "imreadmulti", "imwritemulti"})
    | {"VideoCapture", "VideoWriter", "FileStorage"},
}
MODULE_ALIASES = {"numpy": "np", "np": "np", "cv2": "cv2"}

Sources = Mapping[str, str]  # a file's path below the root -> its text


def main() -> int:
    files = tracked(ROOT)
    texts = read_texts(ROOT, files)
    code = {
        path: text
        for path, text in texts.items()
        if path.endswith(".py") and path.split("/")[0] in PACKAGES
    }
    print("\n".join(numbers(code, texts)))
    problems = broken(files, texts, code)
    for problem in problems:
        print(f"house: {problem}", file=sys.stderr)
    return 1 if problems else 0


def broken(files: Iterable[str], texts: Sources, code: Sources) -> list[str]:
    """Every rule's complaints, one line each."""
    core = {path: text for path, text in code.items() if path.startswith("runtime/core/")}
    return [
        *too_long(code),
        *same_class_names(code),
        *machine_paths(texts),
        *tests_without_a_room(files),
        *files_opened(core),
    ]


def numbers(code: Sources, texts: Sources) -> list[str]:
    """What the rules count, for a reader."""
    lengths = {path: count_lines(text) for path, text in code.items()}
    functions = [span for path, text in code.items() for span in spans(path, text)]
    longest = max(lengths, key=lengths.__getitem__)
    largest, lines = max(functions, key=lambda span: span[1])
    return [
        f"{len(code)} files of {', '.join(PACKAGES)}; the longest is {longest}, "
        f"{lengths[longest]} lines (limit {FILE_LINES})",
        f"{len(functions)} functions; the longest is {largest}, {lines} lines "
        f"(limit {FUNCTION_LINES})",
        f"{sum(len(paths) for paths in public_classes(code).values())} public classes",
        f"{len(texts)} text files without a path of one machine",
    ]


def tracked(root: Path) -> list[str]:
    """What git tracks, and what it would if it were added."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=root, check=True, capture_output=True, text=True).stdout
    return sorted({path for path in listed.split("\0") if path and (root / path).is_file()})


def read_texts(root: Path, files: Iterable[str]) -> dict[str, str]:
    """The files that are UTF-8 text."""
    texts = {}
    for path in files:
        content = (root / path).read_bytes()
        if b"\0" not in content:
            try:
                texts[path] = content.decode()
            except UnicodeDecodeError:
                continue
    return texts


@cache
def parse(text: str) -> ast.Module:
    return ast.parse(text)


def count_lines(text: str) -> int:
    return len(text.splitlines())


@cache
def spans(path: str, text: str) -> tuple[tuple[str, int], ...]:
    """Every function as `path:name` and its lines, from `def` to the last."""
    found = []
    waiting: list[ast.AST] = [parse(text)]
    while waiting:
        for node in ast.iter_child_nodes(waiting.pop()):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                assert node.end_lineno is not None
                found.append((f"{path}:{node.name}", node.end_lineno - node.lineno + 1))
            if isinstance(node, ast.stmt | ast.excepthandler | ast.match_case):
                waiting.append(node)  # no expression holds a `def`
    return tuple(sorted(found))


def too_long(code: Sources) -> list[str]:
    """Files and functions over the limits."""
    over = []
    for path, text in code.items():
        if (lines := count_lines(text)) > FILE_LINES:
            over.append(f"{path}: {lines} lines, {FILE_LINES} at most: divide it by its parts")
        for name, lines in spans(path, text):
            if lines > FUNCTION_LINES:
                over.append(f"{name}: {lines} lines, {FUNCTION_LINES} at most")
    return over


def public_classes(code: Sources) -> dict[str, list[str]]:
    """Name -> the files that define a class of that name at their top."""
    found = defaultdict(list)
    for path, text in code.items():
        for node in parse(text).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                found[node.name].append(path)
    return dict(found)


def same_class_names(code: Sources) -> list[str]:
    return [
        f"class {name}: in {' and '.join(paths)}: a name means one thing"
        for name, paths in public_classes(code).items()
        if len(paths) > 1
    ]


def machine_paths(texts: Sources) -> list[str]:
    """Absolute paths that exist on one machine only."""
    return [
        f"{path}:{number}: {found[0]}...: a path of one machine"
        for path, text in texts.items()
        for number, line in enumerate(text.splitlines(), 1)
        if (found := MACHINE_PATH.search(line))
    ]


def tests_without_a_room(files: Iterable[str]) -> list[str]:
    """Files of tests that lie where the tree has no room of that name."""
    files = list(files)
    rooms = {path.rpartition("/")[0] for path in files if path.endswith(".py")}
    problems = []
    for path in files:
        top, _, below = path.partition("/")
        folder = below.rpartition("/")[0]
        if top != "tests" or not folder or folder.split("/")[0] in ONLY_IN_TESTS:
            continue
        if folder not in rooms:
            problems.append(f"{path}: there is no {folder}/ that it tests")
    return problems


def files_opened(core: Sources) -> list[str]:
    """Where code opens, reads or writes a file: the core takes values and gives values."""
    return [
        f"{path}:{node.lineno}: {name}: the core opens no files"
        for path, text in core.items()
        for node in ast.walk(parse(text))
        if isinstance(node, ast.expr | ast.stmt) and (name := _file_name(node))
    ]


def _file_name(node: ast.AST) -> str:
    """What opens a file in this node; "" when nothing does."""
    match node:
        case ast.Name(id="open"):
            return "open"
        case ast.Attribute(value=ast.Name(id=module), attr=name) if name in FILE_FUNCTIONS.get(
            MODULE_ALIASES.get(module, ""), ()
        ):
            return f"{module}.{name}"
        case ast.Call(func=ast.Attribute(attr=name)) if name in {*FILE_METHODS, "tofile"}:
            return f".{name}()"
        case ast.ImportFrom(module=str(module), names=names):
            taken = FILE_FUNCTIONS.get(MODULE_ALIASES.get(module, ""), frozenset())
            return ", ".join(n.name for n in names if n.name in taken)
    return ""


if __name__ == "__main__":
    sys.exit(main())
