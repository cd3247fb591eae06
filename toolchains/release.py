#!/usr/bin/env python3
"""What a release would upload, from what is built: release.py FOLDER VERSION SECONDS NAME=PATH...

FOLDER is new; SECONDS is the time that files in archives get, so that equal input gives equal bytes. A PATH is a folder, which
becomes FOLDER/sandglass-VERSION-NAME.tar.gz, or a file, which is copied as sandglass-VERSION-NAME with its ending. An npm package
(`npm`, `unity`) becomes the tarball that npm would make of it. Beside them: SHA256SUMS and the SBOM, in SPDX 2.3."""

import gzip
import hashlib
import io
import json
import pathlib
import re
import shutil
import sys
import tarfile
import time

# What a release contains that others wrote: name, licence, where it comes from, in what.
OTHERS = [
    ("FlatBuffers", "Apache-2.0", "https://github.com/google/flatbuffers", "its headers are compiled into the library"),
    ("DenseNet-121 weights", "BSD-3-Clause", "https://github.com/liuzhuang13/DenseNet", "models/lights/room.light descends from them"),
    ("meshoptimizer", "MIT", "https://github.com/zeux/meshoptimizer", "its decoder is part of the page"),
]
NPM = ("npm", "unity")


def members(name, root):
    """The files of an archive, and their names in it."""
    if name == "npm":
        files = set()
        for entry in ["package.json", "README.md", "LICENSE"] + json.loads((root / "package.json").read_text())["files"]:
            found = set(root.glob(entry.lstrip("!")))
            if not found:
                sys.exit(f"release.py: {root} lacks {entry}, which its package.json names: build it again")
            files = files - found if entry.startswith("!") else files | found
    else:
        files = [path for path in root.rglob("*") if path.is_file() and not path.is_symlink()]
    if not files:
        sys.exit(f"release.py: {root} is empty: build it first")
    return sorted((path.relative_to(root).as_posix(), path) for path in files)


def pack(out, top, files, seconds):
    data = io.BytesIO()
    with tarfile.open(fileobj=data, mode="w", format=tarfile.PAX_FORMAT) as tar:
        for name, path in files:
            entry = tarfile.TarInfo(f"{top}/{name}")
            entry.size, entry.mtime = path.stat().st_size, seconds
            entry.mode = 0o755 if path.stat().st_mode & 0o100 else 0o644
            with path.open("rb") as file:
                tar.addfile(entry, file)
    with out.open("wb") as raw, gzip.GzipFile(filename="", fileobj=raw, mode="wb", mtime=seconds) as file:
        file.write(data.getvalue())


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def sbom(folder, version, seconds):
    own = "SPDXRef-Package-sandglass"
    package = {"downloadLocation": "NOASSERTION", "filesAnalyzed": False, "copyrightText": "NOASSERTION"}
    packages = [
        {
            **package,
            "SPDXID": own,
            "name": "sandglass",
            "versionInfo": version,
            "licenseDeclared": "Apache-2.0",
            "licenseConcluded": "Apache-2.0",
        }
    ]
    packages += [
        {
            **package,
            "SPDXID": "SPDXRef-Package-" + re.sub(r"\W", "-", name),
            "name": name,
            "downloadLocation": place,
            "comment": what,
            "licenseDeclared": licence,
            "licenseConcluded": licence,
        }
        for name, licence, place, what in OTHERS
    ]
    files = [
        {"SPDXID": f"SPDXRef-File-{i}", "fileName": "./" + path.name, "checksums": [{"algorithm": "SHA256", "checksumValue": sha256(path)}]}
        for i, path in enumerate(sorted(folder.iterdir()))
    ]
    links = (
        [("SPDXRef-DOCUMENT", "DESCRIBES", own)]
        + [(own, "CONTAINS", p["SPDXID"]) for p in packages[1:]]
        + [(own, "GENERATES", f["SPDXID"]) for f in files]
    )
    digest = hashlib.sha256("".join(f["checksums"][0]["checksumValue"] for f in files).encode()).hexdigest()
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"sandglass-{version}",
        "documentNamespace": f"urn:sandglass:{version}:{digest}",
        "creationInfo": {"created": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(seconds)), "creators": ["Tool: sandglass-release"]},
        "packages": packages,
        "files": files,
        "relationships": [{"spdxElementId": a, "relationshipType": kind, "relatedSpdxElement": b} for a, kind, b in links],
    }


def main():
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    folder, version, seconds = pathlib.Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    pieces = [(name, pathlib.Path(path)) for name, _, path in (piece.partition("=") for piece in sys.argv[4:])]
    for name, path in pieces:
        if not path.exists():
            sys.exit(f"release.py: {name}: there is no {path}: build it first")
    if folder.exists():
        sys.exit(f"release.py: {folder} is there already: name a new folder")
    inside = {name: members(name, path) for name, path in pieces if path.is_dir()}
    made = folder.with_name(folder.name + ".part")  # so that what is interrupted leaves no half release
    shutil.rmtree(made, ignore_errors=True)
    made.mkdir(parents=True)
    for name, path in pieces:
        stem = f"sandglass-{version}-{name}"
        if name in inside:
            pack(made / (stem + (".tgz" if name in NPM else ".tar.gz")), "package" if name in NPM else stem, inside[name], seconds)
        else:
            shutil.copyfile(path, made / (stem + path.suffix))
    bill = json.dumps(sbom(made, version, seconds), indent=1) + "\n"
    (made / f"sandglass-{version}.spdx.json").write_text(bill)
    (made / "SHA256SUMS").write_text("".join(f"{sha256(path)}  {path.name}\n" for path in sorted(made.iterdir())))
    made.rename(folder)
    for path in sorted(folder.iterdir()):
        print(f"{path.stat().st_size:10d}  {path}")


main()
