"""What the core may import, and what of that it may not call: it knows no file and no clock."""

import ast
from collections.abc import Mapping
from functools import cache

# What the core may import: arrays, images, itself, and modules that only compute.
CORE_PACKAGES = frozenset({"numpy", "cv2"})
CORE_MODULES = frozenset(
    {"base64", "collections", "collections.abc", "dataclasses", "enum", "functools", "itertools"}
    | {"json", "math", "random", "re", "statistics", "typing"}
)
FILE_METHODS = frozenset({"read_text", "read_bytes", "write_text", "write_bytes", "tofile"})
BUILTINS = {"open": "the core opens no files"} | dict.fromkeys(
    ("__import__", "eval", "exec", "input", "print"), "the core has no way out"
)
# Names of a package, however far below it, that reach out of the process.
REACHING = {
    "numpy": frozenset({"load", "save", "savez", "savez_compressed", "loadtxt", "savetxt"})
    | {"genfromtxt", "fromfile", "fromregex", "memmap", "DataSource"}
    | {"open_memmap", "read_array", "write_array"},
    "cv2": frozenset({"imread", "imwrite", "imreadmulti", "imwritemulti", "imcount"})
    | {"VideoCapture", "VideoWriter", "FileStorage", "FileNode", "samples", "dnn", "utils"}
    | {"getTickCount", "getTickFrequency", "getCPUTickCount", "TickMeter", "setNumThreads"},
}

Sources = Mapping[str, str]  # a file's path below the root -> its text


@cache
def parse(text: str) -> ast.Module:
    return ast.parse(text)


def foreign_imports(core: Sources) -> list[str]:
    """Imports of the core, wherever they stand, beside what it may import."""
    return [
        f"{path}:{node.lineno}: {name}: the core imports only what computes"
        for path, text in core.items()
        for node in ast.walk(parse(text))
        for name in _imported(node)
        if not _may_be_imported(name)
    ]


def _imported(node: ast.AST) -> list[str]:
    """The modules that an import names, dotted."""
    match node:
        case ast.Import(names=names):
            return [alias.name for alias in names]
        case ast.ImportFrom(module="runtime", level=0, names=names):
            return [f"runtime.{alias.name}" for alias in names]
        case ast.ImportFrom(module=module, level=level):
            return ["." * level + (module or "")]
    return []


def _may_be_imported(name: str) -> bool:
    ours = name == "runtime.core" or name.startswith("runtime.core.")
    return ours or name in CORE_MODULES or name.partition(".")[0] in CORE_PACKAGES


def reaches_out(core: Sources) -> list[str]:
    """Where code opens a file or reads a clock by what it may import: the core takes values and
    gives values."""
    return [
        f"{path}:{node.lineno}: {said}"
        for path, text in core.items()
        for node in ast.walk(parse(text))
        if isinstance(node, ast.expr | ast.stmt) and (said := _reached(node, aliases_of(text)))
    ]


@cache
def aliases_of(text: str) -> Mapping[str, str]:
    """Each imported name, as the file calls it, by what it stands for: `np` is `numpy`."""
    found = {}
    for node in ast.walk(parse(text)):
        match node:
            case ast.Import(names=names):
                for alias in names:
                    whole = alias.name if alias.asname else alias.name.partition(".")[0]
                    found[alias.asname or whole] = whole
            case ast.ImportFrom(module=str(module), names=names):
                for alias in names:
                    found[alias.asname or alias.name] = f"{module}.{alias.name}"
    return found


def _reached(node: ast.AST, aliases: Mapping[str, str]) -> str:
    """What in this node reaches out of the core, and why not; "" when nothing does."""
    match node:
        case ast.Name(id=name) if name in BUILTINS:
            return f"{name}: {BUILTINS[name]}"
        case ast.Call(func=ast.Attribute(attr=name)) if name in {*FILE_METHODS, "open"}:
            return f".{name}(): the core opens no files"
        case ast.Attribute():
            name = resolved(node, aliases)
        case ast.ImportFrom(module=str(module), names=names):
            name = next(
                (f"{module}.{n.name}" for n in names if _reaching(f"{module}.{n.name}")), ""
            )
        case ast.Import(names=names):
            name = next((n.name for n in names if _reaching(n.name)), "")
        case _:
            return ""
    return f"{name}: the core knows no file and no clock" if _reaching(name) else ""


def resolved(node: ast.AST, aliases: Mapping[str, str]) -> str:
    """`n.lib.format` -> "numpy.lib.format" where n is numpy; "" of what is no imported name."""
    match node:
        case ast.Name(id=name):
            return aliases.get(name, "")
        case ast.Attribute(value=value, attr=attr):
            below = resolved(value, aliases)
            return f"{below}.{attr}" if below else ""
    return ""


def _reaching(name: str) -> bool:
    package, *below = name.split(".")
    return bool(below) and below[-1] in REACHING.get(package, frozenset())
