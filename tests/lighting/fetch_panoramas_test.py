#!/usr/bin/env python3
"""The script that fetches panoramas, with files of its own: what it fetches, goes on with, and refuses.

    fetch_panoramas_test.py SCRIPT SANDGLASS
"""
import csv
import hashlib
import http.server
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import unittest

SCRIPT, SANDGLASS = sys.argv.pop(1), sys.argv.pop(1)
COMMIT = "0123456789abcdef0123456789abcdef01234567"
COLUMNS = "file,blob,source,licence,resolution,category,group,fold,notes"


def panorama(level):
    """A room whose one side is brighter, 64 x 32 pixels of RGBE without run lengths."""
    pixels = b"".join(bytes([level, level - column, 90, 128]) for _ in range(32) for column in range(64))
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n" + pixels


def git_hash(data):
    return hashlib.sha1(b"blob %d\0" % len(data) + data).hexdigest()


class WithRanges(http.server.BaseHTTPRequestHandler):
    """A server that knows ranges, and remembers how many bytes each answer had."""

    def do_GET(self):
        begin = int(self.headers.get("Range", "bytes=0-")[6:-1])
        data = (self.server.folder / self.path[1:]).read_bytes()[begin:]
        self.server.sent.append(len(data))
        self.send_response(206 if begin else 200)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, *_):
        pass


class FetchPanoramas(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory()
        self.addCleanup(held.cleanup)
        self.root = pathlib.Path(held.name)
        self.folder, self.list = self.root / "mine", self.root / "list.csv"
        self.data = {"cellar_2k.hdr": panorama(200), "attic_2k.hdr": panorama(150)}
        source = self.root / "owner" / "rooms" / COMMIT / "hdri"
        source.mkdir(parents=True)
        for name, data in self.data.items():
            (source / name).write_bytes(data)
        self.source, self.base = source, self.root.as_uri()
        self.write_list()

    def write_list(self, licence="CC0 (Poly Haven)", group="cellar", blob=None):
        lines = [COLUMNS]
        for name, data in self.data.items():
            first = name == "cellar_2k.hdr"
            lines.append(f"hdri/indoor/{name},{(first and blob) or git_hash(data)},owner/rooms@{COMMIT}:hdri/{name},"
                         f"{licence},64x32,indoor,{group if first else 'attic'},,")
        self.list.write_text("\n".join(lines) + "\n")

    def run_script(self, *more):
        words = [sys.executable, SCRIPT, self.folder, "--list", self.list, "--base", self.base, *more]
        return subprocess.run(words, capture_output=True, text=True, check=False)

    def rows(self):
        with open(self.folder / "manifest.csv", newline="", encoding="utf-8") as file:
            return {row["file"]: row for row in csv.DictReader(file)}

    def test_files_come_with_a_manifest_that_sandglass_reads(self):
        answer = self.run_script()
        self.assertEqual(answer.returncode, 0, answer.stderr)
        for name, data in self.data.items():
            self.assertEqual((self.folder / "hdri/indoor" / name).read_bytes(), data)
            self.assertEqual(self.rows()[f"hdri/indoor/{name}"]["sha256"], hashlib.sha256(data).hexdigest())
        out = self.root / "out"
        words = [SANDGLASS, "dataset", self.folder, "-o", out, "--manifest", self.folder / "manifest.csv"]
        read = subprocess.run(words, capture_output=True, text=True, check=False)
        self.assertEqual(read.returncode, 0, read.stderr)
        self.assertIn("cellar_2k.hdr,cellar,-1,", (out / "manifest.csv").read_text())

    def test_what_is_there_is_not_fetched_again_and_other_rows_stay(self):
        self.assertEqual(self.run_script().returncode, 0)
        manifest = self.folder / "manifest.csv"
        manifest.write_text(manifest.read_text() + "own.hdr,00,me,CC0,1x1,indoor,own,,\n")
        answer = self.run_script("--base", "file:///nowhere")
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertEqual(len(self.rows()), 3)

    def test_a_run_that_was_cut_off_goes_on(self):
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), WithRanges)
        server.folder, server.sent = self.root, []
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        self.base = f"http://127.0.0.1:{server.server_port}"
        cellar = self.data["cellar_2k.hdr"]
        (self.folder / "hdri/indoor").mkdir(parents=True)
        (self.folder / "hdri/indoor/cellar_2k.hdr.part").write_bytes(cellar[:3000])
        answer = self.run_script()
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertEqual(server.sent, [len(cellar) - 3000, len(self.data["attic_2k.hdr"])])
        self.assertEqual((self.folder / "hdri/indoor/cellar_2k.hdr").read_bytes(), cellar)

    def test_other_bytes_are_not_kept_and_the_rest_comes_all_the_same(self):
        (self.source / "cellar_2k.hdr").write_bytes(panorama(201))
        answer = self.run_script()
        self.assertEqual(answer.returncode, 1)
        self.assertIn("cannot keep", answer.stderr)
        self.assertEqual(list(self.rows()), ["hdri/indoor/attic_2k.hdr"])
        self.assertEqual([path.name for path in (self.folder / "hdri/indoor").iterdir()], ["attic_2k.hdr"])

    def test_a_missing_file_is_named(self):
        (self.source / "cellar_2k.hdr").unlink()
        answer = self.run_script()
        self.assertEqual(answer.returncode, 1)
        self.assertIn(f"cannot fetch \"{self.base}/owner/rooms/{COMMIT}/hdri/cellar_2k.hdr\"", answer.stderr)

    def refused(self, sentence, *more):
        answer = self.run_script(*more)
        self.assertEqual(answer.returncode, 1)
        self.assertIn(sentence, answer.stderr)
        self.assertFalse(self.folder.exists(), "nothing may be fetched")

    def test_reserved_panoramas_are_refused_at_any_resolution(self):
        names = self.root / "reserved.txt"
        names.write_text("# judged with\ncellar\n")
        self.refused("is reserved for judging results", "--reserved", names)
        names.write_text("vault_01\n")
        self.write_list(group="Vault 01")
        self.refused("\"Vault 01\" is reserved", "--reserved", names)
        names.write_text("cellar_01\n")  # another place
        self.write_list()
        self.assertEqual(self.run_script("--reserved", names).returncode, 0)

    def test_other_licences_are_refused(self):
        for licence in ["CC BY-NC 4.0", "CC BY-ND", "Apache-2.0", "unknown", "MITx"]:
            self.write_list(licence=licence)
            self.refused("none of CC0, CC BY, MIT, BSD")

    def test_lists_that_lead_elsewhere_are_refused(self):
        good = self.list.read_text()
        for wrong, sentence in [("hdri/indoor/cellar_2k.hdr,", "it is no .hdr or .exr below FOLDER"),
                                (f"owner/rooms@{COMMIT}", "its source is not")]:
            self.list.write_text(good.replace(wrong, "../" + wrong, 1))
            self.refused(sentence)
        self.write_list(blob="abc")
        self.refused("is no hash of git")
        self.list.write_text("file,blob\n")
        self.refused("no columns")

    def test_the_shipped_list_passes_its_own_checks(self):
        sys.path.insert(0, os.path.dirname(SCRIPT))
        import fetch_panoramas as script  # noqa: E402
        rows = script.read_rows(os.path.join(os.path.dirname(SCRIPT), "panoramas.csv"), ["blob"])
        script.check(rows, script.read_reserved(None))
        self.assertEqual(len({row["file"] for row in rows}), len(rows))


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    unittest.main()
