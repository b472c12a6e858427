#!/usr/bin/env python3
"""study.py page PICTURES OUT [--ours METHOD]   PICTURES/METHOD/VIEW.png → OUT/study.html, OUT/study.key.json
study.py results KEY ANSWERS                 the files that participants sent back → study.results.json beside KEY

A page of picture pairs that asks which of two methods people prefer, and how often each was chosen. Needs python3-opencv."""
import argparse
import base64
import hashlib
import itertools
import json
import math
import pathlib
import random
import re
import sys

import cv2

QUESTIONS = ["Which picture has less visible stretch?", "In which picture are patterns in the background smaller?"]
MAX_PX, JPEG_QUALITY, RESAMPLES = 960, 90, 2000


def comparisons(key):
    """{(method, later method): [(picture of the first, of the second), …]}, pictures by their numbers."""
    views, found = {}, {}
    for number, picture in enumerate(key["pictures"]):
        views.setdefault(picture["name"], {})[picture["method"]] = number
    for _, numbers in sorted(views.items()):
        for first, second in itertools.combinations(sorted(numbers), 2):
            if key["ours"] in ("", first, second):
                found.setdefault((first, second), []).append((numbers[first], numbers[second]))
    return dict(sorted(found.items()))


def jpegs(files):
    """The pictures of one view, {method: file}, all in the smallest one's size: resolution must not give a method away."""
    pictures = {method: cv2.imread(str(file)) for method, file in files.items()}
    if damaged := [str(files[method]) for method, picture in pictures.items() if picture is None]:
        sys.exit(f"{damaged[0]}: cannot be read as a picture")
    height, width = min(picture.shape[:2] for picture in pictures.values())
    for method, picture in pictures.items():
        if abs(picture.shape[1] / picture.shape[0] * height / width - 1) > 0.01:
            sys.exit(f"{files[method]}: has another shape than the other pictures of its view, {width}x{height}")
    scale = min(1, MAX_PX / max(width, height))
    width, height = round(width * scale), round(height * scale)
    for method, picture in pictures.items():
        picture = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
        yield method, cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()


