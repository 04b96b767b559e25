"""What the documents tell a reader to type, click and open exists: commands with their options,
configuration keys, links, files. Nothing is run."""

import importlib.util
import os
import re
import shlex
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click
import pytest
from places import ROOT

from hil_sim.__main__ import cli as hil_sim
from hil_sim.driving.methods import METHODS
from runtime.__main__ import cli as rfnav
from runtime.config import _tell, known_keys, load
from runtime.errors import ConfigError
from runtime.former_keys import FORMER

PAGES = [
    ROOT / "README.md",
    ROOT / "ARCHITECTURE.md",
    ROOT / "models/weights/README.md",
    ROOT / "hil_sim/scenes/robothor/README.md",
    *sorted((ROOT / "docs").glob("*.md")),
    ROOT / "docs/lab/experts-tables.md",  # their blocks are filled in anew
    ROOT / "docs/lab/scene-layout.md",
]
LAB = sorted({*(ROOT / "docs/lab").glob("*.md")} - {*PAGES})
"""What was tried, and how: its commands are of their day, its links and pictures are not."""
PROGRAMS = {"hil-sim": hil_sim, "rfnav": rfnav}
ROOMS = ("runtime", "models", "hil_sim", "tests", "scripts", "docs", "deploy")
GONE = "## Names that went away"
"""Below it the first cell of a row is what is no longer there."""
FENCED = re.compile(r"^ *```(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"`([^`]+)`")
FIRST = r"(?:\.venv/bin/)?(?:hil-sim|rfnav|python)|scripts/[\w-]+"
DOTTED = re.compile(r"(?<![\w./])[a-z_]+(?:\.[a-z_0-9]+)+(?![\w/(])")
"""What may be a key, `table.name`, wherever it stands."""
COMMAND = re.compile(rf"(?:^|\s)((?:{FIRST})(?:\s.*)?)$", re.DOTALL)


@dataclass(frozen=True)
class Line:
    """A command line; `whole`: as it is typed, not only mentioned in a sentence."""

    words: tuple[str, ...]
    whole: bool

    def __str__(self) -> str:
        return " ".join(self.words)


def text_of(page: Path) -> str:
    """A page, without names that it says are gone."""
    text, _, gone = page.read_text(encoding="utf-8").partition(GONE)
    return text + "\n".join(line.split("|", 2)[-1] for line in gone.splitlines())


def commands(text: str) -> Iterator[Line]:
    """All command lines of a page: those of its blocks, then those in its sentences."""
    for language, block in FENCED.findall(text):
        if language in ("", "sh", "bash"):
            for line in block.replace("\\\n", " ").splitlines():
                for part in line.split(" && "):
                    yield from _read(part, True)
    for phrase in INLINE.findall(FENCED.sub("", text)):
        yield from _read(" ".join(phrase.split()), False)


def _read(text: str, whole: bool) -> Iterator[Line]:
    found = COMMAND.search(text)
    if found is None:
        return
    words = [w for w in shlex.split(found[1], comments=whole) if w not in ("…", "...")]
    words[0] = words[0].removeprefix(".venv/bin/")
    if whole or len(words) > 1 or words[0].startswith("scripts/"):
        yield Line(tuple(words), whole)


def wrong(line: Line) -> str | None:
    """What is not so in a command line; None when all is well."""
    program, rest = line.words[0], list(line.words[1:])
    if program.startswith("scripts/"):
        if not os.access(ROOT / program, os.X_OK):
            return f"there is no script {program}"
        forwards = program == "scripts/demo" and rest
        return wrong(Line(("hil-sim", "demo", *rest), line.whole)) if forwards else None
    if program == "python":
        return _wrong_module(rest)
    return _wrong_command(PROGRAMS[program], program, rest, line.whole)


def _wrong_module(rest: list[str]) -> str | None:
    if rest[:1] != ["-m"] or len(rest) < 2:
        return "is no python -m MODULE"
    try:
        spec = importlib.util.find_spec(rest[1])
        if spec is not None and spec.submodule_search_locations is not None:
            spec = importlib.util.find_spec(f"{rest[1]}.__main__")
    except ModuleNotFoundError:
        spec = None
    if spec is None or spec.origin is None:
        return f"there is no module {rest[1]}"
    if not Path(spec.origin).is_relative_to(ROOT) or ".venv" in spec.origin:
        return None  # another project's options are its own
    source = Path(spec.origin).read_text(encoding="utf-8")
    known = set(re.findall(r"--[a-z][\w-]*", source)) | {"--help"}
    return next((f"no option {w}" for w in rest if w.startswith("--") and w not in known), None)


def _wrong_command(command: click.Command, name: str, rest: list[str], whole: bool) -> str | None:
    context = click.Context(command, info_name=name)
    while isinstance(command, click.Group) and rest and not rest[0].startswith("-"):
        name = rest.pop(0)
        inner = command.get_command(context, name)
        if inner is None:
            return f"no command {name}"
        command, context = inner, click.Context(inner, info_name=name, parent=context)
    try:
        given, left, _ = command.make_parser(context).parse_args(rest)
        for parameter in command.params:
            value = given.get(parameter.name)
            if value and isinstance(parameter.type, click.Choice):
                parameter.type_cast_value(context, value)
            if whole and parameter.required and not value and not given.get("help"):
                return f"{parameter.name} is missing"
    except click.UsageError as error:
        return error.format_message()
    if left and not isinstance(command, click.Group):
        return f"takes no {' '.join(left)}"
    return _wrong_value(given)


def _wrong_value(given: dict[str, object]) -> str | None:
    for values in (given.get("sets"), given.get("settings")):
        for setting in values if isinstance(values, list | tuple) else ():
            if setting.partition("=")[0] not in known_keys():
                return f"no key {setting}"
    methods = given.get("method") or given.get("methods") or ()
    for method in (methods,) if isinstance(methods, str) else methods:
        if method not in METHODS:
            return f"no method {method}"
    return None


def wrong_keys(text: str) -> list[str]:
    """What is named as keys are, though there is no such key: one that went away or was renamed
    wherever it stands, one that never was where a sentence marks it."""
    tables = {key.partition(".")[0] for key in (*known_keys(), *FORMER)}
    former = [key for key in DOTTED.findall(text) if key in FORMER]
    unknown = []
    for name in INLINE.findall(FENCED.sub("", text)):
        key = name.partition(" ")[0].partition("=")[0]
        if key.endswith((".py", ".png", ".npz", ".md", ".pem")) or not DOTTED.fullmatch(key):
            continue
        if key.partition(".")[0] in tables and key not in {*known_keys(), *former}:
            unknown += [] if _is_module(key) else [key]
    return former + unknown


def configurations(text: str) -> list[str]:
    """The fenced TOML of a page, as it would be copied to a file."""
    return [textwrap.dedent(block) for kind, block in FENCED.findall(text) if kind == "toml"]


def told_of(block: str, path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """What reading a configuration says: the error, or the renamed keys; "" when nothing."""
    path.write_text(block, encoding="utf-8")
    _tell.cache_clear()  # a renamed key is told once a process
    try:
        load(path)
    except ConfigError as error:
        return str(error)
    return capsys.readouterr().err


def slug(heading: str) -> str:
    """What a heading is linked by."""
    kept = re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", heading.strip().lower()))
    return kept.replace(" ", "-")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_command_and_option_exists(page: Path) -> None:
    faults = [f"{line}: {fault}" for line in commands(text_of(page)) if (fault := wrong(line))]
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("page", [*PAGES, *LAB], ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page: Path) -> None:
    for file, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)]*))?\)", text_of(page)):
        if file.startswith(("http://", "https://")):
            continue
        target = page.parent / file if file else page
        assert target.exists(), file
        if anchor:
            headings = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in {slug(heading) for heading in headings}, f"{file}#{anchor}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_file_that_is_named_exists(page: Path) -> None:
    modules = {p.name for room in ROOMS for p in (ROOT / room).rglob("*.py")}
    modules |= {p.name for p in ROOT.glob("*.py")}
    for name in INLINE.findall(FENCED.sub("", text_of(page))):
        if re.fullmatch(r"[\w-]+\.py", name):
            assert name in modules, name
        elif re.fullmatch(rf"(?:{'|'.join(ROOMS)})/[\w./-]*", name):
            assert (ROOT / name).exists(), name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_key_that_is_named_exists(page: Path) -> None:
    assert not wrong_keys(text_of(page))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_configuration_can_be_loaded(
    page: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = [told_of(b, tmp_path / "robot.toml", capsys) for b in configurations(text_of(page))]
    assert not any(said), said


def test_there_are_configurations_to_load() -> None:
    assert len([block for page in PAGES for block in configurations(text_of(page))]) >= 6


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("the key `cloud.enabled`, or `models.threads=2`, and `research.consensus_mode`", []),
        ("`models.train.export` is a module, `map.png` a picture, `cloud.py` a file", []),
        ("set `consensus.mode`", ["consensus.mode"]),
        ("or planner.margin_m without marks", ["planner.margin_m"]),
        ("```sh\nhil-sim demo --set semantics.max_step=2\n```", ["semantics.max_step"]),
        ("`planner.no_such_key` of a table that went away", ["planner.no_such_key"]),
        ("`cloud.no_such_key` of one that did not", ["cloud.no_such_key"]),
    ],
)
def test_a_key_that_is_none_is_found(text: str, wrong: list[str]) -> None:
    assert wrong_keys(text) == wrong


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("[models]\nthreads = 2\n", ""),
        ("[consensus]\nmode = 'lenient'\n", "is called research.consensus_mode now"),
        ("[planner]\nmargin_m = 0.05\n", "cannot be set any more"),
        ("[cloud]\nno_such_key = 1\n", "unknown"),
        ("[cloud\n", "not valid TOML"),
    ],
)
def test_a_configuration_that_is_none_is_found(
    block: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    [found] = configurations(f"as in\n\n```toml\n{block}```\n")
    told = told_of(found, tmp_path / "robot.toml", capsys)
    assert said in told
    assert bool(said) == bool(told)


def _is_module(name: str) -> bool:
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def test_every_figure_is_shown_somewhere() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in [*PAGES, *LAB])
    unused = [p.name for p in (ROOT / "docs/figures").iterdir() if f"figures/{p.name})" not in text]
    assert not unused


def test_what_is_filled_in_by_a_command_stands_where_it_says() -> None:
    lines = [line.words for page in PAGES for line in commands(text_of(page))]
    filled = {
        (words[1], words[words.index("--out") + 1])
        for words in lines
        if words[:2] in (("hil-sim", "questions"), ("hil-sim", "report")) and "--out" in words
    }
    documents = {(command, file) for command, file in filled if file.startswith("docs/")}
    assert {command for command, _ in documents} >= {"questions"}
    for command, file in documents:
        block = "<!-- report questions-" if command == "questions" else "<!-- report "
        assert block in (ROOT / file).read_text(encoding="utf-8"), file


def test_there_is_much_to_check() -> None:
    lines = [line for page in PAGES for line in commands(text_of(page))]
    assert sum(line.whole for line in lines) >= 30
    assert {line.words[0] for line in lines} >= {"hil-sim", "rfnav", "python", "scripts/demo"}


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("```sh\nhil-sim demo --goal toilet   # one episode\n```", None),
        ("```sh\nhil-sim demo --goal bed \\\n  --scene cedar\n```", None),
        ("```sh\nhil-sim show maple\n```", "out is missing"),
        ("as `hil-sim demo` does", None),
        ("```sh\nhil-sim drive --goal toilet\n```", "no command drive"),
        ("```\nhil-sim demo --goal toilet --sceen cedar\n```", "No such option"),
        ("by `hil-sim\ndemo --goal bed --realtime 3`", "takes no 3"),
        ("by `chrt -r 1 hil-sim decisions --cuont 60`", "No such option"),
        ("with `rfnav models pull --every`", "No such option"),
        ("```sh\nOMP_NUM_THREADS=1 .venv/bin/rfnav check\n```", "path is missing"),
        ("```sh\nrfnav run --set map.no_such_key=1\n```", "no key map.no_such_key=1"),
        ("`hil-sim eval --suite val --method oracle`", "no method oracle"),
        ("`hil-sim demo --goal bed --renderer vulkan`", "'vulkan' is not one of"),
        ("```sh\nscripts/demo --gaol toilet\n```", "No such option"),
        ("`scripts/no-such-script`", "there is no script"),
        ("```sh\npython -m hil_sim.no_such_module\n```", "there is no module"),
        ("```sh\npython -m models.train --out out --data frames --hight 2\n```", "no option"),
        ("```sh\ncd out && python -m hil_sim.evaluation.compare A B\n```", None),
        ("```python\nhil-sim nothing\n```", None),
    ],
)
def test_a_fault_is_found(text: str, fault: str | None) -> None:
    found = [wrong(line) for line in commands(text)]
    if fault is None:
        assert not any(found)
    else:
        assert len(found) == 1
        assert fault in (found[0] or "")
