#!/usr/bin/env python3
"""Pictures of the page's hourglass, turned over once and run down, as headless Chromium draws them, and a GIF of at most 2 MB that goes round, because the
first and the last show the same: film.py PAGE FOLDER GIF

PAGE is what `./sg page` makes."""

import pathlib
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests/page"))
from browser import Browser  # noqa: E402

WIDTH, HEIGHT, FRAMES_A_PICTURE, REST = 480, 560, 5, 4  # 12 pictures a second; pictures of rest at both ends
ABOVE = """(() => { const {page} = sandglassPage, n = page.scene.report.sand.particle_numbers, p = page.sand.allocate(12 * n);
    page.sand.sandglass_scene_particles(page.scene.handle, p, 0);
    const above = page.sand.floats(p, 3 * n).filter((y, i) => i % 3 === 1 && y > 0.127).length;
    page.sand.free(p);
    return above; })()"""

GIF = (
    "[0]scale=360:-1:flags=area,crop=360:350:0:15,split[film][colours]; [colours]palettegen=max_colors=96:stats_mode=full[palette];"
    "[film][palette]paletteuse=dither=none:diff_mode=rectangle"
)


def main():
    page, folder, film = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    browser = Browser(shutil.which("chromium"), WIDTH, HEIGHT)
    try:
        browser.call("Emulation.setDeviceMetricsOverride", width=WIDTH, height=HEIGHT, deviceScaleFactor=1, mobile=False)
        browser.open(page)
        end = time.monotonic() + 120
        while not browser.ask("!!window.sandglassPage"):
            if time.monotonic() > end:
                sys.exit(f"film.py: {page} does not open")
            time.sleep(0.2)
        browser.ask("""(() => { const {page} = sandglassPage;
            page.measuring = true;
            for (const part of document.querySelectorAll('header, nav, #hint')) part.style.display = 'none';
            document.getElementById('budget').max = document.getElementById('budget').value = 1e4;
            page.again(), page.fillGlass(Infinity), page.pace.step = 0;  // as on a fast device
            for (let i = 0; i < 60; ++i) page.advance(1 / 60); })()""")
        rest, number = 0, 0
        while rest < REST:
            if number == REST:
                browser.ask("sandglassPage.page.turnOver()")
            browser.ask(
                f"(() => {{ const {{page}} = sandglassPage; for (let i = 0; i < {FRAMES_A_PICTURE}; ++i) page.advance(1 / 60); page.draw(); }})()"
            )
            browser.screenshot(folder / f"{number:04}.png")
            number += 1
            rest = rest + 1 if number > REST + 20 and browser.ask(ABOVE) == 0 else 0
            print(f"\rpicture {number}", end="", file=sys.stderr)
            if number > 400:
                sys.exit("film.py: the hourglass does not run down")
    finally:
        browser.close()
    print(file=sys.stderr)
    subprocess.run(["ffmpeg", "-v", "error", "-y", "-framerate", "12", "-i", folder / "%04d.png", "-filter_complex", GIF, film], check=True)
    if film.stat().st_size > 2e6:
        sys.exit(f"film.py: {film} is larger than 2 MB")


if __name__ == "__main__":
    main()
