"""What a user does in usdview with the renderer Stf, done by a script inside of it (``testusdview --testScript``).

Writes what it saw to the folder ``HDSTF_TEST_OUTPUT``: pictures as PNG and as raw RGBA bytes, the rest as
``session.json``. It judges nothing; ``run_usdview_test.py`` does.
"""

import json
import os
import time

from pxr import Usd
from pxr.Usdviewq.qt import QtCore, QtGui, QtWidgets

OUTPUT = os.environ["HDSTF_TEST_OUTPUT"]
SIZE = tuple(int(n) for n in os.environ["HDSTF_TEST_SIZE"].split("x"))
LONGEST_WAIT = 300  # seconds


class Session:
    """usdview as its user has it: menus, panels, the view."""

    def __init__(self, controller):
        self.controller = controller
        self.view = controller._stageView
        self.settings = controller._dataModel.viewSettings
        self.seen = {"pictures": {}}

    @staticmethod
    def events():
        """Lets usdview handle what is pending, its timer for the next picture too."""
        QtWidgets.QApplication.processEvents()
        time.sleep(0.005)

    def wait(self):
        """Until the renderer has converged and the view shows it; the seconds that took."""
        start = time.monotonic()
        self.view.updateGL()
        while not self.view.IsRendererConverged():
            if time.monotonic() - start > LONGEST_WAIT:
                raise RuntimeError("no convergence after %d s: %s" % (LONGEST_WAIT, self.stats()))
            self.events()
        self.view.updateGL()
        return time.monotonic() - start

    def stats(self):
        """The delegate's statistics that have a plain type."""
        stats = dict(self.view._renderer.GetRenderStats())
        return {key: value for key, value in stats.items() if isinstance(value, (int, float, str))}

    def samples_done(self):
        """Samples of each pixel so far."""
        return self.stats().get("numCompletedSamples", -1)

    def shoot(self, name):
        """Keeps what the view shows."""
        image = self.view.grabFrameBuffer().convertToFormat(QtGui.QImage.Format_RGBA8888)
        image.save(os.path.join(OUTPUT, name + ".png"))
        with open(os.path.join(OUTPUT, name + ".rgba"), "wb") as raw:
            raw.write(bytes(image.constBits()))
        self.seen["pictures"][name] = [image.width(), image.height()]

    def shoot_window(self, widget, name):
        """Keeps a picture of a window; what OpenGL draws in it has to be put in, Qt does not grab that."""
        self.events()
        picture = widget.grab()
        if widget.isAncestorOf(self.view):
            painter = QtGui.QPainter(picture)
            painter.drawImage(self.view.mapTo(widget, self.view.rect().topLeft()), self.view.grabFrameBuffer())
            painter.end()
        picture.save(os.path.join(OUTPUT, name + ".png"))

    def choose_renderer(self, name):
        """Renderer menu."""
        for action in self.controller._ui.rendererPluginActionGroup.actions():
            if action.text() == name:
                action.trigger()
                return self.view.rendererDisplayName
        raise RuntimeError("no renderer %s in the menu" % name)

    def choose_aov(self, name):
        """Renderer AOV menu."""
        for action in self.controller._ui.rendererAovActionGroup.actions():
            if action.text() == name:
                action.trigger()
                return
        self.controller._rendererAovChanged(name)  # what "Other..." does with the name typed

    def click(self, x, y):
        """A click of the left button; the paths of the prims selected by it."""
        self.view.pickObject(x, y, QtCore.Qt.LeftButton, QtCore.Qt.NoModifier)
        self.events()
        return [str(path) for path in self.controller._dataModel.selection.getPrimPaths()]

    def resize(self, width, height):
        """Another size of the view."""
        self.view.setFixedSize(width, height)
        self.events()

    def look(self):
        """Only the picture: no heads-up display, no boxes, no axes."""
        self.view.DrawAxis = lambda matrix: None
        self.settings.showHUD = False
        self.settings.showBBoxes = False
        self.settings.cameraPrim = self.controller._dataModel.stage.GetPrimAtPath("/World/Camera")

    def panel(self):
        """The settings' menu and dialog: what they offer, and what setting them does."""
        controller, view = self.controller, self.view
        seen = {"flags": {action.key: action.isChecked() for action in controller._ui.settingsFlagActions}}
        controller._moreRendererSettings()
        seen["widgets"] = {widget.key: type(widget).__name__ for widget in controller._ui.settingsMoreWidgets}
        self.shoot_window(controller._ui.settingsMoreDialog, "panel")
        widgets = {widget.key: widget for widget in controller._ui.settingsMoreWidgets}

        self.wait()
        controller._applyMoreRendererSettings()  # nothing was changed
        view.updateGL()
        seen["converged after applying what was"] = bool(view.IsRendererConverged())

        samples = widgets["stf:samples"].value()
        widgets["stf:samples"].setValue(samples + 1)
        controller._applyMoreRendererSettings()
        view.updateGL()
        seen["converged after another number of samples"] = bool(view.IsRendererConverged())
        self.wait()
        seen["samples"] = [samples, view.GetRendererSetting("stf:samples"), self.samples_done()]
        controller._resetMoreRendererSettings()
        controller._applyMoreRendererSettings()
        seen["samples after reset"] = view.GetRendererSetting("stf:samples")
        controller._ui.settingsMoreDialog.reject()
        self.seen["panel"] = seen

    def pause(self):
        """Pause and stop in the menu."""
        controller, view = self.controller, self.view
        many = 100000
        view.SetRendererSetting("stf:samples", many)
        view.updateGL()
        while self.samples_done() < 1:
            self.events()
        controller._togglePause()
        time.sleep(0.3)  # the pass that was under way
        paused = self.samples_done()
        for _ in range(100):
            self.events()
        seen = {"paused": [paused, self.samples_done()], "paused converged": bool(view.IsRendererConverged())}
        controller._togglePause()
        while self.samples_done() <= paused:
            self.events()
        seen["resumed"] = self.samples_done()
        controller._toggleStop()
        seen["stopped converged"] = bool(view.IsRendererConverged())
        self.shoot("stopped")
        view.SetRendererSetting("stf:samples", 2)
        controller._toggleStop()
        self.wait()
        seen["samples after restart"] = self.samples_done()
        self.seen["pause"] = seen


