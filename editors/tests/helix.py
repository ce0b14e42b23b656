"""A session of Helix with the settings of docs/editors.md, over a copy of the project beside this file:

    python3 editors/tests/helix.py

It needs `hx` (or HELIX=...), `tmux` and `rpl`. Helix has no scripts: keys are typed, and what stands on the screen is
read. It ends with the number of things that were not as expected.
"""

import atexit
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
PAGE = (HERE.parent.parent / "docs" / "editors.md").read_text()
SETTINGS = re.search(r"## Helix.*?```text\n(.*?)\n```", PAGE, re.S).group(1)

# In the place of `rpl`: hands on what both sides say, and keeps it.
BETWEEN = """#!{python}
import subprocess, sys, threading
server = subprocess.Popen([{rpl!r}] + sys.argv[1:], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
def hand_on(source, to, log):
    with open(log, "wb") as kept:
        while data := source.read1(65536):
            kept.write(data); kept.flush(); to.write(data); to.flush()
    to.close()
threading.Thread(target=hand_on, args=(sys.stdin.buffer, server.stdin, {log!r} + ".to"), daemon=True).start()
hand_on(server.stdout, sys.stdout.buffer, {log!r} + ".from")
"""


def messages(data):
    found = []
    while data:
        header, data = data.split(b"\r\n\r\n", 1)
        length = int(re.search(rb"Content-Length: (\d+)", header).group(1))
        found.append(json.loads(data[:length]))
        data = data[length:]
    return found


class Session:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder).resolve()
        self.project = self.folder / "project"
        shutil.copytree(HERE / "project", self.project)
        (self.project / ".git").mkdir()
        config = self.folder / "config" / "helix"
        config.mkdir(parents=True)
        (config / "languages.toml").write_text(SETTINGS)
        (config / "config.toml").write_text("[editor.lsp]\ndisplay-inlay-hints = true\n")
        between = self.folder / "bin" / "rpl"
        between.parent.mkdir()
        self.log = str(self.folder / "log")
        between.write_text(BETWEEN.format(python=sys.executable, rpl=shutil.which("rpl"), log=self.log))
        between.chmod(0o755)
        self.failed = self.asked = 0
        self.tmux = ["tmux", "-S", str(self.folder / "tmux")]
        variables = {"PATH": f"{between.parent}:{os.environ['PATH']}", "XDG_CONFIG_HOME": config.parent,
                     "XDG_CACHE_HOME": self.folder / "cache"}
        # Whatever happens, the editor ends with its session.
        atexit.register(subprocess.run, [*self.tmux, "kill-server"], check=False, capture_output=True)
        given = [f"{name}={value}" for name, value in variables.items()]
        # A shell might have other variables.
        subprocess.run([*self.tmux, "-u", "-f", "/dev/null", "new-session", "-d", "-x", "120", "-y", "50", "-c",
                        self.project, "env", *given, os.environ.get("HELIX", "hx"), "main.rpl"], check=True)

    def type(self, *keys):
        for key in keys:
            subprocess.run([*self.tmux, "send-keys", key], check=True)
            time.sleep(0.15)

    def write(self, text):
        # Helix 25.01 may say changes in another order than they were typed in, if they are typed at once.
        for letter in text:
            subprocess.run([*self.tmux, "send-keys", "-l", letter], check=True)
            time.sleep(0.15)

    def screen(self):
        return subprocess.run([*self.tmux, "capture-pane", "-p"], check=True, capture_output=True, text=True).stdout

    def sees(self, name, *words):
        self.asked += 1
        until = time.time() + 20
        while time.time() < until:
            screen = self.screen()
            if all(re.search(word, screen) for word in words):
                return
            time.sleep(0.1)
        self.failed += 1
        print(f"{name}: no {words} in\n{screen}")

    def command(self, text):
        self.type(":")
        subprocess.run([*self.tmux, "send-keys", "-l", text], check=True)
        self.type("Enter")

    def go(self, line, word):
        column = (self.project / "main.rpl").read_text().split("\n")[line].index(word) + 1
        self.type("Escape", *f"{line + 1}", "G", "g", "h", *([*str(column), "l"] if column else []))

    def end(self):
        subprocess.run([*self.tmux, "kill-server"], check=False)
        said = pathlib.Path(self.log + ".to"), pathlib.Path(self.log + ".from")
        to, back = (messages(file.read_bytes()) for file in said)
        asked = {one["id"]: one["method"] for one in to if "method" in one and "id" in one}
        answers = [one for one in back if "method" not in one and one.get("id") in asked]
        faults = [(asked[one["id"]], one["error"]) for one in answers if "error" in one]
        for fault in faults:
            print(*fault)
        print(f"{len(asked)} requests of {len(set(asked.values()))} kinds, {len(answers)} answers, {len(faults)} faults")
        return self.failed + len(faults)


