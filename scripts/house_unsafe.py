"""What would let a message, a file or a model's name run as code: not in what is on the robot."""

import ast
from collections.abc import Iterator, Mapping

from house_core import Sources, aliases_of, parse, resolved

PLACES = ("runtime/", "models/")
MODULES = dict.fromkeys(
    ("pickle", "_pickle", "dill", "cloudpickle", "marshal", "shelve", "joblib"),
    "reading it runs what somebody wrote",
)
CALLS = {
    **dict.fromkeys(("eval", "exec", "compile", "__import__"), "runs text as code"),
    **dict.fromkeys(
        ("os.system", "os.popen", "subprocess.getoutput", "subprocess.getstatusoutput"),
        "is a shell: subprocess.run takes a list",
    ),
    **dict.fromkeys(
        ("asyncio.create_subprocess_shell", "pty.spawn"), "is a shell: subprocess.run takes a list"
    ),
    **dict.fromkeys(
        (
            "yaml.load",
            "yaml.load_all",
            "yaml.full_load",
            "yaml.unsafe_load",
            "yaml.unsafe_load_all",
        ),
        "makes objects: yaml.safe_load",
    ),
    **dict.fromkeys(
        ("importlib.import_module", "runpy.run_path", "runpy.run_module"),
        "runs a file by its name",
    ),
}
# A call that is safe with a keyword of this value only, written out.
KEYWORDS = {"numpy.load": ("allow_pickle", False), "torch.load": ("weights_only", True)}
METHODS = {"exec_module": "runs a file by its name"}
EXCEPTIONS = {
    ("runtime/__main__.py", "importlib.import_module"): "the modules of a table in that file",
    ("models/train/export.py", "pickle"): "the error alone that a damaged checkpoint gives",
    ("runtime/recording/mcap_file.py", "exec_module"): "always the installed mcap.writer",
}


def unsafe(code: Sources, exceptions: Mapping[tuple[str, str], str] = EXCEPTIONS) -> list[str]:
    """Complaints, one line each; also of exceptions that nothing needs any more."""
    found = [
        (path, line, name, why)
        for path, text in code.items()
        if path.startswith(PLACES)
        for line, name, why in _found(text)
    ]
    used = {(path, name) for path, _, name, _ in found}
    return [
        *(f"{p}:{line}: {n}: {why}" for p, line, n, why in found if (p, n) not in exceptions),
        *(f"{p}: {n}: is excepted and not there" for p, n in exceptions if (p, n) not in used),
    ]


def _found(text: str) -> Iterator[tuple[int, str, str]]:
    """(line, what, why not)."""
    names = aliases_of(text)
    for node in ast.walk(parse(text)):
        match node:
            case ast.Import(names=imported):
                modules = [alias.name.partition(".")[0] for alias in imported]
            case ast.ImportFrom(module=str(module), level=0):
                modules = [module.partition(".")[0]]
            case ast.Call():
                modules = []
                yield from ((node.lineno, name, why) for name, why in _called(node, names))
            case ast.Name(id=("eval" | "exec" | "__import__") as name):
                modules = []
                yield node.lineno, name, CALLS[name]  # also where it is handed on
            case _:
                continue
        yield from ((node.lineno, m, MODULES[m]) for m in modules if m in MODULES)


def _called(call: ast.Call, names: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    name = resolved(call.func, names)
    if isinstance(call.func, ast.Name) and not name:
        name = call.func.id
    if name in CALLS and name not in ("eval", "exec", "__import__"):
        yield name, CALLS[name]
    if isinstance(call.func, ast.Attribute) and call.func.attr in METHODS:
        yield call.func.attr, METHODS[call.func.attr]
    given = {keyword.arg: keyword.value for keyword in call.keywords}
    shell = given.get("shell")
    if shell is not None and not (isinstance(shell, ast.Constant) and shell.value is False):
        yield "shell", "is a shell: subprocess.run takes a list"
    if name in KEYWORDS:
        keyword, safe = KEYWORDS[name]
        value = given.get(keyword)
        if not (isinstance(value, ast.Constant) and value.value is safe):
            yield name, f"say {keyword}={safe}: else what it reads may run as code"
