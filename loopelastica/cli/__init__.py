"""The command line: a module per family of commands."""

from loopelastica.cli.app import app

__all__ = ["app"]