def main():
    with tempfile.TemporaryDirectory() as folder:
        session = Session(folder)
        session.sees("the text with names of parameters", r"\(inspect 'mail-slots seconds: ?5\)", r"limit: ?3")
        for line, word, said in [(7, "go-to", r"\(go-to "), (17, "inspect", "looks at it for some seconds"),
                                 (18, "round-trip", "Goes to all places"), (13, "dolist", r"\(dolist "),
                                 (15, "min", r"a function"), (12, "let", "special form"),
                                 (14, "count", "bound in line 13"), (3, "inspected", "a fluent"),
                                 (17, "mail-slots", "a place in the world")]:
            session.go(line, word)
            session.type("Space", "k")
            session.sees(f"hover: {word}", said)
        for line, word, there in [(17, "inspect", "6:11"), (8, "seconds", "6:26"), (14, "count", "13:10"),
                                  (13, "inspected", "4:13")]:
            session.go(line, word)
            session.type("g", "d")
            session.sees(f"definition: {word}", rf"\b{there}\b")
        session.go(18, "round-trip")
        session.type("g", "d")
        session.sees("definition in a loaded text", r"round\.rpl")
        session.type("C-o")
        for line, word, file in [(7, "go-to", r"robot\.rpl"), (13, "dolist", r"prelude\.rpl")]:
            session.go(line, word)
            session.type("g", "d")
            session.sees(f"definition in the library: {word}", file, r"\(def[a-z-]+ " + word)
            session.command("buffer-close")
            session.sees("the text again", r"main\.rpl")
        session.go(5, "inspect")
        session.type("g", "r")
        session.sees("references", "main.rpl:6", "main.rpl:18")
        session.type("Escape", "Space", "s")
        session.sees("outline", "inspected", "keep-count")
        session.type("Escape", "Space", "S")
        session.write("nothing")
        session.sees("symbols of the project", "nothing-is-added")
        session.type("Escape", "Escape")
        session.go(12, "count")
        session.type("Space", "h", "Space", "r", "C-u")
        session.type("n", "u", "m", "b", "e", "r", "Enter")
        session.sees("a variable is renamed", r"\(incf number\)", r"\(min limit number\)")
        session.command("20")
        session.type("x", "d", "O")
        session.write("(print   (keep-cou")
        session.sees("completion", r"keep-count +")
        session.write("nt ")
        session.sees("signature", r"\(keep-count limit\)")
        session.write("(lenght 1)))")
        session.type("Escape")
        session.command("20")
        session.type("g", "h", *"22l")
        session.sees("findings after an edit", "did you mean `length`")
        session.type("Space", "a")
        session.sees("a finding can be mended", "Write `length`")
        session.type("Enter")
        session.sees("it is mended", r"\(print   \(keep-count (limit: ?)?\(length ")
        session.command("format")
        session.sees("the text is laid out", r"\(print \(keep-count ")
        session.command("write")
        session.sees("it is written", "written")
        print(subprocess.run([os.environ.get("HELIX", "hx"), "--version"], capture_output=True, text=True).stdout.strip(),
              f": {session.asked - session.failed} of {session.asked} as expected")
        sys.exit(min(session.end(), 100))


main()
