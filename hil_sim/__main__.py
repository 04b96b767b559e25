"""`hil-sim`: the harness's command line. A command's modules are imported when it is used."""

import importlib
import os
import sys

import click

from runtime.errors import RfNavError

COMMANDS = {
    "beyond": (
        "hil_sim.commands.beyond",
        "beyond_command",
        "What is seen toward frontiers, and what truly lies behind them.",
    ),
    "counts": (
        "hil_sim.commands.counts",
        "counts_command",
        "Count what stands in which room, and what near what.",
    ),
    "decisions": (
        "hil_sim.commands.decisions",
        "decisions_command",
        "How long a vote takes, with experts that hang and fail.",
    ),
    "demo": (
        "hil_sim.commands.demo",
        "demo_command",
        "One episode in a furnished home, told as it goes.",
    ),
    "depth": (
        "hil_sim.commands.depth",
        "depth_command",
        "What depth cameras' faults cost the map.",
    ),
    "episodes": ("hil_sim.commands.episodes", "episodes_command", "Sample episodes into a suite."),
    "eval": (
        "hil_sim.commands.evaluate",
        "eval_command",
        "Drive a suite of episodes; print the table.",
    ),
    "flat": ("hil_sim.commands.flat", "flat_command", "Ways to elect, compared on plans."),
    "frames": (
        "hil_sim.commands.frames",
        "frames_command",
        "Render labelled frames for training.",
    ),
    "hazards": (
        "hil_sim.commands.hazards",
        "hazards_command",
        "What steps in front of the robot, and is it touched.",
    ),
    "import": (
        "hil_sim.commands.import_home",
        "import_command",
        "A Sweet Home 3D drawing as a scene.",
    ),
    "generate": ("hil_sim.commands.generate", "generate_command", "Draw furnished homes by seed."),
    "placed": (
        "hil_sim.commands.placed",
        "placed_command",
        "How far from where they are things are placed.",
    ),
    "questions": (
        "hil_sim.commands.questions",
        "questions_command",
        "Ask the experts what is known, and judge them.",
    ),
    "report": ("hil_sim.commands.report", "report_command", "Tables and figures of evaluations."),
    "robot": (
        "hil_sim.commands.robot",
        "robot_command",
        "A simulated robot, for a service that is running.",
    ),
    "sheet": ("hil_sim.commands.sheet", "sheet_command", "Every goal of the replicas from 1 m."),
    "show": ("hil_sim.commands.show", "show_command", "Draw a scene."),
    "soak": (
        "hil_sim.commands.soak",
        "soak_command",
        "Goals and troubles without end, beside a service.",
    ),
}
ASSETS = {
    "pull": (
        "hil_sim.commands.assets",
        "pull_command",
        "Fetch the furniture into the cache.",
    )
}


class Lazy(click.Group):
    """A group that imports a command when it is asked for, so that `--help` is quick."""

    def __init__(self, table: dict[str, tuple[str, str, str]], **options: object) -> None:
        super().__init__(**options)  # type: ignore[arg-type]
        self._table = table

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted({*self._table, *super().list_commands(ctx)})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self._table:
            return super().get_command(ctx, cmd_name)
        module, name, _ = self._table[cmd_name]
        command: click.Command = getattr(importlib.import_module(module), name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        rows = [(name, help) for name, (_, _, help) in self._table.items()]
        rows += [(name, c.get_short_help_str()) for name, c in self.commands.items()]
        with formatter.section("Commands"):
            formatter.write_dl(sorted(rows))


cli = Lazy(
    COMMANDS,
    help="The simulated homes and robot that RF-NAV is tried and measured in.",
    epilog="Example:  hil-sim demo --goal toilet.  "
    "Exit status: 0 done, 1 the thing measured or attempted failed, 2 an error.",
)
cli.add_command(Lazy(ASSETS, name="assets", help="Furniture."))


def main() -> None:
    """Run the command line; every foreseeable error is one line and exit status 2."""
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    try:
        cli(prog_name="hil-sim", standalone_mode=False)
    except click.UsageError as error:
        error.show()
        sys.exit(2)
    except RfNavError as error:
        click.echo(f"hil-sim: {error}", err=True)
        sys.exit(2)
    except (click.exceptions.Abort, KeyboardInterrupt):
        sys.exit(130)


if __name__ == "__main__":
    main()
