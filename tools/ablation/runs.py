"""One run: a scene trained, scored and timed by `fluxgs`, in a folder of its own.

    request.json   what was asked for: a folder is reused only for the same
    scene.glb      the compact scene         scene.glb.ckpt  checkpoint of an interrupted training
    train.json     report of the training    score.json, frames.json  of the compact scene
    log.txt        messages of fluxgs        error.txt  why the run failed
"""

import json
import os
import signal
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

from rows import merged, picked

RESUME_OPTIONS = ("--threads", "--backend", "--checkpoint-every")  # a checkpoint has the others
DATA_OPTIONS = ("--downscale", "--background", "--threads")


@dataclass
class Run:
    data: str
    seed: int
    preset: str
    options: list  # of `fluxgs train`, without preset and seed


@dataclass
class Result:
    state: str = "waiting"  # waiting, finished, failed, interrupted
    error: str = ""
    notes: list = field(default_factory=list)  # what could not be measured
    values: dict = field(default_factory=dict)  # by the keys of report.METRICS
    curve: list = field(default_factory=list)  # [iteration, PSNR of test images]


class Interrupted(Exception):
    pass


class Failed(Exception):
    pass


def resolved_options(fluxgs, preset, options):
    """All options of a training as JSON text. Raises Failed where fluxgs refuses them."""
    command = [fluxgs, "train", "--plan", "--json", "-", "--preset", preset, *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failed(last_error(done.stderr, done.returncode))
    return json.dumps(json.loads(done.stdout)["options"], sort_keys=True)


def last_error(log, status):
    """The last error message in the output of fluxgs."""
    mark = "fluxgs: error: "
    errors = [line.removeprefix(mark) for line in log.splitlines() if line.startswith(mark)]
    return errors[-1] if errors else f"fluxgs ended with status {status}; see log.txt"


def data_stamp(folder):
    """Number and bytes of the files of a data set, to notice that they were changed."""
    files = [f for f in Path(folder).rglob("*")
             if f.is_file() and "colmap" not in f.relative_to(folder).parts]
    return [len(files), sum(f.stat().st_size for f in files)]


def read_json(path):
    """A JSON file, or None where it is missing or damaged."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return None


def write_text(path, text):
    partial = path.with_name(path.name + ".part")
    partial.write_text(text)
    partial.replace(path)


def call(fluxgs, arguments, folder, output=None):
    """Runs fluxgs to its end, its messages in log.txt and its output, if any, in a file."""
    log = folder / "log.txt"
    start = log.stat().st_size if log.exists() else 0
    partial = folder / "output.part"
    with open(log, "ab") as messages, open(partial if output else os.devnull, "wb") as out:
        # In a session of its own: Ctrl-C reaches it once, from here
        child = subprocess.Popen([fluxgs, *arguments], stdin=subprocess.DEVNULL, stdout=out,
                                 stderr=messages, start_new_session=True)
        try:
            status = child.wait()
        except KeyboardInterrupt:
            child.send_signal(signal.SIGINT)  # training saves a checkpoint
            child.wait()
            raise Interrupted from None
    if status != 0:
        raise Failed(last_error(log.read_bytes()[start:].decode(errors="replace"), status))
    if output:
        partial.replace(output)


def prepare(run, folder, retry):
    """Makes the folder of a run, or checks that the one that is there is of the same run."""
    folder.mkdir(parents=True, exist_ok=True)
    request = {"data": run.data, "files": data_stamp(run.data), "preset": run.preset,
               "seed": run.seed, "options": run.options}
    known = read_json(folder / "request.json")
    if known is not None and known != request:
        raise Failed(f"{folder}: holds a run with other options or other data; "
                     "delete it or choose another --out")
    write_text(folder / "request.json", json.dumps(request) + "\n")
    error = folder / "error.txt"
    if error.exists() and not retry:
        raise Failed(error.read_text().strip())
    error.unlink(missing_ok=True)


def train(fluxgs, run, folder):
    report, scene = folder / "train.json", folder / "scene.glb"
    known = read_json(report)
    if known is not None and scene.exists() and scene.stat().st_size == known.get("bytes"):
        return
    checkpoint = folder / "scene.glb.ckpt"
    files = ["train", run.data, "-o", str(scene), "--float-output", str(folder / "scene.ply"),
             "--json", str(report), "--force"]  # what an interrupted run left
    options = merged(["--checkpoint-every", "1000"], run.options)  # little is lost with the power
    if checkpoint.exists():
        start = ["--resume", str(checkpoint),
                 *picked(options, RESUME_OPTIONS.__contains__)]
    else:
        start = ["--preset", run.preset, "--seed", str(run.seed), *options]
    for old in ("score.json", "frames.json"):
        (folder / old).unlink(missing_ok=True)
    call(fluxgs, [*files, *start], folder)
    checkpoint.unlink(missing_ok=True)


# Measures of images beside PSNR and SSIM, as eval's report names them, and its options for them
MEASURES = {"flip": ["--flip"], "lpips": ["--lpips", "vgg"]}


def measure(fluxgs, run, folder, frames, measures, result):
    """Scores and times the compact scene; what fails is a note and not a failed run."""
    data = ["--data", run.data, *picked(run.options, DATA_OPTIONS.__contains__)]
    steps = []
    if "psnr" in read_json(folder / "train.json"):
        steps.append(("score.json", ["eval", str(folder / "scene.glb"), "--json", *data]
                      + [word for name in measures for word in MEASURES[name]]))
    else:
        result.notes.append("no PSNR and SSIM: the data set has no test images")
    if frames > 0:
        steps.append(("frames.json", ["bench", str(folder / "scene.glb"), "--json",
                                      "--frames", str(frames), *data]))
    for name, arguments in steps:
        known = read_json(folder / name)
        if known is not None and (name != "score.json" or all(m in known for m in measures)):
            continue
        try:
            call(fluxgs, arguments, folder, folder / name)
        except Failed as error:
            result.notes.append(f"no {name.removesuffix('.json')}: {error}")


def at(tree, path):
    """A number in nested objects ("a/b"), or None."""
    for key in path.split("/"):
        tree = tree.get(key) if isinstance(tree, dict) else None
    return tree if isinstance(tree, (int, float)) else None


SOURCES = {
    "train.json": {"psnr": "psnr_before_compression", "ssim": "ssim_before_compression",
                   "splats": "splats", "stored_bytes": "bytes", "ply_bytes": "float_bytes",
                   "seconds": "seconds", "cpu_seconds": "cpu_seconds", "threads": "threads",
                   "peak_memory": "peak_memory_bytes"},
    "score.json": {"stored_psnr": "psnr", "stored_ssim": "ssim", "stored_flip": "flip",
                   "stored_lpips": "lpips/vgg/zero_to_one"},
    "frames.json": {"frame_ms": "sort_to_display_ms/median"},
}


def collect(folder, frames, result):
    """The numbers of a finished run."""
    for name, keys in SOURCES.items():
        report = read_json(folder / name)
        if report is None or (name == "frames.json" and frames == 0):
            continue
        for key, path in keys.items():
            number = at(report, path)
            if number is not None:
                result.values[key] = number
        if name == "frames.json":
            result.notes.append(
                "frame times: projecting, sorting and drawing, medians of {} frames of {}x{}, {}"
                .format(report["frames"], *report["size"], report["gl_renderer"]))
    report = read_json(folder / "train.json")
    result.curve = report["curves"]["psnr"] or []
    for phase in report["curves"]["phases"]:
        if phase["phase"] == "SH reduction" and phase.get("test_psnr"):
            before, after = phase["test_psnr"]
            result.values["sh_reduction_psnr"] = after - before


def execute(fluxgs, run, folder, frames=30, measures=(), retry=False):
    """Does what is not done yet and returns the result; whatever fails is a result, too."""
    result = Result()
    try:
        prepare(run, folder, retry)
        train(fluxgs, run, folder)
        measure(fluxgs, run, folder, frames, measures, result)
        collect(folder, frames, result)
        result.state = "finished"
    except Interrupted:
        result.state = "interrupted"
    except (Failed, OSError, KeyError, ValueError, TypeError) as error:
        result.state, result.error = "failed", str(error)
        if isinstance(error, Failed) and "delete it or choose" not in str(error):
            write_text(folder / "error.txt", str(error) + "\n")
    return result
