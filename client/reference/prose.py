"""Comments and docstrings as this project writes them, as reStructuredText.

They are plain text: paragraphs, `code`, indented lines of code, and lists of "name: what it is", whose further lines are
indented.
"""

import re

ITEM = re.compile(r"^([A-Za-z_*][\w*]*(?:, [\w*]+)*): (.*)$")
CODE = re.compile(r"(``.*?``|`[^`]*`)")
SPECIAL = re.compile(r"([\\*|])|(?<=\w)_(?!\w)")


def inline(text):
    """`code` becomes ``code``; elsewhere nothing is markup."""
    parts = CODE.split(text)
    for i, part in enumerate(parts):
        if i % 2:
            parts[i] = f"``{part.strip('`')}``"
        else:
            parts[i] = SPECIAL.sub(lambda match: "\\" + match[0], part)
    return "".join(parts)


def blocks(lines):
    """Runs of lines without an empty one between them."""
    block = []
    for line in [*lines, ""]:
        if line.strip():
            block.append(line)
        elif block:
            yield block
            block = []


def block_lines(block, has_items):
    if all(line.startswith("    ") for line in block):
        return ["::", "", *block, ""]
    out, is_item = [], False
    for line in block:
        if match := has_items and ITEM.match(line):
            if out and not is_item:
                out.append("")
            is_item = True
            out += [f"``{match[1]}``", f"    {inline(match[2])}"]
        elif is_item and line.startswith(" "):
            out.append("    " + inline(line.strip()))
        else:
            if is_item:
                out.append("")
            is_item = False
            out.append(inline(line.strip()))
    return [*out, ""]


def lines_of(text, has_items=True):
    """The lines of a text in reStructuredText. Comments of the protocol have no lists."""
    return [line for block in blocks(text.splitlines()) for line in block_lines(block, has_items)]
