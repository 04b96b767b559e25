#!/usr/bin/env python3
"""The rules of the house that no other tool checks: prints its numbers, then what breaks a rule.

  scripts/house.py        exit status 1 when a rule is broken

Layers and circles of imports are lint-imports' part.
"""

import ast
import re
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from house_core import Sources, foreign_imports, parse, reaches_out
from house_unsafe import unsafe

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("runtime", "models", "hil_sim")
FILE_LINES = 350  # the aim is 300
FUNCTION_LINES = 45  # the aim is 40
ROBOT_KEYS = 92  # of the configuration, outside [research]: what a robot's owner would turn
RESEARCH = "research."
# Beside the mirrored tree: the whole system, the documents' own commands, stand-ins, reference
# files, how long things take, spoilt input; and what holds for all tests.
ONLY_IN_TESTS = frozenset({"whole", "docs", "doubles", "refs", "latency", "fuzz"})
# A path of one machine; of a user's own machine, examples such as /opt/models are none.
MACHINE_PATH = re.compile(
    r"(?<![\w.~$}>)-])/(?:(?:work|root|farm|mnt|data|workspace|scratch)/|(?:home|Users)/\w)"
)
# What makes a class without a `class` statement: NamedTuple("Plan", ...) and its like.
CLASS_MAKERS = frozenset(
    {"NamedTuple", "namedtuple", "TypedDict", "make_dataclass", "new_class"}
) | {"Enum", "IntEnum", "StrEnum", "Flag"}


def main() -> int:
    files = tracked(ROOT)
    texts = read_texts(ROOT, files)
    code = {
        path: text
        for path, text in texts.items()
        if path.endswith(".py") and path.split("/")[0] in PACKAGES
    }
    keys = configuration_keys()
    print("\n".join(numbers(code, texts, keys)))
    problems = broken(files, texts, code, keys)
    for problem in problems:
        print(f"house: {problem}", file=sys.stderr)
    return 1 if problems else 0


def broken(files: Iterable[str], texts: Sources, code: Sources, keys: Iterable[str]) -> list[str]:
    """Every rule's complaints, one line each."""
    core = {path: text for path, text in code.items() if path.startswith("runtime/core/")}
    return [
        *too_long(code),
        *same_class_names(code),
        *machine_paths(texts),
        *tests_without_a_room(files),
        *foreign_imports(core),
        *reaches_out(core),
        *unsafe(code),
        *only_tested(code, texts),
        *too_many_keys(keys),
    ]


def numbers(code: Sources, texts: Sources, keys: Iterable[str]) -> list[str]:
    """What the rules count, for a reader."""
    lengths = {path: count_lines(text) for path, text in code.items()}
    functions = [span for path, text in code.items() for span in spans(path, text)]
    longest = max(lengths, key=lengths.__getitem__)
    largest, lines = max(functions, key=lambda span: span[1])
    for_research = Counter(key.startswith(RESEARCH) for key in keys)
    return [
        f"{len(code)} files of {', '.join(PACKAGES)}; the longest is {longest}, "
        f"{lengths[longest]} lines (limit {FILE_LINES})",
        f"{len(functions)} functions; the longest is {largest}, {lines} lines "
        f"(limit {FUNCTION_LINES})",
        f"{sum(len(paths) for paths in public_classes(code).values())} public classes",
        f"{len(texts)} text files without a path of one machine",
        f"{for_research[False]} keys of a robot's configuration (limit {ROBOT_KEYS}), "
        f"{for_research[True]} in [research]",
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
    """Name -> the files that define a class of that name, at their top or under an `if`."""
    found = defaultdict(list)
    for path, text in code.items():
        for name in _classes(parse(text)):
            if not name.startswith("_"):
                found[name].append(path)
    return dict(found)


def _classes(node: ast.AST) -> Iterator[str]:
    for inner in ast.iter_child_nodes(node):
        match inner:
            case ast.ClassDef(name=name):
                yield name
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                continue
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Call(func=made)) if (
                _last_name(made) in CLASS_MAKERS
            ):
                yield name
            case ast.stmt() | ast.excepthandler() | ast.match_case():
                yield from _classes(inner)


def _last_name(node: ast.AST) -> str:
    """`c` of `c` and of `a.b.c`; "" of anything else."""
    match node:
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name
    return ""


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
    """Files of tests that lie where the tree has no room of that name, or are called after no
    module of it: `test_panel.py` and `test_panel_rounds.py` test `panel`."""
    files = list(files)
    modules = {path.removesuffix(".py").removesuffix("/__init__") for path in files}
    rooms = {path.rpartition("/")[0] for path in files if path.endswith(".py")}
    problems = []
    for path in files:
        top, _, below = path.partition("/")
        folder, _, name = below.rpartition("/")
        if top != "tests" or not folder or folder.split("/")[0] in ONLY_IN_TESTS:
            continue
        if folder not in rooms:
            problems.append(f"{path}: there is no {folder}/ that it tests")
        elif name.startswith("test_") and name.endswith(".py"):
            words = name.removeprefix("test_").removesuffix(".py").split("_")
            starts = {"_".join(words[:n]) for n in range(1, len(words) + 1)}
            if not any(f"{folder}/{start}" in modules for start in starts):
                problems.append(f"{path}: {folder}/ has no module that it is named after")
    return problems


def only_tested(code: Sources, texts: Sources) -> list[str]:
    """Public functions and classes that nothing but a test uses, as far as names tell. A command
    that its decorator hands to click is used."""
    used = set()
    for path, text in texts.items():
        if path in code:
            used |= _names_used(text)
        elif path.startswith("scripts/") or path == "pyproject.toml":
            used |= set(re.findall(r"\w+", text))
    return [
        f"{path}:{node.lineno}: {node.name}: only tests use it: it belongs to them"
        for path, text in code.items()
        for node in parse(text).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
        and not node.name.startswith("_")
        and node.name not in used
        and not any(map(_registers, node.decorator_list))
    ]


def _registers(decorator: ast.expr) -> bool:
    """A decorator `@group.command(...)`, that hands the function to `group`."""
    return isinstance(decorator, ast.Call) and _last_name(decorator.func) in {"command", "group"}


@cache
def _names_used(text: str) -> frozenset[str]:
    """Names that a file reads, imports, or has in a string without spaces, as annotations are."""
    found: set[str] = set()
    for node in ast.walk(parse(text)):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name):
                found.add(name)
            case ast.alias(name=name):
                found.update(name.split("."))
            case ast.Constant(value=str(words)) if not re.search(r"\s", words):
                found.update(re.findall(r"\w+", words))
    return frozenset(found)


def configuration_keys() -> list[str]:
    """Every key that the configuration may have, `table.name`."""
    sys.path.insert(0, str(ROOT))  # this checkout's, wherever another one is installed
    from runtime.config import known_keys

    return list(known_keys())


def too_many_keys(keys: Iterable[str]) -> list[str]:
    count = sum(not key.startswith(RESEARCH) for key in keys)
    if count <= ROBOT_KEYS:
        return []
    return [f"{count} keys outside [research], {ROBOT_KEYS} at most: make some constants"]


if __name__ == "__main__":
    sys.exit(main())
