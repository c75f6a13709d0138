"""What an ablation found: runs.jsonl, report.md and a plot for each group."""

import json
import shutil
import statistics
from collections import Counter

from plot import draw
from rows import GROUPS
from runs import Result, write_text

# key, title with the unit that is shown, factor from the stored unit to it, digits
METRICS = (
    ("psnr", "PSNR (dB)", 1, 2),
    ("ssim", "SSIM", 1, 4),
    ("sh_reduction_psnr", "SH reduction (dB)", 1, 2),
    ("stored_psnr", "compact: PSNR (dB)", 1, 2),
    ("stored_ssim", "compact: SSIM", 1, 4),
    ("stored_flip", "compact: FLIP", 1, 4),
    ("stored_lpips", "compact: LPIPS (VGG, [0,1])", 1, 4),
    ("splats", "splats", 1, 0),
    ("stored_bytes", "compact .glb (MB)", 1e-6, 3),
    ("ply_bytes", ".ply (MB)", 1e-6, 2),
    ("seconds", "time (min)", 1 / 60, 2),
    ("cpu_seconds", "CPU (min)", 1 / 60, 2),
    ("peak_memory", "memory at most (MB)", 1e-6, 0),
    ("frame_ms", "frame (ms)", 1, 1),
)
PARTIAL = {"sh_reduction_psnr"}  # not every kind of training has it


class Table:
    """Results by scene, row and seed."""

    def __init__(self, command, version, scenes, rows, seeds):
        self.command, self.version = command, version
        self.scenes, self.rows, self.seeds = scenes, rows, seeds  # scenes: names
        self.notes = []
        self.results = {}  # (scene, row name, seed)

    def at(self, scene, row, seed):
        return self.results.get((scene, row.name, seed), Result())

    def value(self, scene, row, seed, key):
        result = self.at(scene, row, seed)
        return result.values.get(key) if result.state == "finished" else None

    def count(self, state):
        return sum(r.state == state for r in self.results.values())

    def of_scene(self, scene, row, key):
        """The values of the finished runs of a row on one scene."""
        found = (self.value(scene, row, seed, key) for seed in self.seeds)
        return [v for v in found if v is not None]

    def of_all(self, row, key):
        """Means over all scenes, one a seed. A seed that lacks a scene does not count."""
        means = []
        for seed in self.seeds:
            found = [self.value(scene, row, seed, key) for scene in self.scenes]
            if found and None not in found:
                means.append(statistics.fmean(found))
        return means


def deviation(values):
    """Sample standard deviation; 0 for a single value."""
    return statistics.stdev(values) if len(values) > 1 else 0.0


# --- runs.jsonl: a head, then one run a line ---


def rounded(value):
    return float(f"{value:.7g}") if isinstance(value, float) else value


def to_json_lines(table):
    lines = [{"command": table.command, "version": table.version, "scenes": table.scenes,
              "seeds": table.seeds, "rows": [r.name for r in table.rows], "notes": table.notes}]
    for (scene, row, seed), r in table.results.items():
        lines.append({"scene": scene, "row": row, "seed": seed, "state": r.state,
                      "error": r.error, "notes": r.notes,
                      "values": {k: rounded(v) for k, v in r.values.items()},
                      "curve": [[i, round(p, 3)] for i, p in r.curve]})
    return "".join(json.dumps(line, ensure_ascii=False) + "\n" for line in lines)


def from_json_lines(text, rows):
    """The table of a runs.jsonl. Raises ValueError for anything else."""
    try:
        head, *runs = [json.loads(line) for line in text.splitlines()]
        by_name = {r.name: r for r in rows}
        table = Table(head["command"], head["version"], head["scenes"],
                      [by_name[name] for name in head["rows"]], head["seeds"])
        table.notes = head["notes"]
        for r in runs:
            table.results[r["scene"], r["row"], r["seed"]] = Result(
                r["state"], r["error"], r["notes"], r["values"], r["curve"])
        return table
    except (KeyError, TypeError) as error:
        raise ValueError(f"expected the runs.jsonl of an ablation ({error})") from error


# --- report.md ---


def cell(text):
    return " ".join(text.split())[:300].replace("|", "\\|")


def shown(values, factor, digits, runs):
    """ "28.70 ± 0.05", and of how many runs where others of the row are of more."""
    if not values:
        return "–"
    text = f"{statistics.fmean(values) * factor:.{digits}f}"
    if len(values) > 1:
        text += f" ± {deviation(values) * factor:.{digits}f}"
    return text + (f" ({len(values)})" if len(values) < runs else "")


def runs_of(table, row, scenes):
    """ "3", or "2 of 3, 1 failed"."""
    states = Counter(table.at(scene, row, seed).state for scene in scenes for seed in table.seeds)
    if states["finished"] == states.total():
        return str(states.total())
    text = f"{states['finished']} of {states.total()}"
    return text + (f", {states['failed']} failed" if states["failed"] else "")


def group_table(table, rows, values, scenes):
    """Rows against metrics; a metric that no row has is left out."""
    metrics = [m for m in METRICS if any(values(r, m[0]) for r in rows)]
    lines = ["| |" + "".join(f" {title} |" for _, title, _, _ in metrics) + " runs |",
             "|---|" + "---:|" * (len(metrics) + 1)]
    for row in rows:
        runs = max((len(values(row, key)) for key, *_ in metrics), default=0)
        cells = [shown(values(row, key), factor, digits, runs) for key, _, factor, digits in metrics]
        lines.append("| " + " | ".join([cell(row.label), *cells, runs_of(table, row, scenes)]) + " |")
    return "\n".join(lines) + "\n\n"


