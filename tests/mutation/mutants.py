"""Small faults of C++ code: where one can be put, and which are chosen."""

import dataclasses
import random
import re

# What is found in a line, and what it becomes. In code that clang-format has spaced, an operator between spaces is binary:
# `<` of a template has none.
SWAPS = {
    "relation": {" < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " == ": " != ", " != ": " == "},
    "sum": {" + ": " - ", " - ": " + "},
    "logic": {" && ": " || ", " || ": " && "},
}
SKIPPED = re.compile(r"^\s*(#|//|using |namespace |template|static_assert|assert\(|\}|case |public:|private:|default:)")
CONSTANT = re.compile(r"(?<![\w.\"'])(\d+)(?![\w.'\"])")
CONDITION = re.compile(r"\b(if|while) \((?!constexpr)(.*)\)( \{| [a-z].*;|)$")
STATEMENT = re.compile(r"^\s+(?!return\b|const\b|auto\b|static\b|break|continue|else|throw\b|using\b)[\w.:>\[\]\-]+(\(.*\)| [+\-|&*/]?= .*);$")
EARLY = re.compile(r"^\s+if \(.*\) (return\b.*|continue|break|throw_\w+\(.*\)|throw .*);$")


@dataclasses.dataclass(frozen=True)
class Mutant:
    file: str
    line: int  # from 1
    operator: str
    before: str
    after: str


def blanked(line):
    """The line with its strings and its comment blanked, of the same length."""
    line = re.sub(r'"(\\.|[^"\\])*"|\'(\\.|[^\'\\])\'', lambda found: "_" * len(found[0]), line)
    return re.sub(r"//.*", lambda found: " " * len(found[0]), line).rstrip()


def changes(line):
    """(operator, changed line) for all faults of one line."""
    code = blanked(line)
    if not code.strip() or SKIPPED.match(code):
        return
    for operator, swaps in SWAPS.items():
        for old, new in swaps.items():
            for found in re.finditer(re.escape(old), code):
                yield operator, line[:found.start()] + new + line[found.end():]
    for found in CONSTANT.finditer(code):
        yield "constant", line[:found.start()] + str(int(found[1]) + 1) + line[found.end():]
    if found := CONDITION.search(code):
        if found[2].count("(") == found[2].count(")") and ";" not in found[2] and " = " not in found[2]:
            yield "negation", line[:found.start(2)] + f"!({line[found.start(2):found.end(2)]})" + line[found.end(2):]
    if STATEMENT.match(code) or EARLY.match(code):
        yield "removal", re.match(r"\s*", line)[0] + ";"


def mutants_of(file, text):
    lines, in_comment = text.split("\n"), False
    for number, line in enumerate(lines, 1):
        in_comment = in_comment or line.lstrip().startswith("/*")
        if not in_comment:
            for operator, after in changes(line):
                yield Mutant(file, number, operator, line, after)
        in_comment = in_comment and "*/" not in line


def applied(mutant, text):
    lines = text.split("\n")
    assert lines[mutant.line - 1] == mutant.before, "the file has changed"
    lines[mutant.line - 1] = mutant.after
    return "\n".join(lines)


def chosen(texts, count, seed):
    """`count` mutants of {file: text}, one a line, spread over files by their lines of code; the same for a seed."""
    lines = {file: {} for file in texts}
    for file, text in texts.items():
        for mutant in mutants_of(file, text):
            lines[file].setdefault(mutant.line, []).append(mutant)
    rng = random.Random(seed)
    slots = [(file, line) for file in sorted(lines) for line in sorted(lines[file])]
    picked = rng.sample(slots, min(count, len(slots)))
    return [rng.choice(lines[file][line]) for file, line in picked]
