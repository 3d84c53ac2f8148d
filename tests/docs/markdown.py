"""Fenced blocks of a Markdown page."""

import pathlib
import re

FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Page:
    def __init__(self, path):
        self.text = pathlib.Path(path).read_text()

    def blocks(self, language="", after=""):
        """Contents of the blocks of a language, from the first line that holds `after` on."""
        start = self.text.index(after)
        return [body for found, body in FENCE.findall(self.text[start:]) if found == language]

    def table(self, after):
        """Rows of cells of the first table after the text `after`, its header first."""
        lines = iter(self.text[self.text.index(after):].splitlines())
        rows = []
        for line in lines:
            if line.startswith("|"):
                rows.append([cell.strip() for cell in line.strip().strip("|").split("|")])
            elif rows:
                break
        return [rows[0]] + rows[2:]
