# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person does at the window, in words: presses a button, chooses an entry, types a number, looks."""

import contextlib
import json
import math
import re
import time

#: How Blender logs what an operator reports, and which files it reads.
_REPORT = re.compile(r"^[0-9:.]+ +(operator +\| |blend +\| Read blend)")

#: The region that is looked at where no other is named.
SIDEBAR = ("VIEW_3D", "UI", 0)

STATE = "bpy.context.scene.diffraction"


class Desk:
    """A person before a window of Blender.

    Parameters
    ----------
    driver
        Of `drivers`.
    work
        A folder that Blender sees too.
    pictures
        Where screenshots go.
    """

    def __init__(self, driver, work, pictures):
        self.driver, self.work, self._pictures = driver, work, pictures
        self._places = []
        self.run = driver.run

    def look(self, expression):
        """A value of the window's Blender."""
        return json.loads(self.run(f"import json\nprint(json.dumps({expression}, default=list))"))

    def state(self, name):
        """A property of the scene's panel."""
        return self.look(f"{STATE}.{name}")

    def open_sidebar(self):
        """The sidebar's tab, and the help of the probe, which a new file has not forgotten but whose places changed."""
        self.run("area().spaces.active.show_region_ui = True")
        time.sleep(0.5)
        self.run("show_tab()")
        time.sleep(0.5)
        self._places = []

    def new_file(self):
        """File > New > General."""
        self.run("with anywhere(): bpy.ops.wm.read_homefile()")
        time.sleep(1.0)
        self.open_sidebar()

    def settle(self):
        """Until what was asked for has been drawn."""
        time.sleep(0.3)
        for _ in range(3):
            self.driver.turn()

    def over_view(self):
        """The mouse over the 3-D view, where its keys go."""
        x, y, width, height = self.look("rectangle('VIEW_3D', 'WINDOW')")
        self.driver.point(x + width // 3, y + height // 2)

    def browse(self, what, path, already=False, **options):
        """Press a button that opens a file browser, choose a file there, or leave it by Esc for None.

        Parameters
        ----------
        what
            The button.
        path
            The file, or a folder where one is asked for.
        already
            A browser is open already; Blender may take it or open another.
        options
            Of the browser's sidebar.

        Returns
        -------
        dict
            The options that the browser offered at first.
        """
        windows = self.look("len(bpy.context.window_manager.windows)")
        self.press(what, wait=False)
        self.settle()
        deadline = time.monotonic() + 30.0
        while not already and self.look("len(bpy.context.window_manager.windows)") == windows:
            assert time.monotonic() < deadline, "No file browser opened"
            time.sleep(0.2)
        self.settle()
        windows = self.look("len(bpy.context.window_manager.windows)") - 1
        space = f"window({windows}).screen.areas[0].spaces.active"
        active = f"{space}.active_operator"
        names = [name for name in ("size_um", "height_nm") if self.look(f"hasattr({active}, {name!r})")]
        offered = {name: self.look(f"{active}.{name}") for name in names}
        self.last_folder = self.look(f"{space}.params.directory.decode()")
        x, y, width, height = self.look(f"rectangle('FILE_BROWSER', 'WINDOW', {windows})")
        self.driver.point(x + width // 2, y + height // 2, windows)
        if path is None:
            self.driver.key("ESC", number=windows)
        else:
            for name, value in options.items():
                self.run(f"{active}.{name} = {value!r}")
            folder = path if path.is_dir() else path.parent
            self.run(f"p = {space}.params\np.directory = {str(folder)!r}.encode()")
            if folder != path:
                self.run(f"p.filename = {path.name!r}")
            self.settle()
            self.run(f"with within('FILE_BROWSER', 'WINDOW', {windows}): bpy.ops.file.execute('INVOKE_DEFAULT')")
        self.settle()
        self.wait()
        return offered

    def render(self, seconds=1500.0):
        """F12 over the 3-D view; the picture as rows of RGB that a display shows."""
        import numpy as np

        x, y, width, height = self.look("rectangle('VIEW_3D', 'WINDOW')")
        self.driver.point(x + width // 3, y + height // 2)
        self.driver.key("F12")
        time.sleep(0.5)
        deadline = time.monotonic() + seconds
        # A window stands still while EEVEE compiles, minutes without a GPU.
        while self.run("print(bpy.app.is_job_running('RENDER'))", seconds) == "True":
            assert time.monotonic() < deadline, "The render did not end"
            time.sleep(0.2)
        place = self.work / "render.png"
        self.run(f"bpy.data.images['Render Result'].save_render({str(place)!r})")
        from PIL import Image

        return np.asarray(Image.open(place).convert("RGB")) / 255.0

    def panel(self):
        """What the sidebar shows now, by pointing at it."""
        self._places = self.driver.sweep()
        return [text for text, _, _ in self._places]

    def find(self, what, share=0.6, where=SIDEBAR):
        """Where a button is: a part of its command or data path, which must not go on after it, or a
        pattern.

        `share` of the region's width is where it is looked for: small buttons stand on the right. `where` is the
        region: kind of editor, of region, number of the window.
        """
        pattern = what.pattern if isinstance(what, re.Pattern) else re.escape(what) + r"(?![a-zA-Z_])"
        if where != SIDEBAR:
            self._places = []
        near = next((place for text, *place in self._places if re.search(pattern, text)), None)
        for tries in range(10):
            found = self.driver.sweep(*where, begin=near[1] if near else None, until=pattern, share=share)
            self._remember(found)
            if found and re.search(pattern, found[-1][0]):
                place = tuple(found[-1][1:])
                self.driver.point(*place, where[2])
                if re.search(pattern, self.run(f"print(under(*{where}))")):
                    return place
            near = None
            self.scroll(40 if tries == 0 else -8, where)
        seen = "\n".join(text for text, _, _ in self._places)
        raise AssertionError(f"{what} is not in {where}, which shows\n{seen}")

    def _remember(self, found):
        new = {text: (text, x, y) for text, x, y in found}
        self._places = [*(place for place in self._places if place[0] not in new), *new.values()]

    def scroll(self, clicks, where=SIDEBAR):
        """Turn the wheel over the sidebar."""
        left, bottom, width, height = self.look(f"rectangle(*{where})")
        x, y = left + width // 3, bottom + height // 2
        self.driver.point(x, y, where[2])
        self.driver.wheel(clicks, where[2])

    def press(self, what, wait=True, share=0.6, where=SIDEBAR):
        """A click on a button of the sidebar; waits until what it started has ended."""
        self.driver.click(*self.find(what, share, where), where[2])
        time.sleep(0.2)
        if wait:
            self.wait()

    def wait(self, seconds=180.0):
        """Until nothing is computed any more."""
        deadline = time.monotonic() + seconds
        while self.run("print(busy())") == "True":
            assert time.monotonic() < deadline, "It did not end"
            time.sleep(0.1)
        time.sleep(0.2)

    def stop(self):
        """Esc, if anything is computed."""
        if self.run("print(busy())") == "True":
            self.over_view()
            self.driver.key("ESC")
            self.wait()

    def enter(self, what, text):
        """Type into a field."""
        self.driver.point(*self.find(what))
        self.driver.key("RET")
        time.sleep(0.1)
        self.driver.key("A", ctrl=True)
        self.driver.type(str(text))
        self.driver.key("RET")
        time.sleep(0.2)
        value = self.look(f"{STATE}.{what}")
        if self.look(f"{STATE}.bl_rna.properties[{what!r}].subtype") == "ANGLE":
            value = math.degrees(value)
        assert abs(value - float(text)) <= 1e-5 * abs(value), f"{what} shows {value}, {text} was typed"

    def choose(self, name, identifier, owner=STATE):
        """Choose an entry of a menu."""
        items = self.look(f"[i.identifier for i in {owner}.bl_rna.properties['{name}'].enum_items]")
        self.driver.click(*self.find(f".{name}"))
        time.sleep(0.3)
        self.driver.key("HOME", *["DOWN_ARROW"] * items.index(identifier), "RET")
        time.sleep(0.3)
        assert self.look(f"{owner}.{name}") == identifier

    def press_near(self, what, share, found_at=0.6, lines=0.0):
        """A click near a button, whose own place is a share of the width: menus tell no command.

        `share` is where in the sidebar's width; `lines` how many lines below the button.
        """
        left, _, width, _ = self.look("rectangle()")
        line = 20.0 * self.look("bpy.context.preferences.system.ui_scale")
        self.driver.click(left + round(share * width), round(self.find(what, found_at)[1] - lines * line))
        self.settle()

    @contextlib.contextmanager
    def only(self, *names):
        """The panels of some names alone, all of them open."""
        self.run(f"show_only({['main', *names]!r})")
        self.open_sidebar()
        try:
            yield
        finally:
            self.run("show_all()")
            self.open_sidebar()

    def pick(self, number):
        """Take an entry of the menu that is open, counted from 0."""
        self.driver.key("HOME", *["DOWN_ARROW"] * number, "RET")
        self.settle()
        self.wait()

    def switch(self, name):
        """Click a check box."""
        self.driver.click(*self.find(f".{name}"))
        time.sleep(0.2)

    def drag(self, begin, end):
        """Drag with the left button over the 3-D view."""
        self.driver.drag(begin, end)

    def image(self, name):
        """An image of Blender's as rows of RGB, from the bottom."""
        import numpy as np

        place = self.work / "image.npy"
        self.run(f"""
import numpy as np
image = bpy.data.images[{name!r}]
pixels = np.empty(len(image.pixels), np.float32)
image.pixels.foreach_get(pixels)
np.save({str(place)!r}, pixels.reshape(image.size[1], image.size[0], -1)[..., :3])
""")
        return np.load(place)

    def close_windows(self):
        """All but the first."""
        self.run("""
for each in list(bpy.context.window_manager.windows)[1:]:
    with bpy.context.temp_override(window=each): bpy.ops.wm.window_close()
""")
        self.settle()

    def open_panels(self):
        """Panels of the sidebar that draw their bodies."""
        self.run("watch_panels()\ndrawn()\nregion().tag_redraw()")
        self.driver.turn()
        return set(json.loads(self.run("drawn()")))

    def open_panel(self, name, above):
        """Click the header of a closed panel that stands below something."""
        before = self.open_panels()
        if f"DIFFRACTION_PT_{name}" in before:
            return
        _, y = self.find(above)
        left = self.look("rectangle()")[0] + 60
        for drop in range(20, 160, 11):
            self.driver.click(left, y - drop)
            self.settle()
            now = self.open_panels()
            if f"DIFFRACTION_PT_{name}" in now:
                return
            if now != before:  # another panel's header
                self.driver.click(left, y - drop)
                self.settle()
        raise AssertionError(f"The panel {name} did not open")

    def keep_picture(self, name, picture):
        """Rows of RGB from the top, for people."""
        import numpy as np
        from PIL import Image

        Image.fromarray((255.0 * picture + 0.5).astype(np.uint8)).save(self._pictures / f"{name}.png")

    def picture(self, name, region="WINDOW", number=0):
        """What the 3-D view or another of its regions shows, as rows of RGB from the top; kept for people too."""
        import numpy as np
        from PIL import Image

        self.settle()
        self.shot(name)
        x, y, width, height = self.look(f"rectangle('VIEW_3D', {region!r}, {number})")
        screen = np.asarray(Image.open(self._pictures / f"{name}.png").convert("RGB"), float) / 255.0
        top = self.driver.top(screen.shape[0]) - (y + height)
        return screen[top : top + height, x : x + width]

    def shot(self, name):
        """A picture for people."""
        self.driver.shot(self._pictures / f"{name}.png")

    def keep(self, name, text):
        """A text for people, beside the pictures."""
        (self._pictures / name).write_text(text, encoding="utf-8")

    def has_osl(self):
        """Whether this Blender was built with Open Shading Language."""
        return self.look("addon('renderers').has_osl()")

    def watch(self, seconds):
        """Let the window go on by itself."""
        time.sleep(seconds)

    def console(self):
        """Lines that Blender printed since the last call, without what operators told."""
        text = self.driver.log.read_text(encoding="utf-8", errors="replace")
        new, self._read = text[getattr(self, "_read", 0) :], len(text)
        return [line for line in new.splitlines() if line.strip() and not _REPORT.search(line)]
