"""Packs an installed fluxgs as a Python wheel: `pip install` then gives the command.

The program becomes a script of the wheel and its libraries data, so that pip puts them into bin/ and
lib/fluxgs/ of the environment, where the program looks for them. Format: packaging.python.org,
"Binary distribution format"; tags: PEP 600.
"""
import argparse
import base64
import hashlib
import os
import pathlib
import platform
import time
import zipfile


def metadata(stage, version):
    readme = (stage / "share/doc/fluxgs/README.md").read_text(encoding="utf-8")
    return (
        "Metadata-Version: 2.1\nName: fluxgs\n"
        f"Version: {version}\n"
        "Summary: Train 3D Gaussian Splatting scenes on a desktop, view them on a phone\n"
        "License: Apache-2.0\nRequires-Python: >=3.7\n"
        "Description-Content-Type: text/markdown\n\n" + readme
    )


class Wheel:
    """A wheel that is being written. Every file is noted with its hash for RECORD."""

    def __init__(self, path, info):
        self.archive = zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9)
        self.info = info
        self.record = []
        moment = int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))
        self.date = time.gmtime(max(moment, 315532800))[:6]  # a zip file knows nothing before 1980

    def add(self, name, data, mode=0o644):
        entry = zipfile.ZipInfo(name, self.date)
        entry.external_attr = (0o100000 | mode) << 16
        entry.compress_type = zipfile.ZIP_DEFLATED
        self.archive.writestr(entry, data)
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        self.record.append(f"{name},sha256={digest},{len(data)}")

    def close(self):
        name = f"{self.info}/RECORD"
        self.record.append(f"{name},,")
        self.archive.writestr(name, "\n".join(self.record) + "\n")
        self.archive.close()


def files_of(folder):
    """All files; of those that a link names, the link alone, since a wheel has no links."""
    files = sorted(file for file in folder.rglob("*") if file.is_file())
    linked = {file.resolve() for file in files if file.is_symlink()}
    return [file for file in files if file.is_symlink() or file.resolve() not in linked]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("stage", type=pathlib.Path, help="folder of the installed program")
    parser.add_argument("output", type=pathlib.Path, help="folder of the wheel")
    parser.add_argument("version")
    parser.add_argument("glibc", help="the oldest glibc that the files run with, as 2.36")
    options = parser.parse_args()

    system = "manylinux_" + options.glibc.replace(".", "_") + "_" + platform.machine()
    tag = f"py3-none-{system}"
    name = f"fluxgs-{options.version}"
    path = options.output / f"{name}-{tag}.whl"
    wheel = Wheel(path, f"{name}.dist-info")
    stage = options.stage
    wheel.add(f"{name}.data/scripts/fluxgs", (stage / "bin/fluxgs").read_bytes(), 0o755)
    for folder in ("lib", "share"):
        for file in files_of(stage / folder):
            where = file.relative_to(stage).as_posix()
            wheel.add(f"{name}.data/data/{where}", file.read_bytes(), file.stat().st_mode & 0o777)
    wheel.add(f"{name}.dist-info/METADATA", metadata(stage, options.version).encode())
    wheel.add(
        f"{name}.dist-info/WHEEL",
        f"Wheel-Version: 1.0\nGenerator: fluxgs\nRoot-Is-Purelib: false\nTag: {tag}\n".encode(),
    )
    wheel.add(f"{name}.dist-info/licenses/LICENSE", (stage / "share/doc/fluxgs/LICENSE").read_bytes())
    wheel.close()
    print(f"package: {path}")


if __name__ == "__main__":
    main()
