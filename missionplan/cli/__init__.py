"""The command line: load → one study → render → exit status. Heavy imports wait until a command needs them.

`planning`, `measurements`, `exchange` and `files` have the commands, `options` what they share,
`running` what is done around a study.
"""

import atexit
import gc
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import Annotated

import typer

from missionplan.cli import exchange, files, measurements, options, planning
from missionplan.cli.options import answering, note, prepare_streams, print_json
from missionplan.errors import OUT_OF_FILES, MissionplanError, Problem, out_of_files

INTERRUPTED = 130
GARBAGE = 50_000
"""Objects made since the last garbage collection from which another is due: each passes through all that is new."""

app = typer.Typer(
    name="missionplan",
    help="Plan missions of a self-mooring AUV by Monte Carlo, and diagnose what the plan's model gets wrong.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
PANELS: Mapping[str, Mapping[str, Callable[..., None]]] = {
    "Start: begin with init": {"init": files.init, "validate": files.validate},
    "Plan a mission: begin with simulate": {
        "simulate": planning.simulate,
        "sweep-dmax": planning.sweep_dmax,
        "plan-legs": planning.plan_legs,
        "size-anchor": planning.size_anchor,
        "export": exchange.export,
    },
    "Choose: begin with optimise": {
        "optimise": planning.optimise,
        "explore": planning.explore,
        "compare": files.compare,
    },
    "Learn from logs: begin with why": {
        "why": exchange.why,
        "import": exchange.import_,
        "diagnose": measurements.diagnose,
        "score": measurements.score,
        "history": measurements.history,
        "tide": measurements.tide,
    },
    "Vehicle and tank: begin with identify": {
        "identify": measurements.identify,
        "sweep-transition": planning.sweep_transition,
        "effects": files.effects,
    },
    "Reports and files: begin with reports": {"reports": files.reports, "verify": files.verify, "schema": files.schema},
}
"""All commands in the order of use, in the groups of `--help`, each with the one to begin with."""
for panel, commands in PANELS.items():
    for name, command in commands.items():
        app.command(name, rich_help_panel=panel)(options.with_option_groups(command))


@app.callback(invoke_without_command=True)
def _root(show_version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False) -> None:
    if show_version:
        typer.echo(f"missionplan {version('missionplan')}")
        raise typer.Exit


def main() -> None:
    """Run the command line; every expected error becomes a message and an exit status."""
    gc.set_threshold(GARBAGE)  # imports make many objects, all of which stay
    atexit.register(gc.freeze)  # saves half a second of garbage collection when the process ends
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):  # but for those that whoever started it ignores (nohup)
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _interrupt)
    prepare_streams()
    status: object = 0
    try:
        with answering():
            status = app(args=planning.with_default_event(sys.argv[1:]), standalone_mode=False)
    except MissionplanError as error:
        problems = _as_options(error)
        words = "\n".join(map(str, problems))
        _fail(f"{'Error' if error.exit_status == 1 else 'Cannot start'}:\n{words}", problems)
        status = error.exit_status
    except KeyboardInterrupt:
        status = INTERRUPTED
    except Exception as error:
        status = INTERRUPTED if _interrupts else _usage_error(error)
    if status == INTERRUPTED:  # typer returns it too; workers would finish their work first
        if pool := sys.modules.get("missionplan.montecarlo.pool"):
            pool.shut_down_pool()
        _fail("Interrupted.", [Problem("interrupted")])
    sys.exit(status if isinstance(status, int) else 0)


_OPTIONS = {
    "force=True": "--force",
    "resume=True": "--resume",
    "allow_outside=True": "--allow-outside",
    "method='monte-carlo'": "--method monte-carlo",
}
"""Arguments of the public functions that hints name, as options."""


def _as_options(error: MissionplanError) -> list[Problem]:
    """Say what is wrong with arguments of the public functions as what is wrong with options."""
    problems = []
    for problem in getattr(error, "problems", ()):
        hint = problem.hint
        for argument, option in _OPTIONS.items():
            hint = hint.replace(argument, option)
        key = f"--{problem.key.replace('_', '-')}" if problem.key and not problem.file else problem.key
        problems.append(replace(problem, hint=hint, key=key))
    return problems or [Problem(str(error))]


def _fail(words: str, problems: Sequence[Problem]) -> None:
    """Say what is wrong on standard error, and to scripts that ask for JSON on standard output."""
    if "--json" in sys.argv:
        print_json(problems)
    note(words)


_interrupts: list[int] = []
"""Signals received: what other packages raise after one, in whose middle it came, is no error of its own."""


def _interrupt(number: int, _: object) -> None:
    _interrupts.append(number)
    raise KeyboardInterrupt


def _usage_error(error: Exception) -> int:
    """Show a usage error with typer's message; any other error is a bug and keeps its traceback.

    Usage errors are recognised by their attributes: depending on its version, typer has its own classes or click's.
    """
    if type(error).__name__ == "Abort":
        return INTERRUPTED
    if out_of_files(error):
        _fail(f"Error:\n{OUT_OF_FILES}", [Problem(OUT_OF_FILES)])
        return 1
    if hasattr(error, "show") and hasattr(error, "exit_code"):
        if "--json" in sys.argv and hasattr(error, "format_message"):
            print_json([Problem(error.format_message())])
        error.show()
        return int(error.exit_code)
    raise error
