"""Sizes of the captures, splats and runs of a report."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Sizes:
    name: str
    splats: tuple     # at `size`, `photos` photos
    pixels: tuple     # sizes of a photo; `splats_of_pixels` splats, `photos` photos
    photos: tuple     # at `size`, `iterations` iterations from `start` splats
    size: str         # of a photo, pixels
    photo_count: int  # in the sweeps of splats and pixels
    splats_of_pixels: int
    short: int        # iterations of the trainings in the sweeps of splats and pixels
    iterations: int   # of those in the sweep of photos
    start: int        # splats that these begin with
    repeats: int      # of what is measured in seconds


FULL = Sizes("full", splats=(30_000, 100_000, 300_000, 1_000_000),
             pixels=("388x258", "672x448", "1224x816", "1732x1154"), photos=(20, 100, 300),
             size="400x266", photo_count=4, splats_of_pixels=100_000, short=100, iterations=2000,
             start=5000, repeats=3)
QUICK = Sizes("quick", splats=(1000, 3000), pixels=("80x54", "120x80"), photos=(6, 12),
              size="96x64", photo_count=6, splats_of_pixels=1000, short=40, iterations=60, start=500,
              repeats=2)
