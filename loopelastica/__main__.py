"""``python -m loopelastica``: the command line."""

from loopelastica.cli import app

if __name__ == "__main__":
    app(prog_name="loopelastica")
