"""`hil-sim flat`: ways to elect, compared on thousands of searches on plans."""

import click

from runtime.errors import RfNavError


@click.command(
    "flat",
    epilog="Examples:  hil-sim flat --homes 20   |   hil-sim flat --method geometry --method prior "
    "--rooms 1.0   |   hil-sim flat --first 500000 --homes 100",
)
@click.option("--homes", default=40, show_default=True, type=click.IntRange(1, 10_000),
              help="How many generated train homes.")  # fmt: skip
@click.option("--first", default=400_000, show_default=True, type=click.IntRange(20_000),
              help="Seed of the first.")  # fmt: skip
@click.option("--goals", default=3, show_default=True, type=click.IntRange(1, 16), help="A home.")
@click.option("--method", "methods", multiple=True, help="All, if none is given.")
@click.option("--rooms", default=0.72, show_default=True, type=click.FloatRange(0, 1),
              help="Of the rooms it stands in, what share it recognises.")  # fmt: skip
@click.option("--beyond", default=0.5, show_default=True, type=click.FloatRange(0, 1),
              help="The same of what lies beyond frontiers.")  # fmt: skip
def flat_command(
    homes: int, first: int, goals: int, methods: tuple[str, ...], rooms: float, beyond: float
) -> None:
    """Search plans of generated homes, without camera or base, by each way to elect, and print what
    each gains on the fallback: with experts that weigh what was counted, and with one of them at
    random. A search takes a twentieth of a second."""
    from hil_sim.expert_bench import flat_bench
    from hil_sim.expert_bench.learned_homes import COUNTED, check_unknown

    check_unknown((f"train-{first + n}" for n in range(homes)), [COUNTED])
    unknown = sorted({*methods} - {*flat_bench.METHODS})
    if unknown:
        known = ", ".join(flat_bench.METHODS)
        raise click.UsageError(f"--method {unknown[0]}: unknown; known: {known}")
    chosen = dict.fromkeys([flat_bench.BASE, *(methods or flat_bench.METHODS)])
    plan = flat_bench.FlatPlan(homes, first, goals, rooms, beyond)
    rows: flat_bench.Rows = {}
    for name, found in flat_bench.run(plan, tuple(chosen)):
        click.echo(f"{name}: {len(found.get((flat_bench.ORACLE, flat_bench.CLEAN), ()))}", err=True)
        for key, results in found.items():
            rows.setdefault(key, []).extend(results)
    if not rows:
        raise RfNavError("none of these homes has a task that can be judged: take more, --homes")
    click.echo(flat_bench.tables(rows))
