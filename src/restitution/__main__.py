"""`python -m restitution` is the command `restitution`."""

from restitution.cli.main import main

if __name__ == "__main__":
    main()
