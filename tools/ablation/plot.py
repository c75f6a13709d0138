"""Plots, by gnuplot."""

import subprocess


def quoted(text):
    return "'" + text.replace("'", "''") + "'"


def draw(path, title, x_label, y_label, series, settings):
    """Draws series of (name, style, points), points being (x, y, error). False where none exist."""
    series = [(name, style, points) for name, style, points in series if points]
    if not series:
        return False
    # gnuplot has eight colors; each eight series get another shape
    shapes = (7, 5, 9, 11, 13)
    script = [f"set terminal pngcairo size 960,600 noenhanced\nset output {quoted(str(path))}",
              f"set title {quoted(title)}\nset xlabel {quoted(x_label)}\nset ylabel {quoted(y_label)}",
              "set grid\nset key outside right top\nset encoding utf8", *settings]
    plots = []
    for i, (name, style, points) in enumerate(series):
        rows = "\n".join(" ".join(f"{v:.9g}" for v in p) for p in points)
        script.append(f"$s{i} << EOD\n{rows}\nEOD")
        plots.append(f"$s{i} with {style} linewidth 2 pointtype {shapes[i // 8 % 5]} "
                     f"title {quoted(name)}")
    script.append("plot " + ", ".join(plots))
    done = subprocess.run(["gnuplot"], input="\n".join(script) + "\n", text=True,
                          capture_output=True, check=False)
    if done.returncode != 0:
        raise OSError(f"{path}: gnuplot: {done.stderr.strip().splitlines()[-1]}")
    return True
