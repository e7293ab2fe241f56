#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints `N passed, N failed` for a test run, from meson's testlog.json, and fails if one failed.

A program that reports its cases in cmocka's form counts by cases, any other program as one. A
program that died without naming a failed case counts as one failure more. Skipped programs are
named apart.
"""
import json
import re
import sys

CASE = re.compile(r"^\[\s*(OK|FAILED|ERROR)\s*\] (\S+)$", re.MULTILINE)
GOOD = {"OK", "EXPECTEDFAIL"}


def count(run):
    """Passed and failed cases of one program."""
    text = run.get("stdout", "") + "\n" + run.get("stderr", "")
    ok = {name for word, name in CASE.findall(text) if word == "OK"}
    bad = {name for word, name in CASE.findall(text) if word != "OK"} - ok
    if run["result"] in GOOD:
        return max(len(ok), 1), 0
    return len(ok), max(len(bad), 1)


def main():
    passed = failed = 0
    skipped = []
    try:
        with open(sys.argv[1], encoding="utf-8") as log:
            runs = [json.loads(line) for line in log if line.strip()]
    except (OSError, ValueError) as error:
        sys.exit(f"summary: no test results: {error}")
    for run in runs:
        if run["result"] == "SKIP":
            skipped.append(run["name"])
            continue
        ok, bad = count(run)
        passed += ok
        failed += bad
    if skipped:
        print("skipped: " + ", ".join(skipped))
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