def group_section(table, group, images):
    rows = [r for r in table.rows if r.group == group.name]
    text = f"## {group.title}\n\n"
    several = len(table.scenes) > 1
    if several:
        text += f"Mean over {len(table.scenes)} scenes:\n\n"
        text += group_table(table, rows, table.of_all, table.scenes)
    for scene in table.scenes:
        text += f"{cell(scene)}:\n\n" if several else ""
        text += group_table(table, rows, lambda r, k, s=scene: table.of_scene(s, r, k), [scene])
    mine = [f"{group.name}{kind}.png" for kind in ("", "-curves")]
    links = " ".join(f"![{group.title}]({name})" for name in mine if name in images)
    return text + (links + "\n\n" if links else "")


def notes_of(table):
    """What failed or is missing; the same note of several runs is one line."""
    finished = [r for r in table.results.values() if r.state == "finished"]
    notes = list(table.notes)
    repeated = Counter(note for r in table.results.values() for note in r.notes)
    notes += [f"{note} ({n} of {len(table.results)} runs)" for note, n in sorted(repeated.items())]
    notes += [f"{scene}, {row}, seed {seed} failed: {r.error}"
              for (scene, row, seed), r in table.results.items() if r.state == "failed"]
    having = Counter(key for r in finished for key in r.values)
    notes += [f"{title}: of {having[key]} of {len(finished)} finished runs"
              for key, title, *_ in METRICS
              if 0 < having[key] < len(finished) and key not in PARTIAL]
    threads = sorted({r.values["threads"] for r in finished if "threads" in r.values})
    if threads:
        notes.append("threads of the trainings: " + " or ".join(f"{n:g}" for n in threads))
    return notes


def to_markdown(table, images=()):
    text = (f"# Ablation\n\nMean ± standard deviation over {len(table.seeds)} seeds, on images that "
            'the training did not see. "compact" is the scene as its compact .glb stores it; 1 MB = '
            "10⁶ bytes; time is that of the training. Compare minutes and frame times only where "
            f"they were measured on an idle machine.\n\n    {table.command}\n\n{table.version}. "
            f"Data: {', '.join(cell(s) for s in table.scenes)}.\n\n")
    for group in GROUPS:
        if any(r.group == group.name for r in table.rows):
            text += group_section(table, group, images)
    notes = notes_of(table)
    return text + ("## Notes\n\n" + "".join(f"- {cell(n)}\n" for n in notes) if notes else "")


# --- plots ---


def scene_title(table, group):
    scenes = table.scenes
    return f"{group.title} ({scenes[0] if len(scenes) == 1 else f'mean over {len(scenes)} scenes'})"


def draw_group(table, group, path):
    """PSNR against the option that the group changes, or PSNR of the compact file against size."""
    series = {}
    for row in (r for r in table.rows if r.group == group.name):
        psnr = table.of_all(row, "psnr" if group.x_label else "stored_psnr")
        size = table.of_all(row, "stored_bytes")
        if not psnr or not (group.x_label or size):
            continue
        x = row.x if group.x_label else statistics.fmean(size) * 1e-6
        points = series.setdefault(row.series if group.x_label else row.label, [])
        points.append((x, statistics.fmean(psnr), deviation(psnr)))
    style = "yerrorlines" if group.x_label else "yerrorbars pointsize 1.5"
    settings = ["set offsets graph 0.03, graph 0.03, graph 0.03, graph 0.03"]
    if group.log_x:
        settings.append("set logscale x 2")
    which = "" if group.x_label else ", compact scene"
    return draw(path, scene_title(table, group), group.x_label or "compact .glb (MB)",
                f"PSNR of test images{which} (dB)",
                [(name, style, points) for name, points in series.items()], settings)


def mean_curve(table, row):
    """The mean over the seeds that have finished on every scene, where all of them have measured."""
    curves = []
    for seed in table.seeds:
        results = [table.at(scene, row, seed) for scene in table.scenes]
        if all(r.state == "finished" for r in results):
            curves += [r.curve for r in results]
    points = {}
    for curve in curves:
        seen = Counter()
        for iteration, psnr in curve:  # the SH reduction has two points at one iteration
            points.setdefault((iteration, seen[iteration]), []).append(psnr)
            seen[iteration] += 1
    return [(at[0], statistics.fmean(v)) for at, v in sorted(points.items()) if len(v) == len(curves)]


def draw_curves(table, group, path):
    """PSNR of the test images over the training; what is far below the best is cut off."""
    curves = [(r.label, "linespoints", mean_curve(table, r))
              for r in table.rows if r.group == group.name]
    best = max((psnr for *_, points in curves for _, psnr in points), default=0)
    return draw(path, scene_title(table, group), "iteration", "PSNR of test images (dB)", curves,
                [f"set yrange [{best - 6}:]"])


def write(table, out):
    """Writes runs.jsonl, the plots and report.md. Returns a warning where there are no plots."""
    write_text(out / "runs.jsonl", to_json_lines(table))
    images, warning = [], ""
    if shutil.which("gnuplot"):
        for group in GROUPS:
            for kind, draws in (("", draw_group), ("-curves", draw_curves)):
                name = f"{group.name}{kind}.png"
                if draws(table, group, out / name):
                    images.append(name)
    else:
        warning = "no plots: gnuplot is not installed (tools/setup installs it)"
    write_text(out / "report.md", to_markdown(table, images))
    return warning
