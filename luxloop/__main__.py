"""The program `luxloop`, also as `python -m luxloop`."""

import sys


def main() -> int:
    """Run the command line and return its exit code, also if its modules cannot be imported."""
    try:
        from luxloop.scenarios.cli import main as run_command_line

        return run_command_line()
    except Exception as error:
        from luxloop.scenarios.commands.error_messages import print_internal_error

        return print_internal_error(error)


if __name__ == "__main__":
    sys.exit(main())
