# SPDX-License-Identifier: GPL-3.0-or-later
"""Two ways to a window: a Blender that the tests start, driven by its own event simulation, or a rig's real mouse."""

import json
import os
import re
import shutil
import subprocess
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCREEN = (1200, 1200)

#: Keys by Blender's names, as xdotool calls them.
_XDOTOOL = {
    "RET": "Return", "ESC": "Escape", "HOME": "Home", "END": "End", "DOWN_ARROW": "Down", "UP_ARROW": "Up",
    "BACK_SPACE": "BackSpace", "TAB": "Tab", "F12": "F12", "F11": "F11", "SPACE": "space",
}  # fmt: skip

#: Characters by Blender's names of their keys.
_KEYS = {
    "0": "ZERO", "1": "ONE", "2": "TWO", "3": "THREE", "4": "FOUR",
    "5": "FIVE", "6": "SIX", "7": "SEVEN", "8": "EIGHT", "9": "NINE",
    ".": "PERIOD", "-": "MINUS", "/": "SLASH", "_": "MINUS", " ": "SPACE",
}  # fmt: skip


class Simulated:
    """A Blender started in the foreground, with `--enable-event-simulate`.

    Parameters
    ----------
    blender
        The program.
    folder
        Of its own: settings, extensions, screenshots' raw files.
    arguments
        More for Blender.
    """

    simulates = True

    def __init__(self, blender, folder, *arguments):
        self.folder = folder / "agent"
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        shutil.copy(HERE / "agent.py", self.folder)
        self.log = folder / "blender.log"
        environment = {
            **os.environ,
            "WINDOW_AGENT_FOLDER": str(self.folder),
            "BLENDER_USER_RESOURCES": str(folder / "user"),
        }
        command = [
            blender, "--enable-event-simulate", "--window-geometry", "0", "0", *map(str, SCREEN),
            "--python", str(self.folder / "agent.py"), *arguments,
        ]  # fmt: skip
        if not os.environ.get("DISPLAY"):
            command = ["xvfb-run", "-a", "-s", f"-screen 0 {SCREEN[0]}x{SCREEN[1]}x24", *command]
        with open(self.log, "w", encoding="utf-8") as log:
            self._process = subprocess.Popen(
                command, stdout=log, stderr=subprocess.STDOUT, env=environment, start_new_session=True
            )
        self._count = 0
        deadline = time.monotonic() + 120.0
        while not (self.folder / "ready").exists():
            assert self._process.poll() is None and time.monotonic() < deadline, self.log.read_text()
            time.sleep(0.05)
        self._at = (10, 10)
        self.run((HERE / "probe.py").read_text(encoding="utf-8"))

    def run(self, code, timeout=300.0):
        """Run Python in the window's Blender; what it prints, or its last value."""
        self._count += 1
        place = self.folder / str(self._count)
        new = place.with_suffix(".new")
        new.write_text(code, encoding="utf-8")
        new.rename(place.with_suffix(".in"))
        deadline = time.monotonic() + timeout
        while True:
            for suffix in (".out", ".err"):
                answer = place.with_suffix(suffix)
                if answer.exists():
                    text = answer.read_text(encoding="utf-8")
                    answer.unlink()
                    assert suffix == ".out", text
                    return text.strip()
            assert self._process.poll() is None, f"Blender ended: {self.log.read_text()[-2000:]}"
            assert time.monotonic() < deadline, f"Blender did not answer {code!r}"
            time.sleep(0.01)

    def turn(self):
        """Until Blender's loop has gone round: what was sent has been handled and drawn."""
        self.run("0")

    def point(self, x, y, number=0):
        """Move the mouse; pixels of the window, y upwards."""
        self._at = (x, y)
        self.run(f"send('MOUSEMOVE', 'NOTHING', {x}, {y}, {number})")
        self.turn()

    def click(self, x, y, number=0):
        """A click of the left button."""
        self.point(x, y, number)
        self.run("\n".join(f"send('LEFTMOUSE', '{value}', {x}, {y}, {number})" for value in ("PRESS", "RELEASE")))
        self.turn()

    def wheel(self, clicks, number=0):
        """Turn the wheel where the mouse is, upwards or downwards."""
        kind, (x, y) = "WHEELUPMOUSE" if clicks > 0 else "WHEELDOWNMOUSE", self._at
        self.run(f"for _ in range({abs(clicks)}): send({kind!r}, 'PRESS', {x}, {y}, {number})")
        self.turn()

    def drag(self, begin, end, number=0, steps=8):
        """Press the left button at one place and let it go at another."""
        self.point(*begin, number)
        self.run(f"send('LEFTMOUSE', 'PRESS', {begin[0]}, {begin[1]}, {number})")
        self.turn()
        # A drag begins with short moves from where the button went down.
        for share in (0.01, 0.02, 0.03, *(step / steps for step in range(1, steps + 1))):
            self.point(*(round(a + (b - a) * share) for a, b in zip(begin, end, strict=True)), number)
        self.run(f"send('LEFTMOUSE', 'RELEASE', {end[0]}, {end[1]}, {number})")
        self.turn()

    def top(self, height):
        """The row of a screenshot, from its top, where the window's y is 0."""
        return int(self.run("print(window().height)"))

    def key(self, *names, number=0, **modifiers):
        """Keys by Blender's names, over the place where the mouse is."""
        place = f"{self._at[0]}, {self._at[1]}, {number}, **{modifiers}"
        self.run("\n".join(f"send('{name}', '{v}', {place})" for name in names for v in ("PRESS", "RELEASE")))
        self.turn()

    def type(self, text):
        """Characters into a field that is being edited."""
        lines = []
        for letter in text:
            key = _KEYS.get(letter, letter.upper())
            shift = letter.isupper() or letter == "_"
            lines += [
                f"send({key!r}, 'PRESS', {self._at[0]}, {self._at[1]}, unicode={letter!r}, shift={shift})",
                f"send({key!r}, 'RELEASE', {self._at[0]}, {self._at[1]}, shift={shift})",
            ]
        self.run("\n".join(lines))
        self.turn()

    def sweep(self, kind="VIEW_3D", name="UI", number=0, begin=None, until="", share=0.6):
        """What lies in a region: commands and data paths with their places, till one matches a pattern."""
        self.run(f"sweep({kind!r}, {name!r}, {number}, {begin}, {until!r}, {share})")
        deadline = time.monotonic() + 300.0
        while not (found := self.run("swept()")):
            assert time.monotonic() < deadline, "The mouse did not come through the region"
            time.sleep(0.05)
        return json.loads(found)

    def shot(self, path):
        """A picture of the screen."""
        display = dict(
            line.split("=", 1)
            for line in self.run(
                "import os\nfor n in ('DISPLAY', 'XAUTHORITY'):\n    print(n + '=' + os.environ.get(n, ''))"
            ).splitlines()
        )
        time.sleep(0.4)
        if shutil.which("xwd") and shutil.which("convert"):
            environment = {**os.environ, **{key: value for key, value in display.items() if value}}
            raw = self.folder / "shot.xwd"
            subprocess.run(["xwd", "-silent", "-root", "-out", str(raw)], check=True, env=environment)
            subprocess.run(["convert", f"xwd:{raw}", str(path)], check=True)
        else:
            self.run(f"shot({str(path)!r})")

    def gaps(self):
        """Waits of the window over 0.05 s since the last call: seconds, and seconds that its thread worked."""
        place = self.folder / "gaps.log"
        self.run("0")
        lines = place.read_text().splitlines() if place.exists() else []
        place.unlink(missing_ok=True)
        return [tuple(map(float, line.split())) for line in lines]

    def quit(self):
        """Close without saving."""
        if self._process.poll() is None:
            with_window = "with bpy.context.temp_override(window=window()): bpy.ops.wm.quit_blender()"
            (self.folder / "quit.new").write_text(with_window, encoding="utf-8")
            (self.folder / "quit.new").rename(self.folder / "quit.in")
        try:
            self._process.wait(30)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, 9)
            self._process.wait()


