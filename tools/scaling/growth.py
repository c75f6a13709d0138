"""Growth of stages: runs.jsonl, report.md and the plots."""

import json
import math
import shutil
import statistics
from dataclasses import dataclass

from measure import SWEEPS
from plot import draw
from runs import write_text  # of tools/ablation

# An exponent this much above that of the work, of a stage with this share of the time, is marked
MARGIN, LEAST_SHARE = 0.15, 0.02
# trainer/model/view_budget.h: so many renders a run affords for looking at many photos, at least 40
# photos; the SH reduction takes the fewest for one photo and so may look at the most
RENDERS_PER_ITERATION, FEWEST_RENDERS, FEWEST_PHOTOS = 0.05 * 1.5, 2.5, 40
MANY_PHOTOS = ("late pruning", "SH reduction", "storing")

TITLES = {"splats": "Splats", "pixels": "Pixels", "photos": "Photos"}
AXES = {"splats": "splats", "pixels": "megapixels of a photo", "photos": "photos"}
FACTORS = {"splats": 1, "pixels": 1e-6, "photos": 1}


@dataclass
class Results:
    head: dict
    rows: list

    def of(self, sweep, kind):
        """x and the values of all repeats, in the order of x."""
        by_x = {}
        for row in self.rows:
            if (row["sweep"], row["kind"]) == (sweep, kind):
                by_x.setdefault(row["x"], []).append(row)
        return sorted(by_x.items())


def to_json_lines(results):
    return "".join(json.dumps(line) + "\n" for line in [results.head, *results.rows])


def from_json_lines(text):
    """The results of a runs.jsonl. Raises ValueError for anything else."""
    try:
        head, *rows = [json.loads(line) for line in text.splitlines()]
        results = Results(head, rows)
        to_markdown(results)
        return results
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"expected the runs.jsonl of a scaling report ({error})") from error


def median(rows, *keys):
    """Of a value of all repeats, 0 where a stage was not there."""
    def value(row):
        found = row["values"]
        for key in keys:
            found = found.get(key, 0)
        return found
    return statistics.median(map(value, rows))


def exponent(before, after):
    """p of y ~ x^p between two points (x, y); None where there is nothing to compare."""
    (x0, y0), (x1, y1) = before, after
    return math.log(y1 / y0) / math.log(x1 / x0) if min(x0, x1, y0, y1) > 0 and x0 != x1 else None


def work_of(sweep, stage, row):
    """The work of a stage, in units of its own: its time should not grow faster."""
    if sweep != "photos":
        return row["x"]
    if stage not in MANY_PHOTOS:
        return 1  # an iteration sees one photo
    affordable = RENDERS_PER_ITERATION * row["iterations"] / FEWEST_RENDERS
    return min(row["photos"], max(FEWEST_PHOTOS, affordable))


def faster_than_work(sweep, stage, before, after, share):
    """True where the time of a stage grew faster from one point to the next than its work. `before`
    and `after`: (row, milliseconds); `share`: of the whole, at the second point."""
    (row0, y0), (row1, y1) = before, after
    grown = exponent((row0["x"], y0), (row1["x"], y1))
    work = exponent((row0["x"], work_of(sweep, stage, row0)), (row1["x"], work_of(sweep, stage, row1)))
    return grown is not None and share >= LEAST_SHARE and grown > work + MARGIN


def number(value):
    if value >= 100:
        return f"{value:,.0f}"
    return f"{value:.1f}" if value >= 1 else f"{value:.2g}"


def name_of_x(sweep, row):
    if sweep == "pixels":
        return f"{row['size']} ({row['x'] / 1e6:.2g} MP)"
    return f"{row['x']:,}"


def markdown_row(cells):
    return "| " + " | ".join(cells) + " |\n"


def table(sweep, points, series):
    """Series (name, value of the rows of a point, the whole's) against the points, with the exponents
    between neighbours. A series without a whole is not judged."""
    names = [name_of_x(sweep, rows[0]) for _, rows in points]
    text = markdown_row(["", *names, "growth between neighbours"])
    text += "|---|" + "---:|" * (len(points) + 1) + "\n"
    for name, value, whole in series:
        values = [value(rows) for _, rows in points]
        growths = []
        for i in range(1, len(points)):
            grown = exponent((points[i - 1][0], values[i - 1]), (points[i][0], values[i]))
            shown = "–" if grown is None else f"{grown:.2f}"
            before, after = ((points[j][1][0], values[j]) for j in (i - 1, i))
            if whole and faster_than_work(sweep, name, before, after,
                                          values[i] / whole(points[i][1])):
                shown = f"**{shown}** ▲"
            growths.append(shown)
        text += markdown_row([name, *map(number, values), ", ".join(growths)])
    return text + "\n"


