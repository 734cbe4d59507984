"""The command `restitution`, also as `python -m restitution`."""

import signal


def main() -> None:
    """Load the command line and run it."""
    # Ctrl-C while the modules load ends the process at once. A shell may have it ignored.
    heard = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if heard:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from restitution.cli.main import main as command

    if heard:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    command()


if __name__ == "__main__":
    main()