def testUsdviewInputFunction(controller):
    """Called by testusdview once the scene is there."""
    session = Session(controller)
    seen = session.seen
    width, height = SIZE
    session.look()
    session.resize(width, height)

    seen["renderer"] = session.choose_renderer("Stf")
    seen["aovs"] = list(session.view.GetRendererAovs())
    seen["seconds"] = session.wait()
    session.shoot("color")
    seen["stats"] = session.stats()
    session.panel()

    # Not primId: usdview of 20.08 uploads integers as GL_RED, which is an error of OpenGL, whatever the renderer.
    for aov in ("depth", "normal", "color"):
        session.choose_aov(aov)
        session.wait()
        session.shoot("aov_" + aov)

    seen["clicks"] = {
        "body": session.click(width // 2, height * 3 // 5),
        "ground": session.click(width // 10, height * 9 // 10),
        "sky": session.click(width // 10, height // 10),
    }
    session.click(width // 2, height * 3 // 5)
    session.wait()
    session.shoot("selected")
    session.click(width // 10, height // 10)

    # From here on few samples: what counts is that something happens.
    session.view.SetRendererSetting("stf:samples", 2)
    session.wait()
    session.shoot("before")
    session.view.switchToFreeCamera()
    session.settings.freeCamera.rotTheta += 6
    session.view.updateGL()
    seen["converged after moving the camera"] = bool(session.view.IsRendererConverged())
    session.wait()
    session.shoot("moved")
    session.look()
    session.wait()
    session.shoot("moved_back")

    controller._dataModel.currentFrame = Usd.TimeCode(12)
    session.wait()
    session.shoot("frame_12")

    session.resize(width // 2, height // 2)
    session.wait()
    session.shoot("smaller")
    session.resize(width, height)
    session.wait()
    session.pause()

    seen["other renderer"] = session.choose_renderer("GL")
    session.wait()
    session.shoot("storm")
    seen["renderer again"] = session.choose_renderer("Stf")
    session.view.SetRendererSetting("stf:samples", 2)
    del session.view.DrawAxis
    session.settings.showHUD = True
    session.settings.showBBoxes = True
    session.wait()
    session.shoot("hud")
    session.shoot_window(controller._mainWindow, "window")

    with open(os.path.join(OUTPUT, "session.json"), "w") as file:
        json.dump(seen, file, indent=1)
