"""The keys that client/JSON.md lists, and how JSON is compared with them."""

import pathlib
import re

PAGE = pathlib.Path(__file__).parents[3] / "client" / "JSON.md"
TYPES = {"text": str, "number": (int, float), "flag": bool, "list": list, "object": dict, "null": type(None)}


def documented():
    """Of each key its types, and whether keys below it are names of their own."""
    keys = {}
    for row in re.findall(r"^\| (`.*?) \| (.*?) \| (.*?) \|$", PAGE.read_text(encoding="utf-8"), re.M):
        for key in re.findall(r"`([^`]+)`", row[0]):
            assert key not in keys, f"{key} is listed twice"
            keys[key] = row[1].split(", "), "*by name*" in row[2]
    return keys


def type_of(value):
    return next(name for name, types in TYPES.items() if isinstance(value, types) and (name != "number" or value is not True
                                                                                     and value is not False))


class KeyChecks:
    """For test cases."""

    KEYS = documented()
    seen = set()

    def check(self, value, path):
        """All keys of a value are documented, and have the type and unit that the page says."""
        if isinstance(value, list):
            for entry in value:
                self.check(entry, path)
        if not isinstance(value, dict):
            return
        for key, below in value.items():
            at = f"{path}.{key}"
            self.assertTrue(key in self.KEYS, f"client/JSON.md does not list {key}, of {at}")
            types, is_by_name = self.KEYS[key]
            self.assertIn(type_of(below), types, at)
            KeyChecks.seen.add(key)
            self.check_unit(key, below, at)
            if is_by_name and isinstance(below, dict):
                self.seen.update(name for name, entry in below.items() if not isinstance(entry, dict) and name in self.KEYS)
                for name, entry in below.items():
                    is_key = isinstance(entry, dict) and self.KEYS.get(name, ([], False))[1]
                    self.check({name: entry} if is_key else entry, at if is_key else f"{at}.{name}")
            else:
                self.check(below, at)

    def check_unit(self, key, value, at):
        self.assertNotRegex(key, r"_(us|ns|s|sec|msec|kb|mb|mib|gb)(_|$)", at)
        if key.endswith("bytes") and not isinstance(value, dict):
            self.assertEqual(value, int(value), at)