class Rig:
    """The window of a rig: its scripts move a real mouse. Its folder must be set up."""

    simulates = False

    def __init__(self, scripts, folder, *arguments):
        self._scripts, self._folder = Path(scripts), Path(folder)
        self.log = self._folder / "run" / "blender.log"
        subprocess.run(["bash", str(self._scripts / "blender.sh"), str(folder), *arguments], check=True)
        self._x("gaps")
        self.run((HERE / "probe.py").read_text(encoding="utf-8"))
        self._at = (10, 10)

    def _x(self, *words, timeout=120.0):
        done = subprocess.run(
            ["bash", str(self._scripts / "x.sh"), str(self._folder), *map(str, words)],
            capture_output=True, text=True, timeout=timeout + 10.0, check=False,
            env={**os.environ, "TIMEOUT": str(round(timeout))},
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout.strip()

    def run(self, code, timeout=300.0):
        return self._x("py", code, timeout=timeout)

    def turn(self):
        self.run("0")

    def _screen(self, x, y, number=0):
        left, bottom = json.loads(self.run(f"print([window({number}).x, window({number}).y])"))
        return x + left, 1080 - bottom - y

    def point(self, x, y, number=0):
        self._at = (x, y)
        self._x("move", *self._screen(x, y, number))

    def wheel(self, clicks, number=0):
        for _ in range(abs(clicks)):
            self._x("click", *self._screen(*self._at, number), 4 if clicks > 0 else 5)

    def click(self, x, y, number=0):
        self._x("click", *self._screen(x, y, number))

    def drag(self, begin, end, number=0, steps=8):
        self._x("drag", *self._screen(*begin, number), *self._screen(*end, number))

    def top(self, height):
        return height - int(self.run("print(window().y)"))

    def key(self, *names, number=0, **modifiers):
        words = [_XDOTOOL.get(name, name.lower()) for name in names]
        self._x("key", *("+".join([*(m for m, on in modifiers.items() if on), word]) for word in words))

    def type(self, text):
        self._x("type", text)

    def sweep(self, kind="VIEW_3D", name="UI", number=0, begin=None, until="", share=0.6):
        found = []
        for x, y in json.loads(
            self.run(f"print(json.dumps(places({kind!r}, {name!r}, {number}, {begin}, share={share})))")
        ):
            self.point(x, y, number)
            text = self.run(f"print(under({kind!r}, {name!r}, {number}))")
            if text:
                found.append([text, x, y])
                if until and re.search(until, text):
                    break
        return found

    def shot(self, path):
        self._x("shot", path)

    def gaps(self):
        """As of `Simulated`; how long its thread worked is not known."""
        return [(float(line.split()[0]), float("nan")) for line in self._x("gaps").splitlines()]

    def quit(self):
        self._x("quit")
        subprocess.run(["bash", str(self._scripts / "stop.sh"), str(self._folder)], check=False)
