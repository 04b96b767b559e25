"""`rfnav replay`: a recorded drive again, and whether anything comes out otherwise."""

import sys
from collections import Counter
from contextlib import ExitStack
from pathlib import Path

import click

from runtime.clock import SystemClock
from runtime.commands.status_screen import printable
from runtime.errors import RecordingError
from runtime.perception.loaded_models import LoadedModels
from runtime.recording.reader import Recording
from runtime.replay.drive import Replayed, replay
from runtime.replay.models_again import ModelsAgain
from runtime.replay.question import asked
from runtime.replay.reflex_again import ReflexAgain
from runtime.replay.script import Script

DIFFS = 40  # that --diff tells


@click.command(
    "replay",
    epilog="Exit status: 0 everything is as it was, 1 something differs or nothing was compared, "
    "2 an error. Examples:  rfnav replay drive.mcap   |   rfnav replay drive.mcap --info",
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--info", is_flag=True, help="Only say what is in it.")
@click.option("--diff", is_flag=True, help="Tell more than the first difference.")
@click.option(
    "--config", "path", type=click.Path(path_type=Path), help="A TOML file over the recorded one."
)
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Override one key.")
@click.option("--models", is_flag=True, help="Run the models again, too, and compare.")
@click.option("--goal", metavar="X", help="Ask instead: what of this would have been found, when?")
@click.option(
    "--obstacle", is_flag=True, help="Hold one before its camera instead: does the base stand?"
)
def replay_command(
    file: Path,
    info: bool,
    diff: bool,
    path: Path | None,
    settings: tuple[str, ...],
    models: bool,
    goal: str | None,
    obstacle: bool,
) -> None:
    """Feed a recorded drive (or a folder that a fault left) through the loop again: every decision
    and every command must come out to the last bit."""
    if info:
        for line in contents(Recording(file)):
            click.echo(printable(line))
        return
    script = Script.open(file)
    if goal is not None:
        sys.exit(0 if _ask(script, goal, path, settings) else 1)
    if obstacle:
        sys.exit(0 if _held(script, path, settings) else 1)
    script.check_robot(path, settings)
    if models:
        script.check_colour()
    with ExitStack() as stack:
        again = None
        if models:
            loaded = LoadedModels(script.config(path, settings), SystemClock())
            again = ModelsAgain(stack.enter_context(loaded))
        replayed = replay(script, path, settings, again)
    for line in told(script, replayed, DIFFS if diff else 1):
        click.echo(printable(line))
    if again is not None:
        click.echo(printable(again.detections.in_words("detections")))
        click.echo(printable(again.votes.in_words("votes")))
    sys.exit(0 if replayed.equal and (again is None or again.alike) else 1)


def _ask(script: Script, goal: str, path: Path | None, settings: tuple[str, ...]) -> bool:
    """Whether anything would have been found."""
    config = script.config(path, (*settings, "panel.experts=[]"))
    with LoadedModels(config, SystemClock()) as models:
        how, found = asked(script, goal, models, config)
    click.echo(printable(how))
    for finding in found:
        click.echo(printable(finding.in_words()))
    if not found:
        click.echo(f"nothing that it would have gone to as {goal}")
    return any(finding.believed_s is not None for finding in found)


def _held(script: Script, path: Path | None, settings: tuple[str, ...]) -> bool:
    """Whether the base stood as long as something was before the camera, and only so long."""
    if script.lockstep:
        raise RecordingError(f"{script.recording.path}: in lockstep no reflex drives")
    reflex = ReflexAgain(script.config(path, settings))
    replay(script, path, settings, reflex=reflex)
    click.echo(reflex.account.in_words())
    return reflex.account.well


def told(script: Script, replayed: Replayed, most: int) -> list[str]:
    """How a replay went, in lines."""
    lines = []
    if script.recording.cut:
        lines.append(f"the file was cut off: replayed is what was there, {replayed.seconds:.1f} s")
    if replayed.skipped:
        lines.append(f"{replayed.skipped} frames at the beginning are of a search before it")
    if script.lost:
        lost = ", ".join(f"{n} {kind}" for kind, n in script.lost.items())
        lines.append(f"the recorder could not keep up and lost {lost}: what follows may differ")
    found = replayed.differences.found
    if replayed.equal:
        lines.append(f"equal in {replayed.turns} turns: {replayed.differences.in_words()}")
        elected = ", ".join(str(frontier) for frontier in replayed.elected)
        ended = ", ".join(replayed.ended) or "nobody's word"
        return [*lines, f"decided for {elected or 'nothing'}; ended by {ended}"]
    if found:
        lines.append(f"differs first in {found[0].in_words()}")
        lines += [difference.in_words() for difference in found[1:most]]
        if len(found) > most:
            lines.append(f"and {len(found) - most} more")
    if replayed.stopped:
        lines.append(f"could not go on: {replayed.stopped}")
    return lines


def contents(recording: Recording) -> list[str]:
    """What a recording is, and what of it takes how much room."""
    counts: Counter[str] = Counter()
    sizes: Counter[str] = Counter()
    schemas: dict[str, str] = {}
    began_ns, ended_ns = None, 0
    for message in recording:
        counts[message.topic] += 1
        sizes[message.topic] += len(message.payload)
        schemas[message.topic] = message.schema
        began_ns = message.log_time_ns if began_ns is None else began_ns
        ended_ns = max(ended_ns, message.log_time_ns)
    minutes = max(ended_ns - (began_ns or ended_ns), 1) / 60e9
    size_mb = recording.size_bytes() / 1e6
    about = recording.about
    lines = [
        f"{recording.path}: {about['loop']}, rfnav {about['version']}, begun {about['began']}, "
        f"colour {about['colour']}" + (", cut off" if recording.cut else ""),
        f"{minutes:.2f} min, {size_mb:.1f} MB, {size_mb / minutes:.1f} MB a minute",
    ]
    for topic, count in counts.most_common():
        lines.append(f"{count:7} {sizes[topic] / 1e6:9.2f} MB  {topic}  {schemas[topic]}")
    return lines
