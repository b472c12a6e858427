"""What evaluate.reprojection and evaluate.circles found in several modes, as a table with 95 % bootstrap intervals over pictures.

A run is {"reprojection": its file} with, or without, "circles" beside it. An order of two modes is said only where their intervals
do not overlap.
"""

import math
import random


def pearson(n, x, y, xx, yy, xy):
    spread = (n * xx - x * x) * (n * yy - y * y)
    return (n * xy - x * y) / math.sqrt(spread) if n > 2 and spread > 0 else None


def circle_sums(runs):
    """Of every picture, over the orders: sums of depth d, radius r in pixels and m in meters, and stretch, of its circles."""
    sums = {}
    for one in runs:
        for picture in one["circles"]["picture_circles"]:
            of = sums.setdefault(picture["picture"], [0.0] * 10)
            for circle in picture["circles"]:
                if circle.get("radius_m") is None:
                    continue
                d, r, m = circle["depth_m"], circle["radius_px"], circle["radius_m"]
                for i, value in enumerate((1, d, d * d, r, r * r, d * r, m, m * m, d * m, circle["stretch"])):
                    of[i] += value
    return list(sums.values())


def circle_figures(total):
    n, d, dd, r, rr, dr, m, mm, dm, stretch = total
    return {"Corr2D": pearson(n, d, r, dd, rr, dr), "Corr3D": pearson(n, d, m, dd, mm, dm), "Stretch": stretch / n if n else None}


def pair_sums(runs, gap):
    """Of every source frame, over the orders: sums of the pairs' figures, and their number."""
    sums = {}
    for one in runs:
        for pair in one["reprojection"][gap]["pair_figures"]:
            of = sums.setdefault(pair["source"], [0.0] * 5)
            values = [pair.get(key) for key in ("value", "floor", "sharpness", "headline")]
            if None in values:
                continue
            for i, value in enumerate(values + [1]):
                of[i] += value
    return list(sums.values())


def pair_figures(gap):
    def of(total):
        return {f"{gap} {key}": total[i] / total[4] if total[4] else None
                for i, key in enumerate(("value", "floor", "sharpness", "headline"))}
    return of


def bootstrapped(sums, figures, resamples=2000):
    """The figures of all pictures together, and where 95 % of them lie when pictures are resampled (Efron 1979)."""
    draw = random.Random(1)
    drawn = [figures([sum(column) for column in zip(*draw.choices(sums, k=len(sums)))]) for _ in range(resamples)]
    result = {}
    for name, value in figures([sum(column) for column in zip(*sums)]).items():
        known = sorted(one[name] for one in drawn if one[name] is not None)
        low, high = (known[int(0.025 * len(known))], known[int(0.975 * len(known))]) if known else (None, None)
        result[name] = {"value": value if known else None, "low": low, "high": high}
    return result


def over_seeds(runs):
    """Of the same mode and picture, all orders together: a frame is drawn with what every order made of it."""
    merged = bootstrapped(circle_sums(runs), circle_figures) if "circles" in runs[0] else {}
    for gap in ("short", "long"):
        merged.update(bootstrapped(pair_sums(runs, gap), pair_figures(gap)))
    return merged


def cell(figure):
    if figure["value"] is None:
        return "-"
    return f"{figure['value']:.4g} [{figure['low']:.4g}, {figure['high']:.4g}]"


def order(figures):
    """What may be said of one figure of all modes."""
    known = {mode: f for mode, f in figures.items() if f["value"] is not None}
    ranked = sorted(known, key=lambda mode: known[mode]["value"])
    said = [f"{a} < {b}" for a, b in zip(ranked, ranked[1:]) if known[a]["high"] < known[b]["low"]]
    if len(ranked) > 2 and not said and known[ranked[0]]["high"] < known[ranked[-1]]["low"]:
        said = [f"{ranked[0]} < {ranked[-1]}"]
    return ", ".join(said) or "not distinguishable"


def table(title, merged, runs):
    print(f"\n{title}")
    for name in next(iter(merged.values())):
        figures = {mode: merged[mode][name] for mode in merged}
        print(f"  {name:16}" + "".join(f"{cell(figures[mode]):36}" for mode in merged) + order(figures))
    if all("circles" in one for several in runs.values() for one in several):
        counts = {mode: [one["circles"]["circles"] for one in several] for mode, several in runs.items()}
        print("  circles         " + "".join(f"{' + '.join(map(str, counts[mode])):36}" for mode in merged))