def make_page(given):
    files = {}
    for file in sorted(given.source.glob("[!.]*/*")):
        if file.suffix.lower() in (".png", ".jpg", ".jpeg") and files.setdefault(file.stem, {}).setdefault(file.parent.name, file) != file:
            sys.exit(f"{file}: {file.parent.name} has two pictures of the view {file.stem}")
    shared = sorted(name for name, methods in files.items() if len(methods) >= 2)
    shared = [shared[(2 * i + 1) * len(shared) // (2 * given.views)] for i in range(given.views)] if len(shared) > given.views else shared
    encoded = [(method, name, jpeg) for name in shared
               for method, jpeg in jpegs(files[name])]
    random.Random(1).shuffle(encoded)
    key = {"format": "fresco.study_key", "version": 1, "study": "", "questions": QUESTIONS, "pairs_count": given.pairs, "ours": given.ours,
           "pictures": [{"method": method, "name": name} for method, name, _ in encoded]}
    compared = comparisons(key)
    if not compared:
        sys.exit(f"{given.source}: found no view by two compared methods; expected METHOD/VIEW.png, with one name for one view")
    key["study"] = hashlib.sha256(json.dumps(key).encode() + b"".join(jpeg for *_, jpeg in encoded)).hexdigest()[:32]
    # By number, so that neither the order of the pairs nor that within a pair gives the methods away.
    data = {name: key[name] for name in ("study", "questions", "pairs_count")}
    data |= {"strata": [sorted(sorted(pair) for pair in pairs) for pairs in compared.values()],
             "pictures": ["data:image/jpeg;base64," + base64.b64encode(jpeg).decode() for *_, jpeg in encoded]}
    page = pathlib.Path(__file__).with_name("study.html").read_text().replace("<!--DATA-->", json.dumps(data).replace("<", "\\u003c"))
    given.folder.mkdir(parents=True, exist_ok=True)
    (given.folder / "study.html").write_text(page)
    (given.folder / "study.key.json").write_text(json.dumps(key, indent=1) + "\n")
    print(f"{given.folder}/study.html: {len(page) >> 20} MB, {len(encoded)} pictures; keep study.key.json, which says who made them, to yourself")


def read_sheet(file, key):
    """A participant's answers, checked: nothing but what the page of this study writes."""
    def check(holds, problem):
        if not holds:
            sys.exit(f"{file}: {problem}")
    try:
        sheet = json.loads(file.read_text())
        check(sheet["format"] == "fresco.study_answers" and sheet["version"] == 1, "not the answers of a study; keep only files that the page wrote")
        check(sheet["study"] == key["study"], "answers of another study: move the file away")
        check(re.fullmatch("[A-Za-z0-9_-]{1,40}", sheet["participant"]), "'participant': expected 1 to 40 letters, digits, - and _")
        pairs, known = {tuple(sorted(pair)) for pairs in comparisons(key).values() for pair in pairs}, set()
        for number, answer in enumerate(sheet["answers"]):
            pair = tuple(sorted((answer["left"], answer["right"])))
            check(pair in pairs and 0 <= answer["question"] < len(key["questions"]), f"answer {number}: not a pair or question of the study")
            check((answer["question"], pair) not in known, f"answer {number}: this pair is answered twice")
            check(answer["choice"] in ("left", "right", "neither") and answer["seconds"] >= 0, f"answer {number}: unknown choice or seconds")
            known.add((answer["question"], pair))
        check(isinstance(sheet["complete"], bool), "'complete': expected true or false")
        check(len(known) <= key["pairs_count"], f"{len(known)} answers, but a participant sees {key['pairs_count']} pairs")
        return sheet
    except (KeyError, TypeError, ValueError) as error:
        sys.exit(f"{file}: not the answers of a study: {error!r}")


def share(people, which):
    """How often choice `which` of [first, second, neither] was made, with a 95% interval: Wilson's (1927), since few or unanimous answers
    prove little, and a bootstrap over participants (Efron, 1979), since one person's answers are alike. `people`: counts per participant."""
    count, trials, z = sum(counts[which] for counts in people), sum(map(sum, people)), 1.959963984540054
    value = count / trials
    center = (value + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * math.sqrt(value * (1 - value) / trials + z * z / (4 * trials ** 2))
    low, high = max(0, center - half), min(1, center + half)
    if len(people) >= 2:
        draws = random.Random(1)
        samples = (draws.choices(people, k=len(people)) for _ in range(RESAMPLES))
        drawn = sorted(sum(counts[which] for counts in sample) / sum(map(sum, sample)) for sample in samples)
        low, high = min(low, drawn[RESAMPLES // 40]), max(high, drawn[-RESAMPLES // 40 - 1])
    return {"value": value, "low": low, "high": high, "count": count}


def make_results(given):
    key = json.loads(given.source.read_text())
    sheets = {}
    for file in sorted(given.folder.glob("*.json")):
        sheet = read_sheet(file, key)
        if sheets.setdefault(sheet["participant"], sheet) is not sheet:
            sys.exit(f"{file}: two files of the participant {sheet['participant']}: keep one of them")
    if not sheets:
        sys.exit(f"{given.folder}: no result files (*.json)")
    method = lambda number: key["pictures"][number]["method"]
    questions = []
    for question, text in enumerate(key["questions"]):
        found = []
        for first, second in comparisons(key):
            people = []
            for _, sheet in sorted(sheets.items()):
                chosen = [method(answer[answer["choice"]]) if answer["choice"] != "neither" else "neither" for answer in sheet["answers"]
                          if answer["question"] == question and {method(answer["left"]), method(answer["right"])} == {first, second}]
                people += [[chosen.count(name) for name in (first, second, "neither")]] if chosen else []
            if not people:
                continue
            one, other, neither = (share(people, which) for which in range(3))
            preferred = None if len(people) < 2 else first if one["low"] > other["high"] else second if other["low"] > one["high"] else None
            found.append({"first": first, "second": second, "participants": len(people), "answers": sum(map(sum, people)),
                          "first_share": one, "second_share": other, "neither_share": neither, "preferred": preferred})
            texts = [f"{name} {of['value']:.1%} [{of['low']:.1%}, {of['high']:.1%}]"
                     for name, of in zip((first, second, "neither"), (one, other, neither))]
            verdict = preferred + " is chosen more often" if preferred else "no significant preference"
            print(f"{text} {', '.join(texts)} of {found[-1]['answers']} answers: {verdict}")
        questions.append({"question": text, "comparisons": found})
    seconds = [answer["seconds"] for _, sheet in sorted(sheets.items()) for answer in sheet["answers"]]
    result = {"study": key["study"], "participants": len(sheets), "complete": sum(sheet["complete"] for sheet in sheets.values()),
              "answers": len(seconds), "mean_seconds": sum(seconds) / len(seconds) if seconds else None, "questions": questions}
    given.source.with_name("study.results.json").write_text(json.dumps(result, indent=1) + "\n")


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS)
parser.add_argument("command", choices=["page", "results"])
parser.add_argument("source", type=pathlib.Path, help="PICTURES, a folder with a folder of pictures for each method; or KEY")
parser.add_argument("folder", type=pathlib.Path, help="OUT, for the page and its key; or ANSWERS")
parser.add_argument("--ours", default="", help="compare only this method with the others (default: all pairs of methods)")
parser.add_argument("--pairs", type=int, default=70, help="number of pairs shown to each participant (default: 70)")
parser.add_argument("--views", type=int, default=40, help="maximum number of views in the page (default: 40)")
arguments = parser.parse_args()
(make_page if arguments.command == "page" else make_results)(arguments)
