"""The process of `rfnav view`, which loads what a page needs and no more."""

import json
import os
import signal
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click
import cv2

from runtime.commands.running import running
from runtime.commands.status_screen import wrong
from runtime.config import load
from runtime.errors import RfNavError
from runtime.private_files import keep_to_owner
from runtime.robot.heard_topics import heard_topics
from runtime.tracing.budgets import read_budgets
from runtime.view.access import access
from runtime.view.feed import Feed
from runtime.view.live import LiveFeed, LiveParts
from runtime.view.replay import ReplayFeed
from runtime.view.server import serve_page

LIVELY = ("color", "depth", "odom")  # on which something new comes all the time


@dataclass(frozen=True)
class ViewOptions:
    """As `rfnav view` has them; files by their names."""

    listen: str
    config: str | None = None
    settings: Sequence[str] = ()
    names: Sequence[str] = ()
    replay: str | None = None
    certificate: str | None = None
    key: str | None = None
    token_file: str | None = None


def serve_view(options: ViewOptions) -> None:
    """Until SIGTERM or Ctrl-C. RfNavError, one line, for what cannot be served."""
    cv2.setNumThreads(1)
    certificate, key, token = map(_path, (options.certificate, options.key, options.token_file))
    allowed = access(options.listen, certificate, key, token, options.names)
    feed = _feed(options)
    called = options.names[0] if options.names else allowed.host
    shown = f"[{called}]" if ":" in called else called
    told = f"open {allowed.scheme}://{shown}:{allowed.port}/   (Ctrl-C ends it)"
    serve_page(allowed, feed, lambda: click.echo(told))


def _feed(options: ViewOptions) -> Feed:
    if options.replay is not None:
        return ReplayFeed(Path(options.replay), read_budgets())
    config = load(_path(options.config), options.settings)
    topics = heard_topics(config.bus)
    needed = tuple(topics[name].name for name in LIVELY)
    connect = partial(running, config.bus)
    return LiveFeed(LiveParts(connect, config, read_budgets(), lambda told: wrong(told, needed)))


def _path(name: str | None) -> Path | None:
    return Path(name) if name is not None else None


def ends_with_its_threads() -> threading.Event:
    """From now on what goes wrong in any thread ends the process, as Ctrl-C does, which lets go of
    the sticks: a page that is told nothing new any more would be believed. Set when that was."""
    mistaken, tells = threading.Event(), threading.excepthook

    def ended(args: threading.ExceptHookArgs) -> None:
        tells(args)
        mistaken.set()
        os.kill(os.getpid(), signal.SIGTERM)

    threading.excepthook = ended
    return mistaken


def main() -> None:
    """The options come as JSON, of `rfnav view`."""
    keep_to_owner()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    mistaken = ends_with_its_threads()
    try:
        serve_view(ViewOptions(**json.loads(sys.argv[1])))
    except KeyboardInterrupt:
        sys.exit(1 if mistaken.is_set() else 0)
    except RfNavError as error:
        click.echo(f"rfnav: {error}", err=True)
        sys.exit(2)


if __name__ == "__main__":
    main()
