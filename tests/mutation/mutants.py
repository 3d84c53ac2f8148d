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


def end_of_expression(code, at, step):
    """Where the expression around `at` ends to the left (step -1) or right (step 1): at what separates or encloses expressions."""
    opens, closes = (")]}", "([{") if step < 0 else ("([{", ")]}")
    depth, ahead = 0, 0 if step > 0 else -1
    while 0 <= at + ahead < len(code):
        here = code[at + ahead]
        if here in closes and depth == 0:
            break
        depth += (here in opens) - (here in closes)
        if depth == 0 and (here in ",;?" or (here == ":" and "::" not in code[max(at + ahead - 1, 0):at + ahead + 2]) or
                           (here == "=" and code[at + ahead - 1] not in "=<>!" and code[at + ahead + 1] != "=") or
                           (step < 0 and code[:at].endswith("return "))):
            break
        at += step
    return at


def switched(mutant, number, previous=""):
    """The line with its fault behind a switch, so that one program holds many; None where that would change the line itself.

    `previous` is the code of the line before: an expression that goes on from there is left alone, but after `||`.
    """
    blank, active = blanked(mutant.before), f"collided_mutant == {number}"
    code = mutant.before[:len(blank)]
    if mutant.operator == "removal":
        statement = code.lstrip()
        return f"{code[:-len(statement)]}{{ if (!({active})) {statement} }}"
    after = mutant.after[:len(mutant.after) - len(mutant.before) + len(code)]
    first = next(i for i, (old, new) in enumerate(zip(code + "\n", after + "\n")) if old != new)
    start, end = end_of_expression(blank, first, -1), end_of_expression(blank, first, 1)
    start += len(code[start:]) - len(code[start:].lstrip())
    whole_line = not code[:start].strip()
    if whole_line and not previous.rstrip().endswith(("(", ",", "{", "=", "||", "return")):
        return None
    if end == len(code):
        if not code.endswith(" ||"):
            return None
        end -= len(" ||")
    end -= len(code[start:end]) - len(code[start:end].rstrip())
    changed = after[start:end + len(after) - len(code)]
    if mutant.operator == "negation":
        return f"{code[:start]}({active}) != static_cast<bool>({code[start:end]}){code[end:]}"
    return f"{code[:start]}({active} ? ({changed}) : ({code[start:end]})){code[end:]}"


def mutants_of(file, text):
    lines, in_comment, previous = text.split("\n"), False, ""
    for number, line in enumerate(lines, 1):
        in_comment = in_comment or line.lstrip().startswith("/*")
        if not in_comment:
            for operator, after in changes(line):
                mutant = Mutant(file, number, operator, line, after)
                if switched(mutant, 1, previous):
                    yield mutant
        in_comment = in_comment and "*/" not in line
        previous = blanked(line)


def applied(numbered, text):
    """The text with mutants of it, {number: mutant}, each behind its switch."""
    lines = text.split("\n")
    code = [blanked(line) for line in lines]
    for number, mutant in numbered.items():
        assert lines[mutant.line - 1] == mutant.before, "the file has changed, or two mutants are of one line"
        lines[mutant.line - 1] = switched(mutant, number, code[mutant.line - 2])
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
