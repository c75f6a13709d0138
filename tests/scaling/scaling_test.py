"""Tests of tools/scaling.

    python3 scaling_test.py FOLDER_OF_THE_PROJECT FOLDER_OF_PROGRAMS
"""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT, PROGRAMS = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools/scaling"), str(ROOT / "tools/ablation")]

import growth  # noqa: E402


def scaling(*words):
    command = [sys.executable, str(ROOT / "tools/scaling/scaling"), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def iteration(splats, ms):
    """An iteration that is one stage."""
    return {"sweep": "splats", "kind": "iteration", "size": "10x10", "photos": 3, "points": splats,
            "iterations": 20, "repeat": 0, "x": splats,
            "values": {"width": 10, "height": 10, "splats": splats, "pairs_per_pixel": 5.0,
                       "instruction_set": "AVX2", "cpu_ms": ms, "stages_cpu": {"sort": ms},
                       "peak_memory_bytes": 1000}}


def report_of(*rows):
    return growth.to_markdown(growth.Results({"command": "c", "version": "1", "planned": 9}, list(rows)))


class Growth(unittest.TestCase):
    def test_exponents(self):
        self.assertAlmostEqual(growth.exponent((10, 3), (100, 300)), 2)
        self.assertAlmostEqual(growth.exponent((2, 5), (8, 5)), 0)
        self.assertIsNone(growth.exponent((1, 0), (2, 5)))

    def test_what_grows_faster_than_its_work_is_marked(self):
        self.assertIn("| sort | 1.0 | 10.0 | 1.00 |", report_of(iteration(10, 1), iteration(100, 10)))
        self.assertIn("| **1.30** ▲ |", report_of(iteration(10, 1), iteration(100, 20)))

    def test_repeats_count_by_their_median(self):
        rows = [iteration(10, 1), *(iteration(100, ms) for ms in (10, 500, 9))]
        self.assertIn("| sort | 1.0 | 10.0 |", report_of(*rows))

    def test_photos_are_the_work_of_what_looks_at_them_until_the_run_affords_no_more(self):
        def faster(stage, photos, ms):
            rows = [{"x": n, "photos": n, "iterations": 2000} for n in photos]
            return growth.faster_than_work("photos", stage, (rows[0], ms[0]), (rows[1], ms[1]), 0.5)
        self.assertFalse(faster("late pruning", (20, 40), (1, 2)))
        self.assertTrue(faster("late pruning", (20, 40), (1, 4)))
        self.assertTrue(faster("late pruning", (100, 300), (1, 2)))
        self.assertFalse(faster("late pruning", (100, 300), (1, 1.1)))
        self.assertTrue(faster("forward", (20, 40), (1, 2)))

    def test_stages_of_next_to_no_time_are_not_judged(self):
        rows = [{"x": x, "photos": 1, "iterations": 1} for x in (1, 10)]
        self.assertFalse(growth.faster_than_work("splats", "s", (rows[0], 1), (rows[1], 1000), 0.001))

    def test_anything_but_results_is_refused(self):
        for text in ("", "{}\n[1]\n", "[]\n", "not JSON\n"):
            with self.assertRaises(ValueError):
                growth.from_json_lines(text)


class Report(unittest.TestCase):
    def test_the_one_of_the_documentation_is_that_of_its_results(self):
        folder = ROOT / "docs/scaling"
        results = growth.from_json_lines((folder / "runs.jsonl").read_text())
        images = [image.name for image in folder.glob("*.png")]
        self.assertEqual(growth.to_markdown(results, images), (folder / "report.md").read_text())


class Program(unittest.TestCase):
    def test_a_quick_run(self):
        with tempfile.TemporaryDirectory() as folder:
            out, work = Path(folder) / "out", Path(folder) / "work"
            words = ("-o", out, "--quick", "--work", work, "--bin", PROGRAMS)
            done = scaling(*words)
            self.assertEqual(done.returncode, 0, done.stderr)
            text = (out / "report.md").read_text()
            for title in ("## Splats", "## Pixels", "## Photos"):
                self.assertIn(title, text)
            for stage in ("backward", "late pruning", "SH reduction", "storing"):
                self.assertIn(f"| {stage} |", text)
            rows = [json.loads(line) for line in (out / "runs.jsonl").read_text().splitlines()[1:]]
            starts = {r["x"]: r["values"]["splats"] for r in rows
                      if (r["sweep"], r["kind"]) == ("splats", "iteration")}
            self.assertEqual(starts, {1000: 1000, 3000: 3000})
            for row in rows:
                self.assertGreater(row["values"]["stages_cpu"]["backward"], 0)
                self.assertGreater(row["values"]["peak_memory_bytes"], 1e6)
            # Drawn again it is the same
            again = scaling("-o", out, "--redraw")
            self.assertEqual(again.returncode, 0, again.stderr)
            self.assertEqual((out / "report.md").read_text(), text)

    def test_what_is_wrong_is_said_in_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            done = scaling("-o", folder, "--bin", folder)
            self.assertEqual(done.returncode, 2)
            self.assertIn("no such program; build the targets make_capture", done.stderr)
            done = scaling("-o", folder, "--redraw")
            self.assertEqual(done.returncode, 2)
            self.assertIn("runs.jsonl: no such file; --redraw shows earlier measurements", done.stderr)
            file = Path(folder) / "file"
            file.write_text("")
            done = scaling("-o", file)
            self.assertEqual(done.returncode, 2)
            self.assertIn("file: is a file; expected a folder", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
