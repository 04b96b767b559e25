"""`rfnav cloud`: what was spent, and whether the endpoint answers."""

from pathlib import Path

import click

from runtime import config as configuration
from runtime.clock import Deadline, SystemClock
from runtime.core.types import Missing
from runtime.errors import ConfigError
from runtime.experts.cloud import Bill, Cloud
from runtime.experts.trial_question import TRIAL


@click.command("cloud", epilog="Example:  rfnav cloud --config robot.toml --ask")
@click.option("--config", "path", type=click.Path(path_type=Path), required=True)
@click.option("--ask", is_flag=True, help="Ask one question; it is booked like any other.")
def cloud_command(path: Path, ask: bool) -> None:
    """Show what the cloud model has cost, and try it.

    Exit status 1 when it was asked and did not answer.
    """
    cfg = configuration.load(path).cloud
    if not cfg.enabled:
        raise ConfigError(f"{path}: cloud.enabled: is false; nothing is asked and nothing is spent")
    clock = SystemClock()
    with Cloud(cfg, clock) as cloud:
        cloud.begin("rfnav cloud")
        outcome = cloud.expert("o2f")(TRIAL, Deadline.never(clock)) if ask else None
        bills = cloud.bills()
        cloud.finish()
        status = cloud.status()
    click.echo(f"{cfg.model} at {cfg.base_url}, privacy {cfg.privacy}")
    for bill in bills:
        click.echo(_told(bill))
    click.echo(f"spent today: {status['day_usd']} of {cfg.cap_day_usd:g} USD")
    if outcome is None:
        return
    if isinstance(outcome, Missing):
        click.echo(f"no vote: {outcome.cause}")
        raise SystemExit(1)
    click.echo(f"vote for {', '.join(map(str, outcome.frontiers))} (1 is right): {outcome.reason}")


def _told(bill: Bill) -> str:
    counted = bill.tokens_in is not None
    tokens = f"{bill.tokens_in} tokens in, {bill.tokens_out} out" if counted else "tokens not told"
    return f"asked: {bill.took_s:.2f} s, {tokens}, {bill.usd:g} USD"
