"""Tests of tools/ablation over tiny trainings.

    python3 ablation_test.py FOLDER_OF_THE_PROJECT FOLDER_OF_PROGRAMS
"""

import json
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

ROOT, PROGRAMS = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tools/ablation"))

import report  # noqa: E402
from rows import GROUPS, all_rows, chosen_rows, merged, picked  # noqa: E402
from runs import Result  # noqa: E402

TINY = ("--", "--iterations", "60", "--max-splats", "300", "--threads", "1")


def ablation(*words):
    command = [sys.executable, str(ROOT / "tools/ablation/ablation"), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def finished(psnr):
    return Result("finished", values={"psnr": psnr, "splats": 1000.0})


def table_of(results, scenes=1):
    """One row, these results: scenes × seeds."""
    names = [f"scene{i}" for i in range(scenes)]
    seeds = list(range(1, len(results) // scenes + 1))
    table = report.Table("command", "fluxgs 1", names, [all_rows()[0]], seeds)
    cells = [(scene, "flux", seed) for scene in names for seed in seeds]
    table.results = dict(zip(cells, results))
    return table


class Statistics(unittest.TestCase):
    def test_mean_and_sample_deviation(self):
        table = table_of([finished(v) for v in (2, 4, 4, 4, 5, 5, 7, 9)])
        values = table.of_scene("scene0", table.rows[0], "psnr")
        self.assertEqual(statistics.fmean(values), 5)
        self.assertAlmostEqual(report.deviation(values), (32 / 7) ** 0.5)
        self.assertEqual(report.deviation([3]), 0)

    def test_failed_runs_do_not_count(self):
        table = table_of([finished(30), Result("failed", "no | splats"), finished(32)])
        self.assertEqual(table.of_scene("scene0", table.rows[0], "psnr"), [30, 32])
        text = report.to_markdown(table)
        self.assertIn("| 31.00 ± 1.41 |", text)
        self.assertIn("2 of 3, 1 failed", text)
        self.assertIn("seed 2 failed: no \\| splats", text)

    def test_a_seed_that_lacks_a_scene_does_not_count(self):
        table = table_of([finished(30), finished(31), finished(20), Result("failed")], scenes=2)
        self.assertEqual(table.of_all(table.rows[0], "psnr"), [25])

    def test_json_lines_there_and_back(self):
        table = table_of([finished(30), finished(32)])
        text = report.to_json_lines(table)
        self.assertEqual(len(text.splitlines()), 3)
        again = report.from_json_lines(text, all_rows())
        self.assertEqual(report.to_markdown(again), report.to_markdown(table))
        with self.assertRaises(ValueError):
            report.from_json_lines('{"rows": 1}\n', all_rows())

    def test_the_report_of_the_documentation_is_that_of_its_results(self):
        folder = ROOT / "docs/ablation"
        table = report.from_json_lines((folder / "runs.jsonl").read_text(), all_rows())
        images = [image.name for image in folder.glob("*.png")]
        self.assertEqual(report.to_markdown(table, images), (folder / "report.md").read_text())

    def test_curves_are_means_where_all_have_measured(self):
        results = [finished(1), finished(1)]
        results[0].curve, results[1].curve = [[10, 20], [20, 22], [20, 21]], [[10, 22], [20, 24]]
        table = table_of(results)
        self.assertEqual(report.mean_curve(table, table.rows[0]), [(10, 21), (20, 23)])


class Rows(unittest.TestCase):
    def test_names_are_unique_and_groups_known(self):
        names = [r.name for r in all_rows()]
        self.assertEqual(len(names), len(set(names)))
        self.assertEqual({r.group for r in all_rows()}, {g.name for g in GROUPS})

    def test_choice_and_preset(self):
        rows = chosen_rows(["cameras", "densify-mcmc"], "3dgs")
        self.assertEqual(len(rows), 4)
        self.assertEqual({r.preset for r in rows}, {"3dgs"})
        with self.assertRaises(ValueError):
            chosen_rows(["camera"], "")

    def test_options_of_a_row_replace_the_common_ones(self):
        common = ["--phi", "on", "--threads=1", "--background", "0,0,0"]
        self.assertEqual(merged(common, ["--phi", "off"]),
                         ["--threads=1", "--background", "0,0,0", "--phi", "off"])
        self.assertEqual(picked(common, ("--threads", "--background").__contains__), common[2:])

    def test_every_row_is_a_training_that_fluxgs_accepts(self):
        for row in all_rows():
            with self.subTest(row.name):
                done = subprocess.run([PROGRAMS / "fluxgs", "train", "--plan", "--json", "-",
                                       "--preset", row.preset, *row.options],
                                      capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertNotIn("no effect", done.stderr)


class Sweep(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = Path(cls.folder.name)
        cls.data = cls.path / "spheres"
        subprocess.run([PROGRAMS / "make_capture", cls.data, "--size", "48x36", "--train", "8",
                        "--test", "2", "--samples", "1"], check=True, capture_output=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def sweep(self, out, *words, common=TINY, data=None):
        return ablation(data or self.data, "-o", self.path / out, "--fluxgs", PROGRAMS / "fluxgs",
                        "--preset", "3dgs", *words, *common)

    def test_trains_measures_and_does_not_repeat(self):
        words = ("--only", "densify-gradient,ours-full,ours-no-error-rank", "--seeds", "2",
                 "--frames", "2")
        first = self.sweep("whole", *words)
        self.assertEqual(first.returncode, 0, first.stderr)
        out = self.path / "whole"
        text = (out / "report.md").read_text()
        self.assertIn("compact: PSNR (dB)", text)
        self.assertIn("frame (ms)", text)
        # 3dgs densifies by the gradient: the three rows are the same training
        self.assertIn("densify-gradient has the same options as ours-full", text)
        self.assertFalse((out / "spheres/densify-gradient").exists())
        scene = out / "spheres/ours-full/seed-2/scene.glb"
        before = scene.stat().st_mtime_ns
        again = self.sweep("whole", *words)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(scene.stat().st_mtime_ns, before)
        self.assertEqual((out / "report.md").read_text(), text)
        # A damaged scene is made again
        scene.write_bytes(b"glTF")
        self.assertEqual(self.sweep("whole", *words).returncode, 0)
        self.assertGreater(scene.stat().st_size, 1000)
        # Other options for the same folder are refused
        other = self.sweep("whole", *words, common=(*TINY, "--sh-degree", "1"))
        self.assertEqual(other.returncode, 1)
        self.assertIn("holds a run with other options", other.stderr)
        # From the numbers alone
        runs = (out / "runs.jsonl").read_text()
        redrawn = ablation("--redraw", "-o", out)
        self.assertEqual(redrawn.returncode, 1)  # as its runs had failed
        self.assertEqual((out / "runs.jsonl").read_text(), runs)

    def test_a_failed_run_leaves_the_others_alone(self):
        done = self.sweep("failed", "--only", "densify-gradient,sh-target-0", "--seeds", "1",
                          "--frames", "0", common=(*TINY, "--max-memory", "1"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("2 of 2 runs failed", done.stderr)
        runs = (self.path / "failed/runs.jsonl").read_text().splitlines()
        self.assertEqual(json.loads(runs[1])["state"], "failed")
        self.assertIn("memory", json.loads(runs[1])["error"])

    def test_continues_from_a_checkpoint(self):
        arguments = ("--only", "densify-gradient", "--seeds", "1", "--frames", "0")
        self.assertEqual(self.sweep("resumed", *arguments).returncode, 0)
        run = self.path / "resumed/spheres/densify-gradient/seed-1"
        whole = (run / "scene.ply").read_bytes()
        # As after an interruption: a checkpoint and no report
        (run / "train.json").unlink()
        subprocess.run([PROGRAMS / "fluxgs", "train", self.data, "-o", run / "scene.glb",
                        "--preset", "3dgs", "--seed", "1", *TINY[1:], "--densify", "gradient",
                        "--force"], check=True, capture_output=True)
        self.assertTrue((run / "scene.glb.ckpt").exists())
        self.assertEqual(self.sweep("resumed", *arguments).returncode, 0)
        self.assertEqual(json.loads((run / "train.json").read_text())["resumed_at"], 60)
        self.assertEqual((run / "scene.ply").read_bytes(), whole)

    def test_an_interruption_saves_and_the_same_command_continues(self):
        arguments = ("--only", "densify-gradient", "--seeds", "1", "--frames", "0")
        common = ("--", "--iterations", "1500", "--max-splats", "2000", "--threads", "1",
                  "--checkpoint-every", "50")
        out = self.path / "interrupted"
        command = [sys.executable, ROOT / "tools/ablation/ablation", self.data, "-o", out,
                   "--fluxgs", PROGRAMS / "fluxgs", *arguments, *common]
        checkpoint = out / "spheres/densify-gradient/seed-1/scene.glb.ckpt"
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True) as child:
            deadline = time.monotonic() + 60
            while not checkpoint.exists() and time.monotonic() < deadline:
                time.sleep(0.05)
            child.send_signal(signal.SIGTERM)
            _, errors = child.communicate()
        self.assertEqual(child.returncode, 1)
        self.assertIn("interrupted: 0 of 1 runs are finished; continue with: ", errors)
        self.assertTrue(checkpoint.exists())
        self.assertTrue((out / "report.md").exists())
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        train = json.loads((checkpoint.parent / "train.json").read_text())
        self.assertGreater(train["resumed_at"], 0)

    def test_wrong_usage_is_one_line(self):
        for words, expected in (
            (("--only", "nothing"), "nothing"),
            (("--preset", "best"), "best"),
            (("--only", "densify", "--", "--iterations", "x"), "iterations"),
        ):
            done = ablation(self.data, "-o", self.path / "wrong", "--fluxgs", PROGRAMS / "fluxgs",
                            *words)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn(expected, done.stderr)
        self.assertIn("inside the data set", ablation(
            self.data, "-o", self.data / "out", "--fluxgs", PROGRAMS / "fluxgs").stderr)
        self.assertIn("expected the folder", self.sweep("x", data=self.path / "none").stderr)
        for words in (("--", "--seed", "3"), ("--", "-ox.glb"), ("--seeds", "0")):
            self.assertEqual(self.sweep("wrong", *words, common=()).returncode, 2)
        file = self.path / "file"
        file.write_text("")
        for words, expected in (
            ((self.data, "-o", file), "is a file; expected a folder"),
            ((self.data, "-o", self.path / "x", "--fluxgs", self.path / "none"), "no such program"),
            (("-o", self.path / "x", "--redraw"), "runs.jsonl: no such file"),
        ):
            done = ablation(*words)
            self.assertEqual(done.returncode, 2)
            self.assertIn(expected, done.stderr)

    def test_lists_its_rows(self):
        done = ablation("--list", "--only", "cameras")
        self.assertEqual(done.returncode, 0)
        self.assertEqual(len(done.stdout.splitlines()), 3)
        self.assertIn("--score-views 12", done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
