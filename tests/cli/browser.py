# SPDX-License-Identifier: Apache-2.0
"""Headless Chromium for tests, driven by its DevTools protocol over a pipe: JSON messages on file
descriptors 3 and 4, each ended by a zero byte. Needs nothing but the browser.
"""
import base64
import fcntl
import json
import os
import pathlib
import select
import shutil
import signal
import struct
import tempfile
import time
import zlib

PROGRAMS = ["chromium", "chromium-browser", "google-chrome"]
# The sandbox does not start as root, and all pages are the tests' own.
ARGUMENTS = ["--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu",
             "--disable-dev-shm-usage", "--disable-background-networking", "--disable-extensions",
             "--disable-component-update", "--disable-sync", "--disable-breakpad",
             "--disable-crash-reporter", "--no-first-run", "--no-default-browser-check",
             "--hide-scrollbars", "--force-color-profile=srgb"]
KEYS = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Enter": 13, "Tab": 9,
        "Home": 36, "End": 35}


def find():
    """The path of a browser, or None. A script that only starts a snap is none: a snap cannot read
    files in temporary folders."""
    for name in PROGRAMS:
        path = shutil.which(name)
        if path is None or "/snap/" in os.path.realpath(path):
            continue
        with open(path, "rb") as file:
            head = file.read(8192)
        if not (head.startswith(b"#!") and b"/snap" in head):
            return path
    return None