def stages_of(points, least):
    """Names of stages by their time at the last point, those of next to no time left out."""
    rows = points[-1][1]
    names = {name for _, some in points for row in some for name in row["values"]["stages_cpu"]}
    times = {name: median(rows, "stages_cpu", name) for name in names}
    whole = sum(times.values())
    return sorted((n for n in names if times[n] >= least * whole), key=lambda n: -times[n])


def pairs(rows):
    return median(rows, "pairs_per_pixel") * median(rows, "width") * median(rows, "height")


def iteration_series(points):
    def whole(rows):
        return median(rows, "cpu_ms")
    series = [(stage, lambda rows, s=stage: median(rows, "stages_cpu", s), whole)
              for stage in stages_of(points, 0.003)]
    series.append(("all, ms", whole, whole))

    def blending(rows):
        return median(rows, "stages_cpu", "forward") + median(rows, "stages_cpu", "backward")
    return series + [
        ("splat-pixel pairs of a photo, millions", lambda rows: pairs(rows) / 1e6, None),
        ("forward and backward, ns a pair", lambda rows: 1e6 * blending(rows) / pairs(rows), None),
        ("all, ns a pair", lambda rows: 1e6 * whole(rows) / pairs(rows), None),
        ("memory at most, MB", lambda rows: median(rows, "peak_memory_bytes") / 1e6, None)]


def stage_seconds(rows, stage):
    """Of a whole training."""
    return median(rows, "stages_cpu", stage) * rows[0]["iterations"] / 1e3


def storing(rows):
    return median(rows, "storing_cpu_seconds")


def run_whole(rows):
    return median(rows, "cpu_seconds") + storing(rows)


def rest(rows):
    return median(rows, "all_cpu_seconds") - run_whole(rows)


def run_series(points):
    series = [(stage, lambda rows, s=stage: stage_seconds(rows, s), run_whole)
              for stage in stages_of(points, 0.002)]
    return series + [
        ("storing", storing, run_whole),
        ("all, s", run_whole, run_whole),
        ("before and after (reading photos, scores), s", rest, None),
        ("splats at the end", lambda rows: median(rows, "splats"), None),
        ("compact .glb, MB", lambda rows: median(rows, "bytes") / 1e6, None),
        (".ply, MB", lambda rows: median(rows, "float_bytes") / 1e6, None),
        ("checkpoint, MB", lambda rows: median(rows, "checkpoint_bytes") / 1e6, None),
        ("memory at most, MB", lambda rows: median(rows, "peak_memory_bytes") / 1e6, None)]


def shares(points):
    """Shares of the stages that look at many photos, in percent of a training."""
    text = markdown_row(["% of the training", *(name_of_x("photos", rows[0]) for _, rows in points)])
    text += "|---|" + "---:|" * len(points) + "\n"
    for stage in MANY_PHOTOS:
        values = [storing(rows) if stage == "storing" else stage_seconds(rows, stage)
                  for _, rows in points]
        text += markdown_row([stage, *(f"{100 * v / run_whole(rows):.1f}"
                                       for v, (_, rows) in zip(values, points))])
    return text + "\n"


def fixed(sweep, row):
    """The quantities that stay in a sweep."""
    parts = [f"{row['photos']} photos" if sweep != "photos" else "",
             f"of {row['size']}" if sweep != "pixels" else "",
             f"{row['points']:,} splats at the start" if sweep != "splats" else ""]
    return " ".join(p for p in parts[:2] if p) + (f", {parts[2]}" if parts[2] else "")


