"""Skipped tests are listed at the end of the whole check."""
import os


def skip(text):
    """What was not tried, and why."""
    print(f"SKIPPED {text}")
    if log := os.environ.get("FRESCO_SKIP_LOG"):
        with open(log, "a") as file:
            file.write(text + "\n")
