"""Studies that a reader can rerun: measured success, accuracy and speed."""