def section(results, sweep, images):
    text = f"## {TITLES[sweep]}\n\n"
    iterations, runs = results.of(sweep, "iteration"), results.of(sweep, "run")
    if not iterations and not runs:
        return ""
    some = (runs or iterations)[0][1][0]
    text += f"The same throughout: {fixed(sweep, some)}.\n\n"
    if f"{sweep}.png" in images:
        text += f"![{TITLES[sweep]}]({sweep}.png)\n\n"
    if iterations:
        repeats = max(len(rows) for _, rows in iterations)
        again = f", and of up to {repeats} such runs" if repeats > 1 else ""
        text += (f"The stages of an iteration with all SH (`train_benchmark`, medians of "
                 f"{iterations[0][1][0]['iterations']} iterations{again}), ms:\n\n")
        text += table(sweep, iterations, iteration_series(iterations))
    if runs:
        text += (f"A whole training of {runs[0][1][0]['iterations']:,} iterations with `flux`, seconds:"
                 "\n\n")
        text += table(sweep, runs, run_series(runs))
    if sweep == "photos" and runs:
        text += shares(runs)
    return text


def to_markdown(results, images=()):
    kinds = sorted({row["values"]["instruction_set"] for row in results.rows})
    text = (
        "# How a training grows\n\n"
        "Processor time on one thread, by stage, where splats, pixels or photos grow and the other two "
        "stay. The captures are of `make_capture`; splats begin as points on the surfaces, so that the "
        "same picture is drawn by more and smaller ones. Growth is the exponent p of time ~ xᵖ between "
        "neighbours. **▲** marks a stage that grows faster than its work (p more than "
        f"{MARGIN} above it) and takes {LEAST_SHARE:.0%} of the time or more. The work of a stage is "
        "the splats or the pixels; with the photos the work of an iteration does not grow, and that of "
        f"{', '.join(MANY_PHOTOS)} only until a run of this length affords no more of them "
        "(`trainer/model/view_budget.h`).\n\n"
        f"    {results.head['command']} -o OUT\n\n"
        f"fluxgs {results.head['version']}, {' or '.join(kinds)}. Numbers of one run may be some "
        "percent off where others used the machine.\n\n")
    missing = results.head["planned"] - len(results.rows)
    if missing:
        text += f"**{missing} of {results.head['planned']} measurements are missing.**\n\n"
    return text + "".join(section(results, sweep, images) for sweep in SWEEPS).rstrip() + "\n"


def draw_sweep(results, sweep, path):
    """Time by stage, both axes in powers: of an iteration, or of a training where photos grow."""
    points = results.of(sweep, "run" if sweep == "photos" else "iteration")
    if len(points) < 2:
        return False
    if sweep == "photos":
        title, label = "processor time of a training", "seconds of one core"
        values = {s: (lambda rows, s=s: stage_seconds(rows, s)) for s in stages_of(points, 0.01)}
        values |= {"storing": storing, "all": run_whole}
    else:
        title, label = "processor time of an iteration", "ms of one core"
        values = {s: (lambda rows, s=s: median(rows, "stages_cpu", s)) for s in stages_of(points, 0.01)}
        values["all"] = lambda rows: median(rows, "cpu_ms")
    series = [(name, "linespoints",
               [(x * FACTORS[sweep], value(rows)) for x, rows in points if value(rows) > 0])
              for name, value in values.items()]
    # gnuplot by itself names powers of ten, of which there are few
    ticks = ", ".join(f"'{x * FACTORS[sweep]:{'.2g' if sweep == 'pixels' else ','}}' "
                      f"{x * FACTORS[sweep]:.9g}" for x, _ in points)
    low, high = points[0][0] * FACTORS[sweep], points[-1][0] * FACTORS[sweep]
    return draw(path, f"{TITLES[sweep]}: {title}", AXES[sweep], label, series,
                ["set logscale xy", f"set xtics ({ticks})", f"set xrange [{low / 1.2}:{high * 1.2}]"])


def write(results, out):
    """Writes runs.jsonl, the plots and report.md. Returns a warning where there are no plots."""
    write_text(out / "runs.jsonl", to_json_lines(results))
    images, warning = [], ""
    if shutil.which("gnuplot"):
        images = [f"{sweep}.png" for sweep in SWEEPS
                  if draw_sweep(results, sweep, out / f"{sweep}.png")]
    else:
        warning = "no plots: gnuplot is not installed (tools/setup installs it)"
    write_text(out / "report.md", to_markdown(results, images))
    return warning
