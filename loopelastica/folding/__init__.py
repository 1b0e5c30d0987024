"""From a stem to the ranked shapes of its loop: :mod:`.fold` has the steps."""
