"""One measurement: train_benchmark for the stages of an iteration, or a whole `fluxgs train`."""

import json
import os
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path

PROGRAMS = ("make_capture", "train_benchmark", "fluxgs")
SWEEPS = ("splats", "pixels", "photos")
REPEATED = 6_000_000  # cost of what is repeated, at most


@dataclass(frozen=True)
class Job:
    sweep: str     # what grows
    kind: str      # "iteration" or "run"
    size: str      # of a photo
    photos: int
    points: int    # on the surfaces, which the splats begin as
    iterations: int
    repeat: int

    @property
    def pixels(self):
        width, height = map(int, self.size.split("x"))
        return width * height

    @property
    def x(self):
        return {"splats": self.points, "pixels": self.pixels, "photos": self.photos}[self.sweep]

    @property
    def cost(self):
        """Roughly proportional to the time it takes."""
        of_iteration = 0.15 * self.points + 0.25 * self.pixels + 20_000
        return self.iterations * of_iteration + 2 * self.photos * self.pixels  # and the capture

    def __str__(self):
        kind = "iterations of" if self.kind == "iteration" else "a training of"
        return (f"{self.sweep}: {kind} {self.photos} photos of {self.size}, {self.points:,} points, "
                f"{self.iterations} iterations")


def plan_of(sizes):
    """All measurements; those that tell most for their time come first."""
    grown = [Job("splats", "iteration", sizes.size, sizes.photo_count, splats, 10, 0)
             for splats in sizes.splats]
    grown += [Job("pixels", "iteration", size, sizes.photo_count, sizes.splats_of_pixels, 10, 0)
              for size in sizes.pixels]
    # Those of more work are steadier by themselves
    again = [replace(job, repeat=i) for i in range(1, sizes.repeats) for job in grown
             if job.cost < REPEATED]
    photos = [Job("photos", "run", sizes.size, count, sizes.start, sizes.iterations, 0)
              for count in sizes.photos]
    runs = [replace(job, kind="run", iterations=sizes.short) for job in grown]
    return grown + photos + again + sorted(runs, key=lambda job: job.cost)


def version_of(folder):
    return {"version": output_of([folder / "fluxgs", "--version"]).strip()}


def output_of(command):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or [f"status {done.returncode}"])[-1]
        raise ValueError(f"{Path(command[0]).name}: {last}")
    return done.stdout


def measured(command):
    """Output, processor seconds and bytes of memory at most of a program."""
    with subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as child:
        # The output of these programs fits the pipes: one object, and progress only to a terminal
        try:
            _, status, used = os.wait4(child.pid, 0)
        except KeyboardInterrupt:
            child.terminate()
            raise
        child.returncode = os.waitstatus_to_exitcode(status)
        out, err = child.stdout.read(), child.stderr.read()
    if child.returncode != 0:
        last = (err.strip().splitlines() or [f"status {child.returncode}"])[-1]
        raise ValueError(f"{Path(command[0]).name}: {last}")
    return out, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024


def capture_of(job, programs, work):
    folder = work / f"spheres-{job.size}-{job.photos}-{job.points}"
    if not (folder / "transforms_train.json").exists():  # written last
        output_of([programs / "make_capture", folder, "--size", job.size, "--train", job.photos,
                   "--test", 1, "--samples", 1, "--points", job.points])
    return folder


def run(job, programs, work):
    """The numbers of a measurement."""
    capture = capture_of(job, programs, work)
    if job.kind == "iteration":
        out, _, memory = measured([programs / "train_benchmark", capture, "--downscale", 1,
                                   "--threads", 1, "--warmup", 3, "--iterations", job.iterations,
                                   "--json"])
        return {**json.loads(out.splitlines()[-1]), "peak_memory_bytes": memory}
    scene, report = work / "scene.glb", work / "report.json"
    _, cpu, memory = measured(
        [programs / "fluxgs", "train", capture, "-o", scene, "--float-output", work / "scene.ply",
         "--json", report, "--force", "--threads", 1, "--iterations", job.iterations])
    found = json.loads(report.read_text())
    checkpoint = work / "scene.glb.ckpt"
    values = {key: found[key] for key in ("splats", "bytes", "float_bytes", "cpu_seconds",
                                          "instruction_set", "psnr")}
    values |= {"stages_cpu": found["stages_cpu"], "storing_cpu_seconds": found["storing"]["cpu_seconds"],
               "all_cpu_seconds": cpu, "peak_memory_bytes": memory,
               "checkpoint_bytes": checkpoint.stat().st_size}
    checkpoint.unlink()
    return values


def rounded(value):
    if isinstance(value, dict):
        return {k: rounded(v) for k, v in value.items()}
    return float(f"{value:.5g}") if isinstance(value, float) else value


class Kept:
    """Measurements in a file, one a line after a head, so that an interruption loses one only."""

    def __init__(self, path, head):
        self.path, self.head, self.rows = path, head, []
        lines = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
        if lines and lines[0] == head:
            self.rows = lines[1:]
        else:
            path.write_text(json.dumps(head) + "\n")

    @staticmethod
    def key(job):
        return {**job.__dict__, "x": job.x}

    def has(self, job):
        key = self.key(job)
        return any(all(row[k] == v for k, v in key.items()) for row in self.rows)

    def add(self, job, values):
        row = {**self.key(job), "values": rounded(values)}
        self.rows.append(row)
        with open(self.path, "a", encoding="utf8") as file:
            file.write(json.dumps(row) + "\n")
