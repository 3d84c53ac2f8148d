"""Readable names of tests."""


def short(name):
    """Without the value that GoogleTest adds to the name of a parameter."""
    return name.split("  # ")[0]


def suite_of(name):
    """The part before the test's own name; for a script, its group."""
    return short(name).rpartition(".")[0]


def clipped(text, width):
    return text if len(text) <= width else text[:width - 3] + "..."


def groups(names):
    """Returns the suites of many tests with their numbers of cases, largest first; a lone test by its name."""
    suites = {}
    for name in sorted(names):
        suites.setdefault(suite_of(name), []).append(name)
    return [cases[0] if len(cases) == 1 else f"{suite}: {len(cases)} cases"
            for suite, cases in sorted(suites.items(), key=lambda item: -len(item[1]))]