class Browser:
    """A browser that runs until the `with` ends, or for `limit` seconds."""

    def __init__(self, path, limit):
        self.deadline = time.monotonic() + limit
        self.profile = tempfile.mkdtemp(prefix="browser-")
        self.log = os.path.join(self.profile, "log.txt")
        self.buffer, self.last, self.events = b"", 0, {}
        # Above 4, so that neither replaces the other before it is duplicated.
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in os.pipe() + os.pipe()]
        read_commands, self.commands, self.answers, write_answers = ends
        environment = dict(os.environ, HOME=self.profile)
        write = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        self.pid = os.posix_spawn(
            path, [path, *ARGUMENTS, "--user-data-dir=" + self.profile, "about:blank"], environment,
            file_actions=[(os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0),
                          (os.POSIX_SPAWN_OPEN, 1, self.log, write, 0o600),
                          (os.POSIX_SPAWN_DUP2, 1, 2),
                          (os.POSIX_SPAWN_DUP2, read_commands, 3),
                          (os.POSIX_SPAWN_DUP2, write_answers, 4)], setpgroup=0)
        os.close(read_commands)
        os.close(write_answers)

    def __enter__(self):
        # A test that is ended from outside ends its browser.
        self.before = signal.signal(signal.SIGTERM, self.end_at_signal)
        return self

    def __exit__(self, *_):
        signal.signal(signal.SIGTERM, self.before)
        os.close(self.commands)
        os.close(self.answers)
        os.killpg(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        shutil.rmtree(self.profile, ignore_errors=True)

    @staticmethod
    def end_at_signal(*_):
        raise SystemExit("ended by a signal")

    def fail(self, why):
        with open(self.log, encoding="utf-8", errors="replace") as file:
            raise RuntimeError(f"the browser {why}; its last messages are:\n{file.read()[-2000:]}")

    def receive(self, seconds=None):
        """The next message. None if there is none for so many seconds."""
        while b"\0" not in self.buffer:
            left = self.deadline - time.monotonic()
            wait = left if seconds is None else min(left, seconds)
            if not select.select([self.answers], [], [], max(0.0, wait))[0]:
                if wait < left:
                    return None
                self.fail("has not answered in time")
            data = os.read(self.answers, 1 << 20)
            if not data:
                self.fail("has ended")
            self.buffer += data
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def note(self, message):
        if "method" in message:
            self.events.setdefault(message.get("sessionId"), []).append(message)

    def call(self, method, session=None, **parameters):
        """Calls a method of the protocol and returns its result."""
        self.last += 1
        text = {"id": self.last, "method": method, "params": parameters}
        if session:
            text["sessionId"] = session
        data = json.dumps(text).encode() + b"\0"
        while data:
            data = data[os.write(self.commands, data):]
        while True:
            message = self.receive()
            if message.get("id") == self.last:
                assert "error" not in message, f"{method}: {message['error']}"
                return message["result"]
            self.note(message)


class Page:
    """A page of a file in a browser context of its own. `problems` lists errors, warnings and
    requests for anything but the file and data in it."""

    def __init__(self, browser, path, width, height, scheme, phone=False):
        self.browser, self.problems = browser, []
        self.url = pathlib.Path(path).resolve().as_uri()
        self.context = browser.call("Target.createBrowserContext")["browserContextId"]
        target = browser.call("Target.createTarget", url="about:blank",
                              browserContextId=self.context)["targetId"]
        self.session = browser.call("Target.attachToTarget", targetId=target,
                                    flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=phone)
        self.call("Emulation.setTouchEmulationEnabled", enabled=phone)
        self.scheme = scheme
        self.media("screen")
        failed = self.call("Page.navigate", url=self.url).get("errorText")
        assert not failed, f"{self.url}: {failed}"
        self.wait_for("location.href !== 'about:blank' && document.readyState === 'complete'")
        self.wait(0.3)

    def media(self, kind):
        """Shows the page as on a `screen` or in `print`."""
        self.call("Emulation.setEmulatedMedia", media="" if kind == "screen" else kind,
                  features=[{"name": "prefers-color-scheme", "value": self.scheme}])

    def call(self, method, **parameters):
        result = self.browser.call(method, self.session, **parameters)
        self.take_events()
        return result

    def take_events(self):
        for event in self.browser.events.pop(self.session, []):
            method, what = event["method"], event["params"]
            if method == "Runtime.exceptionThrown":
                self.problems.append(json.dumps(what["exceptionDetails"]))
            elif method == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning",
                                                                           "assert"):
                self.problems.append(json.dumps(what["args"]))
            elif method == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
                self.problems.append(what["entry"]["text"])
            elif method == "Network.requestWillBeSent":
                url = what["request"]["url"]
                if url != self.url and not url.startswith("data:"):
                    self.problems.append("a request for " + url)

    def wait(self, seconds):
        """Lets the page work for so long."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            message = self.browser.receive(left)
            if message:
                self.browser.note(message)
        self.take_events()

    def wait_for(self, script, seconds=20):
        """Waits until a script gives true."""
        end = time.monotonic() + seconds
        while not self.evaluate(script):
            assert time.monotonic() < end, f"never true: {script}"
            self.wait(0.05)

    def evaluate(self, script):
        """The value of an expression, or of what a function without arguments returns."""
        found = self.call("Runtime.evaluate", expression=script, returnByValue=True,
                          awaitPromise=True, userGesture=True)
        assert "exceptionDetails" not in found, f"{script}: {found['exceptionDetails']}"
        return found["result"].get("value")

    def of(self, selector, script, index=0):
        """The value of an expression of e, the element of that index for a selector."""
        return self.evaluate(f"(e => {script})(document.querySelectorAll({json.dumps(selector)})"
                             f"[{index}])")

    def count(self, selector):
        return self.evaluate(f"document.querySelectorAll({json.dumps(selector)}).length")

    def value(self, selector):
        return self.of(selector, "e.value")

    def focus(self, selector):
        assert self.of(selector, "(e.focus(), document.activeElement === e)"), \
            f"{selector} takes no focus"

    def press(self, key):
        text = {"text": "\r"} if key == "Enter" else {}
        for kind in ("keyDown" if text else "rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key,
                      windowsVirtualKeyCode=KEYS[key], **(text if kind == "keyDown" else {}))

    def select(self, selector, value):
        script = f"""(e.value = {json.dumps(value)},
            ['input', 'change'].forEach(n => e.dispatchEvent(new Event(n, {{bubbles: true}}))),
            e.value)"""
        assert self.of(selector, script) == value, f"{selector} has no value {value}"

    def mouse(self, kind, x, y):
        button = {} if kind == "mouseMoved" else {"button": "left", "clickCount": 1}
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button)

    def click_at(self, x, y):
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            self.mouse(kind, x, y)

    def box(self, selector, index=0):
        """Where an element is in the window, into which it is scrolled: x, y, width, height."""
        return self.of(selector, """{ e.scrollIntoView({block: 'center', behavior: 'instant'});
            const b = e.getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; }""", index)

    def click(self, selector, index=0):
        x, y, width, height = self.box(selector, index)
        self.click_at(x + 0.5 * width, y + 0.5 * height)

    def screenshot(self, path=None):
        """A picture of the whole page: its width, its height, and how many rows differ as they are
        stored. A picture of one colour has a few: one of each of the filters of PNG."""
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        data = base64.b64decode(self.call(
            "Page.captureScreenshot", captureBeyondViewport=True,
            clip=dict(x=0, y=0, width=size["width"], height=size["height"], scale=1))["data"])
        if path:
            with open(path, "wb") as file:
                file.write(data)
        return png_rows(data)

    def pdf(self, path=None):
        data = base64.b64decode(self.call("Page.printToPDF")["data"])
        if path:
            with open(path, "wb") as file:
                file.write(data)
        return data

    def close(self):
        self.browser.call("Target.disposeBrowserContext", browserContextId=self.context)


def png_rows(data):
    """Width, height and the number of different stored rows of a PNG."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "no PNG"
    width, height, bits, colour = struct.unpack(">IIBB", data[16:26])
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    stride = 1 + width * {2: 3, 6: 4}[colour] * bits // 8
    rows = zlib.decompress(packed)
    assert len(rows) == stride * height
    return width, height, len({rows[i:i + stride] for i in range(0, len(rows), stride)})
