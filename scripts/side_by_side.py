#!/usr/bin/env python3
"""Times programs alone and two at a time.

    scripts/side_by_side.py scan.ply build/release/bin/gpsrecon
    scripts/side_by_side.py scan.ply old/gpsrecon 'OMP_WAIT_POLICY=active new/gpsrecon' --rounds 7

Each round runs every command twice one after the other and then twice at once, the commands in turn, so that a change of the
machine's speed meets all of them. Writes a table of medians: wall and processor seconds of one run alone, wall and processor
seconds of two at once, and the median ratio of the latter to the sum of the two runs before. Where waiting threads spin,
two at once take more processor time than one after the other.
"""

import argparse
import os
import shlex
import statistics
import tempfile
import time


def start(command, scan, folder, number):
    words = shlex.split(command)
    variables = dict(os.environ)
    while "=" in words[0]:
        name, value = words.pop(0).split("=", 1)
        variables[name] = value
    return os.posix_spawn(words[0], [*words, scan, os.path.join(folder, f"{number}.ply"), "--quiet"], variables)


def run(command, scan, folder, copies):
    """Wall seconds from the start to the last one's end, and the processor seconds of all copies."""
    begin = time.monotonic()
    processor = 0.0
    for process in [start(command, scan, folder, number) for number in range(copies)]:
        _, status, usage = os.wait4(process, 0)
        if status != 0:
            raise SystemExit(f"{command}: exit status {os.waitstatus_to_exitcode(status)}")
        processor += usage.ru_utime + usage.ru_stime
    return time.monotonic() - begin, processor


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scan", help="the points to reconstruct")
    parser.add_argument("commands", nargs="+", help="programs, each with variables before it and options after it")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()

    figures = {command: [] for command in arguments.commands}
    with tempfile.TemporaryDirectory() as folder:
        for command in arguments.commands:
            run(command, arguments.scan, folder, 1)
        for _ in range(arguments.rounds):
            for command, rows in figures.items():
                first, second = (run(command, arguments.scan, folder, 1) for _ in range(2))
                both = run(command, arguments.scan, folder, 2)
                rows.append([(first[0] + second[0]) / 2, (first[1] + second[1]) / 2, *both,
                             both[0] / (first[0] + second[0]), both[1] / (first[1] + second[1])])

    print("| command | alone: wall s | processor s | two at once: wall s | processor s | wall ratio | processor ratio |")
    print("|---|---|---|---|---|---|---|")
    for command, rows in figures.items():
        print("| " + " | ".join([command, *(f"{statistics.median(column):.2f}" for column in zip(*rows))]) + " |")


if __name__ == "__main__":
    main()
