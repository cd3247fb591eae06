#!/usr/bin/env python3
"""Fetches panoramas of rooms from public repositories into a folder of your own, for `sandglass verify room`.

    fetch_panoramas.py FOLDER [--list FILE] [--reserved FILE] [--base URL]

The list (panoramas.csv beside this script) names repository, commit, path, licence and git's own hash of each file.
Nothing is trusted but that hash: bytes that differ are not kept. FOLDER gets the files and manifest.csv, with the
columns of the data folder's manifest. A run that was cut off goes on where it stopped.

Refused before anything is fetched: a licence other than CC0, CC BY, MIT, BSD or public domain, and panoramas that
reserved.txt names, at any resolution and in any format, because they judge results that nothing was fitted to.
"""
import argparse
import csv
import hashlib
import os
import re
import sys
import urllib.request

HERE = os.path.dirname(os.path.abspath(__file__))
COLUMNS = ["file", "sha256", "source", "licence", "resolution", "category", "group", "fold", "notes"]
FREE = re.compile(r"(CC0|CC BY( \d\.\d)?|MIT|BSD(-\d-Clause)?|public domain)($|[ ,;(])", re.IGNORECASE)
NOT_FREE = re.compile(r"\b(NC|ND|SA)\b|non-?commercial", re.IGNORECASE)
BLOCK = 1 << 18


class Refused(Exception):
    """A sentence: what is wrong, where, and what to do."""


def read_rows(path, columns):
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    except OSError as error:
        raise Refused(f'cannot read "{path}": {error.strerror}. Check the path.') from error
    missing = [c for c in columns if not rows or rows[0].get(c) is None]
    if missing:
        raise Refused(f'cannot read "{path}": no columns {", ".join(missing)}. Name them in its first line.')
    return rows


def plain_name(name):
    """The name of a panorama without folder, ending, resolution (_1k, _2048x1024) and signs between words."""
    stem = os.path.basename(name).split(".")[0].lower()
    stem = re.sub(r"([_-](\d+k|\d+x\d+|hdr|exr|\d{3,}))+$", "", stem)
    return re.sub(r"[^a-z0-9]", "", stem)


def read_reserved(path):
    if not path:
        data = os.environ.get("SANDGLASS_DATA_DIR", "")
        path = os.path.join(data, "reserved.txt") if data else ""
        if not os.path.exists(path):
            return set()
    try:
        with open(path, encoding="utf-8") as file:
            lines = [line.split("#")[0].strip() for line in file]
    except OSError as error:
        raise Refused(f'cannot read "{path}": {error.strerror}. Check the path.') from error
    return {plain_name(line) for line in lines if line}


def check(rows, reserved):
    for row in rows:
        if not re.fullmatch(r"[0-9a-f]{40}", row["blob"]):
            raise Refused(f'cannot use "{row["file"]}": "{row["blob"]}" is no hash of git. Take it from git ls-tree.')
        if os.path.isabs(row["file"]) or ".." in row["file"].split("/") or not row["file"].endswith((".hdr", ".exr")):
            raise Refused(f'cannot use "{row["file"]}": it is no .hdr or .exr below FOLDER. Correct the list.')
        if not re.fullmatch(r"[\w.-]+/[\w.-]+@[0-9a-f]{40}:[^ ?#]+", row["source"]):
            raise Refused(f'cannot use "{row["file"]}": its source is not OWNER/NAME@COMMIT:PATH. Correct the list.')
        if not FREE.match(row["licence"]) or NOT_FREE.search(row["licence"]):
            raise Refused(f'cannot use "{row["file"]}": the licence "{row["licence"]}" is none of CC0, CC BY, MIT, BSD '
                          "and public domain. Leave it out.")
        names = [row["file"], row["group"], row["source"].split(":", 1)[1]]
        taken = [name for name in names if plain_name(name) in reserved]
        if taken:
            raise Refused(f'cannot use "{row["file"]}": "{taken[0]}" is reserved for judging results. Leave it out.')


def hashes(path):
    """Git's hash of a file, and its SHA-256."""
    blob, sha256 = hashlib.sha1(b"blob %d\0" % os.path.getsize(path)), hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(BLOCK):
            blob.update(block)
            sha256.update(block)
    return blob.hexdigest(), sha256.hexdigest()


def download(url, path):
    """Goes on with what is there already, where the server allows it."""
    begun = os.path.getsize(path) if os.path.exists(path) else 0
    request = urllib.request.Request(url, headers={"Range": f"bytes={begun}-"} if begun else {})
    try:
        with urllib.request.urlopen(request, timeout=60) as answer:
            whole = getattr(answer, "status", None) != 206
            with open(path, "wb" if whole else "ab") as file:
                while block := answer.read(BLOCK):
                    file.write(block)
    except OSError as error:  # urllib's errors are of this kind
        if getattr(error, "code", None) == 416:  # what is there is longer than the file
            os.remove(path)
        raise Refused(f'cannot fetch "{url}": {getattr(error, "reason", error)}. Run again to go on.') from error


def fetch(row, folder, base):
    """Gets one file and returns its SHA-256."""
    path = os.path.join(folder, row["file"])
    if os.path.exists(path):
        blob, sha256 = hashes(path)
        if blob == row["blob"]:
            return sha256
        raise Refused(f'cannot keep "{path}": it is not the file of the list. Move it away and run again.')
    repository, source = row["source"].split(":", 1)
    url = "/".join([base.rstrip("/"), repository.replace("@", "/"), source])
    part = path + ".part"
    os.makedirs(os.path.dirname(path), exist_ok=True)
    print(f"{row['file']} <- {url}", flush=True)
    if not os.path.exists(part) or hashes(part)[0] != row["blob"]:
        download(url, part)
    blob, sha256 = hashes(part)
    if blob != row["blob"]:
        os.remove(part)
        raise Refused(f'cannot keep "{url}": its hash is {blob} and must be {row["blob"]}. '
                      "Run again, or correct the list.")
    os.replace(part, path)
    return sha256


def write_manifest(path, rows):
    """The new rows, after those of the manifest that is there for other files."""
    new = {row["file"] for row in rows}
    old = [row for row in read_rows(path, COLUMNS) if row["file"] not in new] if os.path.exists(path) else []
    with open(path + ".part", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(old + rows)
    os.replace(path + ".part", path)


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("folder", metavar="FOLDER", help="where files and manifest.csv go")
    words.add_argument("--list", default=os.path.join(HERE, "panoramas.csv"), help="what to fetch")
    words.add_argument("--reserved", help="names that must not be used (reserved.txt of SANDGLASS_DATA_DIR)")
    words.add_argument("--base", default="https://raw.githubusercontent.com", help="where OWNER/NAME/COMMIT/PATH is")
    options = words.parse_args()
    rows = read_rows(options.list, [c for c in COLUMNS if c != "sha256"] + ["blob"])
    check(rows, read_reserved(options.reserved))
    done, failed = [], []
    for row in rows:
        try:
            done.append({**row, "sha256": fetch(row, options.folder, options.base)})
        except Refused as reason:
            failed.append(str(reason))
    if done:
        write_manifest(os.path.join(options.folder, "manifest.csv"), done)
    for reason in failed:
        print(f"fetch_panoramas: {reason}", file=sys.stderr)
    print(f"{len(done)} of {len(rows)} panoramas in {options.folder}")
    return 1 if failed else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Refused as reason:
        sys.exit(f"fetch_panoramas: {reason}")
