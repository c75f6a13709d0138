"""The rows of an ablation: presets, and presets with some of their options changed."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Group:
    """Rows that share a table and a plot."""

    name: str
    title: str
    x_label: str = ""  # of the option that changes; empty: PSNR is plotted against file size
    log_x: bool = False


@dataclass(frozen=True)
class Row:
    group: str
    name: str  # unique; names a folder
    label: str  # in tables and plots
    preset: str
    options: tuple = ()  # of `fluxgs train`, on top of the preset
    series: str = ""  # rows of one series are joined by a line
    x: float = 0.0  # value of the option that changes


GROUPS = (
    Group("presets", "Presets"),
    Group("ours", "The parts of flux, each taken away"),
    Group("parts", "The parts of the paper's method, each taken away"),
    Group("quadrature", "Quadrature of the energy moments", "directions", True),
    Group("score", "How splats are scored over views"),
    Group("cameras", "Views behind a score", "views"),
    Group("quantile-plus", "Quantile of densification", "Q⁺"),
    Group("quantile-minus", "Quantile of pruning", "Q⁻"),
    Group("size", "Size of the scene, by the gradient above which splats are added"),
    Group("store", "Precision of the file, by its PSNR against the uncompressed scene (dB)"),
    Group("sh", "SH degree, and how it is reached"),
    Group("switch", "The iteration of the SH reduction", "iteration"),
    Group("densify", "Densification"),
)

PRESETS = ("flux", "flux-paper", "3dgs", "3dgs-sh1")
OURS, PAPER = "flux", "flux-paper"


def values(group, option, numbers, also=()):
    """A row for each value of one option."""
    return [
        Row(group, f"{group}-{v:g}", f"{v:g}", OURS, (*also, option, f"{v:g}"), group, v)
        for v in numbers
    ]


def choices(group, option, names, also=()):
    """A row for each name that an option can have."""
    word = option.removeprefix("--")
    return [
        Row(group, f"{word}-{n}", f"{word} {n}", OURS, (*also, option, n)) for n in names
    ]


def named(group, preset, rows):
    return [Row(group, name, label, preset, tuple(words.split())) for name, label, words in rows]


def presets():
    return [Row("presets", name, name, name) for name in PRESETS]


def ours():
    """What `flux` adds to 3DGS and to the paper, each taken away from the whole."""
    return named("ours", OURS, [
        ("ours-full", "full", ""),
        ("ours-no-dropout", "without dropout", "--dropout 0"),
        ("ours-no-coarse-start", "without halved images first", "--resolution-levels 0"),
        ("ours-no-error-rank", "growth by gradients only", "--densify gradient"),
        ("ours-random-split", "splits at random", "--split random"),
        ("ours-unlimited-growth", "without a limit to growth", "--densify-growth 0"),
        ("ours-no-late-prune", "without late pruning", "--late-prune off"),
        ("ours-no-adaptive-degree", "all of degree 3", "--sh-target 3"),
        ("ours-fixed-gradient", "growth whatever the loss", "--densify-loss 0"),
        ("ours-no-depth-spread", "splats of any depth", "--depth-spread 0"),
    ])


def parts():
    """The paper's table "Ablation": each part of the method taken away from the whole."""
    return named("parts", PAPER, [
        ("full", "full", ""),
        ("no-mc-sea", "without MC-SEA (truncated)", "--sh-reduce truncate"),
        ("no-delta-c", "without Δc", "--phi off"),
        ("no-multiview-densify", "without multi-view densification", "--densify gradient"),
        ("no-multiview-prune", "without multi-view pruning", "--prune opacity"),
        ("no-prune", "without pruning", "--prune none"),
    ])


ENERGY = ("--sh-target", "1", "--sh-reduce", "energy")


def quadratures():
    """The integrals behind E_mag and E_dir, which only the paper's reduction needs."""
    sizes = {
        "mc": (64, 2048),
        "fibonacci": (64, 2048),
        "lebedev": (86, 302),  # Lebedev's rules exist for certain sizes only
    }
    return [
        Row("quadrature", f"{rule}-{n}", f"{rule} {n}", OURS,
            (*ENERGY, "--quadrature", rule, "--samples", str(n)), rule, n)
        for rule, all_sizes in sizes.items() for n in all_sizes
    ]


def scores():
    """How views and scores are chosen, each different from the whole."""
    return named("score", OURS, [
        ("score-full", "full", ""),
        ("score-random-views", "views at random", "--camera-sampling random"),
        ("score-alpha", "α instead of αT", "--score-weight alpha"),
        ("score-l1", "L1 instead of L1 and D-SSIM", "--score-loss l1"),
        ("score-raw", "errors as they are", "--score-unit raw"),
        ("score-by-gradient", "the largest gradients first", "--growth-rank gradient"),
    ])


def all_rows():
    return [
        *presets(),
        *ours(),
        *parts(),
        *quadratures(),
        *scores(),
        *values("cameras", "--score-views", (2, 6, 12)),
        *values("quantile-plus", "--quantile-plus", (0.4, 0.6, 0.8, 0.9)),
        # Only the prunings that use it: the late one of `flux` does not
        *values("quantile-minus", "--quantile-minus", (0.1, 0.7, 0.9),
                ("--prune", "multiview", "--late-prune", "opacity")),
        *values("size", "--densify-gradient", (2e-4, 3e-4, 4.8e-4, 6e-4, 9e-4)),
        # So that the other limit does not decide
        *values("store", "--compress-psnr", (36, 40, 44), ("--max-psnr-drop", "0.01")),
        *choices("sh", "--sh-target", ("0", "1", "2", "3", "adaptive")),
        *choices("sh", "--sh-reduce", ("view-ls", "truncate", "uniform-ls", "energy"),
                 ("--sh-target", "1")),
        *choices("sh", "--phi", ("on",), ("--sh-target", "1")),
        *choices("sh", "--residual", ("3-1", "3-2", "3-0"), ENERGY),
        *choices("sh", "--psi", ("off",), ENERGY),
        *values("switch", "--sh-reduce-iter", (1000, 3000, 4900, 6000)),
        *choices("densify", "--densify", ("multiview", "gradient")),
        # As its authors use it
        *choices("densify", "--densify", ("mcmc",),
                 ("--densify-interval", "100", "--opacity-reset-interval", "0",
                  "--opacity-weight", "0.01", "--scale-weight", "0.01")),
    ]


def chosen_rows(only, preset):
    """The rows of these groups and names (all for none), changed to one preset if it is given.

    Raises ValueError for a name that is neither a group nor a row.
    """
    rows = all_rows()
    known = {r.name for r in rows} | {g.name for g in GROUPS}
    for word in only:
        if word not in known:
            groups = ", ".join(g.name for g in GROUPS)
            raise ValueError(f"--only: '{word}' is neither a group ({groups}) nor a row (see --list)")
    if preset and preset not in PRESETS:
        raise ValueError(f"--preset: '{preset}' is not a preset; expected {', '.join(PRESETS)}")
    return [
        Row(**{**r.__dict__, "preset": preset}) if preset and r.group != "presets" else r
        for r in rows if not only or r.group in only or r.name in only
    ]


def picked(options, wanted):
    """The options whose names `wanted` accepts, with their values."""
    kept, keep = [], wanted("")
    for word in options:
        if word.startswith("--"):
            keep = wanted(word.split("=")[0])
        if keep:
            kept.append(word)
    return kept


def merged(common, changes):
    """The options of both lists; an option in `changes` replaces that in `common`."""
    changed = {word.split("=")[0] for word in changes if word.startswith("--")}
    return [*picked(common, lambda name: name not in changed), *changes]
