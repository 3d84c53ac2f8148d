#!/usr/bin/env python3
"""What is mutated and what is not."""

import unittest

import mutants


def results(line):
    return {after.strip() for _, after in mutants.changes(line)}


class MutantsTest(unittest.TestCase):
    def test_relations_sums_and_logic(self):
        self.assertEqual(results("  return a < b;"), {"return a <= b;"})
        self.assertEqual(results("  return a + b && c;"), {"return a - b && c;", "return a + b || c;"})

    def test_constants_conditions_and_removals(self):
        self.assertEqual(results("  if (done) return 7;"), {"if (!(done)) return 7;", "if (done) return 8;", ";"})
        self.assertEqual(results("  count.add(x);"), {";"})
        self.assertEqual(results("  total_ = x;"), {";"})

    def test_templates_strings_comments_and_asserts_are_left(self):
        for line in ("std::vector<int> v;", "// a < b", "static_assert(a < 2);", "#if A < 2"):
            self.assertEqual(results(line), set(), line)
        self.assertEqual(results("  return f(\"a < b\");  // 1 < 2"), set())

    def test_choice_is_the_same_for_a_seed_and_takes_one_a_line(self):
        texts = {f"f{i}": "\n".join(f"  return a{n} < b && c;" for n in range(20)) for i in range(3)}
        first = mutants.chosen(texts, 12, 1)
        self.assertEqual(first, mutants.chosen(texts, 12, 1))
        self.assertNotEqual(first, mutants.chosen(texts, 12, 2))
        self.assertEqual(len({(mutant.file, mutant.line) for mutant in first}), 12)

    def switched(self, line, after, previous=""):
        mutant = next(mutants.Mutant("f", 1, operator, line, new) for operator, new in mutants.changes(line) if new.strip() == after)
        return mutants.switched(mutant, 7, previous)

    def test_a_switch_holds_the_smallest_whole_expression(self):
        self.assertEqual(self.switched("  return a < b;", "return a <= b;"), "  return (collided_mutant == 7 ? (a <= b) : (a < b));")
        self.assertEqual(self.switched("  x = f(a, b + c[1]) - 2;  // why", "x = f(a, b - c[1]) - 2;  // why"),
                         "  x = f(a, (collided_mutant == 7 ? (b - c[1]) : (b + c[1]))) - 2;")
        self.assertEqual(self.switched("  for (int k = 0; k < 3; ++k) {", "for (int k = 0; k <= 3; ++k) {"),
                         "  for (int k = 0; (collided_mutant == 7 ? (k <= 3) : (k < 3)); ++k) {")
        self.assertEqual(self.switched("  const T d = a - b, e = a::c + b;", "const T d = a - b, e = a::c - b;"),
                         "  const T d = a - b, e = (collided_mutant == 7 ? (a::c - b) : (a::c + b));")
        self.assertEqual(self.switched("  return p ? a + b : c;", "return p ? a - b : c;"),
                         "  return p ? (collided_mutant == 7 ? (a - b) : (a + b)) : c;")

    def test_statements_and_conditions_have_switches(self):
        self.assertEqual(self.switched("  count.add(x);  // one more", ";"), "  { if (!(collided_mutant == 7)) count.add(x); }")
        self.assertEqual(self.switched("  if (done) {", "if (!(done)) {"), "  if ((collided_mutant == 7) != static_cast<bool>(done)) {")

    def test_an_expression_of_several_lines_is_left_but_at_its_ors(self):
        self.assertIsNone(self.switched("      b < c);", "b <= c);", previous="  f(a +"))
        self.assertEqual(self.switched("      b < c ||", "b <= c ||", previous="  return a ||"), "      (collided_mutant == 7 ? (b <= c) : (b < c)) ||")
        self.assertIsNone(self.switched("  return a < b &&", "return a <= b &&"))

    def test_application_changes_one_line_for_each_mutant(self):
        text = "int f() {\n  g();\n  return a < b;\n}\n"
        removal, relation = mutants.mutants_of("f", text)
        self.assertEqual(mutants.applied({1: removal, 2: relation}, text), "int f() {\n  { if (!(collided_mutant == 1)) g(); }\n"
                         "  return (collided_mutant == 2 ? (a <= b) : (a < b));\n}\n")


if __name__ == "__main__":
    unittest.main()
