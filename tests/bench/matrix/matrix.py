#!/usr/bin/env python3
"""Time and peak memory of checking and planning a large matrix: python3 tests/bench/matrix/matrix.py build/bin/fresco [SCANS PICTURES]...

Six stages, three per scan and three per combination; none of them runs."""
import os
import subprocess
import sys
import tempfile
import time

PIPELINE = """stages:
  recording: {type: command, run: [echo, "${scan}", "{made}"], outputs: {made: mesh}}
  mesh: {type: command, run: [echo, "{used}", "{made}"], inputs: {used: mesh}, outputs: {made: mesh}, input: recording}
  atlas: {type: command, run: [echo, "{used}", "{made}"], inputs: {used: mesh}, outputs: {made: mesh}, input: mesh}
  paint: {type: command, run: [echo, "{used}", "${picture}", "{made}"], inputs: {used: mesh}, outputs: {made: mesh}, input: atlas}
  bake: {type: command, run: [echo, "{used}", "{made}"], inputs: {used: mesh}, outputs: {made: mesh}, input: paint}
  glb: {type: command, run: [echo, "{used}", "{made}"], inputs: {used: mesh}, outputs: {made: files}, input: bake}
"""


def write_pipeline(file, scans, pictures):
    with open(file, "w", encoding="utf-8") as out:
        out.write("version: 1\nvars: {scan: , picture: }\nmatrix:\n  scan:\n")
        out.writelines(f"  - scan{i}\n" for i in range(scans))
        out.write("  picture:\n")
        out.writelines(f"  - picture{i}\n" for i in range(pictures))
        out.write(PIPELINE)


def measured(command, folder):
    """Seconds and peak MB of a command that must succeed."""
    with open(os.path.join(folder, "said"), "wb") as said:
        begin = time.monotonic()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said, cwd=folder)
        _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        with open(os.path.join(folder, "said"), encoding="utf-8") as said:
            sys.exit(f"{' '.join(command)}: {said.read()}")
    return time.monotonic() - begin, usage.ru_maxrss / 1024


def main():
    fresco = os.path.abspath(sys.argv[1])
    numbers = [int(word) for word in sys.argv[2:]] or [10, 1000, 100, 100, 100, 1000]
    print(f"{'combinations':>14} {'command':<14} {'seconds':>8} {'peak MB':>8}")
    for scans, pictures in zip(numbers[::2], numbers[1::2]):
        with tempfile.TemporaryDirectory() as folder:
            write_pipeline(os.path.join(folder, "many.yaml"), scans, pictures)
            subprocess.run([fresco, "stages"], stdout=subprocess.DEVNULL, check=True)  # The first start reads from the disk.
            for words in (["check"], ["plan"], ["plan", "--tasks", "--folder", "tasks"]):
                seconds, memory = measured([fresco, *words, "many.yaml"], folder)
                print(f"{scans:>6} x {pictures:<5} {' '.join(words[:2]):<14} {seconds:8.2f} {memory:8.0f}")


if __name__ == "__main__":
    main()
