"""Entry point: runs a command and turns every error into one line and an exit code."""

from __future__ import annotations

import gc
import os
import sys
from itertools import pairwise


def main(arguments: list[str] | None = None) -> int:
    """Returns the exit code. arguments: without the program's name; by default the process's own."""
    # NumPy's BLAS would start a thread a core, which costs more than all of NumPy that is used here.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # What is imported lives until the end: looking for garbage in it costs a tenth of a cached picture.
    gc.set_threshold(50_000)
    import warnings

    import click

    from .app import app
    from .output import say, speak_json

    warnings.showwarning = lambda message, *_, **__: say(str(message))

    args = sys.argv[1:] if arguments is None else arguments
    speak_json(_json_wanted(args))
    try:
        if not args and "_TRIMRAY_COMPLETE" not in os.environ:
            args = ["--help"]
        code = app.main(args, prog_name="trimray", standalone_mode=False)
        gc.freeze()  # nor is there any worth finding at the end
        return code if isinstance(code, int) else 0
    except click.ClickException as error:
        say(error.format_message(), error=True)
        return error.exit_code
    except (KeyboardInterrupt, click.Abort):
        say("interrupted", error=True)
        return 130
    except BrokenPipeError:
        return 4
    except Exception as error:
        from trimray import Error

        if isinstance(error, Error):
            say(str(error), error=True)
            return error.exit_code
        say(f"internal error: {type(error).__name__}: {error}; -vv shows where", error=True)
        if any(a.startswith("-vv") for a in args) or args.count("-v") + args.count("--verbose") > 1:
            import traceback

            for line in traceback.format_exc().splitlines():
                say(line, error=True)
        return 70


def _json_wanted(args: list[str]) -> bool:
    """Before the arguments are understood, since that can be what fails."""
    asked = [b for a, b in pairwise(args) if a == "--progress"]
    asked += [a.partition("=")[2] for a in args if a.startswith("--progress=")]
    return (asked[-1] if asked else os.environ.get("TRIMRAY_PROGRESS")) == "json"


def entry() -> None:
    """For ``python -m trimray.cli``."""
    sys.exit(main())


if __name__ == "__main__":
    entry()
